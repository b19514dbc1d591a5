"""The flow at each rotor of a moving vehicle, due to its motion and the wakes of other rotors."""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import asdict, astuple, dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.results import spin_sign
from propmap.rotor import Rotor
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.model.model import Model
    from propmap.vehicle.vehicle import Mount, Vehicle, Wakes


# -------------------------------------------------------------------------------------------------
# Interaction of the rotors: the axial flow that wakes add at the disks of other rotors.
#
# docs/theory.md, "Rotor wakes", describes the model.  The core computes the flow from splines of
# the velocity that a wake induces at other rotors.


@dataclass(frozen=True, eq=False)
class WakeFlow:
    """Axial velocity added by the wakes at each of m rotors in n samples, and its derivatives."""

    inflow: Floats  # uniform inflow of each rotor by eq. (10) (n, m) [m/s]
    added: Floats  # (n, m), added to V cos(beta), with gains [m/s]; positive for downwash
    by_gain: dict[str, Floats]  # derivatives (n, m) by the fields of ``Wakes`` [m/s]
    by_thrust: Floats  # derivatives (n, m, m) by the thrust of each rotor, the last axis [m/s/N]


def in_wakes(vehicle: Vehicle, wakes: Wakes, model: Model, flow: HubFlow) -> HubFlow:
    """Return the flow at interacting rotors; ``Rotor.attached_thrust`` determines the wakes.

    Parameters
    ----------
    vehicle, wakes : Vehicle, Wakes
        Vehicle with m rotors, and their interaction.
    model : Model
        Model of its rotors.
    flow : HubFlow
        Flow of n samples without interaction.

    Raises
    ------
    InputError
        For two rotors at the same position.
    """
    check_apart(vehicle)
    thrust, _ = Rotor(model).attached_thrust(flow.omega, flow.axial, flow.inplane)
    return flow.perturbed(wake_flow(vehicle, wakes, flow, thrust).added)


def wake_flow(vehicle: Vehicle, wakes: Wakes, flow: HubFlow, thrust: Floats) -> WakeFlow:
    """Return the axial flow that other wakes add at each rotor, and its derivatives.

    Parameters
    ----------
    vehicle : Vehicle
        Vehicle with m rotors.
    wakes : Wakes
        Gains of the wakes, and the factor on the inflow in the velocity that carries a wake away.
    flow : HubFlow
        Flow of n samples without interaction.
    thrust : ndarray, shape (n, m)
        Thrust of each rotor without interaction [N].  NaN if the thrust is unknown; the flow at the
        other rotors is then NaN.
    """
    of, gains = core_wakes(vehicle, wakes)
    inflow, added, by_gain, by_thrust = of.flow(
        gains,
        flow.axial.ravel(),
        flow.inplane.ravel(),
        flow.downstream.reshape(-1, 3),
        np.ascontiguousarray(thrust).ravel(),
    )
    return WakeFlow(inflow, added, dict(zip(asdict(wakes), by_gain, strict=True)), by_thrust)


def limits() -> dict[str, float]:
    """Return the limits in ``interaction.hpp`` by name, for exported code."""
    from propmap import core

    return dict(core.wake_limits)


def check_apart(vehicle: Vehicle) -> None:
    """Raise ``InputError`` if two rotors of a ``vehicle`` with wakes are in one place."""
    for k, mount in enumerate(vehicle.mounts):
        for j, other in enumerate(vehicle.mounts[:k]):
            distance = float(np.linalg.norm(np.subtract(mount.position, other.position)))
            if distance < 0.05 * vehicle.propeller.radius:
                raise InputError(
                    f"rotors {j + 1} and {k + 1} are {distance:g} m apart",
                    "give each hub its own position",
                )


# -------------------------------------------------------------------------------------------------
# The flow at each rotor of a moving vehicle, and the rotors' forces and moments on the vehicle.


