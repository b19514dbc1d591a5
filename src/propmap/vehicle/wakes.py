"""The flow at each rotor of a moving vehicle: by its motion, and by the other rotors' wakes."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
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
# The rotors' wakes on each other: what they add to the axial flow at each other's disks.
#
# Each rotor's wake is a skewed vortex cylinder (below) that carries twice the inflow of Glauert's
# momentum theory (10).  Its velocity along the axis of each other rotor, averaged over that disk,
# times a gain, adds to V cos(beta) there.  The gains stand for what the cylinder leaves out, as
# rolled-up tip vortices; they are one where the cylinder is right.  Rotors above each other have
# the contracted slipstream (further below) in place of cylinders, without a gain.

LARGEST_INFLOW = 2.0
"""Inflow over that of the same thrust in hover [-], at most: about what is measured in the vortex
ring, where momentum theory has no solution."""

UPWASH = 0.005  # per density of circulation [-], from which the gain is all that of upwash

LARGEST_UPWASH = 0.5
"""Upwash per density of circulation, gain included [-], at most: a wake then moves the air by the
inflow of its rotor, as a cylinder does at its own surface, the fastest there is outside."""

SLOW = 0.5  # in-plane velocity [m/s] about which ahead and beside begin to differ
STEPS = 40  # steps of Newton's method, which is monotone from above


@dataclass(frozen=True, eq=False)
class WakeFlow:
    """What the wakes add to the axial velocity at each of m rotors, n samples."""

    added: Floats  # (n, m) to V cos(beta) [m/s], gains included; positive is downwash
    by_gain: dict[str, Floats]  # its derivatives (n, m) by the fields of ``Wakes`` [m/s]
    by_thrust: Floats  # its derivatives (n, m, m) by each rotor's thrust, the last axis [m/s/N]


def glauert_inflow(
    thrust: Floats, axial: Floats, inplane: Floats, disk: float
) -> tuple[Floats, Floats]:
    """Solve eq. (10) for a disk's uniform inflow v, T = 2 rho A v sqrt(V_in^2 + (V_ax + v)^2).

    Arrays are (...): ``thrust`` [N], V cos(beta) and V sin(beta) [m/s]; ``disk`` is rho A [kg/m].
    Where descent has several solutions v [m/s] is the largest, but no more than ``LARGEST_INFLOW``;
    0 without thrust, NaN where an argument is.  Also returns its derivative by T [m/s/N].
    """
    square = np.maximum(thrust, 0.0) / (2.0 * disk)
    hover = np.sqrt(square)
    v = hover + np.maximum(-axial, 0.0) * 1.5 + 1e-9
    for _ in range(STEPS):
        through = axial + v
        speed = np.sqrt(inplane**2 + through**2 + 1e-12)
        slope = speed + v * through / speed
        v = np.maximum(v - (v * speed - square) / np.maximum(slope, 1e-6), 0.0)
    through = axial + v
    speed = np.sqrt(inplane**2 + through**2 + 1e-12)
    slope = 1.0 / (2.0 * disk * np.maximum(speed + v * through / speed, 1e-6))
    # The hover's inflow rises without bound as its thrust begins.
    at_most = LARGEST_INFLOW * hover
    limit_slope = at_most / np.maximum(2.0 * thrust, 1e-6)
    slope = np.where(v < at_most, slope, limit_slope)
    return np.minimum(v, at_most), np.where(thrust > 0.0, slope, 0.0)


def in_wakes(vehicle: Vehicle, wakes: Wakes, model: Model, flow: HubFlow) -> HubFlow:
    """Find the flow at rotors in each other's wakes, each of which has attached thrust.

    Parameters
    ----------
    vehicle, wakes : Vehicle, Wakes
        Where its m rotors are, and how they act on each other.
    model : Model
        Physics of its rotors.
    flow : HubFlow
        Flow of n samples without the wakes.

    Raises
    ------
    InputError
        Where two rotors are in one place.
    """
    check_apart(vehicle)
    thrust, _ = Rotor(model).attached_thrust(flow.omega, flow.axial, flow.inplane)
    added = added_flow(vehicle, wakes, flow, thrust)
    return flow._replace(axial=flow.axial + added)


def added_flow(vehicle: Vehicle, wakes: Wakes, flow: HubFlow, thrust: Floats) -> Floats:
    """Return what the wakes of all other rotors add to V cos(beta) at each [m/s], (n, m).

    ``vehicle``, ``wakes``, ``flow`` and ``thrust`` are those of ``wake_flow``, which gives the
    derivatives as well and takes twice the time.
    """
    inflow, _ = _inflow(vehicle, flow, thrust)
    seen, _ = _seen(vehicle, wakes, flow, inflow)
    along = _along(vehicle, flow.velocity)
    upwash = wakes.beside + (wakes.ahead - wakes.beside) * along
    rising, _ = _rising(seen)
    gained = downwash_gains(vehicle, wakes) * (seen - rising) + _limited(upwash * rising)[0]
    found: Floats = np.sum(2.0 * inflow[:, None, :] * gained, axis=2)
    return found


def wake_flow(vehicle: Vehicle, wakes: Wakes, flow: HubFlow, thrust: Floats) -> WakeFlow:
    """Return what the wakes of all other rotors add to the axial flow at each, and its derivatives.

    Parameters
    ----------
    vehicle : Vehicle
        Where its m rotors are.
    wakes : Wakes
        Gains, and the share of its inflow that skews a wake.
    flow : HubFlow
        Flow of n samples.
    thrust : ndarray, shape (n, m)
        Thrust of each rotor [N], without its neighbours.
    """
    inflow, by_thrust = _inflow(vehicle, flow, thrust)
    seen, by_share = _seen(vehicle, wakes, flow, inflow, slope=True)
    rising, slope = _rising(seen)
    along = _along(vehicle, flow.velocity)
    upwash = wakes.beside + (wakes.ahead - wakes.beside) * along
    lifted, share = _limited(upwash * rising)
    down = downwash_gains(vehicle, wakes)
    gained = down * (seen - rising) + lifted
    steeper = down * (1.0 - slope) + share * upwash * slope
    twice = 2.0 * inflow[:, None, :]
    # A wake goes as 2 v K(share v): its strength and its direction change with the inflow.
    by_inflow = 2.0 * (gained + wakes.share * steeper * by_share)
    return WakeFlow(
        added=np.sum(twice * gained, axis=2),
        by_gain={
            "ahead": np.sum(twice * along * share * rising, axis=2),
            "beside": np.sum(twice * (1.0 - along) * share * rising, axis=2),
            "downwash": np.sum(twice * (seen - rising) * ~above_each_other(vehicle), axis=2),
            "share": np.sum(twice * steeper * by_share, axis=2),
        },
        by_thrust=by_inflow * by_thrust[:, None, :],
    )


def _inflow(vehicle: Vehicle, flow: HubFlow, thrust: Floats) -> tuple[Floats, Floats]:
    """Return ``glauert_inflow`` at each rotor."""
    disk = vehicle.air.density * np.pi * vehicle.propeller.radius**2
    return glauert_inflow(thrust, flow.axial, flow.inplane, disk)


def _rising(seen: Floats) -> tuple[Floats, Floats]:
    """Return the part of the velocities that is upwash, and its derivative; both continuous."""
    share = np.clip(-seen / UPWASH, 0.0, 1.0)
    return seen * share**2 * (3.0 - 2.0 * share), share**2 * (9.0 - 8.0 * share)


def _limited(upwash: Floats) -> tuple[Floats, Floats]:
    """Limit upwash per density of circulation, gain included, to ``LARGEST_UPWASH``.

    Also returns what a little more upwash adds to it [-].
    """
    relative = np.tanh(upwash / LARGEST_UPWASH)
    return LARGEST_UPWASH * relative, 1.0 - relative**2


def _along(vehicle: Vehicle, velocity: Floats) -> Floats:
    """Say how far a target is along the flight of a source, not beside it (n, target, source) [-].

    This is the squared cosine between the source's in-plane velocity and the direction to the
    target in the source's disk plane; it fades to 0 as the velocity does, where there is neither.
    """
    position, axis = vehicle.hub_positions, vehicle.rotor_axes
    offset = position[:, None] - position[None]
    offset = offset - np.sum(offset * axis, axis=-1, keepdims=True) * axis
    length = np.linalg.norm(offset, axis=-1)
    unit = offset / np.where(length > 1e-9, length, 1.0)[..., None]
    speed2 = np.sum(np.square(np.cross(velocity, axis)), axis=-1)
    return np.einsum("nsk,tsk->nts", velocity, unit) ** 2 / (speed2 + SLOW**2)[:, None, :]


def _seen(
    vehicle: Vehicle, wakes: Wakes, flow: HubFlow, inflow: Floats, *, slope: bool = False
) -> tuple[Floats, Floats]:
    """Return the downward velocity (n, target, source) at each rotor by the wake of each [-].

    It is per density of the wake's circulation.  With ``slope``, also its derivative by the share
    of the inflow that skews a wake, else zeros.
    """
    mounts, radius, share = vehicle.mounts, vehicle.propeller.radius, wakes.share
    alone = wakes.slipstreams_alone
    found = np.zeros((inflow.shape[0], len(mounts), len(mounts)))
    by_share = np.zeros_like(found)
    for source, mount in enumerate(mounts):
        # The air carries a wake against the hub's velocity and down its own axis.
        away = -flow.velocity[:, source] @ frame_of(mount.axis).T
        away[:, 2] -= share * inflow[:, source]
        away[np.all(np.abs(away) < 1e-9, axis=1)] = 0.0, 0.0, -1.0
        length2 = np.sum(away**2, axis=1)
        straighter = -np.hypot(away[:, 0], away[:, 1]) * inflow[:, source] / length2
        for target, other in enumerate(mounts):
            if target != source and (wake := seen_wake(mount, other, radius, alone)).acts:
                found[:, target, source] = wake.at(away)
                if slope:
                    by_share[:, target, source] = wake.at(away, skewing=True) * straighter
    return found, by_share


def check_apart(vehicle: Vehicle) -> None:
    """Raise ``InputError`` where two rotors of a ``vehicle`` with wakes are in one place."""
    for k, mount in enumerate(vehicle.mounts):
        for j, other in enumerate(vehicle.mounts[:k]):
            distance = float(np.linalg.norm(np.subtract(mount.position, other.position)))
            if distance < 0.05 * vehicle.propeller.radius:
                raise InputError(
                    f"rotors {j + 1} and {k + 1} are {distance:g} m apart",
                    "give each hub its own position",
                )


# -------------------------------------------------------------------------------------------------
# The flow at each rotor of a moving vehicle, and the rotors' forces and moments back on it.


class HubFlow(NamedTuple):
    """Operating points of n samples of m rotors, in the vehicle's frame."""

    omega: Floats  # (n, m) [rad/s]
    axial: Floats  # V_i cos(beta_i), (n, m) [m/s]
    inplane: Floats  # V_i sin(beta_i) >= 0, (n, m) [m/s]
    axis: Floats  # unit vectors along the thrust, (m, 3)
    downstream: Floats  # unit vectors (n, m, 3) along the rotor drag, zero without in-plane flow
    position: Floats  # of the hubs from the centre of mass, (m, 3) [m]
    spin: Floats  # 1 for counter-clockwise, else -1, (m,)

    @property
    def velocity(self) -> Floats:
        """Velocity of the hubs through the air, in the vehicle's frame [m/s]; (n, m, 3)."""
        along: Floats = self.axial[..., None] * self.axis
        return along - self.inplane[..., None] * self.downstream

    def part(self, which: NDArray[np.intp] | slice) -> HubFlow:
        """Return some samples."""
        return self._replace(
            omega=self.omega[which],
            axial=self.axial[which],
            inplane=self.inplane[which],
            downstream=self.downstream[which],
        )

    def perturbed(self, added: Floats) -> HubFlow:
        """Return this flow with ``added`` (n, m) to the axial velocity [m/s]."""
        return self._replace(axial=self.axial + added)


