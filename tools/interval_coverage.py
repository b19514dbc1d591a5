"""How often stated intervals hold the truth: data with made-up noise, fitted again and again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from propmap.fit.fit import Settings, fit
from propmap.fit.least_squares import Rows, RowsElsewhere
from propmap.fit.parameters import Choice
from propmap.tasks import InTurn, Workers, in_order
from propmap.typing import Floats


@dataclass(frozen=True, eq=False)
class Intervals:
    """The 95 % intervals of B fits and P parameters.

    Attributes
    ----------
    low, high : ndarray, shape (B, P)
        Their ends.
    identified : ndarray, shape (B, P)
        Whether the fit calls the parameter identified.
    """

    low: Floats
    high: Floats
    identified: NDArray[np.bool_]

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
    """Fit data again and again, each time with other noise.

    Parameters
    ----------
    rows : Rows
        Data without noise.
    choice : Choice
        What is free, and where searches start.
    noise : float
        Standard deviation over the rows' ``scale`` [-].
    draws : int
        How many fits.
    seed : int
        Of the noise.
    workers : Workers, optional
        Who fits; by default this process.  Results are the same to the last digit.
    remake : callable, optional
        Makes ``rows`` again in another process; it needs to be picklable.
    """
    rng = np.random.default_rng(seed)
    noises = (noise * rows.scale * rng.standard_normal(rows.measured.size) for _ in range(draws))
    measured = (rows.measured + one for one in noises)
    found = in_order((workers or InTurn()).results(_fitted, _Exact(rows, choice, remake), measured))
    low, high, identified = (np.stack(part) for part in zip(*found, strict=True))
    return Intervals(low, high, identified)


class _Exact(RowsElsewhere):
    """Rows without noise; what is sent to another process remakes them there."""

    def __init__(self, rows: Rows, choice: Choice, remake: Callable[[], Rows] | None) -> None:
        self.rows, self.choice, self.remake = rows, choice, remake


def _fitted(exact: _Exact, measured: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    rows = replace(exact.rows, measured=measured)
    sure = fit(rows, exact.choice, Settings(starts=1, folds=0)).uncertainty
    return sure.low, sure.high, np.asarray(sure.identified)
