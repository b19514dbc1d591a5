"""Products of vectors."""

from __future__ import annotations

import numpy as np

from propmap.typing import Floats


def cross(one: Floats, other: Floats) -> Floats:
    """Cross products (..., 3) of vectors (..., 3), to the bits of ``np.cross``.

    That spends ten times as long on its axes as on the products of a few rotors.
    """
    (a, b, c), (x, y, z) = ((v[..., 0], v[..., 1], v[..., 2]) for v in (one, other))
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=-1)
