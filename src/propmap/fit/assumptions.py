"""Which assumption of the section law a misfit points at, found by giving it up."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from propmap.fit.fitted import Fitted
from propmap.fit.parameters import SECTION, Choice
from propmap.fit.rows import Rows
from propmap.fit.search import search

TELLING = 0.7
"""Share of the residuals' size below which giving up an assumption is worth saying."""

POOR = 0.03
"""Relative residual from which a fit is looked into."""

GIVEN_UP = {
    "zero_lift_angle": "C_L(0) = 0, an uncambered section",
    "c_d0": "c_d0 = 0.01, the constant drag",
    "drag_factor": "the rotor drag of blade element theory",
}


def failing_assumptions(fitted: Fitted, rows_for: Callable[[Choice], Rows]) -> list[str]:
    """Sentences on the assumptions whose giving up lowers the residuals by a third or more.

    fitted : the fit that is looked into.
    rows_for : the same data as rows for another choice of free parameters.
    """
    size = float(np.sqrt(np.mean(fitted.minimum.residual**2)))
    if size < POOR:
        return []
    told = []
    for name, assumption in GIVEN_UP.items():
        if name in fitted.choice.free or (
            name == "drag_factor" and "drag" not in fitted.rows.names
        ):
            continue
        choice = Choice((*fitted.choice.free, name), _without(fitted, name), fitted.choice.priors)
        begin = np.append(fitted.x, fitted.values[name])
        again = search(rows_for(choice), choice, [choice.first, begin])
        better = float(np.sqrt(np.mean(again.residual**2))) / size
        if better < TELLING:
            told.append(
                f"{assumption}, does not hold: with {name} free ({again.x[-1]:.3g} "
                f"{SECTION[name].unit}) the residuals fall to {100.0 * better:.0f} %"
            )
    return told


def _without(fitted: Fitted, name: str) -> dict[str, float]:
    return {k: v for k, v in fitted.choice.fixed.items() if k != name}
