"""What one more free parameter changes in a fit: assumptions that fail, terms of the body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from propmap.fit.fitted import Fitted
from propmap.fit.parameters import MOUNT, Choice, described
from propmap.fit.residuals import rms
from propmap.fit.rows import Rows
from propmap.fit.search import search
from propmap.fit.uncertainty import uncertainty
from propmap.model.drag_factor import drag_factor_accepted
from propmap.typing import Floats

TELLING = 0.7
"""Share of the residuals' size below which giving up an assumption is worth saying."""

POOR = 0.03
"""Relative residual from which a fit is looked into."""

ASSUMPTIONS = {
    "zero_lift_angle": "C_L(0) = 0, an uncambered section",
    "c_d0": "c_d0 = 0.01, the constant drag",
    "mount_area": "the rotor drag without more in the slipstream",
}
"""What holds as long as the parameter is not free."""

BODY_TERMS = ("lift_area", "drag_area_x")

LEAST_FALL = 0.05
"""Share by which a term of the body has to lower the residuals to earn its place."""


def failing_assumptions(fitted: Fitted, rows_for: Callable[[Choice], Rows]) -> list[str]:
    """Which assumptions of the section law a poor fit points at.

    Parameters
    ----------
    fitted : Fitted
        The fit.
    rows_for : callable
        The same data as rows for another choice of free parameters.

    Returns
    -------
    list of str
        A sentence per assumption that lowers the residuals by 30 % or more when it is given up;
        none where the fit is good.
    """
    size = rms(fitted.minimum.residual)
    if size < POOR:
        return []
    told = []
    for name, assumption in ASSUMPTIONS.items():
        acts = name not in MOUNT or "drag" in fitted.rows.names
        if name in fitted.choice.free or not acts:
            continue
        choice, begin = _with(fitted, name)
        again = search(rows_for(choice), choice, [choice.first, begin], error=fitted.error)
        left = rms(again.residual) / size
        if left < TELLING:
            told.append(
                f"{assumption}, does not hold: with {name} free ({again.x[-1]:.3g} "
                f"{described(name).unit}) the residuals fall to {100.0 * left:.0f} %"
            )
    return told


def body_terms_verdict(fitted: Fitted, rows_for: Callable[[Choice], Rows]) -> list[str]:
    """Whether lift and drag of the body earn their place in a flight fit (section III.A).

    A term does if its 95 % interval leaves out zero and the residuals fall by more than 5 %.

    Parameters
    ----------
    fitted : Fitted
        The fit without them.
    rows_for : callable
        The same data as rows for another choice of free parameters.

    Returns
    -------
    list of str
        A sentence per term of the body that was not free.
    """
    told = []
    size = rms(fitted.minimum.residual)
    for name in BODY_TERMS:
        if name in fitted.choice.free:
            continue
        choice, begin = _with(fitted, name)
        rows = rows_for(choice)
        again = search(rows, choice, [begin], error=fitted.error)
        sure = uncertainty(rows, choice, again, fitted.error)
        fall = 1.0 - rms(again.residual) / size if size > 0.0 else 0.0
        shift = np.max(np.abs(again.x[:-1] - fitted.x) / fitted.choice.column("spread"))
        nonzero = sure.low[-1] > 0.0 or sure.high[-1] < 0.0
        earns = "earns its place" if nonzero and fall > LEAST_FALL else "does not earn its place"
        told.append(
            f"{name} {earns}: {again.x[-1]:.4g} m^2 ({sure.low[-1]:.2g} to {sure.high[-1]:.2g}), "
            f"residuals {-100.0 * fall:+.1f} %, the other parameters move by at most "
            f"{shift:.2f} of their spread"
        )
    return told


def _with(fitted: Fitted, name: str) -> tuple[Choice, Floats]:
    """The choice of a fit with one more free parameter, the last, and where to begin."""
    fixed = {k: v for k, v in fitted.choice.fixed.items() if k != name}
    with drag_factor_accepted():
        choice = replace(fitted.choice, free=(*fitted.choice.free, name), fixed=fixed)
    return choice, np.append(fitted.x, fitted.values.get(name, described(name).start))
