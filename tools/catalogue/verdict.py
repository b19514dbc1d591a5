"""What the reader of identified constants has to know: a sentence on each, and errors of all."""

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
"""Share by which the rotational speeds of repeated runs differ at most."""

CONFLICT = 0.05
"""Difference of repeated runs, as a share of the coefficient at the least J, worth saying."""

SAYS_LITTLE = 0.8
"""Posterior over prior standard deviation from which a constant is the prior's."""

WORST = 10
"""How many propellers are named as the worst."""


def conflict(tested: MeasuredPropeller) -> tuple[float, float]:
    """The largest rms difference of C_T and of C_P between two runs at nearly one rpm.

    Each is over where the runs overlap, as a share of its largest value in them; 0 where no run was
    repeated.
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
    """Say what is wrong with the constants or the data; "good" where nothing is."""
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

    propellers: int  # of a propeller of which several blades were measured, the best counts
    thrust: tuple[float, float]  # median and 90th percentile of the rms of C_T [-]
    power: tuple[float, float]
    worst: list[Identified]  # those farthest beyond the errors of nine in ten


def summary(entries: Sequence[Identified]) -> Summary:
    """Say how well identified constants fit as a whole."""
    chosen = [one for one in one_of_each(entries) if one.geometry == "measured"]
    thrust, power = (
        tuple(np.quantile([getattr(one, name) for one in chosen], (0.5, 0.9)).tolist())
        for name in ("thrust_rms", "power_rms")
    )
    worst = sorted(chosen, key=badness, reverse=True)[:WORST]
    return Summary(len(chosen), thrust, power, worst)
