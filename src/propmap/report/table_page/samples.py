"""A table asked for what its page shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.table.content import LOADS
from propmap.table.lookup import NO_VALUE, OK, UNRESOLVED, VORTEX_RING
from propmap.table.query import LoadTable

Floats = NDArray[np.float64]

RPM = 30.0 / np.pi
POINTS = 32_768
"""Of the envelope, on which shares are counted."""

SEED = 2017
SPEEDS, ANGLES = 121, 91
CURVES = (0.0, 45.0, 90.0, 135.0, 180.0)
"""Angles of the curves [deg], where the envelope has them."""

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


@dataclass(frozen=True, eq=False)
class TableSamples:
    """What is drawn and counted.

    omega : of the curves and maps [rad/s], the geometric middle of the envelope.
    speed (n,) [m/s], beta (m,) [rad] : of the maps.  maps : by load, (n, m).
    code : of the maps (n, m).  curves : see there.
    shares : of the envelope, by "ok", "vortex_ring", "unresolved", "no_value".
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
        shares={
            name: float(np.mean(everywhere.code == code))
            for name, code in (
                ("ok", OK),
                ("vortex_ring", VORTEX_RING),
                ("unresolved", UNRESOLVED),
                ("no_value", NO_VALUE),
            )
        },
        k_thrust=k_thrust,
        k_torque=k_torque,
        hover=_hover(points, everywhere, (k_thrust, k_torque)) if known else [],
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


def _hover(
    points: tuple[Floats, Floats, Floats], found: Any, constants: tuple[float, float]
) -> list[HoverErrors]:
    omega, speed, _ = points
    thrust, torque = (k * omega**2 for k in constants)
    off = (thrust - found.thrust) / thrust
    turning = (torque - found.torque) / torque
    drag = found.drag / thrust
    edges = np.linspace(speed.min(), speed.max(), BANDS + 1)
    told = []
    for k in range(BANDS):
        mine = (speed >= edges[k]) & (speed <= edges[k + 1]) & np.isfinite(off)
        if mine.any():
            told.append(
                HoverErrors(
                    (float(edges[k]), float(edges[k + 1])),
                    int(mine.sum()),
                    *(float(np.sqrt(np.mean(e[mine] ** 2))) for e in (off, turning, drag)),
                    tuple(float(np.mean(np.abs(off[mine]) > limit)) for limit in OFF),
                )
            )
    return told
