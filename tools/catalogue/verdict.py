"""Verdicts on identified constants: a sentence on each propeller, and a summary of errors."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from propmap.catalogue.identified import PARAMETERS, POOR, Identified, badness, one_of_each
from propmap.typing import Floats
from tools.catalogue.database import MeasuredPropeller
from tools.catalogue.identification import Identification

SAME_RPM = 0.02
"""Largest relative difference of rotational speed between repeated runs."""

CONFLICT = 0.05
"""Smallest difference of repeated runs that a verdict reports, as a share of the largest value."""

SAYS_LITTLE = 0.8
"""Posterior over prior standard deviation above which a constant counts as from the prior."""

WORST = 10
"""Number of propellers with the largest errors in a summary."""


def conflict(tested: MeasuredPropeller) -> tuple[float, float]:
    """Return the largest rms differences of C_T and C_P between two runs at nearly equal rpm.

    A difference covers the advance ratios that both runs contain, divided by the largest value of
    the coefficient in both.  Without repeated runs, it is 0.
    """
    moving = [tested.run == k for k in np.unique(tested.run[tested.advance > 0.0])]
    worst = [0.0, 0.0]
    for one, other in itertools.combinations(moving, 2):
        rates = tested.rpm[one].mean(), tested.rpm[other].mean()
        if abs(rates[0] - rates[1]) > SAME_RPM * rates[0]:
            continue
        for k, measured in enumerate((tested.thrust, tested.power)):
            difference = _difference(tested.advance, measured, one, other)
            worst[k] = max(worst[k], difference)
    return worst[0], worst[1]


def _difference(advance: Floats, measured: Floats, one: Floats, other: Floats) -> float:
    order = np.argsort(advance[other])
    x, y = advance[other][order], measured[other][order]
    inside = (advance[one] >= x[0]) & (advance[one] <= x[-1])
    if inside.sum() < 2:
        return 0.0
    difference = measured[one][inside] - np.interp(advance[one][inside], x, y)
    size = max(np.abs(y).max(), np.abs(measured[one]).max())
    return float(np.sqrt(np.mean(difference**2)) / size)


def verdict(tested: MeasuredPropeller, found: Identification) -> str:
    """Return the problems of the constants or the data as a text; "good" without problems."""
    said = []
    differs = [
        f"{100.0 * share:.0f} % in {name}"
        for name, share in zip(("thrust", "power"), conflict(tested), strict=True)
        if share > CONFLICT
    ]
    if differs:
        said.append(f"runs at one rotational speed differ by {' and '.join(differs)}")
    errors = zip(("C_T", "C_P"), (found.thrust_rms, found.power_rms), POOR, strict=True)
    poor = [f"{name} {rms:.4f}" for name, rms, limit in errors if rms > limit]
    if poor:
        said.append(f"worse than nine in ten: rms of {' and '.join(poor)}")
    if not (tested.advance == 0.0).any():
        said.append("no rows at rest")
    if not (tested.advance > 0.0).any():
        said.append("rows at rest alone")
    lost = int(np.isnan(found.residual[0]).sum())
    if lost:
        said.append(f"{lost} rows without a solution")
    prior = [n for n, h in zip(PARAMETERS, found.held, strict=True) if h > SAYS_LITTLE]
    if prior:
        said.append(f"{', '.join(prior)} from the prior")
    return "; ".join(said) or "good"


class Summary(NamedTuple):
    """Errors of C_T and C_P over propellers with a measured blade."""

    propellers: int  # of several measured specimens of a propeller, the best fit counts
    thrust: tuple[float, float]  # median and 90th percentile of the rms of C_T [-]
    power: tuple[float, float]
    worst: list[Identified]  # largest errors relative to their 90th percentiles


def summary(entries: Sequence[Identified]) -> Summary:
    """Return the errors of all identified constants."""
    chosen = [one for one in one_of_each(entries) if one.geometry == "measured"]
    thrust, power = (
        tuple(np.quantile([getattr(one, name) for one in chosen], (0.5, 0.9)).tolist())
        for name in ("thrust_rms", "power_rms")
    )
    worst = sorted(chosen, key=badness, reverse=True)[:WORST]
    return Summary(len(chosen), thrust, power, worst)
