"""Which operating points the data of a fit cover, and what they cannot tell."""

from __future__ import annotations

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.errors import InputError
from propmap.fit.rows import Rows

AT_REST = 0.1
"""Speed [m/s] below which the direction of the flow means nothing."""

BAND = 15.0
"""Width of the bands of the angle beta [deg], the first one about 0."""

FEW = 0.02
"""Share of the points in motion below which an angle is hardly covered."""

HOVER_BELOW, NARROW = 1.0, 2.0
"""Speeds [m/s]: below the first everything hovers; a range below the second is one speed."""

RPM = 30.0 / np.pi

Range = tuple[float, float]
"""Least and largest."""


class Covered(msgspec.Struct, frozen=True, omit_defaults=True):
    """Operating points of one kind: how many, their ranges, and the median rotational speed."""

    points: int
    rpm: Range
    typical_rpm: float
    speed: Range = msgspec.field(name="speed_mps")
    advance: Range = msgspec.field(name="advance_ratio")
    """V/(Omega R) [-]."""

    def __post_init__(self) -> None:
        _check_ranges(self.rpm, self.speed, self.advance)
        _check_turning(self.typical_rpm)


class CoveredAngle(Covered, frozen=True):
    """Operating points in a band of the angle beta: its range and its median [deg]."""

    beta: Range = msgspec.field(name="beta_deg")
    typical_beta: float = msgspec.field(name="typical_beta_deg")


class Coverage(msgspec.Struct, frozen=True, omit_defaults=True):
    """All operating points of a fit's data.

    Attributes
    ----------
    points : int
        Operating points with a turning propeller.
    rpm, speed : tuple of float
        Least and largest [rpm], [m/s].
    typical_rpm : float
        Median [rpm].
    angles : list of CoveredAngle
        Points in motion, one entry for each band of beta that holds any, by rising angle.
    at_rest : Covered or None
        Points at rest, where there are any.
    """

    points: int
    rpm: Range
    typical_rpm: float
    speed: Range = msgspec.field(name="speed_mps")
    angles: list[CoveredAngle]
    at_rest: Covered | None = None

    def __post_init__(self) -> None:
        _check_ranges(self.rpm, self.speed)
        _check_turning(self.typical_rpm)

    @property
    def main_angles(self) -> list[CoveredAngle]:
        """The angles with a share of the points that counts."""
        moving = sum(one.points for one in self.angles)
        return [one for one in self.angles if one.points >= FEW * moving]


def coverage(omega: Floats, speed: Floats, beta: Floats, radius: float) -> Coverage:
    """Ranges of n operating points, at rest and by angle.

    Loads over Omega^2 depend on the advance ratio and the angle, and on little else.

    Parameters
    ----------
    omega, speed, beta : ndarray, shape (n,)
        Rotational speed [rad/s], flight speed [m/s], angle to the axis [rad] in 0...pi.
    radius : float
        Of the tip [m].

    Raises
    ------
    InputError
        Where the propeller turns at none of the points.
    """
    turning = omega > 0.0
    if not turning.any():
        raise InputError("the propeller stands still at all points", "give rpm above 0")
    omega, speed, beta = omega[turning], speed[turning], beta[turning]
    rpm, degrees, still = omega * RPM, np.degrees(beta), speed < AT_REST
    band = np.round(degrees / BAND).astype(int)

    def at(mine: NDArray[np.bool_]) -> tuple[int, Range, float, Range, Range]:
        advance = speed[mine] / (omega[mine] * radius)
        return int(mine.sum()), *_spread(rpm[mine]), _ends(speed[mine]), _ends(advance)

    angles = []
    for k in np.unique(band[~still]).tolist():
        mine = ~still & (band == k)
        beta_range, typical_beta = _spread(degrees[mine])
        angles.append(CoveredAngle(*at(mine), beta_range, typical_beta))
    at_rest = Covered(*at(still)) if still.any() else None
    return Coverage(int(omega.size), *_spread(rpm), _ends(speed), angles, at_rest)


def range_warnings(rows: Rows) -> list[str]:
    """Sentences on what the range of speeds of the rows cannot tell; none where it is wide."""
    speed = rows.speed[rows.weight > 0.0]
    low, high = _ends(speed)
    if high < HOVER_BELOW:
        return [
            "all data are from hover: they fix the static loads alone and cannot tell one "
            "parameter from another; add data at speed"
        ]
    if high - low < NARROW:
        return [
            f"all data are from one speed, {low:.1f} to {high:.1f} m/s: the parameters can hardly "
            "be told apart; add data at other speeds"
        ]
    return []


def _ends(values: Floats) -> Range:
    return float(np.min(values)), float(np.max(values))


def _spread(values: Floats) -> tuple[Range, float]:
    """Ends and median."""
    return _ends(values), float(np.median(values))


def _check_ranges(*ranges: Range) -> None:
    for low, high in ranges:
        if not (math.isfinite(low) and math.isfinite(high) and low <= high):
            raise ValueError(f"{low:g} to {high:g} is no range")


def _check_turning(rpm: float) -> None:
    if not 0.0 < rpm < math.inf:
        raise ValueError(f"{rpm:g} rpm is no rotational speed of a turning propeller")