class HubFlow(NamedTuple):
    """Operating points of n samples of m rotors, in the vehicle's frame."""

    omega: Floats  # (n, m) [rad/s]
    axial: Floats  # V_i cos(beta_i), (n, m) [m/s]
    inplane: Floats  # V_i sin(beta_i) >= 0, (n, m) [m/s]
    axis: Floats  # unit vectors along the thrust, (m, 3)
    downstream: Floats  # unit vectors (n, m, 3) along the rotor drag, zero without in-plane flow
    position: Floats  # of the hubs relative to the center of mass, (m, 3) [m]
    spin: Floats  # 1 for counter-clockwise, -1 for clockwise, (m,)

    @property
    def velocity(self) -> Floats:
        """Velocity of the hubs through the air, in the vehicle's frame [m/s]; (n, m, 3)."""
        along: Floats = self.axial[..., None] * self.axis
        return along - self.inplane[..., None] * self.downstream

    def part(self, which: NDArray[np.intp] | slice) -> HubFlow:
        """Return the selected samples."""
        return self._replace(
            omega=self.omega[which],
            axial=self.axial[which],
            inplane=self.inplane[which],
            downstream=self.downstream[which],
        )

    def perturbed(self, added: Floats) -> HubFlow:
        """Return this flow with ``added`` (n, m) in the axial velocity [m/s]."""
        return self._replace(axial=self.axial + added)


def hub_flow_at(vehicle: Vehicle, omega: Floats, velocity: Floats, rates: Floats) -> HubFlow:
    """Return the flow at the hubs of rotors at ``omega`` (n, m) [rad/s].

    The vehicle has the ``velocity`` [m/s] and the angular ``rates`` [rad/s], (n, 3) in its frame.
    """
    hubs = velocity[:, None] + cross(rates[:, None], vehicle.hub_positions)
    return flow_of_hubs(vehicle, omega, hubs)


def flow_of_hubs(vehicle: Vehicle, omega: Floats, hubs: Floats) -> HubFlow:
    """Return the flow for velocities of the ``hubs`` through the air (n, m, 3) [m/s].

    The velocities are in the vehicle's frame; ``omega`` is (n, m) [rad/s].
    """
    from propmap import core

    position, axis = vehicle.hub_positions, vehicle.rotor_axes
    spin = np.array([spin_sign(mount.spin) for mount in vehicle.mounts])
    found = core.hub_flows(axis, np.ascontiguousarray(hubs).reshape(-1, 3))
    axial, inplane, *downstream = found.reshape(5, *omega.shape)
    return HubFlow(omega, axial, inplane, axis, np.stack(downstream, axis=-1), position, spin)


def rotor_forces(flow: HubFlow, thrust: Floats, drag: Floats) -> Floats:
    """Return the total force of the rotors [N], (..., n, 3), from loads (..., n, m) [N]."""
    along = np.einsum("...nm,mk->...nk", thrust, flow.axis)
    return along + np.einsum("...nm,nmk->...nk", drag, flow.downstream)


def hub_wrenches(flow: HubFlow, loads: Floats) -> tuple[Floats, Floats]:
    """Return each rotor's force [N] on the vehicle and moment about its hub [N m], (..., n, m, 3).

    The ``loads`` (L, ..., n, m) are in the order of ``LOADS``.  Both results are linear in the
    loads, so that derivatives of loads give derivatives of forces and moments.
    """
    from propmap import core

    size = flow.inplane.size
    rows = np.ascontiguousarray(loads).reshape(len(LOADS), math.prod(loads.shape[1:-2]), size)
    found = core.hub_wrenches(flow.axis, flow.spin, flow.downstream.reshape(-1, 3), rows)
    force, moment = (each.reshape(*loads.shape[1:], 3) for each in found)
    return force, moment


def rotor_wrench(flow: HubFlow, loads: Floats) -> tuple[Floats, Floats]:
    """Return the total force [N] and moment about the center of mass [N m] of the rotors.

    The shapes are (..., n, 3); ``flow`` and ``loads`` are those of ``hub_wrenches``.
    """
    force, moment = hub_wrenches(flow, loads)
    return force.sum(axis=-2), (moment + cross(flow.position, force)).sum(axis=-2)


