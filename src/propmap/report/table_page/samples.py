"""A table asked for what its page shows."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.export.files import evenly
from propmap.fit.residuals import rms
from propmap.loads import LOADS
from propmap.report.page import number
from propmap.report.style import RPM
from propmap.table.interpolation import NO_VALUE, OK, STATUSES, UNRESOLVED, VORTEX_RING
from propmap.table.query import LoadTable
from propmap.typing import Floats

POINTS = 32_768
"""Of the envelope, on which shares are counted."""

SPEEDS, ANGLES = 121, 91
"""Of the maps."""

CURVES = (0.0, 45.0, 90.0, 135.0, 180.0)
"""Angles of the curves [deg], where the envelope has them."""

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
    """Loads over speed at one angle [rad]: by name (n,), and the codes of the points (n,)."""

    beta: float
    loads: dict[str, Floats]
    code: NDArray[np.uint8]


@dataclass(frozen=True)
class HoverErrors:
    """The hover model less the table in a band of speed [m/s], as shares of the static load.

    Attributes
    ----------
    points : int
        How many are in the band.
    rms : tuple of float
        Root mean squares of thrust, torque, and the drag, which the hover model lacks.
    off : tuple of float
        Share of the points where thrust is off by more than each of ``OFF``.
    """

    speed: tuple[float, float]
    points: int
    rms: tuple[float, ...]
    off: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class TableSamples:
    """What is drawn and counted.

    Attributes
    ----------
    rpm : float
        Rotational speed of the curves and maps [1/min], the geometric middle of the envelope.
    speed, beta : ndarray, shape (n,), (m,)
        Of the maps [m/s], [rad].
    maps : dict of str to ndarray, shape (n, m)
        Loads by name.
    code : ndarray, shape (n, m)
        Statuses of the maps.
    curves : sequence of Curve
        At the speeds of the maps.
    still : dict of str to float
        The hover model's loads: those of the table at rest, NaN where it has none.
    shares : dict of str to float
        Of the envelope, by status.
    by_angle : sequence of tuple of str
        Range of the angle, kind of flow, and the shares there [%].
    hover : sequence of HoverErrors
        By band of speed; empty without loads at rest.
    """

    rpm: float
    speed: Floats
    beta: Floats
    maps: dict[str, Floats]
    code: NDArray[np.uint8]
    curves: Sequence[Curve]
    still: dict[str, float]
    shares: dict[str, float]
    by_angle: Sequence[tuple[str, ...]]
    hover: Sequence[HoverErrors]


def sample(table: LoadTable) -> TableSamples:
    """Curves, maps and counts of a table."""
    (w0, w1), (v0, v1), (b0, b1) = table.envelope.values()
    omega = float(np.sqrt(w0 * w1))
    speed, beta = np.linspace(v0, v1, SPEEDS), np.linspace(b0, b1, ANGLES)
    found, rest = table.loads(omega, speed[:, None], beta), table.loads(omega, 0.0, b0)
    still = {
        load.name: 0.0 if load.inplane else float(getattr(rest, load.name))
        for load in LOADS.values()
    }
    points = evenly(table, POINTS)
    everywhere = table.loads(*points)
    return TableSamples(
        rpm=omega * RPM,
        speed=speed,
        beta=beta,
        maps={name: getattr(found, name) for name in LOADS},
        code=np.asarray(found.code),
        curves=[_curve(table, omega, speed, angle) for angle in _angles(b0, b1)],
        still=still,
        shares=_shares(everywhere.code),
        by_angle=_by_angle(points[2], everywhere.code),
        hover=_hover(points, everywhere, {n: k / omega**2 for n, k in still.items()}, (v0, v1)),
    )


def _angles(low: float, high: float) -> list[float]:
    inside = [a for a in np.radians(CURVES) if low - 1e-9 <= a <= high + 1e-9]
    far = [end for end in (low, high) if all(abs(end - a) > np.radians(10.0) for a in inside)]
    return sorted(float(a) for a in (*inside, *far))


def _curve(table: LoadTable, omega: float, speed: Floats, beta: float) -> Curve:
    found = table.loads(omega, speed, beta)
    return Curve(beta, {name: getattr(found, name) for name in LOADS}, np.asarray(found.code))


def _shares(code: NDArray[np.uint8]) -> dict[str, float]:
    return {STATUSES[k]: float(np.mean(code == k)) for k in (OK, VORTEX_RING, UNRESOLVED, NO_VALUE)}


def _by_angle(beta: Floats, code: NDArray[np.uint8]) -> list[tuple[str, ...]]:
    degrees, rows = np.degrees(beta), []
    for name, low, high in FLOWS:
        mine = (degrees >= low) & (degrees < high)
        if mine.any():
            ends = f"{max(low, degrees.min()):.0f}° to {min(high, degrees.max()):.0f}°"
            shares = _shares(code[mine]).values()
            rows.append((ends, name, *(number(100.0 * share) for share in shares)))
    return rows


def _hover(
    points: tuple[Floats, Floats, Floats],
    found: Any,
    constants: dict[str, float],
    ends: tuple[float, float],
) -> list[HoverErrors]:
    if not (constants["thrust"] > 0.0 and constants["torque"] > 0.0):
        return []
    omega, speed, _ = points
    thrust, torque = (constants[name] * omega**2 for name in ("thrust", "torque"))
    off = (thrust - found.thrust) / thrust
    shares = (off, (torque - found.torque) / torque, found.drag / thrust)
    bands = []
    for low, high in itertools.pairwise(np.linspace(*ends, BANDS + 1).tolist()):
        mine = (speed >= low) & (speed <= high) & np.isfinite(off)
        if mine.any():
            beyond = tuple(float(np.mean(np.abs(off[mine]) > limit)) for limit in OFF)
            each = tuple(rms(share[mine]) for share in shares)
            bands.append(HoverErrors((low, high), int(mine.sum()), each, beyond))
    return bands
