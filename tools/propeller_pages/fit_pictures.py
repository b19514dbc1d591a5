"""Plots of the fit of one propeller: C_T and C_P over J, their errors, and both at rest."""

from __future__ import annotations

import numpy as np

from propmap.typing import Floats
from tools.propeller_pages.comparison import Comparison
from tools.propeller_pages.plot import COLORS, Series, plot

NAMES = ("C_T", "C_P")

LEAST_ERRORS = (0.01, 0.006)
"""Minimum range [-] of the error plots, so that cards can be compared."""


def keys(found: Comparison) -> str:
    """Return the legend of colors and rotor speeds as HTML."""
    items = [
        f'<li class="c{n % COLORS}">{curve.rpm[0]:.0f} rpm</li>'
        for n, curve in enumerate(found.moving)
    ]
    return f'<ul class="plot-keys">{"".join(items)}</ul>'


def pictures(found: Comparison) -> list[str]:
    """Return the plots in pairs of C_T and C_P."""
    measured = np.stack([found.tested.thrust, found.tested.power])
    rms = (found.entry.thrust_rms, found.entry.power_rms)
    plots = []
    if found.moving:
        plots += [_over_advance(found, k, measured[k]) for k in range(2)]
        plots += [_errors(found, k, rms[k]) for k in range(2)]
    if found.still is not None:
        plots += [_at_rest(found, k, measured[k]) for k in range(2)]
    return plots


def _over_advance(found: Comparison, k: int, measured: Floats) -> str:
    points = _points(found, measured)
    lines = [
        Series(curve.advance, curve.coefficients[k], line=True, color=n)
        for n, curve in enumerate(found.moving)
    ]
    return plot(NAMES[k], "J", [*points, *lines])


def _errors(found: Comparison, k: int, rms: float) -> str:
    ends = (-LEAST_ERRORS[k], LEAST_ERRORS[k])
    title = f"{NAMES[k]}, model minus measurement"
    return plot(title, "J", _points(found, found.error[k]), rms, ends)


def _at_rest(found: Comparison, k: int, measured: Floats) -> str:
    assert found.still is not None
    rows = found.still.rows
    points = Series(found.tested.rpm[rows], measured[rows], line=False)
    line = Series(found.still.rpm, found.still.coefficients[k], line=True)
    return plot(f"{NAMES[k]} at rest", "rpm", [points, line])


def _points(found: Comparison, values: Floats) -> list[Series]:
    """Return the values of all rows in axial flow over J, in the colors of their curves."""
    return [
        Series(found.tested.advance[curve.rows], values[curve.rows], line=False, color=n)
        for n, curve in enumerate(found.moving)
    ]