def hub_flow_at(vehicle: Vehicle, omega: Floats, velocity: Floats, rates: Floats) -> HubFlow:
    """Find the flow at the hubs of rotors at ``omega`` (n, m) [rad/s].

    The vehicle moves at ``velocity`` [m/s] and turns at ``rates`` [rad/s], (n, 3) in its frame.
    """
    hubs = velocity[:, None] + cross(rates[:, None], vehicle.hub_positions)
    return flow_of_hubs(vehicle, omega, hubs)


def flow_of_hubs(vehicle: Vehicle, omega: Floats, hubs: Floats) -> HubFlow:
    """Find the flow at ``hubs`` whose velocities (n, m, 3) through the air are known.

    They are in the vehicle's frame [m/s]; ``omega`` is (n, m) [rad/s].
    """
    from propmap import core

    position, axis = vehicle.hub_positions, vehicle.rotor_axes
    spin = np.array([spin_sign(mount.spin) for mount in vehicle.mounts])
    axial, inplane, downstream = core.hub_flows(axis, np.ascontiguousarray(hubs).reshape(-1, 3))
    axial, inplane = axial.reshape(omega.shape), inplane.reshape(omega.shape)
    return HubFlow(omega, axial, inplane, axis, downstream.reshape(hubs.shape), position, spin)


