"""How much more thrust there is before the first limit."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from propmap.typing import Floats

SLOWEST, FASTEST = 0.2, 20.0
"""Least and largest factor on rotor speeds that is looked at."""

PIECES, ROUNDS = 8, 3
"""The factor's range is cut into so many, so many times; then shares are interpolated."""


def thrust_margin(at: Callable[[Floats], tuple[Floats, Floats]], count: int) -> Floats:
    """Thrust with all rotors at the first limit over that as they turn, (n,).

    All are sped up alike, or slowed down, where they are beyond a limit: then it is below 1.

    Parameters
    ----------
    at : callable
        The largest share used of any limit, and the thrust, both (f, n), at f factors (f, n) on the
        rotor speeds of n states.
    count : int
        n.
    """
    low, high = (np.full(count, math.log(factor)) for factor in (SLOWEST, FASTEST))
    each, (_, needed) = np.arange(count), at(np.ones((1, count)))
    for _ in range(ROUNDS):
        logs = np.linspace(low, high, PIECES + 1)
        share, thrust = at(np.exp(logs))
        beyond = ~(share <= 1.0)
        beyond[0], beyond[-1] = False, True
        k = beyond.argmax(axis=0)
        low, high = logs[k - 1, each], logs[k, each]
    (s0, s1), (t0, t1) = ((a[k - 1, each], a[k, each]) for a in (share, thrust))
    found = (t0 + (1.0 - s0) / (s1 - s0) * (t1 - t0)) / needed[0]
    return np.where(s0 <= 1.0, found, math.nan)
