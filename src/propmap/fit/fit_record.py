"""What a fit file tells of its fit, read for a report."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from propmap.arrays.types import Floats
from propmap.errors import InputError

Range = tuple[float, float]


FEW = 0.02
"""Share of the points in motion below which an angle is hardly covered."""


@dataclass(frozen=True)
class FreeParameter:
    """One fitted parameter: its value, the ends of its 95 % interval, its bounds, its verdict."""

    name: str
    unit: str
    value: float
    low: float
    high: float
    lower: float
    upper: float
    verdict: str
    identified: bool


@dataclass(frozen=True)
class FitErrors:
    """Errors, model minus measurement, over so many rows; NaN where there is no number."""

    rows: int
    rms: float
    bias: float
    worst: float
    hover_rms: float


@dataclass(frozen=True)
class FittedLoad:
    """Errors of one load.

    measured_rms : root mean square of what was measured.  cross_validated : rms on rows left out.
    all in ``unit``.  by_speed : by a name such as "3-6 m/s".
    """

    name: str
    unit: str
    all: FitErrors
    measured_rms: float
    cross_validated: float
    by_speed: Mapping[str, FitErrors]


@dataclass(frozen=True)
class Covered:
    """Operating points of the data at rest, or about one angle.

    points : how many.  rpm, speed [m/s], advance [-], beta [deg] : least and largest; typical_rpm
    and typical_beta [deg] : medians.  beta is None at rest.
    """

    points: int
    rpm: Range
    typical_rpm: float
    speed: Range
    advance: Range
    beta: Range | None
    typical_beta: float


@dataclass(frozen=True, eq=False)
class FitRecord:
    """A fit.

    kind : "tunnel", "level flight" or "flight".  version : of propmap.  data : files and names of
    the catalogue, each with its hash or "".  remarks : sentences.  rows, unsolved : how many.
    parameters, loads : see there.  points : operating points, over rpm and speed [m/s].
    typical_rpm : median.  at_rest : None if there were no such points.  angles : by rising angle.
    covariance, correlation : (P, P).  singular_values : (P,), relative.
    minima : how many different ones the starts ended in.  starts : how many there were.
    """

    kind: str
    version: str
    data: Sequence[tuple[str, str]]
    remarks: Sequence[str]
    rows: int
    unsolved: int
    parameters: Sequence[FreeParameter]
    loads: Sequence[FittedLoad]
    points: int
    rpm: Range
    typical_rpm: float
    speed: Range
    at_rest: Covered | None
    angles: Sequence[Covered]
    covariance: Floats
    correlation: Floats
    singular_values: Floats
    minima: int
    starts: int

    @property
    def main_angles(self) -> list[Covered]:
        """The angles with a share of the points that counts."""
        moving = sum(one.points for one in self.angles)
        return [one for one in self.angles if one.points >= FEW * moving]


def read_record(record: Mapping[str, Any], where: str) -> FitRecord:
    """The table ``fit`` of a fit file.

    record : as ``FitFile`` has it.  where : the file, for messages.
    Raises ``InputError`` where something is missing or of another kind.
    """
    if "covered" not in record:
        raise InputError(
            "the fit does not say which operating points its data cover",
            "write it again with this version's propmap fit",
            where,
        )
    try:
        return _read(record)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        told = f"there is no {error}" if isinstance(error, KeyError) else str(error)
        raise InputError(
            f"the table [fit] is damaged: {told}", "write it again with propmap fit", where
        ) from None


def _read(record: Mapping[str, Any]) -> FitRecord:
    covered, starts = record["covered"], record["starts"]
    free = list(record["free"])
    matrices = [np.array(record[name], float) for name in ("covariance", "correlation")]
    singular = np.array(record["singular_values"], float)
    if any(m.shape != (len(free), len(free)) for m in matrices) or singular.shape != (len(free),):
        raise ValueError(f"the matrices are not of {len(free)} parameters")
    if not (covered["points"] and record["residuals"]):
        raise ValueError("there are no operating points")
    return FitRecord(
        kind=str(record["kind"]),
        version=str(record["propmap"]),
        data=[source_name(entry) for entry in record["data"]],
        remarks=[str(text) for text in record["remarks"]],
        rows=int(record["rows"]),
        unsolved=int(record["unsolved_rows"]),
        parameters=[_parameter(name, record["parameters"][name]) for name in free],
        loads=[_load(name, told) for name, told in record["residuals"].items()],
        points=int(covered["points"]),
        rpm=_range(covered["rpm"]),
        typical_rpm=_positive(covered["typical_rpm"]),
        speed=_range(covered["speed_mps"]),
        at_rest=_covered(covered["at_rest"]) if "at_rest" in covered else None,
        angles=sorted((_covered(c) for c in covered["angles"]), key=lambda c: c.typical_beta),
        covariance=matrices[0],
        correlation=matrices[1],
        singular_values=singular,
        minima=max(int(start["minimum"]) for start in starts),
        starts=len(starts),
    )


def source_name(entry: Mapping[str, str]) -> tuple[str, str]:
    """Name and SHA-256 of a source as a fit file names it; "" for the hash of the catalogue."""
    if "catalogue" in entry:
        return f"{entry['catalogue']} of the catalogue", ""
    return str(entry["file"]), str(entry["sha256"])


def _parameter(name: str, told: Mapping[str, Any]) -> FreeParameter:
    return FreeParameter(
        name=name,
        unit=str(told["unit"]),
        value=float(told["value"]),
        low=float(told["low_95"]),
        high=float(told["high_95"]),
        lower=float(told["lower"]),
        upper=float(told["upper"]),
        verdict=str(told["verdict"]),
        identified=bool(told["identified"]),
    )


def _load(name: str, told: Mapping[str, Any]) -> FittedLoad:
    relative = float(told["relative_rms"])
    whole = _errors(told)
    return FittedLoad(
        name=name,
        unit=str(told["unit"]),
        all=whole,
        measured_rms=whole.rms / relative if relative > 0.0 else math.nan,
        cross_validated=float(told["cross_validated_rms"]),
        by_speed={str(band): _errors(e) for band, e in told["by_speed"].items()},
    )


def _errors(told: Mapping[str, Any]) -> FitErrors:
    numbers = (float(told[key]) for key in ("rms", "bias", "worst", "hover_rms"))
    return FitErrors(int(told["rows"]), *numbers)


def _covered(told: Mapping[str, Any]) -> Covered:
    return Covered(
        points=int(told["points"]),
        rpm=_range(told["rpm"]),
        typical_rpm=_positive(told["typical_rpm"]),
        speed=_range(told["speed_mps"]),
        advance=_range(told["advance_ratio"]),
        beta=_range(told["beta_deg"]) if "beta_deg" in told else None,
        typical_beta=float(told.get("typical_beta_deg", 0.0)),
    )


def _range(ends: Sequence[float]) -> Range:
    low, high = (float(end) for end in ends)
    if not (math.isfinite(low) and math.isfinite(high) and low <= high):
        raise ValueError(f"{low:g} to {high:g} is no range")
    return low, high


def _positive(value: Any) -> float:
    if not (math.isfinite(float(value)) and float(value) > 0.0):
        raise ValueError(f"{value} is no rotational speed")
    return float(value)
