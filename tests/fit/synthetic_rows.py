"""Rows with cheap models, for what does not depend on the physics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from propmap.fit.fit import Fitted
from propmap.fit.least_squares import RowModel, Rows, errors
from propmap.fit.parameters import EVERY, Choice
from propmap.typing import Floats

TRUTH = {"c_l1": 5.0, "c_l2": 2.5, "c_d": 1.5}


def linear_model(design: Mapping[str, Floats]) -> RowModel:
    """The sum of parameter times column; other parameters do not act."""

    def model(values: Mapping[str, float], free: tuple[str, ...]) -> tuple[Floats, Floats]:
        value = sum(values[name] * column for name, column in design.items())
        nothing = np.zeros_like(value)
        slopes = [design.get(name, nothing) for name in free]
        return np.asarray(value), np.reshape(slopes, (len(free), value.size)).T

    return model


def decay_model(time: Floats) -> RowModel:
    """c_l1 exp(-c_l2 t) + c_d."""

    def model(values: Mapping[str, float], free: tuple[str, ...]) -> tuple[Floats, Floats]:
        fall = np.exp(-values["c_l2"] * time)
        slopes = {"c_l1": fall, "c_l2": -values["c_l1"] * time * fall, "c_d": np.ones_like(time)}
        by = np.reshape([slopes[name] for name in free], (len(free), time.size)).T
        return values["c_l1"] * fall + values["c_d"], by

    return model


def rows_of(
    model: RowModel,
    measured: Floats,
    *,
    load: NDArray[np.intp] | None = None,
    group: NDArray[np.intp] | None = None,
) -> Rows:
    """Return rows of scale 1; by default of one load.  Every number is a point."""
    count = measured.size
    load = np.zeros(count, np.intp) if load is None else load
    loads = int(load.max()) + 1
    return Rows(
        names=tuple(f"load_{k}" for k in range(loads)),
        units=("N",) * loads,
        measured=measured,
        load=load,
        scale=np.ones(count),
        speed=np.linspace(0.0, 10.0, count),
        point=np.arange(count),
        group=group,
        model=model,
        weight=np.ones(count),
    )


def true_values(model: RowModel, **truth: float) -> Floats:
    """Return the values of the model at ``TRUTH``, with changes."""
    values = {name: p.start for name, p in EVERY.items()} | TRUTH | truth
    return model(values, ("c_l1",))[0]


def noisy(rows: Rows, noise: Floats) -> Rows:
    return replace(rows, measured=rows.measured + noise)


def truth_of(choice: Choice) -> Floats:
    return np.array([TRUTH[name] for name in choice.free])


def rms_of(fitted: Fitted, load: int) -> float:
    """Root mean square of the residuals of the load of this index, in its unit."""
    return errors(*fitted.compared(load)).rms
