"""How far a model is from measurements: per load and per band of speed."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from propmap.arrays.types import Floats

BANDS = (0.0, 3.0, 6.0, 9.0, 12.0, 15.0, np.inf)
"""Edges of the bands of speed [m/s]."""


@dataclass(frozen=True)
class Errors:
    """Errors, model minus measurement, of ``rows`` numbers, in the unit of the load.

    rms, bias (mean), worst (largest, with its sign).  relative_rms : rms over the root mean
    square of the measurements [-].  hover_rms : rms of the hover model, NaN where none was given.
    """

    rows: int
    rms: float
    relative_rms: float
    bias: float
    worst: float
    hover_rms: float


def errors(model: Floats, measured: Floats, hover: Floats | None = None) -> Errors:
    """Errors over all numbers that are both measured and modelled; all (n,)."""
    both = np.isfinite(model) & np.isfinite(measured)
    if not both.any():
        return Errors(0, *(5 * (np.nan,)))
    off = (model - measured)[both]
    size = float(np.sqrt(np.mean(measured[both] ** 2)))
    rms = float(np.sqrt(np.mean(off**2)))
    return Errors(
        rows=int(both.sum()),
        rms=rms,
        relative_rms=rms / size if size > 0.0 else np.nan,
        bias=float(off.mean()),
        worst=float(off[np.argmax(np.abs(off))]),
        hover_rms=np.nan
        if hover is None
        else float(np.sqrt(np.mean((hover - measured)[both] ** 2))),
    )


def by_band(
    model: Floats, measured: Floats, speed: Floats, hover: Floats | None = None
) -> dict[str, Errors]:
    """Errors per band of speed that has numbers, by a name such as "3-6 m/s"."""
    found = {}
    for low, high in itertools.pairwise(BANDS):
        mine = (speed >= low) & (speed < high)
        if mine.any():
            name = f"{low:g}-{high:g} m/s" if np.isfinite(high) else f"above {low:g} m/s"
            part = None if hover is None else hover[mine]
            found[name] = errors(model[mine], measured[mine], part)
    return found
