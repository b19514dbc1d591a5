"""Knots placed where a rotor's loads need them, until interpolation meets the tolerance."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.table.axis import interpolate, on_planes, pad
from propmap.table.content import PARITY
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.table.model import Model

FIRST_KNOTS = 13

LINE_SHARE = 0.35
"""Share of the tolerance that interpolation along one axis may take; both add up."""

CELL_SHARE = 0.6
"""Share of the tolerance that a cell's centre may show; the rest is for the cell's corners and
for the Reynolds term."""

FINEST_INFLOW = 300
"""Knots per hover inflow ratio, sqrt(C_T/2), where the loads jump and no number is enough."""

FINEST_ANGLE = np.pi / 512
"""[rad] between knots at the least, likewise."""

MOST_KNOTS = 400_000
"""Of a table; 32 bytes each in its file, before compression."""

ROUNDS = 40


@dataclass
class Axis:
    """Knots (n,), the least distance between them, and which intervals are yet to be tested."""

    knots: Floats
    finest: float
    parity: tuple[Floats | None, Floats | None] = (None, None)
    untested: NDArray[np.bool_] = field(default_factory=lambda: np.ones(0, bool))

    def __post_init__(self) -> None:
        self.untested = np.ones(self.knots.size - 1, bool)

    @property
    def middles(self) -> Floats:
        """Of the intervals (n - 1,)."""
        return np.asarray(0.5 * (self.knots[:-1] + self.knots[1:]))

    @property
    def divisible(self) -> NDArray[np.bool_]:
        """Intervals (n - 1,) whose halves would not be too narrow."""
        return np.asarray(np.diff(self.knots) >= 2.0 * self.finest)

    def padded(self, values: Floats) -> Floats:
        """Values (n, ...) with ghosts."""
        return pad(self.knots, values, *self.parity)

    def split(self, intervals: NDArray[np.bool_]) -> None:
        """Halve these intervals; their halves and what is beside them are to be tested."""
        fresh = intervals.copy()
        fresh[1:] |= intervals[:-1]
        fresh[:-1] |= intervals[1:]
        open_ = np.repeat(self.untested | fresh, np.where(intervals, 2, 1))
        self.knots = np.sort(np.concatenate([self.knots, self.middles[intervals]]))
        self.untested = open_


@dataclass(frozen=True)
class Refined:
    """Axes, loads over static ones (2, n, m, 4), the vortex ring state (n, m), and the cells
    (n - 1, m - 1) where the tolerance was not met."""

    advance: Axis
    beta: Axis
    values: Floats
    ring: NDArray[np.bool_]
    missed: NDArray[np.bool_]


def starting_axes(
    model: Model, advance: tuple[float, float], beta: tuple[float, float]
) -> tuple[Axis, Axis]:
    """Few knots, those of the advance ratio denser where it is small."""
    blade, air = model.rotor.model.propeller, model.rotor.model.air
    force = air.density * np.pi * blade.radius**4 * model.omega[1] ** 2
    inflow = float(np.sqrt(0.5 * model.static[1, 0] / force))
    share = np.linspace(0.0, 1.0, FIRST_KNOTS)
    low, high = advance
    first, last = (PARITY if on else None for on in on_planes(np.array(beta)))
    return (
        Axis(low + (high - low) * share**1.5, inflow / FINEST_INFLOW),
        Axis(np.linspace(*beta, FIRST_KNOTS), FINEST_ANGLE, (first, last)),
    )


def refine(model: Model, advance: Axis, beta: Axis, tolerance: float) -> Refined:
    """Insert knots until lines and cells, tested at their middles, are within the tolerance.

    Where the loads jump it cannot be met; knots end at the axes' finest distance, and the cells
    are told.  Raises ``InputError`` where more than ``MOST_KNOTS`` knots would be needed.
    """
    model.stage = "placing knots"
    for _ in range(ROUNDS):
        _refine_lines(model, advance, beta, tolerance)
        bad = _centre_errors(model, advance, beta) > CELL_SHARE * tolerance
        split_advance = np.any(bad & advance.divisible[:, None], axis=1)
        split_beta = np.any(bad & beta.divisible[None, :], axis=0)
        if not (split_advance.any() or split_beta.any()):
            break
        advance.split(split_advance)
        beta.split(split_beta)
    nodes = [model.relative(node, advance.knots, beta.knots) for node in (0, 1)]
    ring = (nodes[0][1] > 0.0) | (nodes[1][1] > 0.0)
    return Refined(advance, beta, np.stack([n[0] for n in nodes]), ring, spread(bad))


def spread(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """These cells and their neighbours, into whose interpolation a jump reaches."""
    wide = np.pad(cells, 1)
    n, m = cells.shape
    parts = [wide[i : i + n, j : j + m] for i in range(3) for j in range(3)]
    return np.asarray(np.any(parts, axis=0))


def _refine_lines(model: Model, advance: Axis, beta: Axis, tolerance: float) -> None:
    """Test the axes' untested intervals in turn until none is left."""
    while advance.untested.any() or beta.untested.any():
        for axis, other, along in ((advance, beta, 0), (beta, advance, 1)):
            tested = axis.untested & axis.divisible
            axis.untested[:] = False
            if not tested.any():
                continue
            if (axis.knots.size + tested.sum()) * other.knots.size > MOST_KNOTS:
                raise InputError(
                    f"a tolerance of {tolerance:.2%} takes more than {MOST_KNOTS} knots here",
                    "allow more, or make the envelope smaller, the least omega higher above all",
                )
            known, _ = model.relative(0, advance.knots, beta.knots)
            middles = axis.middles[tested]
            if along == 0:
                found, _ = model.relative(0, middles, other.knots)
                expected = interpolate(axis.knots, axis.padded(known), middles)
            else:
                found = model.relative(0, other.knots, middles)[0].transpose(1, 0, 2)
                expected = interpolate(axis.knots, axis.padded(known.transpose(1, 0, 2)), middles)
            missed = _largest(found - expected, (1, 2)) > LINE_SHARE * tolerance
            split = np.zeros(axis.knots.size - 1, bool)
            split[np.flatnonzero(tested)[missed]] = True
            axis.split(split)


def _centre_errors(model: Model, advance: Axis, beta: Axis) -> Floats:
    """Largest error of the loads at the cells' centres, (n - 1, m - 1)."""
    known, _ = model.relative(0, advance.knots, beta.knots)
    across = interpolate(advance.knots, advance.padded(known), advance.middles)
    expected = interpolate(beta.knots, beta.padded(across.transpose(1, 0, 2)), beta.middles)
    found, _ = model.relative(0, advance.middles, beta.middles)
    return _largest(found - expected.transpose(1, 0, 2), (2,))


def _largest(error: Floats, axes: tuple[int, ...]) -> Floats:
    """Largest size along the axes; where there is no value there is no error."""
    return np.asarray(np.max(np.nan_to_num(np.abs(error), nan=0.0), axis=axes))