# -------------------------------------------------------------------------------------------------
# Table of the velocity that one rotor's wake induces, averaged over the disk of another rotor.
#
# The velocity depends only on the direction in which the air carries the wake.  A table over the
# two angles of this direction is therefore valid for all flights of a vehicle.  At the first use,
# the table is computed from the vortex cylinder.  This takes some tenths of a second for each pair
# of rotors with a new relative position.  Cubic splines interpolate it with continuous derivatives.

SKEWS, BEARINGS = 121, 96  # nodes: skew from straight down to straight up, bearing over a turn
TABLE_AZIMUTHS = 64
"""Azimuths per ring.  On the wake's surface, the error of ``axial_velocity`` is up to 0.015 for
skews up to 85 degrees, and 0.03 at 90 degrees."""

RINGS, SPOKES = 4, 8  # nodes over a disk: Gauss-Legendre in the squared radius, and azimuths
_BEYOND = 4  # bearings repeated on both sides of a full turn, so that the spline is periodic
_SKEW = np.linspace(0.0, np.pi, SKEWS)
_AROUND = 2.0 * np.pi * np.arange(BEARINGS) / BEARINGS


class WakeGeometry(NamedTuple):
    """The wakes of k rotors on each other, by target and source."""

    frames: Floats  # rows: two directions in the disk, and the axis (k, 3, 3)
    kind: NDArray[np.intp]  # index of the spline of each target and source (k, k)
    # Bearing of the target in the source's frame [rad] (k, k); splines use bearings relative to it.
    bearing: Floats
    slipstream: NDArray[np.bool_]  # whether the rotors are above each other (k, k)
    splines: list[Any]  # velocities induced by a wake, over its skew and bearing


@functools.lru_cache(maxsize=64)
def wake_geometry(
    mounts: tuple[Mount, ...], radius: float, slipstreams_alone: bool
) -> WakeGeometry:
    """Return the wakes of rotors with this ``radius`` [m]."""
    k = len(mounts)
    kind, bearing = np.zeros((k, k), int), np.zeros((k, k))
    splines: dict[Any, int] = {}
    for (t, target), (s, source) in itertools.permutations(enumerate(mounts), 2):
        spline, bearing[t, s] = seen_wake(source, target, radius, slipstreams_alone)
        kind[t, s] = splines.setdefault(spline, len(splines))
    frames = np.stack([frame_of(mount.axis) for mount in mounts])
    return WakeGeometry(frames, kind, bearing, _above_each_other(mounts, radius), list(splines))


def core_wakes(vehicle: Vehicle, wakes: Wakes) -> tuple[Any, Floats]:
    """Return ``core.Wakes``, and a vector of the gains followed by rho times the disk area."""
    radius = vehicle.propeller.radius
    gains = np.array([*astuple(wakes), vehicle.air.density * np.pi * radius**2])
    return _core_wakes(vehicle.mounts, radius, wakes.slipstreams_alone), gains


@functools.lru_cache(maxsize=64)
def _core_wakes(mounts: tuple[Mount, ...], radius: float, slipstreams_alone: bool) -> Any:
    from propmap import core

    frames, kind, bearing, slipstream, splines = wake_geometry(mounts, radius, slipstreams_alone)
    pairs = np.stack([kind, bearing, slipstream], axis=-1).reshape(-1, 3)
    axes = []
    for knots in _slipstream_table(0.0, 0.0, 0.0).tck[:2]:  # of all splines
        ends = np.unique(knots)
        _, weights = interval_weights(knots, ends)
        axes.append((ends, weights.swapaxes(1, 2).ravel()))
    shape = [len(ends) + 2 for ends, _ in axes]
    values = np.reshape([spline.get_coeffs() for spline in splines], (len(splines), *shape))
    return core.Wakes(frames.reshape(-1, 3), pairs, *axes, values)


