"""The velocity of one rotor's wake, averaged over another's disk, for every way the wake may go.

It depends on where the air carries the wake alone, so that a table over the two angles of that
direction serves all flights of a vehicle.  The table is made from ``vehicle.vortex_cylinder`` when
it is first asked for, in some tenths of a second per pair of rotors that no other pair resembles.
Cubic splines go through it, so that the velocity and its slope are continuous.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from propmap.typing import Floats
from propmap.vehicle.vortex_cylinder import axial_velocity

if TYPE_CHECKING:
    from propmap.vehicle.vehicle import Mount

SKEWS, BEARINGS = 121, 96
"""Of the table: from straight down to straight up, and around."""

AZIMUTHS = 64
"""Around each ring.  With the core of the sheet the error on the wake's surface is below 1 %."""

RINGS, SPOKES = 4, 8
"""Of the disk that is averaged: Gauss's radii for equal areas, and angles."""

_BEYOND = 4
"""Bearings by which the table goes on past a full turn, so that splines close."""


class SeenWake:
    """The wake of one rotor as seen by the disk of another.

    Parameters
    ----------
    source, target : Mount
        Whose wake it is, and who is in it.
    radius : float
        Of their propellers [m].

    Attributes
    ----------
    towards : float
        Bearing of the target in the source's frame [rad]; those of ``spline`` count from it.
    spline : RectBivariateSpline
        Over skew and bearing [rad]; the same object for pairs that are alike.
    """

    def __init__(self, source: Mount, target: Mount, radius: float) -> None:
        frame = frame_of(source.axis)
        apart = frame @ (np.subtract(target.position, source.position) / radius)
        towards = float(np.arctan2(apart[1], apart[0])) if np.hypot(*apart[:2]) > 1e-9 else 0.0
        turn = np.array(
            [
                [np.cos(towards), np.sin(towards), 0.0],
                [-np.sin(towards), np.cos(towards), 0.0],
                [0.0, 0.0, 1.0],
            ]
        )
        self.towards = towards
        place, axis = turn @ apart, turn @ frame @ np.array(target.axis)
        # Equal but for rounding: one table for all pairs that are alike.
        self.spline = _table(*(float(x) for x in np.round([*place, *axis], 9) + 0.0))

    def at(self, direction: Floats, *, skewing: bool = False) -> Floats:
        """Velocity against the target's axis per density of circulation [-], (n,).

        Parameters
        ----------
        direction : ndarray, shape (n, 3)
            Along which the air carries the wake away, of any length, in the source's frame.
        skewing : bool
            Whether to give the derivative by the wake's angle from straight down [1/rad] instead.
        """
        skew = np.arctan2(np.hypot(direction[:, 0], direction[:, 1]), -direction[:, 2])
        bearing = np.arctan2(direction[:, 1], direction[:, 0]) - self.towards
        found: Floats = self.spline.ev(skew, np.mod(bearing, 2.0 * np.pi), dx=int(skewing))
        return found


@functools.lru_cache(maxsize=1024)
def seen_wake(source: Mount, target: Mount, radius: float) -> SeenWake:
    """``SeenWake`` of the same arguments, made once: a flight asks for it at every step."""
    return SeenWake(source, target, radius)


@functools.lru_cache(maxsize=256)
def frame_of(axis: tuple[float, float, float]) -> Floats:
    """Rows: two directions in the disk and the ``axis``, right-handed; (3, 3), read-only."""
    z = np.array(axis)
    nearest = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    y = np.cross(z, nearest)
    y /= np.linalg.norm(y)
    frame = np.stack([np.cross(y, z), y, z])
    frame.flags.writeable = False
    return frame


@functools.lru_cache(maxsize=256)
def _table(x: float, y: float, z: float, along_x: float, along_y: float, along_z: float) -> Any:
    """Spline over skew and bearing for a target at (x, y, z) radii with such an axis."""
    from scipy.interpolate import RectBivariateSpline

    rim, weights = _disk()
    axis = (along_x, along_y, along_z)
    points = np.array([x, y, z]) + rim @ frame_of(axis)
    skew = np.linspace(0.0, np.pi, SKEWS)
    bearing = 2.0 * np.pi * np.arange(-_BEYOND, BEARINGS + _BEYOND + 1) / BEARINGS
    seen = np.empty((SKEWS, BEARINGS))
    around = bearing[_BEYOND : _BEYOND + BEARINGS]
    for row, chi in enumerate(skew):
        side = np.sin(chi) * np.stack([np.cos(around), np.sin(around), 0.0 * around], axis=1)
        way = side - [0.0, 0.0, np.cos(chi)]
        found = axial_velocity(points[None], way[:, None], azimuths=AZIMUTHS)
        seen[row] = along_z * (found @ weights)
    closed = np.concatenate([seen[:, -_BEYOND:], seen, seen[:, : _BEYOND + 1]], axis=1)
    return RectBivariateSpline(skew, bearing, closed)


def _disk() -> tuple[Floats, Floats]:
    """Points (S, 3) of a disk of radius one, and their weights, which sum to one."""
    node, weight = np.polynomial.legendre.leggauss(RINGS)
    radius = np.sqrt(0.5 * (node + 1.0))
    angle = 2.0 * np.pi * np.arange(SPOKES) / SPOKES
    # Each ring is turned against the next, so that no direction has more points than others.
    turned = angle + (np.pi / SPOKES) * (np.arange(RINGS) % 2)[:, None]
    flat = radius[:, None] * np.stack([np.cos(turned), np.sin(turned)])
    points = np.concatenate([flat, np.zeros((1, RINGS, SPOKES))]).reshape(3, -1).T
    return points, np.repeat(weight / (2.0 * SPOKES), SPOKES)