def rotor_forces(flow: HubFlow, thrust: Floats, drag: Floats) -> Floats:
    """Sum the rotors' forces on the vehicle [N], (..., n, 3), of loads (..., n, m) [N]."""
    along = np.einsum("...nm,mk->...nk", thrust, flow.axis)
    return along + np.einsum("...nm,nmk->...nk", drag, flow.downstream)


def hub_wrenches(flow: HubFlow, loads: Floats) -> tuple[Floats, Floats]:
    """Return each rotor's force [N] on the vehicle and moment about its hub [N m], (..., n, m, 3).

    The ``loads`` (L, ..., n, m) are in the order of ``LOADS``.  Both results are linear in them:
    derivatives of loads give derivatives of forces and moments.
    """
    from propmap import core

    size = flow.inplane.size
    rows = np.ascontiguousarray(loads).reshape(len(LOADS), math.prod(loads.shape[1:-2]), size)
    found = core.hub_wrenches(flow.axis, flow.spin, flow.downstream.reshape(-1, 3), rows)
    force, moment = (each.reshape(*loads.shape[1:], 3) for each in found)
    return force, moment


def rotor_wrench(flow: HubFlow, loads: Floats) -> tuple[Floats, Floats]:
    """Sum the rotors' forces [N] and their moments about the centre of mass [N m], (..., n, 3).

    ``flow`` and ``loads`` are those of ``hub_wrenches``.
    """
    force, moment = hub_wrenches(flow, loads)
    return force.sum(axis=-2), (moment + cross(flow.position, force)).sum(axis=-2)


