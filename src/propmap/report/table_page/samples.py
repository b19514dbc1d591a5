"""A table asked for what its page shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.fit.residuals import rms
from propmap.loads import LOADS
from propmap.table.lookup import NO_VALUE, OK, STATUSES, UNRESOLVED, VORTEX_RING
from propmap.table.query import LoadTable

RPM = 30.0 / np.pi
POINTS = 32_768
"""Of the envelope, on which shares are counted."""

SEED = 2017
SPEEDS, ANGLES = 121, 91
CURVES = (0.0, 45.0, 90.0, 135.0, 180.0)
"""Angles of the curves [deg], where the envelope has them."""

MARKED = (OK, VORTEX_RING, UNRESOLVED, NO_VALUE)

FLOWS = (
    ("climb and fast cruise", 0.0, 60.0),
    ("level flight", 60.0, 100.0),
    ("descent", 100.0, 181.0),
)
"""Parts of the envelope by angle [deg]."""

BANDS = 5
"""Of the speeds, in which the hover model is judged."""

OFF = (0.05, 0.1)
"""Shares of the static thrust by which the hover model is said to be off."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Loads over speed at one angle: by load (n,), and the codes of the points (n,)."""

    beta: float
    loads: dict[str, Floats]
    code: NDArray[np.uint8]


@dataclass(frozen=True)
class HoverErrors:
    """The hover model less the table in a band of speed [m/s], as shares of the static load.

    thrust_rms, torque_rms : root mean squares.  drag_rms : of the drag, over static thrust.
    off : share of the points where thrust is off by more than each of ``OFF``.
    """

    speed: tuple[float, float]
    points: int
    thrust_rms: float
    torque_rms: float
    drag_rms: float
    off: tuple[float, ...]


@dataclass(frozen=True)
class AngleShares:
    """Shares of a part of the envelope, by status.  beta : its ends [deg]."""

    name: str
    beta: tuple[float, float]
    shares: dict[str, float]


@dataclass(frozen=True, eq=False)
class TableSamples:
    """What is drawn and counted.

    omega : of the curves and maps [rad/s], the geometric middle of the envelope.
    speed (n,) [m/s], beta (m,) [rad] : of the maps.  maps : by load, (n, m).
    code : of the maps (n, m).  curves : see there.
    shares : of the envelope, by the words of ``MARKED``.  by_angle : the same of its parts.
    k_thrust, k_torque : the hover model's constants, from the table at rest; NaN where the
    envelope has no rest.  hover : by band of speed; empty where there are no constants.
    """

    omega: float
    speed: Floats
    beta: Floats
    maps: dict[str, Floats]
    code: NDArray[np.uint8]
    curves: Sequence[Curve]
    shares: dict[str, float]
    by_angle: Sequence[AngleShares]
    k_thrust: float
    k_torque: float
    hover: Sequence[HoverErrors]


def sample(table: LoadTable) -> TableSamples:
    """Curves, maps and counts of a table."""
    (w0, w1), (v0, v1), (b0, b1) = table.envelope.values()
    omega = float(np.sqrt(w0 * w1))
    speed, beta = np.linspace(v0, v1, SPEEDS), np.linspace(b0, b1, ANGLES)
    found = table.loads(omega, speed[:, None], beta)
    still: Any = table.loads(omega, 0.0, b0)
    k_thrust, k_torque = still.thrust / omega**2, still.torque / omega**2
    points = _points(table)
    everywhere = table.loads(*points)
    known = np.isfinite([k_thrust, k_torque]).all() and k_thrust > 0.0 and k_torque > 0.0
    return TableSamples(
        omega=omega,
        speed=speed,
        beta=beta,
        maps={name: getattr(found, name) for name in LOADS},
        code=np.asarray(found.code),
        curves=[_curve(table, omega, speed, angle) for angle in _angles(b0, b1)],
        shares=_shares(everywhere.code),
        by_angle=_by_angle(points[2], everywhere.code),
        k_thrust=k_thrust,
        k_torque=k_torque,
        hover=_hover(points, everywhere, (k_thrust, k_torque), (v0, v1)) if known else [],
    )


def _points(table: LoadTable) -> tuple[Floats, Floats, Floats]:
    """omega, speed, beta, spread evenly over the envelope; (n,) each."""
    # Without SciPy, which a table's user need not have: Kronecker's sequence.
    steps = 1.0 / 1.220744084605759 ** np.arange(1, 4)
    unit = (0.5 + np.arange(1, POINTS + 1)[:, None] * steps) % 1.0
    low, high = np.array(list(table.envelope.values())).T
    omega, speed, beta = (low + (high - low) * unit).T
    return omega, speed, beta


def _angles(low: float, high: float) -> list[float]:
    inside = [a for a in np.radians(CURVES) if low - 1e-9 <= a <= high + 1e-9]
    far = [end for end in (low, high) if all(abs(end - a) > np.radians(10.0) for a in inside)]
    return sorted(float(a) for a in (*inside, *far))


def _curve(table: LoadTable, omega: float, speed: Floats, beta: float) -> Curve:
    found = table.loads(omega, speed, beta)
    return Curve(beta, {name: getattr(found, name) for name in LOADS}, np.asarray(found.code))


def _shares(code: NDArray[np.uint8]) -> dict[str, float]:
    return {STATUSES[k]: float(np.mean(code == k)) for k in MARKED}


def _by_angle(beta: Floats, code: NDArray[np.uint8]) -> list[AngleShares]:
    degrees, told = np.degrees(beta), []
    for name, low, high in FLOWS:
        mine = (degrees >= low) & (degrees < high)
        if mine.any():
            ends = (max(low, degrees.min()), min(high, degrees.max()))
            told.append(AngleShares(name, (float(ends[0]), float(ends[1])), _shares(code[mine])))
    return told


def _hover(
    points: tuple[Floats, Floats, Floats],
    found: Any,
    constants: tuple[float, float],
    fastest: tuple[float, float],
) -> list[HoverErrors]:
    omega, speed, _ = points
    thrust, torque = (k * omega**2 for k in constants)
    off = (thrust - found.thrust) / thrust
    turning = (torque - found.torque) / torque
    drag = found.drag / thrust
    edges = np.linspace(*fastest, BANDS + 1)
    told = []
    for k in range(BANDS):
        mine = (speed >= edges[k]) & (speed <= edges[k + 1]) & np.isfinite(off)
        if mine.any():
            told.append(
                HoverErrors(
                    speed=(float(edges[k]), float(edges[k + 1])),
                    points=int(mine.sum()),
                    thrust_rms=rms(off[mine]),
                    torque_rms=rms(turning[mine]),
                    drag_rms=rms(drag[mine]),
                    off=tuple(float(np.mean(np.abs(off[mine]) > limit)) for limit in OFF),
                )
            )
    return told
