"""How far a model is from measurements: over all rows and by speed."""

from __future__ import annotations

import itertools

import msgspec
import numpy as np

from propmap.typing import Floats

BANDS = (0.0, 3.0, 6.0, 9.0, 12.0, 15.0, np.inf)
"""Edges of the bands of speed [m/s]."""


class Errors(msgspec.Struct, frozen=True):
    """Errors of one load, model minus measurement, in the unit of the load.

    Attributes
    ----------
    rows : int
        Numbers that are both measured and modelled.
    rms : float
        Root mean square of the errors.
    relative_rms : float
        ``rms`` over the root mean square of the measurements [-].
    bias : float
        Mean of the errors.
    worst : float
        The error of largest magnitude, with its sign.
    hover_rms : float
        Root mean square of the hover model's errors; NaN where it was not asked for.
    """

    rows: int
    rms: float
    relative_rms: float
    bias: float
    worst: float
    hover_rms: float


class FlightErrors(msgspec.Struct, frozen=True):
    """Errors of one load on one flight, model minus measurement, in the unit of the load.

    Attributes
    ----------
    rows : int
        Numbers that are both measured and modelled.
    rms, bias : float
        Root mean square and mean of the errors.
    cross_validated_rms : float
        Root mean square of the errors on stretches left out of the fit; NaN where it was not done.
    """

    rows: int
    rms: float
    bias: float
    cross_validated_rms: float


def rms(values: Floats) -> float:
    """Root mean square of all values, in their unit."""
    return float(np.sqrt(np.mean(np.square(values))))


def rms_known(values: Floats) -> float:
    """Root mean square of those values that are known; NaN where none is."""
    known = values[np.isfinite(values)]
    return rms(known) if known.size else float("nan")


def errors(model: Floats, measured: Floats, hover: Floats | None = None) -> Errors:
    """Errors over all numbers that are both measured and modelled; arrays of shape (n,)."""
    both = np.isfinite(model) & np.isfinite(measured)
    if not both.any():
        return Errors(0, *(5 * (np.nan,)))
    off = (model - measured)[both]
    size, left = rms(measured[both]), rms(off)
    return Errors(
        rows=int(both.sum()),
        rms=left,
        relative_rms=left / size if size > 0.0 else np.nan,
        bias=float(off.mean()),
        worst=float(off[np.argmax(np.abs(off))]),
        hover_rms=np.nan if hover is None else rms((hover - measured)[both]),
    )


def by_band(
    model: Floats, measured: Floats, speed: Floats, hover: Floats | None = None
) -> dict[str, Errors]:
    """Errors in each band of speed that has numbers, by a name such as "3-6 m/s"."""
    found = {}
    for low, high in itertools.pairwise(BANDS):
        mine = (speed >= low) & (speed < high)
        if mine.any():
            name = f"{low:g}-{high:g} m/s" if np.isfinite(high) else f"above {low:g} m/s"
            part = None if hover is None else hover[mine]
            found[name] = errors(model[mine], measured[mine], part)
    return found
