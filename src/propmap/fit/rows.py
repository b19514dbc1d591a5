"""What every fit sees: numbers measured, and a model of them with its derivatives."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from propmap.typing import Floats

Evaluation = tuple[Floats, Floats]
Model = Callable[[Mapping[str, float], tuple[str, ...]], Evaluation]
"""From all parameters by name and the P free names: values (M,) and derivatives (M, P)."""

INDEPENDENT = 10.0
"""Independent numbers that the rows of one load are worth at most, beside what is known of
propellers in general: what a model or a stand gets wrong, neighbouring rows have in common."""

INDEPENDENT_AT_REST = 4.0
"""The same of rows that are all at rest, which differ in rotational speed alone."""

REMEMBERED = 16
"""Evaluations that are kept: more than one refit takes."""


@dataclass(frozen=True, eq=False)
class Rows:
    """M measured numbers of one or several kinds of load, and a model of them.

    Attributes
    ----------
    names, units : tuple of str
        Of each kind of load.
    measured : ndarray, shape (M,)
        In the unit of the load.
    load : ndarray, shape (M,)
        Index into ``names``.
    scale : ndarray, shape (M,)
        By which residuals are divided before they are squared.
    speed : ndarray, shape (M,)
        Flight speed [m/s].
    point : ndarray, shape (M,)
        Operating point of each number; points are drawn and left out as a whole.
    group : ndarray, shape (M,), or None
        Stretches within which errors may be alike; None where every number errs by itself.
    model : callable
        Gives values and derivatives, see ``Model``.
    weight : ndarray, shape (M,)
        1, or 0 for what is left out.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    measured: Floats
    load: NDArray[np.intp]
    scale: Floats
    speed: Floats
    point: NDArray[np.intp]
    group: NDArray[np.intp] | None
    model: Model
    weight: Floats

    @classmethod
    def of_points(
        cls,
        names: tuple[str, ...],
        units: tuple[str, ...],
        measured: Floats,
        scale: Floats,
        speed: Floats,
        model: Model,
        group: NDArray[np.intp] | None = None,
    ) -> Rows:
        """A row for each finite number of a table of L loads at n operating points.

        Parameters
        ----------
        names, units : tuple of str
            Of the L loads.
        measured, scale : ndarray, shape (n, L)
            See ``Rows``.
        speed, group : ndarray, shape (n,)
            The same.
        model : callable
            Gives values of shape (n, L) and derivatives of shape (n, L, P).
        """
        point, load = np.nonzero(np.isfinite(measured))

        # A search is polished where it ended, and refits of parts of the data begin there.
        @functools.lru_cache(REMEMBERED)
        def at(values: tuple[tuple[str, float], ...], free: tuple[str, ...]) -> Evaluation:
            value, slope = model(dict(values), free)
            return value[point, load], slope[point, load]

        return cls(
            names=names,
            units=units,
            measured=measured[point, load],
            load=load,
            scale=scale[point, load],
            speed=speed[point],
            point=point,
            group=None if group is None else group[point],
            model=lambda values, free: at(tuple(values.items()), free),
            weight=np.ones(point.size),
        )

    @property
    def unit(self) -> NDArray[np.intp]:
        """What is drawn and left out as a whole (M,): the group, or else the operating point."""
        return self.point if self.group is None else self.group

    def picked(self, table: Floats) -> Floats:
        """The numbers (M,) of these rows in a ``table`` (n, L) of loads at the operating points."""
        return np.asarray(table[self.point, self.load])

    def of_load(self, load: int) -> NDArray[np.bool_]:
        """Which rows (M,) are of the ``load`` of this index and have weight."""
        return (self.load == load) & (self.weight > 0.0)

    @property
    def counts(self) -> NDArray[np.intp]:
        """How many rows of each load (L,) have weight."""
        return np.array([np.count_nonzero(self.of_load(k)) for k in range(len(self.names))])

    @property
    def independent(self) -> Floats:
        """How many independent numbers the rows of each load (L,) are worth.

        In flight that is one for each group; each manoeuvre meets another flow.
        """
        parts = [self.of_load(k) for k in range(len(self.names))]
        if self.group is not None:
            return np.array([float(np.unique(self.group[part]).size) for part in parts])
        moving = [np.any(self.speed[part] > 0.0) for part in parts]
        return np.minimum(self.counts, np.where(moving, INDEPENDENT, INDEPENDENT_AT_REST))

    def left(self, kept: NDArray[np.bool_]) -> Rows:
        """The same rows, without weight where ``kept``, shape (M,), is false."""
        return replace(self, weight=self.weight * kept)