def interval_weights(knots: Floats, breaks: Floats) -> tuple[NDArray[np.intp], Floats]:
    """Convert a cubic B-spline with ``knots`` to polynomials in n intervals between ``breaks``.

    Return the index of the first of the four coefficients used in each interval (n,).  Also return
    their weights as polynomials (n, power, coefficient) of the position in the interval, 0 to 1.
    """
    from scipy.interpolate import BSpline

    inside = np.linspace(0.1, 0.9, 4)
    to_powers = np.linalg.inv(np.vander(inside, increasing=True))
    first = np.searchsorted(knots, 0.5 * (breaks[:-1] + breaks[1:]), side="right") - 4
    weights = []
    for span, low, high in zip(first, breaks[:-1], breaks[1:], strict=True):
        at = low + inside * (high - low)
        four = [BSpline.basis_element(knots[j : j + 5])(at) for j in range(span, span + 4)]
        weights.append(to_powers @ np.stack(four, axis=1))
    return first, np.array(weights)


def seen_wake(
    source: Mount, target: Mount, radius: float, slipstreams_alone: bool = False
) -> tuple[Any, float]:
    """Return the velocity induced by the wake of ``source`` at the disk of ``target``.

    Both rotors have the ``radius`` [m].  The first result is a spline over skew and bearing [rad]
    of the wake.  It contains the velocity against the target's axis, divided by the circulation per
    length [-].  The second result is the bearing of the target in the source's frame [rad].  The
    bearings in the spline are relative to this bearing.  Pairs with equal relative positions share
    one spline.  The velocity is zero at rotors above the source that overlap it.  With
    ``slipstreams_alone`` it is zero at all rotors except overlapping rotors below the source.
    """
    frame = frame_of(source.axis)
    offset = frame @ (np.subtract(target.position, source.position) / radius)
    towards = float(np.arctan2(offset[1], offset[0])) if np.hypot(*offset[:2]) > 1e-9 else 0.0
    c, s = np.cos(towards), np.sin(towards)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    place, axis = turn @ offset, turn @ frame @ np.array(target.axis)
    # Round, so that pairs that differ only by rounding errors share one table.
    where = tuple(float(x) for x in np.round([*place, *axis], 9) + 0.0)
    depth = depth_below(source, target, radius)
    acts = depth > 0.0 or not (depth or slipstreams_alone)
    if acts and not depth:
        return _table(*where), towards
    below = (round(depth, 9), where[0], where[5]) if acts else (0.0, 0.0, 0.0)
    return _slipstream_table(*below), towards


@functools.lru_cache(maxsize=256)
def frame_of(axis: tuple[float, float, float]) -> Floats:
    """Return two directions in the disk and the ``axis`` as rows of a right-handed frame."""
    z = np.array(axis)
    nearest = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    y = np.cross(z, nearest)
    y /= np.linalg.norm(y)
    frame = np.stack([np.cross(y, z), y, z])
    frame.flags.writeable = False
    return frame


@functools.lru_cache(maxsize=256)
def _table(x: float, y: float, z: float, along_x: float, along_y: float, along_z: float) -> Any:
    """Return the spline over skew and bearing for a target at (x, y, z) [radii] with axis
    (along_x, along_y, along_z)."""
    rim, weights = _disk()
    axis = (along_x, along_y, along_z)
    points = np.array([x, y, z]) + rim @ frame_of(axis)
    seen = np.empty((SKEWS, BEARINGS))
    for row, chi in enumerate(_SKEW):
        side = np.sin(chi) * np.stack([np.cos(_AROUND), np.sin(_AROUND), 0.0 * _AROUND], axis=1)
        way = side - [0.0, 0.0, np.cos(chi)]
        found = axial_velocity(points[None], way[:, None], azimuths=TABLE_AZIMUTHS)
        seen[row] = along_z * (found @ weights)
    return _spline(seen)


def _spline(seen: Floats) -> Any:
    """Return the spline through velocities (SKEWS, BEARINGS)."""
    from scipy.interpolate import RectBivariateSpline

    bearing = 2.0 * np.pi * np.arange(-_BEYOND, BEARINGS + _BEYOND + 1) / BEARINGS
    closed = np.concatenate([seen[:, -_BEYOND:], seen, seen[:, : _BEYOND + 1]], axis=1)
    return RectBivariateSpline(_SKEW, bearing, closed)


