"""Operating points and their loads as users write them: rpm, m/s, degrees, columns with units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.results import Loads, LoadValues
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
    "height": "give the height of the disk above level ground in m, or leave it out",
}

FURTHER = {"height": "height_m"}
"""Columns of what an operating point may have beside these, see ``operating_points.Further``."""

SIGNED = ("beta", "climb")
"""Quantities that may be negative."""


@dataclass(frozen=True)
class OperatingPoints:
    """rpm [1/min], speed [m/s], beta [degrees] and what is ``further`` given, arrays (n,)."""

    rpm: Floats
    speed_mps: Floats
    beta_deg: Floats
    further: Mapping[str, Floats] = field(default_factory=dict)

    @classmethod
    def grid(cls, rpm: Floats, speed: Floats, beta: Floats) -> OperatingPoints:
        """All combinations, beta fastest."""
        w, v, b = (axis.ravel() for axis in np.meshgrid(rpm, speed, beta, indexing="ij"))
        return cls(w, v, b)

    @property
    def count(self) -> int:
        """How many points there are."""
        return self.rpm.size

    def part(self, start: int, count: int) -> OperatingPoints:
        """Up to ``count`` points from ``start`` on."""
        cut = slice(start, start + count)
        further = {name: values[cut] for name, values in self.further.items()}
        return OperatingPoints(self.rpm[cut], self.speed_mps[cut], self.beta_deg[cut], further)

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of ``rows``."""
        return *COLUMNS[:3], *(FURTHER[name] for name in self.further), *COLUMNS[3:]

    @property
    def si(self) -> tuple[Floats, Floats, Floats]:
        """Omega [rad/s], V [m/s] and beta [rad], (n,) each."""
        return self.rpm * RPM, self.speed_mps, np.radians(self.beta_deg)

    def loads(self, rotor: Rotor) -> Loads:
        """Loads of the rotor at these points, fields of shape (n,)."""
        return rotor.loads(*self.si, **self.further)

    def rows(
        self, loads: Loads, further: Mapping[str, Floats] | None = None
    ) -> list[dict[str, Any]]:
        """One mapping of ``columns`` per point; None where a number is NaN.

        Parameters
        ----------
        loads : Loads
            At these points.
        further : mapping of str to ndarray, shape (n,)
            Columns to follow.
        """
        numbers = (*(getattr(loads, name) for name in LOADS), loads.power)
        given = (self.rpm, self.speed_mps, self.beta_deg, *self.further.values())
        columns = [values.tolist() for values in (*given, *numbers)]
        status = loads.status.tolist()
        rows = [
            dict(zip(self.columns, [*(_number(v) for v in row[:-1]), row[-1]], strict=True))
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


def std_columns(loads: Loads, *, by_source: bool) -> dict[str, Floats]:
    """Standard deviations by their columns in files, "thrust_std_N" or "thrust_std_tunnel_N".

    Parameters
    ----------
    loads : Loads
        With deviations, else there are no columns.
    by_source : bool
        Whether there is a column for each source, too.
    """
    if not loads.std_by_source:
        return {}
    found = dict(_columns("std", loads.std))
    if by_source:
        for source, values in loads.std_by_source.items():
            found.update(_columns(f"std_{source}", values))
    return found


def _number(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _columns(what: str, values: LoadValues) -> Iterator[tuple[str, Floats]]:
    for name, load in LOADS.items():
        yield load.column_of(what), getattr(values, name)
    yield f"power_{what}_W", values.power
