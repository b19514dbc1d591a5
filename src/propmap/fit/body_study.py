"""Whether the body's lift and drag earn their place in a flight fit: section III.A's study."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from propmap.fit.fitted import Fitted
from propmap.fit.parameters import Choice
from propmap.fit.rows import Rows
from propmap.fit.search import search
from propmap.fit.uncertainty import uncertainty
from propmap.vehicle.vehicle import Vehicle

TERMS = ("lift_area", "drag_area_x")


def wing_values(vehicle: Vehicle) -> dict[str, float]:
    """The wing's parameters by name, as the vehicle file gives them."""
    wing = vehicle.wing
    if wing is None:
        return {}
    return {"wing_c_l1": wing.c_l1, "wing_c_l2": wing.c_l2, "wing_alpha_0": wing.alpha_0}


def body_terms_verdict(fitted: Fitted, rows_for: Callable[[Choice], Rows]) -> list[str]:
    """A sentence per term of the body: what adding it to the free parameters changes.

    fitted : the fit without them.  rows_for : the same data as rows for another choice of free
    parameters.

    A term earns its place if its 95 % interval leaves out zero and the residuals fall by more
    than five per cent.
    """
    told = []
    size = float(np.sqrt(np.mean(fitted.minimum.residual**2)))
    for name in TERMS:
        if name in fitted.choice.free:
            continue
        choice = Choice((*fitted.choice.free, name), fitted.choice.fixed, fitted.choice.priors)
        rows = rows_for(choice)
        again = search(rows, choice, [np.append(fitted.x, fitted.values[name])])
        sure = uncertainty(rows, choice, again)
        fall = 1.0 - float(np.sqrt(np.mean(again.residual**2))) / size if size > 0.0 else 0.0
        spread = choice.column("spread")[:-1]
        shift = np.max(np.abs(again.x[:-1] - fitted.x) / spread)
        nonzero = sure.low[-1] > 0.0 or sure.high[-1] < 0.0
        earns = "earns its place" if nonzero and fall > 0.05 else "does not earn its place"
        told.append(
            f"{name} {earns}: {again.x[-1]:.4g} m^2 ({sure.low[-1]:.2g} to {sure.high[-1]:.2g}), "
            f"residuals {-100.0 * fall:+.1f} %, the other parameters move by at most "
            f"{shift:.2f} of their spread"
        )
    return told
