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
    """From ``low`` to ``high``, both above 0; the middle is the geometric mean."""

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
}  # what a figure of some quantity looks like, and the factor by which it is then wrong

# Names of errors whose size follows from the loads.
ELECTRICAL_RPM, ROTORS = "electrical rpm of {pairs} pole pairs", "that of {rotors} rotors together"
ELECTRICAL_POWER = "electrical power, with the losses of motor and controller"
LOAD_UNIT_ERRORS = (
    ("rpm in rad/s", (RPM**-2, RPM**-2)),
    ("rpm in revolutions per second", (3600.0, 3600.0)),
    ("rpm in thousands", (1e6, 1e6)),
    ("rpm converted from rad/s twice", (RPM**2, RPM**2)),
    ("a diameter taken for the radius", (1.0 / 16.0, 1.0 / 32.0)),
    ("a radius taken for the diameter", (16.0, 32.0)),
    *((ELECTRICAL_RPM, (pairs**-2.0, pairs**-2.0)) for pairs in (3, 4, 6, 7, 11, 14)),
    *((ROTORS, (count, count)) for count in (2, 3, 4, 6, 8)),
    ("coefficients over rho A (Omega R)^2", (4.0 / math.pi**3, 4.0 / math.pi**4)),
)  # errors of thrust and torque together, over estimates that go with rpm^2, and R^4 and R^5

CLOSE_FACTOR = 2.3  # of loads of similar blades: closer unit errors look alike


def unit_errors(value: float, usual: Range, errors: Mapping[str, float]) -> list[str]:
    """List the unit errors that bring a ``value`` into a usual range, likeliest first."""
    return common_errors((value,), usual, ((name, (factor,)) for name, factor in errors.items()))


def common_errors(
    figures: Sequence[float], usual: Range, errors: Iterable[tuple[str, Sequence[float]]]
) -> list[str]:
    """List the unit errors that bring all ``figures`` into a usual range, likeliest first, up to
    ``CLOSE_FACTOR`` times as far from its middle; none for a figure that is not above 0."""
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
    """Say what a ``suspect`` looks like by its unit errors; empty without any."""
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
    """Warn of a ``value`` out of its usual range; unit errors must lead into the ``likely`` one."""
    if value in usual:
        return []
    found = f"{subject} is {value:.4g} {unit}, usual are {usual.low:g} to {usual.high:g}"
    return [found + likely_cause(value, likely or usual, quantity, suspect)]


def likely_cause(value: float, likely: Range, quantity: str, suspect: str = "it") -> str:
    """Say what unit a value looks like, for the end of a message; empty without a unit error."""
    like = looks_like(unit_errors(value, likely, UNIT_ERRORS[quantity]), suspect)
    return f"; {like}" if like else ""
