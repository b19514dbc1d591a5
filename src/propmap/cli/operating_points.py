"""Operating points in the units of the command line: rpm, m/s, degrees."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from propmap.arrays.types import Floats
from propmap.errors import InputError
from propmap.loads import LOADS

if TYPE_CHECKING:
    from propmap.results import Loads
    from propmap.rotor import Rotor

RPM = np.pi / 30.0
"""[rad/s] per revolution per minute."""

COLUMNS = (
    "rpm",
    "speed_mps",
    "beta_deg",
    *(load.column for load in LOADS.values()),
    "power_W",
    "status",
)

REMEDIES = {
    "rpm": "give revolutions per minute, 0 or more; the spin's direction does not matter here",
    "speed": "give 0 or more m/s; the direction is --beta, 180 in descent",
    "beta": "give degrees: 0 axial climb, 90 edgewise flight, 180 descent",
    "climb": "give m/s, negative in descent",
}

SIGNED = ("beta", "climb")
"""Quantities that may be negative."""


@dataclass(frozen=True)
class OperatingPoints:
    """rpm [1/min], speed [m/s] and beta [degrees], arrays of one shape (n,)."""

    rpm: Floats
    speed_mps: Floats
    beta_deg: Floats

    @classmethod
    def grid(cls, rpm: Floats, speed: Floats, beta: Floats) -> OperatingPoints:
        """All combinations, beta fastest."""
        mesh = np.meshgrid(rpm, speed, beta, indexing="ij")
        return cls(*(axis.ravel() for axis in mesh))

    @property
    def count(self) -> int:
        """How many points there are."""
        return self.rpm.size

    def part(self, start: int, count: int) -> OperatingPoints:
        """Up to ``count`` points from ``start`` on."""
        cut = slice(start, start + count)
        return OperatingPoints(self.rpm[cut], self.speed_mps[cut], self.beta_deg[cut])

    @property
    def si(self) -> tuple[Floats, Floats, Floats]:
        """Omega [rad/s], V [m/s] and beta [rad], (n,) each."""
        return self.rpm * RPM, self.speed_mps, np.radians(self.beta_deg)

    def loads(self, rotor: Rotor) -> Loads:
        """Loads of the rotor at these points, fields of shape (n,)."""
        return rotor.loads(*self.si)

    def rows(
        self, loads: Loads, further: Mapping[str, Floats] | None = None
    ) -> list[dict[str, Any]]:
        """One mapping of ``COLUMNS`` per point; None where a number is NaN.

        Parameters
        ----------
        loads : Loads
            At these points.
        further : mapping of str to ndarray, shape (n,)
            Columns to follow.
        """
        numbers = (*(getattr(loads, name) for name in LOADS), loads.power)
        given = (self.rpm, self.speed_mps, self.beta_deg)
        columns = [values.tolist() for values in (*given, *numbers)]
        status = loads.status.tolist()
        rows = [
            dict(zip(COLUMNS, [*(_number(v) for v in row[:-1]), row[-1]], strict=True))
            for row in zip(*columns, status, strict=True)
        ]
        for name, values in (further or {}).items():
            for one, value in zip(rows, values.tolist(), strict=True):
                one[name] = _number(value)
        return rows


def check_value(quantity: str, value: float) -> float:
    """``value`` if it can be a ``quantity`` of ``REMEDIES``; else raises ``InputError``."""
    if not np.isfinite(value):
        raise InputError(f"{quantity} is {value}, which is no finite number", REMEDIES[quantity])
    if value < 0.0 and quantity not in SIGNED:
        raise InputError(f"{quantity} is negative ({value:g})", REMEDIES[quantity])
    return value


def single_point(rpm: float, speed: float, beta: float) -> OperatingPoints:
    """One checked operating point."""
    values = {"rpm": rpm, "speed": speed, "beta": beta}
    return OperatingPoints(*(np.array([check_value(k, v)]) for k, v in values.items()))


def parse_axis(option: str, quantity: str, text: str, count: int | None = None) -> Floats:
    """Rising values (n,) from "6000", "10,20" or "A:B:N", N values from A to B.

    ``option`` is its name in messages, ``count`` N where "A:B" is written, None to ask for it.
    """
    parts = text.split(":")
    form = "A:B:N" if count is None else "A:B or A:B:N"
    remedy = f"write a number, a list such as 10,20, or {form} (N values from A to B)"
    try:
        if len(parts) == 1:
            values = np.array([float(part) for part in text.split(",")])
        elif len(parts) == 3 or (len(parts) == 2 and count is not None):
            number = int(parts[2]) if len(parts) == 3 else int(count or 0)
            if not 2 <= number <= 1_000_000:
                raise InputError(f"{option} {text}: N is {number}", "use 2 to 1000000 values")
            values = np.linspace(float(parts[0]), float(parts[1]), number)
        else:
            raise ValueError
    except InputError:
        raise
    except (ValueError, OverflowError):
        raise InputError(f"{option} {text!r} cannot be read", remedy) from None
    for value in values.tolist():
        check_value(quantity, value)
    if any(b <= a for a, b in itertools.pairwise(values.tolist())):
        raise InputError(f"{option} {text}: the values do not rise", "write each once, rising")
    return values


def _number(value: float) -> float | None:
    return value if np.isfinite(value) else None
