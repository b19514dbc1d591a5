"""Which operating points the data of a fit cover, and what they cannot tell."""

from __future__ import annotations

import math
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.fit.rows import Rows
from propmap.typing import Floats

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


class _Points(msgspec.Struct, frozen=True, omit_defaults=True):
    """How many operating points, their ranges, and the median rotational speed."""

    points: int
    rpm: Range
    typical_rpm: Annotated[float, msgspec.Meta(gt=0.0)]
    speed: Range = msgspec.field(name="speed_mps")

    def __post_init__(self) -> None:
        for value in (getattr(self, name) for name in self.__struct_fields__):
            if isinstance(value, tuple) and not -math.inf < value[0] <= value[1] < math.inf:
                raise ValueError(f"{value[0]:g} to {value[1]:g} is no range")


class Covered(_Points, frozen=True):
    """Operating points of one kind; the advance ratio is V/(Omega R) [-]."""

    advance: Range = msgspec.field(name="advance_ratio")


class CoveredAngle(Covered, frozen=True):
    """Operating points in a band of the angle beta: its range and its median [deg]."""

    beta: Range = msgspec.field(name="beta_deg")
    typical_beta: float = msgspec.field(name="typical_beta_deg")


class Coverage(_Points, frozen=True):
    """All operating points of a fit's data: their ranges, and those at rest and by angle.

    Points where the propeller stands still do not count.  ``angles`` has an entry for each band of
    beta that holds points in motion, by rising angle.
    """

    angles: list[CoveredAngle]
    at_rest: Covered | None = None

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

    bands = [~still & (band == k) for k in np.unique(band[~still])]
    angles = [CoveredAngle(*at(mine), *_spread(degrees[mine])) for mine in bands]
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
