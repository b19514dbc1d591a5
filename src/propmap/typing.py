"""Names of NumPy's array types, for annotations, and of the compiled core."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Classes of ``propmap.core``, which has no annotations.
CoreRotor: TypeAlias = Any
CoreTable: TypeAlias = Any
