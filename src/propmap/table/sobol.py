"""Points that fill a box evenly: Sobol's sequence in three dimensions, scrambled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propmap.typing import Floats

BITS = 30
"""Of each coordinate."""


def sobol(count: int, seed: int) -> Floats:
    """The first points (n, 3) of the sequence, in the unit cube.

    They are those of ``scipy.stats.qmc.Sobol``, which takes longer to import than a small table to
    build: direction numbers by Joe and Kuo, scrambled by a lower triangular matrix and a shift.

    Parameters
    ----------
    count, seed : int
        How many, and which scrambling.
    """
    rng = np.random.default_rng(seed)
    place = np.arange(BITS, dtype=np.uint32)
    shift = rng.integers(2, size=(3, BITS), dtype=np.uint32) @ (np.uint32(1) << place)
    mixing = np.tril(rng.integers(2, size=(3, BITS, BITS), dtype=np.uint32), -1)
    mixing += np.eye(BITS, dtype=np.uint32)
    # The highest bit first.
    bits = (_directions()[:, None] >> place[::-1, None]) & 1
    directions = (np.uint32(1) << place[::-1]) @ (mixing @ bits % 2)
    found = shift[None]
    for direction in directions.T:
        if len(found) >= count:
            break
        # In Gray code the numbers with a further bit are those without it, backwards.
        found = np.concatenate([found, found[::-1] ^ direction])
    return found[:count] / 2.0**BITS


def _directions() -> NDArray[np.uint32]:
    """Direction numbers (3, ``BITS``): of no polynomial, of x + 1 and of x^2 + x + 1."""
    found = np.ones((3, BITS), np.uint32)
    found[2, 1] = 3
    for k in range(1, BITS):
        found[1, k] = 2 * found[1, k - 1] ^ found[1, k - 1]
    for k in range(2, BITS):
        found[2, k] = 2 * found[2, k - 1] ^ 4 * found[2, k - 2] ^ found[2, k - 2]
    return found << np.arange(BITS, dtype=np.uint32)[::-1]