def _disk() -> tuple[Floats, Floats]:
    """Return points (S, 3) on a disk of radius one, and their weights, whose sum is one."""
    node, weight = np.polynomial.legendre.leggauss(RINGS)
    radius = np.sqrt(0.5 * (node + 1.0))
    angle = 2.0 * np.pi * np.arange(SPOKES) / SPOKES
    # Each second ring is rotated, so that all directions have equally many points.
    turned = angle + (np.pi / SPOKES) * (np.arange(RINGS) % 2)[:, None]
    flat = radius[:, None] * np.stack([np.cos(turned), np.sin(turned)])
    points = np.concatenate([flat, np.zeros((1, RINGS, SPOKES))]).reshape(3, -1).T
    return points, np.repeat(weight / (2.0 * SPOKES), SPOKES)


# -------------------------------------------------------------------------------------------------
# The slipstream of a rotor at the disk of an overlapping lower rotor, such as a coaxial rotor.
#
# docs/theory.md, "Rotors above each other", describes the model.  Induced power in hover for two
# equal thrusts, divided by the induced power of two separate rotors:
# - this model: 1.309
# - momentum theory, lower rotor far below: 1.281
# - momentum theory, both rotors in one plane, a limit that no pair reaches: 1.414
#
# References
# ----------
# J. G. Leishman, S. Ananthan, "Aerodynamic Optimization of a Coaxial Proprotor", American
# Helicopter Society 62nd Annual Forum, 2006.
# J. G. Leishman, M. Syal, J. Am. Helicopter Soc. 53, 2008, doi 10.4050/JAHS.53.290.

IN_ONE_PLANE = 0.05
"""Difference in height [radii] below which overlapping rotors are modeled as side by side."""

PARALLEL = 0.9  # least cosine between the axes of rotors above each other


def depth_below(source: Mount, target: Mount, radius: float) -> float:
    """Return the depth of ``target`` below an overlapping ``source`` in radii; negative if above.

    The depth is 0 for coplanar rotors and for rotors whose axes are not parallel.  It is also 0 for
    rotors that do not overlap in the view along the axis of the ``source``.
    """
    frame = frame_of(source.axis)
    x, y, height = frame @ (np.subtract(target.position, source.position) / radius)
    separate = np.hypot(x, y) >= 2.0 - 1e-9 or abs(height) < IN_ONE_PLANE
    return 0.0 if separate or np.dot(source.axis, target.axis) < PARALLEL else float(-height)


def above_each_other(vehicle: Vehicle) -> NDArray[np.bool_]:
    """Return a mask (m, m) of the pairs of overlapping rotors above each other."""
    return _above_each_other(vehicle.mounts, vehicle.propeller.radius)


@functools.lru_cache(maxsize=64)
def _above_each_other(mounts: tuple[Mount, ...], radius: float) -> NDArray[np.bool_]:
    depths = [[depth_below(source, target, radius) for source in mounts] for target in mounts]
    found: NDArray[np.bool_] = np.array(depths) != 0.0
    found.flags.writeable = False
    return found


def slipstream(depth: float, aside: float, skew: Floats, bearing: Floats) -> Floats:
    """Return the velocity in a contracted slipstream, averaged over a disk below its rotor.

    Parameters
    ----------
    depth, aside : float
        Depth and lateral offset of the disk below the source rotor [radii].
    skew, bearing : ndarray, shape (...)
        Skew of the wake from straight down, up to pi / 2, and its bearing relative to the lateral
        direction from the source rotor to the disk [rad].

    Returns
    -------
    ndarray, shape (...)
        Velocity divided by the circulation per length, as in ``axial_velocity`` [-]; 1/2 for a
        coaxial disk without skew.
    """
    tangent = np.tan(np.minimum(skew, 0.5 * np.pi - 1e-6))
    path = depth * np.hypot(1.0, tangent)
    grown = 1.0 + path / np.hypot(1.0, path)
    radius = np.sqrt(np.hypot(1.0, tangent) / np.hypot(grown, tangent))
    off = np.hypot(depth * tangent * np.cos(bearing) - aside, depth * tangent * np.sin(bearing))
    # The common area of a circle of this radius and a unit circle, from their sectors.
    off = np.clip(off, 1.0 - radius + 1e-12, 1.0 + radius)
    inner = np.arccos(np.clip((off**2 + radius**2 - 1.0) / (2.0 * off * radius), -1.0, 1.0))
    outer = np.arccos(np.clip((off**2 + 1.0 - radius**2) / (2.0 * off), -1.0, 1.0))
    share = (radius**2 * inner + outer - off * np.sin(outer)) / np.pi
    return np.asarray(0.5 * grown * share)


