"""How often stated intervals hold the truth: data with made-up noise, fitted again and again."""

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
        """Which of them (B, P) hold the ``truth`` (P,)."""
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
    """Fit ``rows`` without noise again and again, each time with other noise.

    ``noise`` is its standard deviation over the rows' ``scale`` [-]; ``draws`` says how many fits.
    Workers in other processes need ``remake``, picklable, which makes ``rows`` again there; results
    are the same to the last digit.
    """
    rng = np.random.default_rng(seed)
    noises = (noise * rows.scale * rng.standard_normal(rows.measured.size) for _ in range(draws))
    measured = (rows.measured + one for one in noises)
    found = in_order((workers or InTurn()).results(_fitted, _Exact(rows, choice, remake), measured))
    return Intervals(*(np.stack(part) for part in zip(*found, strict=True)))


class _Exact(RowsElsewhere):
    """Rows without noise; another process makes them again instead of being sent them."""

    def __init__(self, rows: Rows, choice: Choice, remake: Callable[[], Rows] | None) -> None:
        self.rows, self.choice, self.remake = rows, choice, remake


def _fitted(exact: _Exact, measured: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    rows = replace(exact.rows, measured=measured)
    sure = fit(rows, exact.choice, Settings(starts=1, folds=0)).uncertainty
    return sure.low, sure.high, np.asarray(sure.identified)
