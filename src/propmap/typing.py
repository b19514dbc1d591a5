"""Names of NumPy's array types, for annotations, and of the compiled core."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CoreRotor: TypeAlias = Any  # ``propmap.core.Rotor``, which has no annotations
