"""A section by itself in the compiled core."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from propmap.typing import Floats


def section_coefficients(
    law: dict[str, Any], alpha: ArrayLike, reynolds: ArrayLike
) -> tuple[Floats, Floats]:
    """C_L and C_D [-] of a section at angles [rad] from the chord line and Reynolds numbers."""
    from propmap import core

    at = np.broadcast_arrays(np.asarray(alpha, np.float64), np.asarray(reynolds, np.float64))
    flat = [np.ascontiguousarray(a.ravel()) for a in at]
    lift, drag = core.section_coefficients(law, *flat)
    return lift.reshape(at[0].shape), drag.reshape(at[0].shape)
