"""How well identified constants fit as a whole."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from propmap.catalogue.identified import Identified, badness, one_of_each

WORST = 10
"""How many propellers are named as the worst."""


class Summary(NamedTuple):
    """Errors of C_T and C_P over propellers.

    Attributes
    ----------
    propellers : int
        Their number; of a propeller of which several blades were measured, the best counts.
    thrust, power : tuple of float
        Median and 90th percentile of the root mean squares [-].
    worst : list of Identified
        Those farthest beyond the errors of nine in ten.
    """

    propellers: int
    thrust: tuple[float, float]
    power: tuple[float, float]
    worst: list[Identified]


def summary(entries: Sequence[Identified]) -> Summary:
    """What all ``entries`` together say."""
    chosen = one_of_each(entries)
    thrust, power = (
        _median_and_tail([getattr(one, name) for one in chosen])
        for name in ("thrust_rms", "power_rms")
    )
    worst = sorted(chosen, key=badness, reverse=True)[:WORST]
    return Summary(len(chosen), thrust, power, worst)


def _median_and_tail(errors: Sequence[float]) -> tuple[float, float]:
    return float(np.median(errors)), float(np.quantile(errors, 0.9))
