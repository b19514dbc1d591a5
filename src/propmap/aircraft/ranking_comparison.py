"""How sure a ranking is of its neighbours, and what no other propeller beats."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from propmap.aircraft.ranking import Judged


def beats(better: Judged, worse: Judged) -> float:
    """Probability that one candidate beats another, from the uncertainty of their constants alone.

    What the model itself gets wrong is not counted, and is alike for both; constants of different
    propellers were found from different data and are taken as independent.  NaN where either has
    no deviation.

    Parameters
    ----------
    better, worse : Judged
        With deviations; the first is ahead of the second in a ranking.
    """
    spread = math.hypot(better.deviation, worse.deviation)
    gap = abs(worse.score - better.score)
    if not math.isfinite(spread):
        return math.nan
    return 0.5 * (1.0 + math.erf(gap / (spread * math.sqrt(2.0)))) if spread > 0.0 else 1.0


def pareto(judged: Sequence[Judged]) -> NDArray[np.intp]:
    """Numbers of those feasible ones among ``judged`` that no other beats in hover power and in top
    speed, by rising hover power."""
    power = np.array([one.hover_power if one.feasible else math.nan for one in judged])
    speed = np.array([one.top_speed if one.feasible else math.nan for one in judged])
    found = [
        k
        for k in range(len(judged))
        if math.isfinite(power[k] + speed[k])
        and not (
            (power <= power[k]) & (speed >= speed[k]) & ((power < power[k]) | (speed > speed[k]))
        ).any()
    ]
    return np.array(sorted(found, key=lambda k: power[k]), dtype=np.intp)
