"""How much more thrust there is before the first limit."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from propmap.arrays.types import Floats

FASTEST = 20.0
"""Largest factor on rotor speeds that is looked at."""

PIECES, ROUNDS = 8, 3
"""The factor's range is cut into so many, so many times; then shares are interpolated."""


def thrust_margin(at: Callable[[Floats], tuple[Floats, Floats]], count: int) -> Floats:
    """Thrust with all rotors sped up alike to the first limit, over that as they turn, (n,).

    Parameters
    ----------
    at : callable
        The largest share used of any limit, and the thrust, both (f, n), at f factors (f, n) on the
        rotor speeds of n states.
    count : int
        n.
    """
    low, high, each = np.zeros(count), np.full(count, math.log(FASTEST)), np.arange(count)
    needed = None
    for _ in range(ROUNDS):
        logs = np.linspace(low, high, PIECES + 1)
        share, thrust = at(np.exp(logs))
        needed = thrust[0] if needed is None else needed
        beyond = ~(share <= 1.0)
        beyond[0], beyond[-1] = False, True
        k = beyond.argmax(axis=0)
        low, high = logs[k - 1, each], logs[k, each]
    (s0, s1), (t0, t1) = ((a[k - 1, each], a[k, each]) for a in (share, thrust))
    return np.asarray((t0 + (1.0 - s0) / (s1 - s0) * (t1 - t0)) / needed)
