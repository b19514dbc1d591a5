"""The rotors' wakes on each other: what they add to the axial flow at each other's disks.

Each rotor's wake is a skewed vortex cylinder (``vehicle.vortex_cylinder``) that carries twice the
inflow of Glauert's momentum theory (10).  Its velocity along the axis of each other rotor, averaged
over that disk, times a gain, adds to V cos(beta) there.  The gains stand for what the cylinder
leaves out, as rolled-up tip vortices and the wake's contraction; they are one where the cylinder
is right.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from propmap.errors import InputError
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.vehicle.hub_flow import HubFlow
from propmap.vehicle.wake_table import frame_of, seen_wake

if TYPE_CHECKING:
    from propmap.model.model import Model
    from propmap.vehicle.vehicle import Vehicle, Wakes

LARGEST_INFLOW = 2.0
"""Inflow over that of the same thrust in hover [-], at most: about what is measured in the vortex
ring, where momentum theory has no solution."""

UPWASH = 0.005
"""Of the density of circulation [-]: the upwash at which the gain is all that of upwash."""

LARGEST_UPWASH = 0.5
"""Upwash per density of circulation, gain included [-], at most: a wake then moves the air by the
inflow of its rotor, as a cylinder does at its own surface, the fastest there is outside."""

SLOW = 0.5
"""In-plane velocity [m/s] about which ahead and beside begin to differ."""

STEPS = 40
"""Of Newton's method, which is monotone from above."""


@dataclass(frozen=True, eq=False)
class WakeFlow:
    """What the wakes add to the axial velocity at each of m rotors, n samples.

    Attributes
    ----------
    added : ndarray, shape (n, m)
        To V cos(beta) [m/s], gains included; positive is downwash.
    by_gain : mapping of str to ndarray, shape (n, m)
        Its derivatives by the fields of ``Wakes`` [m/s].
    by_thrust : ndarray, shape (n, m, m)
        Its derivatives by the thrust of each rotor, the last axis [m/s/N].
    """

    added: Floats
    by_gain: dict[str, Floats]
    by_thrust: Floats


def glauert_inflow(
    thrust: Floats, axial: Floats, inplane: Floats, disk: float
) -> tuple[Floats, Floats]:
    """Uniform inflow of eq. (10) for a whole disk: T = 2 rho A v sqrt(V_in^2 + (V_ax + v)^2).

    Of several solutions, in descent, it is the largest, but no more than ``LARGEST_INFLOW``.

    Parameters
    ----------
    thrust, axial, inplane : ndarray, shape (...)
        T [N], V cos(beta) and V sin(beta) [m/s].
    disk : float
        rho A, density times area of the disk [kg/m].

    Returns
    -------
    tuple of ndarray, shape (...)
        v [m/s]; 0 without thrust, NaN where an argument is; and its derivative by T [m/s/N].
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
    """The flow at rotors in each other's wakes, of which each comes with attached thrust.

    Parameters
    ----------
    vehicle, wakes : Vehicle, Wakes
        Where its m rotors are, and how they act on each other.
    model : Model
        Of its rotors.
    flow : HubFlow
        Of n samples without the wakes.

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
    """What the wakes of all other rotors add to V cos(beta) at each [m/s], (n, m).

    ``vehicle``, ``wakes``, ``flow`` and ``thrust`` are those of ``wake_flow``, which gives the
    derivatives as well and takes twice the time.
    """
    inflow, _ = _inflow(vehicle, flow, thrust)
    seen, _ = _seen(vehicle, flow, inflow, wakes.share)
    along = _along(vehicle, flow.velocity)
    upwash = wakes.beside + (wakes.ahead - wakes.beside) * along
    rising, _ = _rising(seen)
    gained = wakes.downwash * (seen - rising) + _limited(upwash * rising)[0]
    found: Floats = np.sum(2.0 * inflow[:, None, :] * gained, axis=2)
    return found


