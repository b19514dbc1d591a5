"""The search for a table's largest errors, which evenly spread points alone would miss.

An error that fills one ten-thousandth of the envelope is seldom met by chance, but mostly has
slopes that are.  So each cell of the table is sampled, however small a share of the envelope it
is.  From the worst points of each load, each in a cell of its own, the error is climbed by random
steps, which grow where they succeed and shrink where they fail.  The worse half of the climbs is
given up again and again, for more steps of the others.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from propmap.loads import LOADS
from propmap.table.comparison import Comparison, compare
from propmap.table.content import TableContent
from propmap.table.lookup import UNRESOLVED
from propmap.table.positions import most_position, points_at, positions_of
from propmap.table.sobol import sobol
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.table.model import Model
    from propmap.table.query import LoadTable

OVERHANG = np.array([0.5, 0.5, 0.25])
"""How far beyond the envelope points are spread over the cells, then held back, so that its edges
and corners get their part."""

CLIMBS = 32
"""At first, per load and 32768 points known."""

FEWEST_CLIMBS = 8

TRIES = 4
"""Steps that each climb tries in a round, at first."""

HALVINGS, ROUNDS = 4, 5
"""How often the better half of the climbs goes on, and rounds in between."""

STEP = np.array([0.5, 0.5, 0.25])
"""Largest step of the first round along each axis, as positions count."""

GROWTH, SHRINKAGE = 1.5, 0.6


def largest_errors(table: LoadTable, model: Model, sampled: Comparison, seed: int) -> Comparison:
    """The points that a search for the largest errors, by load, has come by.

    Errors inside unresolved cells are climbed apart from the others.

    Parameters
    ----------
    table, model : LoadTable, Model
        What is compared.
    sampled : Comparison
        Points known already, from which to begin.
    seed : int
        Of the random steps.
    """
    rng = np.random.default_rng(seed)
    content = table.content
    points = sampled.omega.size
    found = compare(table, model, *points_at(content, _over_cells(content, points // 2, seed)))
    known = sampled.and_also(found)
    climbs = _Climbs.begin(content, known, max(FEWEST_CLIMBS, CLIMBS * points // 32_768))
    for halving in range(HALVINGS):
        for _ in range(ROUNDS):
            position = climbs.steps(TRIES * 2**halving, rng, most_position(content))
            tried = compare(table, model, *points_at(content, position))
            found = found.and_also(tried)
            climbs.take(position, tried)
        climbs.halve()
    return found


class _Climbs:
    """Positions (k, 3) with the largest error met so far, (k,), each by one load in one kind of
    cell (k,), and the lengths of their steps (k,), in ``STEP``."""

    def __init__(self, position: Floats, error: Floats, goal: NDArray[np.intp]) -> None:
        self.position, self.error, self.goal = position, error, goal
        self.length = np.ones(goal.size)

    @classmethod
    def begin(cls, content: TableContent, known: Comparison, most: int) -> _Climbs:
        """From the worst points of each goal, the ``most``, no two in the same cell."""
        position = positions_of(content, known.omega, known.advance, known.beta)
        cell = np.floor(position[:, 0]) * content.beta.size + np.floor(position[:, 1])
        sizes = _sizes(known)
        starts, goals = [], []
        for goal, size in enumerate(sizes.T):
            order = np.argsort(-size)[: np.count_nonzero(size > 0.0)]
            first = np.sort(np.unique(cell[order], return_index=True)[1])[:most]
            starts.append(order[first])
            goals.append(np.full(first.size, goal))
        start, goal_of = np.concatenate(starts), np.concatenate(goals)
        return cls(position[start], sizes[start, goal_of], goal_of)

    def steps(self, tries: int, rng: np.random.Generator, most: Floats) -> Floats:
        """Positions (k tries, 3) to be tried, those of the first climb first."""
        share = rng.uniform(-1.0, 1.0, (self.goal.size, tries, 3))
        step = share * STEP * self.length[:, None, None]
        return np.clip(self.position[:, None] + step, 0.0, most).reshape(-1, 3)

    def take(self, position: Floats, tried: Comparison) -> None:
        """Go to the best of the positions tried, where it is better."""
        count = self.goal.size
        if not count:
            return
        size = _sizes(tried).reshape(count, -1, _goals())
        every = np.arange(count)
        size = size[every, :, self.goal]
        best = size.argmax(axis=1)
        better = size[every, best] > self.error
        self.position[better] = position.reshape(count, -1, 3)[every, best][better]
        self.error[better] = size[every, best][better]
        self.length *= np.where(better, GROWTH, SHRINKAGE)

    def halve(self) -> None:
        """Give up the worse half of each goal's climbs."""
        order = np.lexsort((-self.error, self.goal))
        rank = np.arange(order.size) - np.searchsorted(self.goal[order], self.goal[order])
        count = np.bincount(self.goal, minlength=_goals())[self.goal[order]]
        kept = order[2 * rank < count]
        for name in ("position", "error", "goal", "length"):
            setattr(self, name, getattr(self, name)[kept])


def _goals() -> int:
    """Each load in resolved cells, then each in the others."""
    return 2 * len(LOADS)


def _sizes(found: Comparison) -> Floats:
    """Sizes (n, ``_goals``) of the errors; zero where the cell is of the other kind."""
    size = np.where(found.lost[:, None], 0.0, np.abs(found.errors))
    loose = (found.code == UNRESOLVED)[:, None]
    return np.concatenate([np.where(loose, 0.0, size), np.where(loose, size, 0.0)], axis=1)


def _over_cells(content: TableContent, count: int, seed: int) -> Floats:
    """Positions (n, 3) spread evenly over the table's cells, ``count`` or some less."""
    most = most_position(content)
    unit = sobol(2 ** int(np.log2(max(count, 1))), seed)
    return np.clip(unit * (most + 2.0 * OVERHANG) - OVERHANG, 0.0, most)
