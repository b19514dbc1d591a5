"""The rotors' wakes on each other as tables for exported code.

They are the splines of ``vehicle.wake_table``: coefficients over skew and bearing of a wake, and
the weights of four neighbouring ones as polynomials in each interval between the table's knots.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.typing import Floats
from propmap.vehicle.vehicle import Vehicle
from propmap.vehicle.wake_table import BEARINGS, SKEWS, SeenWake, frame_of


@dataclass(frozen=True, eq=False)
class SplineAxis:
    """The intervals of one axis of the splines, all of one width.

    Attributes
    ----------
    per_unit : float
        Intervals per radian.
    first : ndarray of int, shape (n,)
        The first of the four coefficients that count in each.
    kind : ndarray of int, shape (n,)
        Which polynomials are those of each; most intervals have the same.
    weights : ndarray, shape (K, 16)
        Four constant terms, four linear ones, and so on, of the place in the interval, 0 to 1.
    """

    per_unit: float
    first: NDArray[np.intp]
    kind: NDArray[np.intp]
    weights: Floats


@dataclass(frozen=True, eq=False)
class WakeGeometry:
    """Of the wakes of k rotors on each other.

    Attributes
    ----------
    frames : ndarray, shape (k, 3, 3)
        Rows: two directions in the disk, and the axis.
    kind : ndarray of int, shape (k, k)
        Of each target and source: which of the K kinds of pairs they are.
    bearing : ndarray, shape (k, k)
        Of the target in the source's frame [rad].
    towards : ndarray, shape (k, k, 3)
        Unit vector from the source to the target in the plane of the source's disk.
    coefficients : ndarray of float32, shape (K, a, b)
        Of the splines.
    skew, around : SplineAxis
        Their axes: from straight down to straight up, and around.
    """

    frames: Floats
    kind: NDArray[np.intp]
    bearing: Floats
    towards: Floats
    coefficients: NDArray[np.float32]
    skew: SplineAxis
    around: SplineAxis


def wake_geometry(vehicle: Vehicle) -> WakeGeometry:
    """The tables of the rotors of a ``vehicle``, two or more."""
    mounts, radius = vehicle.mounts, vehicle.propeller.radius
    k = len(mounts)
    frames = np.stack([frame_of(mount.axis) for mount in mounts])
    kind, bearing, towards = np.zeros((k, k), int), np.zeros((k, k)), np.zeros((k, k, 3))
    splines: list[object] = []
    for t, target in enumerate(mounts):
        for s, source in enumerate(mounts):
            if t == s:
                continue
            seen = SeenWake(source, target, radius)
            # Pairs that are alike share a spline.
            same = [n for n, spline in enumerate(splines) if spline is seen.spline]
            if not same:
                splines.append(seen.spline)
            kind[t, s] = same[0] if same else len(splines) - 1
            bearing[t, s] = seen.towards
            apart = np.subtract(target.position, source.position)
            beside = apart - (apart @ frames[s, 2]) * frames[s, 2]
            length = np.linalg.norm(beside)
            towards[t, s] = beside / (length if length > 1e-9 else 1.0)
    knots = splines[0].tck[:2]  # type: ignore[attr-defined]
    skew = _axis(knots[0], np.linspace(0.0, np.pi, SKEWS))
    around = _axis(knots[1], np.linspace(0.0, 2.0 * np.pi, BEARINGS + 1))
    used = slice(around.first[0], around.first[-1] + 4)
    tables = [
        spline.get_coeffs().reshape(len(knots[0]) - 4, -1)[:, used]  # type: ignore[attr-defined]
        for spline in splines
    ]
    around.first[:] -= used.start
    return WakeGeometry(
        frames, kind, bearing, towards, np.stack(tables).astype(np.float32), skew, around
    )


def _axis(knots: Floats, breaks: Floats) -> SplineAxis:
    """Of cubic splines with these ``knots``, the intervals between ``breaks``."""
    from scipy.interpolate import BSpline

    inside = np.linspace(0.1, 0.9, 4)
    to_powers = np.linalg.inv(np.vander(inside, increasing=True))
    every, first = [], []
    for low, high in itertools.pairwise(breaks):
        span = int(np.searchsorted(knots, 0.5 * (low + high), side="right")) - 4
        at = low + inside * (high - low)
        four = [BSpline.basis_element(knots[j : j + 5])(at) for j in range(span, span + 4)]
        every.append((to_powers @ np.stack(four, axis=1)).ravel())
        first.append(span)
    rounded = np.round(np.array(every), 9) + 0.0
    _, where, kind = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    per_unit = 1.0 / float(breaks[1] - breaks[0])
    return SplineAxis(per_unit, np.array(first), kind.ravel(), np.array(every)[where])