# -------------------------------------------------------------------------------------------------
# The velocity of one rotor's wake, averaged over another's disk, for every way the wake may go.
#
# It depends on where the air carries the wake alone, so that a table over the two angles of that
# direction serves all flights of a vehicle.  The table is made from the vortex cylinder when it is
# first asked for, in some tenths of a second per pair of rotors that no other pair resembles.
# Cubic splines go through it, so that the velocity and its slope are continuous.

SKEWS, BEARINGS = 121, 96  # nodes of the table: from straight down to straight up, and around
TABLE_AZIMUTHS = 64
"""Around each ring.  With the core of the sheet the error on the wake's surface is below 1 %."""

RINGS, SPOKES = 4, 8  # nodes over a disk: Gauss's radii for equal areas, and angles
_BEYOND = 4  # bearings by which the table goes on past a full turn, so that splines close
_SKEW = np.linspace(0.0, np.pi, SKEWS)
_AROUND = 2.0 * np.pi * np.arange(BEARINGS) / BEARINGS


class SeenWake:
    """The wake of the rotor ``source`` as seen by the disk of ``target``, with one ``radius`` [m].

    ``towards`` is the bearing of the target in the source's frame [rad], from which those of the
    ``spline`` over skew and bearing [rad] count; similar pairs share one spline.  It is zero
    where a wake does not act: on a rotor above its own that this overlaps and, with
    ``slipstreams_alone``, on all that are not overlapped.
    """

    def __init__(
        self, source: Mount, target: Mount, radius: float, slipstreams_alone: bool = False
    ) -> None:
        frame = frame_of(source.axis)
        offset = frame @ (np.subtract(target.position, source.position) / radius)
        towards = float(np.arctan2(offset[1], offset[0])) if np.hypot(*offset[:2]) > 1e-9 else 0.0
        c, s = np.cos(towards), np.sin(towards)
        turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        self.towards = towards
        place, axis = turn @ offset, turn @ frame @ np.array(target.axis)
        # Equal but for rounding: one table for all such pairs.
        where = tuple(float(x) for x in np.round([*place, *axis], 9) + 0.0)
        depth = depth_below(source, target, radius)
        self.acts = depth > 0.0 or not (depth or slipstreams_alone)
        if self.acts and not depth:
            self.spline = _table(*where)
        else:
            below = (round(depth, 9), where[0], where[5]) if self.acts else (0.0, 0.0, 0.0)
            self.spline = _slipstream_table(*below)

    def at(self, direction: Floats, *, skewing: bool = False) -> Floats:
        """Return the velocity against the target's axis per density of circulation [-], (n,).

        The air carries the wake along ``direction`` (n, 3), of any length, in the source's frame.
        With ``skewing``, the derivative by the wake's angle from straight down instead [1/rad].
        """
        skew = np.arctan2(np.hypot(direction[:, 0], direction[:, 1]), -direction[:, 2])
        bearing = np.arctan2(direction[:, 1], direction[:, 0]) - self.towards
        found: Floats = self.spline.ev(skew, np.mod(bearing, 2.0 * np.pi), dx=int(skewing))
        return found


