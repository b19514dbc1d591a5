"""The rotors' wakes on each other: what they add to the axial flow at each other's disks.

Each rotor's wake is a skewed vortex cylinder (``physics.vortex_cylinder``) that carries twice the
inflow of Glauert's momentum theory (10).  Its velocity along the axis of each other rotor, averaged
over that disk, times a gain, adds to V cos(beta) there.  The gains stand for what the cylinder
leaves out, as rolled-up tip vortices and the wake's contraction; they are one where the cylinder
is right.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from propmap.arrays.types import Floats
from propmap.errors import InputError
from propmap.physics.vortex_cylinder import axial_velocity
from propmap.vehicle.hub_flow import HubFlow

if TYPE_CHECKING:
    from propmap.vehicle.vehicle import Vehicle, Wakes

DISK_RADII = np.concatenate([[0.0], np.full(6, np.sqrt(2.0 / 3.0))])
DISK_ANGLES = np.concatenate([[0.0], np.arange(6) * np.pi / 3.0])
DISK_WEIGHTS = np.concatenate([[0.25], np.full(6, 0.125)])
"""Seven points that average polynomials of the fifth degree over a disk exactly: A. H. Stroud,
Approximate Calculation of Multiple Integrals, 1971, formula S2 5-1."""

LARGEST_INFLOW = 2.0
"""Inflow over that of the same thrust in hover [-], at most: about what is measured in the vortex
ring, where momentum theory has no solution."""

SLOW = 0.5
"""In-plane velocity [m/s] about which ahead and beside begin to differ."""

SHARE_STEP = 1e-3
"""Of the difference quotient by the share of the inflow that skews a wake."""

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

    @property
    def known(self) -> Floats:
        """``added``, and 0 where it is not known for want of a rotor's loads."""
        return np.nan_to_num(self.added)


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


def wake_flow(vehicle: Vehicle, wakes: Wakes, flow: HubFlow, thrust: Floats) -> WakeFlow:
    """What the wakes of all other rotors add to the axial flow at each.

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
    radius = vehicle.propeller.radius
    disk = vehicle.air.density * np.pi * radius**2
    inflow, by_thrust = glauert_inflow(thrust, flow.axial, flow.inplane, disk)
    velocity = flow.velocity
    one = _velocities(vehicle, velocity, inflow, wakes.share)
    less, more = (
        _velocities(vehicle, velocity, inflow, wakes.share + step)
        for step in (-SHARE_STEP, SHARE_STEP)
    )
    by_share = (more - less) / (2.0 * SHARE_STEP)
    along = _along(vehicle, velocity)
    gain, rising = _gains(wakes, one, along), np.where(one < 0.0, one, 0.0)
    # A wake goes as 2 v K(share v): its strength and its direction change with the inflow.
    tiny = np.maximum(inflow, 1e-9)[:, None, :]
    by_inflow = (one + wakes.share * by_share) / tiny
    return WakeFlow(
        added=np.sum(gain * one, axis=2),
        by_gain={
            "ahead": np.sum(along * rising, axis=2),
            "beside": np.sum((1.0 - along) * rising, axis=2),
            "downwash": np.sum(one - rising, axis=2),
            "share": np.sum(gain * by_share, axis=2),
        },
        by_thrust=gain * by_inflow * by_thrust[:, None, :],
    )


def added_flow(vehicle: Vehicle, wakes: Wakes, flow: HubFlow, thrust: Floats) -> Floats:
    """``WakeFlow.added`` alone, in a third of the time.

    Parameters
    ----------
    vehicle, wakes, flow, thrust : Vehicle, Wakes, HubFlow, ndarray
        As for ``wake_flow``.

    Returns
    -------
    ndarray, shape (n, m)
        To V cos(beta) [m/s], gains included.
    """
    disk = vehicle.air.density * np.pi * vehicle.propeller.radius**2
    inflow, _ = glauert_inflow(thrust, flow.axial, flow.inplane, disk)
    velocity = flow.velocity
    one = _velocities(vehicle, velocity, inflow, wakes.share)
    return np.asarray(np.sum(_gains(wakes, one, _along(vehicle, velocity)) * one, axis=2))


def _gains(wakes: Wakes, one: Floats, along: Floats) -> Floats:
    """Gains on the velocities ``one`` (n, target, source) [-]; ``along`` is that of ``_along``."""
    upwash = wakes.beside + (wakes.ahead - wakes.beside) * along
    return np.where(one < 0.0, upwash, wakes.downwash)


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


def _velocities(vehicle: Vehicle, velocity: Floats, inflow: Floats, share: float) -> Floats:
    """Downward velocity at each rotor by the wake of each (n, target, source) [m/s]."""
    radius, mounts = vehicle.propeller.radius, vehicle.mounts
    frames = [disk_frame(mount.axis) for mount in mounts]
    rim = DISK_RADII * np.stack([np.cos(DISK_ANGLES), np.sin(DISK_ANGLES), 0.0 * DISK_ANGLES])
    found = np.zeros((inflow.shape[0], len(mounts), len(mounts)))
    for source, mount in enumerate(mounts):
        # The air carries a wake against the hub's velocity and down its own axis.
        away = -velocity[:, source] @ frames[source].T
        away[:, 2] -= share * inflow[:, source]
        length = np.linalg.norm(away, axis=1, keepdims=True)
        still = length < 1e-9
        away = np.where(still, [0.0, 0.0, -1.0], away / np.where(still, 1.0, length))
        for target, other in enumerate(mounts):
            if target != source:
                apart = (np.array(other.position) - np.array(mount.position)) / radius
                place = (apart + rim.T @ frames[target]) @ frames[source].T
                seen = axial_velocity(place[None], away[:, None, :]) @ DISK_WEIGHTS
                tilt = float(np.dot(mount.axis, other.axis))
                found[:, target, source] = 2.0 * inflow[:, source] * tilt * seen
    return found


def disk_frame(axis: tuple[float, float, float]) -> Floats:
    """Rows: two directions in the disk and its ``axis``, right-handed; (3, 3)."""
    z = np.array(axis)
    nearest = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    y = np.cross(z, nearest)
    y /= np.linalg.norm(y)
    return np.stack([np.cross(y, z), y, z])


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
