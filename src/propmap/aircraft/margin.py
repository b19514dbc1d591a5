"""How much more thrust there is before the first limit."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from propmap.typing import Floats

SLOWEST, FASTEST = 0.2, 20.0
"""Least and largest factor on rotor speeds that is looked at."""

PIECES = (8, 4, 4, 4)
"""The factor's range is cut into so many, one after the other; then shares are interpolated."""


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
    each = np.arange(count)
    low, high = (np.full(count, math.log(factor)) for factor in (SLOWEST, FASTEST))
    share, thrust = at(np.exp([np.zeros(count), low, high]))
    needed, share, thrust = thrust[0], share[1:], thrust[1:]
    for pieces in PIECES:
        logs = np.linspace(low, high, pieces + 1)
        inner = at(np.exp(logs[1:-1]))
        share, thrust = (
            np.concatenate([ends[:1], between, ends[1:]])
            for ends, between in zip((share, thrust), inner, strict=True)
        )
        beyond = ~(share <= 1.0)
        beyond[0], beyond[-1] = False, True
        k = beyond.argmax(axis=0)
        around = np.stack([k - 1, k]), each
        (low, high), share, thrust = logs[around], share[around], thrust[around]
    (s0, s1), (t0, t1) = share, thrust
    found = (t0 + (1.0 - s0) / (s1 - s0) * (t1 - t0)) / needed
    return np.where(s0 <= 1.0, found, math.nan)