@functools.lru_cache(maxsize=1024)
def seen_wake(
    source: Mount, target: Mount, radius: float, slipstreams_alone: bool = False
) -> SeenWake:
    """Make each ``SeenWake`` once: a flight asks for it at every step."""
    return SeenWake(source, target, radius, slipstreams_alone)


@functools.lru_cache(maxsize=256)
def frame_of(axis: tuple[float, float, float]) -> Floats:
    """Return two directions in the disk and the ``axis`` as rows, right-handed; read-only."""
    z = np.array(axis)
    nearest = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    y = np.cross(z, nearest)
    y /= np.linalg.norm(y)
    frame = np.stack([np.cross(y, z), y, z])
    frame.flags.writeable = False
    return frame


@functools.lru_cache(maxsize=256)
def _table(x: float, y: float, z: float, along_x: float, along_y: float, along_z: float) -> Any:
    """Fit a spline over skew and bearing for a target at (x, y, z) radii with such an axis."""
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
    """Fit a spline to velocities (SKEWS, BEARINGS)."""
    from scipy.interpolate import RectBivariateSpline

    bearing = 2.0 * np.pi * np.arange(-_BEYOND, BEARINGS + _BEYOND + 1) / BEARINGS
    closed = np.concatenate([seen[:, -_BEYOND:], seen, seen[:, : _BEYOND + 1]], axis=1)
    return RectBivariateSpline(_SKEW, bearing, closed)


def _disk() -> tuple[Floats, Floats]:
    """Return points (S, 3) of a disk of radius one, and their weights, which sum to one."""
    node, weight = np.polynomial.legendre.leggauss(RINGS)
    radius = np.sqrt(0.5 * (node + 1.0))
    angle = 2.0 * np.pi * np.arange(SPOKES) / SPOKES
    # Each ring is turned against the next, so that no direction has more points than others.
    turned = angle + (np.pi / SPOKES) * (np.arange(RINGS) % 2)[:, None]
    flat = radius[:, None] * np.stack([np.cos(turned), np.sin(turned)])
    points = np.concatenate([flat, np.zeros((1, RINGS, SPOKES))]).reshape(3, -1).T
    return points, np.repeat(weight / (2.0 * SPOKES), SPOKES)