@functools.lru_cache(maxsize=256)
def _slipstream_table(depth: float, aside: float, along: float) -> Any:
    """Return the spline of a ``slipstream``; ``along`` is the cosine between the axes."""
    falls = along * (np.cos(_SKEW) > 0.0)[:, None]
    return _spline(falls * slipstream(depth, aside, _SKEW[:, None], _AROUND))


# -------------------------------------------------------------------------------------------------
# The velocity induced by a rotor's wake: a semi-infinite skewed cylinder of vortex rings.
#
# The rings are parallel to the disk and lie along the direction in which the air carries the wake
# away.  docs/theory.md, "Rotor wakes", contains the integral around a ring.  The code replaces this
# integral by a sum over equally spaced azimuths, which converges geometrically outside the surface.
#
# References
# ----------
# W. Castles, J. H. De Leeuw, "The Normal Component of the Induced Velocity in the Vicinity of a
# Lifting Rotor and Some Examples of Its Application", NACA Report 1184, 1954.
# E. Branlard, M. Gaunaa, "Cylindrical Vortex Wake Model: Skewed Cylinder, Application to Yawed or
# Tilted Rotors", Wind Energy 19, 2016, doi 10.1002/we.1838.

CYLINDER_AZIMUTHS = 32
"""Azimuths per ring.  For skews up to 60 degrees, the error is below 0.01 at more than a quarter of
a radius from the wake's surface, and up to 0.08 at the surface."""

CORE = 0.05
"""Radius of the core of the vortex sheet in rotor radii [-].  The core smooths the jump of
the velocity across the wake's surface, so that the loads are smooth when a wake passes a rotor."""


def axial_velocity(
    place: Floats, direction: Floats, *, core: float = CORE, azimuths: int = CYLINDER_AZIMUTHS
) -> Floats:
    """Return the downward velocity induced by a rotor's wake, per unit of vortex-sheet strength.

    The strength is the circulation per length of the wake [m/s].

    Parameters
    ----------
    place : ndarray, shape (..., 3)
        Point relative to the rotor's center in radii, in a frame with z along the thrust [-].
    direction : ndarray, shape (..., 3)
        Unit vector along which the air carries the wake away [-].
    core : float
        Radius of the sheet's core, in radii of the rotor [-].
    azimuths : int
        Nodes around a ring.

    Returns
    -------
    ndarray, shape (...)
        Velocity against z [-], positive inside the wake.  Far below a rotor in axial flow it tends
        to 1 inside the wake.
    """
    psi = 2.0 * np.pi * (np.arange(azimuths) + 0.5) / azimuths
    cosine, sine = np.cos(psi), np.sin(psi)
    x, y, z = (place[..., k, None] for k in range(3))
    along_x, along_y, along_z = (direction[..., k, None] for k in range(3))
    from_x, from_y = x - cosine, y - sine
    distance = np.sqrt(from_x**2 + from_y**2 + z**2 + core**2)
    beside = distance - (from_x * along_x + from_y * along_y + z * along_z)
    # The z components of e_t x a and e_t x d, with e_t = (-sin(psi), cos(psi), 0).
    ring = -sine * from_y - cosine * from_x
    wake = -sine * along_y - cosine * along_x
    # Rings that push air down circulate against e_t, so positive terms are velocities along -z.
    total: Floats = np.mean((ring / distance - wake) / beside, axis=-1)
    return 0.5 * total


def cross(one: Floats, other: Floats) -> Floats:
    """Return cross products (..., 3) of vectors (..., 3), bit for bit equal to ``np.cross``.

    For a few vectors, ``np.cross`` takes ten times as long, because it moves axes.
    """
    (a, b, c), (x, y, z) = ((v[..., 0], v[..., 1], v[..., 2]) for v in (one, other))
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=-1)