def wake_flow(vehicle: Vehicle, wakes: Wakes, flow: HubFlow, thrust: Floats) -> WakeFlow:
    """What the wakes of all other rotors add to the axial flow at each, and its derivatives.

    Parameters
    ----------
    vehicle : Vehicle
        Where its m rotors are.
    wakes : Wakes
        Gains, and the share of its inflow that skews a wake.
    flow : HubFlow
        Of n samples.
    thrust : ndarray, shape (n, m)
        Of each rotor [N], without its neighbours.
    """
    inflow, by_thrust = _inflow(vehicle, flow, thrust)
    seen, by_share = _seen(vehicle, flow, inflow, wakes.share, slope=True)
    rising, slope = _rising(seen)
    along = _along(vehicle, flow.velocity)
    upwash = wakes.beside + (wakes.ahead - wakes.beside) * along
    lifted, share = _limited(upwash * rising)
    gained = wakes.downwash * (seen - rising) + lifted
    steeper = wakes.downwash * (1.0 - slope) + share * upwash * slope
    twice = 2.0 * inflow[:, None, :]
    # A wake goes as 2 v K(share v): its strength and its direction change with the inflow.
    by_inflow = 2.0 * (gained + wakes.share * steeper * by_share)
    return WakeFlow(
        added=np.sum(twice * gained, axis=2),
        by_gain={
            "ahead": np.sum(twice * along * share * rising, axis=2),
            "beside": np.sum(twice * (1.0 - along) * share * rising, axis=2),
            "downwash": np.sum(twice * (seen - rising), axis=2),
            "share": np.sum(twice * steeper * by_share, axis=2),
        },
        by_thrust=by_inflow * by_thrust[:, None, :],
    )


def _inflow(vehicle: Vehicle, flow: HubFlow, thrust: Floats) -> tuple[Floats, Floats]:
    """``glauert_inflow`` at each rotor."""
    disk = vehicle.air.density * np.pi * vehicle.propeller.radius**2
    return glauert_inflow(thrust, flow.axial, flow.inplane, disk)


def _rising(seen: Floats) -> tuple[Floats, Floats]:
    """The part of the velocities that is upwash, and its derivative by them; both continuous."""
    share = np.clip(-seen / UPWASH, 0.0, 1.0)
    return seen * share**2 * (3.0 - 2.0 * share), share**2 * (9.0 - 8.0 * share)


def _limited(upwash: Floats) -> tuple[Floats, Floats]:
    """Upwash per density of circulation with its gain, no more than ``LARGEST_UPWASH``, and what a
    little more adds to it [-]."""
    relative = np.tanh(upwash / LARGEST_UPWASH)
    return LARGEST_UPWASH * relative, 1.0 - relative**2


def _along(vehicle: Vehicle, velocity: Floats) -> Floats:
    """How far a target is along the flight of a source and not beside it (n, target, source) [-].

    This is the squared cosine between the source's in-plane velocity and the direction to the
    target in the source's disk plane; it fades to 0 as the velocity does, where there is neither.
    """
    position = np.array([mount.position for mount in vehicle.mounts])
    axis = np.array([mount.axis for mount in vehicle.mounts])
    apart = position[:, None] - position[None]
    apart = apart - np.sum(apart * axis, axis=-1, keepdims=True) * axis
    length = np.linalg.norm(apart, axis=-1)
    unit = apart / np.where(length > 1e-9, length, 1.0)[..., None]
    speed2 = np.sum(np.square(np.cross(velocity, axis)), axis=-1)
    return np.einsum("nsk,tsk->nts", velocity, unit) ** 2 / (speed2 + SLOW**2)[:, None, :]


def _seen(
    vehicle: Vehicle, flow: HubFlow, inflow: Floats, share: float, *, slope: bool = False
) -> tuple[Floats, Floats]:
    """Downward velocity at each rotor by the wake of each, per density of its circulation [-].

    (n, target, source).  With ``slope``, also its derivative by the share of the inflow that skews
    a wake, else zeros.
    """
    mounts, radius = vehicle.mounts, vehicle.propeller.radius
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
            if target != source:
                wake = seen_wake(mount, other, radius)
                found[:, target, source] = wake.at(away)
                if slope:
                    by_share[:, target, source] = wake.at(away, skewing=True) * straighter
    return found, by_share


def check_apart(vehicle: Vehicle) -> None:
    """Raise ``InputError`` where two rotors of a ``vehicle`` with wakes are in one place."""
    for k, mount in enumerate(vehicle.mounts):
        for j, other in enumerate(vehicle.mounts[:k]):
            apart = float(np.linalg.norm(np.subtract(mount.position, other.position)))
            if apart < 0.05 * vehicle.propeller.radius:
                raise InputError(
                    f"rotors {j + 1} and {k + 1} are {apart:g} m apart",
                    "give each hub its own position, or remove [wakes]",
                )