# -------------------------------------------------------------------------------------------------
# The slipstream of a rotor at the disk of one below that it overlaps, as of a coaxial pair.
#
# At the distance s radii along the wake the inflow v has grown to v (1 + s/sqrt(1 + s^2)), as on
# the axis of the vortex cylinder, and the slipstream has contracted so that as much air goes
# through it as through the disk.  Its area on the lower disk, times the velocity, over that disk is
# what the lower rotor meets: v in hover, at any depth, where it is wholly on the disk.  How much
# it contracts is taken from level flight with this skew; fast climb brings up to twice v.
#
# The upper rotor does not feel the lower one, as in the theory of coaxial rotors of Leishman and
# Ananthan; with that, equal thrusts in hover take 1.309 times the induced power of two separate
# rotors, where momentum theory has 1.281 for a lower rotor far below and 1.414 for one in the same
# plane, which no coaxial pair can be.  A third rotor below has the slipstreams of both.
#
# References
# ----------
# J. G. Leishman, S. Ananthan, "Aerodynamic Optimization of a Coaxial Proprotor", American
# Helicopter Society 62nd Annual Forum, 2006.
# J. G. Leishman, M. Syal, J. Am. Helicopter Soc. 53, 2008, doi 10.4050/JAHS.53.290.

IN_ONE_PLANE = 0.05
"""Height over radius up to which overlapping disks count as in one plane: not modelled."""

PARALLEL = 0.9  # least cosine between the axes of rotors that count as above each other


def depth_below(source: Mount, target: Mount, radius: float) -> float:
    """Return how far a rotor is below another that overlaps it, in radii; negative: above.

    It is 0 where they do not overlap as seen along the axis of the ``source``, where their axes
    are not parallel, and where they are in one plane.
    """
    frame = frame_of(source.axis)
    x, y, height = frame @ (np.subtract(target.position, source.position) / radius)
    separate = np.hypot(x, y) >= 2.0 - 1e-9 or abs(height) < IN_ONE_PLANE
    return 0.0 if separate or np.dot(source.axis, target.axis) < PARALLEL else float(-height)


def above_each_other(vehicle: Vehicle) -> NDArray[np.bool_]:
    """Say which rotors of a ``vehicle`` are above or below one another and overlap, (m, m)."""
    return _above_each_other(vehicle.mounts, vehicle.propeller.radius)


@functools.lru_cache(maxsize=64)
def _above_each_other(mounts: tuple[Mount, ...], radius: float) -> NDArray[np.bool_]:
    depths = [[depth_below(source, target, radius) for source in mounts] for target in mounts]
    found: NDArray[np.bool_] = np.array(depths) != 0.0
    found.flags.writeable = False
    return found


def downwash_gains(vehicle: Vehicle, wakes: Wakes) -> Floats:
    """Return the gain of the downwash at each rotor by each (m, m): 1 in slipstreams."""
    return np.where(above_each_other(vehicle), 1.0, wakes.downwash)


def slipstream(depth: float, aside: float, skew: Floats, bearing: Floats) -> Floats:
    """Return the velocity in a contracted slipstream, averaged over a disk below its rotor.

    Parameters
    ----------
    depth, aside : float
        Where the disk is, in radii.
    skew, bearing : ndarray, shape (...)
        Skew of the wake from straight down, up to pi / 2, and bearing of the disk from it [rad].

    Returns
    -------
    ndarray, shape (...)
        Per density of circulation, as in ``axial_velocity`` [-]: 1/2 on the axis, with no skew.
    """
    tangent = np.tan(np.minimum(skew, 0.5 * np.pi - 1e-6))
    path = depth * np.hypot(1.0, tangent)
    grown = 1.0 + path / np.hypot(1.0, path)
    radius = np.sqrt(np.hypot(1.0, tangent) / np.hypot(grown, tangent))
    off = np.hypot(depth * tangent * np.cos(bearing) - aside, depth * tangent * np.sin(bearing))
    # The area that circles of this radius and of 1 have in common, by their sectors.
    off = np.clip(off, 1.0 - radius + 1e-12, 1.0 + radius)
    inner = np.arccos(np.clip((off**2 + radius**2 - 1.0) / (2.0 * off * radius), -1.0, 1.0))
    outer = np.arccos(np.clip((off**2 + 1.0 - radius**2) / (2.0 * off), -1.0, 1.0))
    share = (radius**2 * inner + outer - off * np.sin(outer)) / np.pi
    return np.asarray(0.5 * grown * share)


