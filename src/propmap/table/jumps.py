"""Cells in which the model's loads jump or nearly so, found and marked as unresolved."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from propmap.table.axis import locate
from propmap.table.comparison import Comparison, compare, quasi_random
from propmap.table.content import UNRESOLVED, TableContent
from propmap.table.positions import points_at
from propmap.table.query import LoadTable
from propmap.table.refine import spread
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.table.model import Model

POINTS = 8192
"""Spread over the whole envelope, for jumps that no cell's middle has shown."""

ROUNDS = 4

REACH = 3
"""Cells around a jump that are searched for its like."""

TRIES = 12
"""Points per cell there."""

GLANCES = 4
"""Points per cell as small as cells become; such cells are where jumps have been met."""


def find_jumps(
    content: TableContent, model: Model, limit: float, suspects: NDArray[np.bool_]
) -> TableContent:
    """The table with further cells marked where its error exceeds ``limit``.

    The ``suspects`` (n - 1, m - 1), cells as small as cells become, are searched first.  A jump
    is seldom alone: then the cells around those marked are searched, and those around what is
    found, always at random points.
    """
    model.stage = "looking for jumps"
    rng = np.random.default_rng(POINTS)
    found = compare(
        LoadTable(content), model, *quasi_random(LoadTable(content), POINTS, seed=POINTS)
    )
    content = marked(content, found, limit)
    content = _searched(content, model, limit, suspects, GLANCES, rng)
    done: NDArray[np.bool_] = np.zeros(content.cells.shape, bool)
    for _ in range(ROUNDS):
        near = (content.cells & UNRESOLVED) > 0
        for _ in range(REACH):
            near = spread(near)
        near = near & ~done
        content = _searched(content, model, limit, near, TRIES, rng)
        done |= near
    return content


def _searched(
    content: TableContent,
    model: Model,
    limit: float,
    cells: NDArray[np.bool_],
    tries: int,
    rng: np.random.Generator,
) -> TableContent:
    """The table with what so many random points in each of these cells have shown."""
    cells = cells & ((content.cells & UNRESOLVED) == 0)
    if not cells.any():
        return content
    points = _inside(content, cells, tries, rng)
    return marked(content, compare(LoadTable(content), model, *points), limit)


def marked(content: TableContent, found: Comparison, limit: float) -> TableContent:
    """The table with the cells in which an error exceeds the limit, and those around, marked."""
    cells = exceeding(content, found, limit)
    unresolved = closed(spread(cells) | ((content.cells & UNRESOLVED) > 0))
    flags = (unresolved * UNRESOLVED).astype(np.uint8)
    return replace(content, cells=content.cells | flags)


def exceeding(content: TableContent, found: Comparison, limit: float) -> NDArray[np.bool_]:
    """Cells (n - 1, m - 1) in which an error exceeds the limit."""
    bad = (np.abs(found.errors) > limit).any(axis=1)
    cells: NDArray[np.bool_] = np.zeros(content.cells.shape, bool)
    cells[
        locate(content.advance, found.advance[bad])[0], locate(content.beta, found.beta[bad])[0]
    ] = True
    return cells


def with_marks_of(old: TableContent, new: TableContent) -> TableContent:
    """The ``new`` table with those cells marked too whose middles the ``old`` one had marked."""
    middles = (0.5 * (k[:-1] + k[1:]) for k in (new.advance, new.beta))
    row, column = (locate(k, x)[0] for k, x in zip((old.advance, old.beta), middles, strict=True))
    return replace(new, cells=new.cells | (old.cells[np.ix_(row, column)] & np.uint8(UNRESOLVED)))


def closed(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """These cells and the gaps among them that are at most two cells wide."""
    return ~spread(~spread(cells))


def _inside(
    content: TableContent, cells: NDArray[np.bool_], tries: int, rng: np.random.Generator
) -> tuple[Floats, Floats, Floats]:
    """Random omega, speed and beta in these cells, at omegas for which they are in the envelope."""
    i, j = (np.repeat(index, tries) for index in np.nonzero(cells))
    return points_at(content, np.stack([i, j, 0 * i], axis=1) + rng.random((3, i.size)).T)
