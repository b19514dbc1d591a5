"""What a table's queries return: tuples of every load of the registry."""

from __future__ import annotations

from collections import namedtuple
from inspect import cleandoc
from typing import Any

import numpy as np

from propmap.loads import LOADS
from propmap.table.lookup import CLAMPED, OUTSIDE, STATUSES

TORQUE = list(LOADS).index("torque")


def _every_load(*further: str) -> Any:
    """A named tuple of all loads; tuples, since for a single point a dataclass takes too long."""
    return namedtuple("_EveryLoad", (*LOADS, *further))


class TableLoads(_every_load("power", "code")):  # type: ignore[misc]
    """Loads from a table; floats for a single point, else arrays of the points' shape.

    The fields are the loads of ``propmap.loads.LOADS``, the power, and ``code``, an index into
    ``STATUSES``; see ``status``.
    """

    __slots__ = ()

    @property
    def status(self) -> Any:
        """A word of ``STATUSES`` per point.

        "vortex_ring": the model's momentum theory does not hold nearby.  "unresolved": the
        model's loads jump or nearly so, and the table's error may exceed its tolerance.
        "clamped": outside the envelope, the loads are those of the nearest point of it.
        "no_value": the model found no loads nearby, or they were left out; NaN.  "outside":
        outside the envelope; NaN.
        """
        words = np.asarray(STATUSES)[self.code]
        return str(words) if words.ndim == 0 else words

    @property
    def inside(self) -> Any:
        """Where the point asked for is inside the envelope."""
        return (self.code != OUTSIDE) & (self.code != CLAMPED)


class Gradient(_every_load("power")):  # type: ignore[misc]
    """Derivatives of the fields below, (..., k).

    The last axis counts what they are taken by: omega, speed and beta, or omega and the
    velocity's x, y, z.
    """

    __slots__ = ()


class Deviation(_every_load("power")):  # type: ignore[misc]
    """Standard deviations of the fields below; NaN outside the envelope."""

    __slots__ = ()


class JaxLoads(_every_load("power")):  # type: ignore[misc]
    """Loads from a table in JAX; NaN outside the envelope."""

    __slots__ = ()


_LINES = [
    *(f"{name} : array\n    {load.meaning} [{load.unit}]" for name, load in LOADS.items()),
    "power : array\n    torque times omega [W]",
]
for _kind in (TableLoads, Gradient, Deviation, JaxLoads):
    _parts = [cleandoc(_kind.__doc__ or ""), "", "Attributes", "----------", *_LINES]
    _kind.__doc__ = "\n".join(_parts)