@functools.lru_cache(maxsize=256)
def _slipstream_table(depth: float, aside: float, along: float) -> Any:
    """Fit a spline to a ``slipstream``; ``along`` is the cosine between the axes."""
    falls = along * (np.cos(_SKEW) > 0.0)[:, None]
    return _spline(falls * slipstream(depth, aside, _SKEW[:, None], _AROUND))


# -------------------------------------------------------------------------------------------------
# The velocity about a rotor's wake: a semi-infinite skewed cylinder of vortex rings.
#
# The rings are parallel to the disk and lie along the direction in which the air carries the wake
# away.  The Biot-Savart integral along that direction has a closed form; what is left is one
# integral around a ring, here by equally spaced azimuths, which converge geometrically away from
# the wake's surface.  With x in radii, a = x - e_r, d the unit direction of the wake, c = |a| and
# b = a . d,
#
#     w = 1/(4 pi) Int [e_t x a / (c (c - b)) - e_t x d / (c - b)] . z dpsi
#
# is the velocity along z per density of circulation along the wake.  At the disk's centre it is 1/2
# for every skew, which is why a wake of density 2 v carries the inflow v of Glauert's eq. (10).
#
# References
# ----------
# W. Castles, J. H. De Leeuw, "The Normal Component of the Induced Velocity in the Vicinity of a
# Lifting Rotor and Some Examples of Its Application", NACA Report 1184, 1954.
# E. Branlard, M. Gaunaa, "Cylindrical Vortex Wake Model: Skewed Cylinder, Application to Yawed or
# Tilted Rotors", Wind Energy 19, 2016, doi 10.1002/we.1838.

CYLINDER_AZIMUTHS = 32
"""Nodes around a ring.  With ``CORE`` the error is below 1 % of the inflow outside the wake's
surface and some per cent on it."""

CORE = 0.05
"""Radius of the core of the vortex sheet, over the rotor's radius [-]: it spreads the jump of the
velocity across the wake's surface, so that the velocity is smooth where a wake sweeps over a
rotor."""


def axial_velocity(
    place: Floats, direction: Floats, *, core: float = CORE, azimuths: int = CYLINDER_AZIMUTHS
) -> Floats:
    """Return the downward velocity by a rotor's wake, per density of circulation along it.

    Parameters
    ----------
    place : ndarray, shape (..., 3)
        Where, in radii from the rotor's centre, in a frame with z along its thrust [-].
    direction : ndarray, shape (..., 3)
        Unit vector along which the air carries the wake away [-].
    core : float
        Radius of the sheet's core, in radii of the rotor [-].
    azimuths : int
        Nodes around a ring.

    Returns
    -------
    ndarray, shape (...)
        Velocity against z [-], positive inside the wake of a rotor that thrusts along z, where it
        goes to 1 far below a rotor in axial flow.
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
    # Rings that push air down turn the other way: the sign of both terms is that of -z.
    total: Floats = np.mean((ring / distance - wake) / beside, axis=-1)
    return 0.5 * total


def cross(one: Floats, other: Floats) -> Floats:
    """Return cross products (..., 3) of vectors (..., 3), to the bits of ``np.cross``.

    That spends ten times as long on its axes as on the products of a few rotors.
    """
    (a, b, c), (x, y, z) = ((v[..., 0], v[..., 1], v[..., 2]) for v in (one, other))
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=-1)
