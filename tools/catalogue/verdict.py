"""What the reader of identified constants has to know of them: a sentence per propeller."""

from __future__ import annotations

import itertools

import numpy as np

from propmap.catalogue.identified import PARAMETERS, POOR
from propmap.fit.population.identification import Identification
from propmap.io.uiuc import MeasuredPropeller
from propmap.typing import Floats

ALIKE_RPM = 0.02
"""Share by which the rotational speeds of repeated runs differ at most."""

CONFLICT = 0.05
"""Difference of repeated runs, as a share of the coefficient at the least J, worth saying."""

SAYS_LITTLE = 0.8
"""Posterior over prior standard deviation from which a constant is the prior's."""


def conflict(tested: MeasuredPropeller) -> tuple[float, float]:
    """The largest rms difference of C_T and of C_P between two runs at nearly one rpm.

    Parameters
    ----------
    tested : MeasuredPropeller
        What was measured.

    Returns
    -------
    tuple of float
        Of each coefficient, over where the runs overlap, as a share of its largest value in them;
        0 where no run was repeated.
    """
    moving = [tested.run == k for k in np.unique(tested.run[tested.advance > 0.0])]
    worst = [0.0, 0.0]
    for one, other in itertools.combinations(moving, 2):
        rates = tested.rpm[one].mean(), tested.rpm[other].mean()
        if abs(rates[0] - rates[1]) > ALIKE_RPM * rates[0]:
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
    apart = measured[one][inside] - np.interp(advance[one][inside], x, y)
    size = max(np.abs(y).max(), np.abs(measured[one]).max())
    return float(np.sqrt(np.mean(apart**2)) / size)


def verdict(tested: MeasuredPropeller, found: Identification) -> str:
    """What is wrong with the constants or the data, in a sentence; "good" where nothing is.

    Parameters
    ----------
    tested : MeasuredPropeller
        The data.
    found : Identification
        The constants.
    """
    told = []
    differs = [
        f"{100.0 * share:.0f} % in {name}"
        for name, share in zip(("thrust", "power"), conflict(tested), strict=True)
        if share > CONFLICT
    ]
    if differs:
        told.append(f"runs at one rotational speed differ by {' and '.join(differs)}")
    poor = [
        f"{name} {rms:.4f}"
        for name, rms, limit in (
            ("C_T", found.thrust_rms, POOR[0]),
            ("C_P", found.power_rms, POOR[1]),
        )
        if rms > limit
    ]
    if poor:
        told.append(f"worse than nine in ten: rms of {' and '.join(poor)}")
    if not (tested.advance == 0.0).any():
        told.append("no rows at rest")
    if not (tested.advance > 0.0).any():
        told.append("rows at rest alone")
    lost = int(np.isnan(found.residual[0]).sum())
    if lost:
        told.append(f"{lost} rows without a solution")
    prior = [n for n, h in zip(PARAMETERS, found.held, strict=True) if h > SAYS_LITTLE]
    if prior:
        told.append(f"{', '.join(prior)} from the prior")
    return "; ".join(told) or "good"
