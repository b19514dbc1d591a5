"""How well identified constants fit as a whole, and how they are spread over propellers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from propmap.catalogue.identified import Identified
from propmap.catalogue.spread import Spread, spread
from propmap.fit.population.verdict import POOR

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
    spread : Spread
        Of the constants.
    """

    propellers: int
    thrust: tuple[float, float]
    power: tuple[float, float]
    worst: list[Identified]
    spread: Spread


def summary(entries: Sequence[Identified]) -> Summary:
    """What all ``entries`` together say."""
    chosen = one_of_each(entries)
    thrust, power = (
        _median_and_tail([getattr(one, name) for one in chosen])
        for name in ("thrust_rms", "power_rms")
    )
    worst = sorted(chosen, key=_badness, reverse=True)[:WORST]
    return Summary(len(chosen), thrust, power, worst, spread(chosen))


def one_of_each(entries: Sequence[Identified]) -> list[Identified]:
    """Of ``entries`` for several blades of one tested propeller, the one that fits best."""
    best: dict[str, Identified] = {}
    for one in entries:
        kept = best.get(one.tested)
        if kept is None or _badness(one) < _badness(kept):
            best[one.tested] = one
    return list(best.values())


def _median_and_tail(errors: Sequence[float]) -> tuple[float, float]:
    return float(np.median(errors)), float(np.quantile(errors, 0.9))


def _badness(one: Identified) -> float:
    return max(one.thrust_rms / POOR[0], one.power_rms / POOR[1])
