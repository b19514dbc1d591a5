"""Coverage of the 95 % intervals of fits, from repeated fits to data with simulated noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.fit.fit import Settings, fit
from propmap.fit.least_squares import Rows, RowsElsewhere
from propmap.fit.parameters import Choice
from propmap.tasks import InTurn, Workers, in_order
from propmap.typing import Floats


class Intervals(NamedTuple):
    """The 95 % intervals of B fits and P parameters."""

    low: Floats  # (B, P)
    high: Floats
    identified: NDArray[np.bool_]  # (B, P): whether the fit calls the parameter identified

    def hold(self, truth: Floats) -> NDArray[np.bool_]:
        """Return which intervals (B, P) contain the ``truth`` (P,)."""
        return (self.low <= truth) & (truth <= self.high)


def noisy_intervals(
    rows: Rows,
    choice: Choice,
    noise: float,
    draws: int,
    *,
    seed: int = 2017,
    workers: Workers | None = None,
    remake: Callable[[], Rows] | None = None,
) -> Intervals:
    """Fit noise-free ``rows`` repeatedly, each time with new simulated noise.

    ``noise`` is its standard deviation over the ``scale`` of the rows [-]; ``draws`` is the number
    of fits.  Workers in other processes need the picklable function ``remake``, which returns the
    same ``rows`` there.  Results do not depend on the workers.
    """
    rng = np.random.default_rng(seed)
    noises = (noise * rows.scale * rng.standard_normal(rows.measured.size) for _ in range(draws))
    measured = (rows.measured + one for one in noises)
    found = in_order((workers or InTurn()).results(_fitted, _Exact(rows, choice, remake), measured))
    return Intervals(*(np.stack(part) for part in zip(*found, strict=True)))


class _Exact(RowsElsewhere):
    """Noise-free rows, which another process makes again because they cannot be pickled."""

    def __init__(self, rows: Rows, choice: Choice, remake: Callable[[], Rows] | None) -> None:
        self.rows, self.choice, self.remake = rows, choice, remake


def _fitted(exact: _Exact, measured: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    rows = replace(exact.rows, measured=measured)
    sure = fit(rows, exact.choice, Settings(starts=1, folds=0)).uncertainty
    return sure.low, sure.high, np.asarray(sure.identified)
