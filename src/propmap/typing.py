"""Array and core types for annotations, and a base class of dataclasses with array fields."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Classes of the compiled ``propmap.core``, which has no type annotations.
CoreRotor: TypeAlias = Any
CoreTable: TypeAlias = Any


class ByValue:
    """Base class with equality and hash by the values of all fields, arrays included."""

    def _key(self) -> tuple[Any, ...]:
        made: Any = self
        values = (getattr(self, one.name) for one in fields(made) if one.compare)
        return tuple(v.tobytes() if isinstance(v, np.ndarray) else v for v in values)

    def __eq__(self, other: object) -> bool:
        return self._key() == other._key() if isinstance(other, type(self)) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key())
