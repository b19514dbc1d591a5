"""Detection of unit errors: values outside their usual range that another unit would explain."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from propmap.units import RPM


@dataclass(frozen=True)
class Range:
    """A range from ``low`` to ``high``, both above 0; its middle is the geometric mean."""

    low: float
    high: float

    def __contains__(self, value: float) -> bool:
        return self.low <= value <= self.high

    def distance(self, value: float) -> float:
        """Return the logarithm of the factor between a ``value`` above 0 and the middle."""
        return abs(math.log(value / math.sqrt(self.low * self.high)))


_SIZES = tomllib.loads(Path(__file__).with_name("unit_errors.toml").read_text(encoding="utf-8"))
UNIT_ERRORS: dict[str, dict[str, float]] = {
    quantity: {name: 1.0 / size for name, size in errors.items()}
    for quantity, errors in _SIZES.items()
}  # names of unit errors by quantity, and the factor between the wrong and the right value

# Names of errors whose numbers in braces follow from the loads.
ELECTRICAL_RPM, ROTORS = "electrical rpm of {pairs} pole pairs", "the total of {rotors} rotors"
ELECTRICAL_POWER = "electrical power, with the losses of motor and controller"
LOAD_UNIT_ERRORS = (
    ("rpm in rad/s", (RPM**-2, RPM**-2)),
    ("rpm in revolutions per second", (3600.0, 3600.0)),
    ("rpm in thousands", (1e6, 1e6)),
    ("rpm converted from rad/s twice", (RPM**2, RPM**2)),
    ("a diameter in place of the radius", (1.0 / 16.0, 1.0 / 32.0)),
    ("a radius in place of the diameter", (16.0, 32.0)),
    *((ELECTRICAL_RPM, (pairs**-2.0, pairs**-2.0)) for pairs in (3, 4, 6, 7, 11, 14)),
    *((ROTORS, (count, count)) for count in (2, 3, 4, 6, 8)),
    ("coefficients over rho A (Omega R)^2", (4.0 / math.pi**3, 4.0 / math.pi**4)),
)  # factors on thrust and torque, whose estimates grow with rpm^2 and with R^4 and R^5

CLOSE_FACTOR = 2.3  # scatter of loads of similar blades, which hides smaller differences


def unit_errors(value: float, usual: Range, errors: Mapping[str, float]) -> list[str]:
    """Return the unit errors that explain a ``value`` outside a usual range, likeliest first."""
    return common_errors((value,), usual, ((name, (factor,)) for name, factor in errors.items()))


def common_errors(
    figures: Sequence[float], usual: Range, errors: Iterable[tuple[str, Sequence[float]]]
) -> list[str]:
    """Return the unit errors that bring all ``figures`` into a usual range, likeliest first.

    Errors farther from the middle of the range than the likeliest, by more than ``CLOSE_FACTOR``,
    are omitted.  The list is empty if a figure is not above 0.
    """
    if not all(0.0 < value < math.inf for value in figures):
        return []
    far: dict[str, float] = {}
    for name, factors in errors:
        corrected = [value / factor for value, factor in zip(figures, factors, strict=True)]
        if all(value in usual for value in corrected):
            far[name] = min(sum(map(usual.distance, corrected)), far.get(name, math.inf))
    limit = min(far.values(), default=0.0) + len(figures) * math.log(CLOSE_FACTOR)
    return sorted((name for name in far if far[name] < limit), key=far.__getitem__)


def looks_like(errors: Sequence[str], suspect: str = "it") -> str:
    """Return the phrase "``suspect`` looks like" with the unit errors; empty without any."""
    return f"{suspect} looks like {' or '.join(errors)}" if errors else ""


def unusual(
    subject: str,
    value: float,
    unit: str,
    usual: Range,
    quantity: str,
    likely: Range | None = None,
    suspect: str = "it",
) -> list[str]:
    """Warn of a ``value`` outside its usual range; unit errors must bring it into ``likely``."""
    if value in usual:
        return []
    found = f"{subject} is {value:.4g} {unit}, usually {usual.low:g} to {usual.high:g}"
    return [found + likely_cause(value, likely or usual, quantity, suspect)]


def likely_cause(value: float, likely: Range, quantity: str, suspect: str = "it") -> str:
    """Return the likely unit error for the end of a message; empty without a unit error."""
    like = looks_like(unit_errors(value, likely, UNIT_ERRORS[quantity]), suspect)
    return f"; {like}" if like else ""
