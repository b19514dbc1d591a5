"""How identified constants are spread over propellers, between families and within them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from propmap.arrays.types import Floats
from propmap.catalogue.identified import Identified
from propmap.catalogue.prior import coordinates, slopes_of


class Spread(NamedTuple):
    """Means and standard deviations of coordinates over propellers, (7,) each.

    Attributes
    ----------
    mean : ndarray
        Over families' means and propellers.
    between, within : ndarray
        Between families, and between propellers of a family, without the errors of the fits; the
        first is NaN of a single family.
    """

    mean: Floats
    between: Floats
    within: Floats


def spread(entries: Sequence[Identified]) -> Spread:
    """Means and spreads of the coordinates of ``prior.PopulationPrior``, by moments.

    The variance within families is that about their means, less the mean variance of the fits;
    that between them is the variance of the means, less what the other two put into it.
    """
    place = coordinates(np.stack([one.constants for one in entries]))
    fit = np.stack([variance_of(one) for one in entries])
    family = np.array([one.family for one in entries])
    codes, which, count = np.unique(family, return_inverse=True, return_counts=True)
    means = np.stack([place[which == k].mean(axis=0) for k in range(codes.size)])
    about = ((place - means[which]) ** 2).sum(axis=0) / max(len(entries) - codes.size, 1)
    within = np.maximum(about - fit.mean(axis=0), 0.0)
    if codes.size < 2:
        return Spread(means[0], np.full(place.shape[1], np.nan), np.sqrt(within))
    of_means = means.var(axis=0, ddof=1)
    between = np.maximum(of_means - ((within + fit.mean(axis=0)) * (1.0 / count).mean()), 0.0)
    return Spread(means.mean(axis=0), np.sqrt(between), np.sqrt(within))


def variance_of(one: Identified) -> Floats:
    """Variances (7,) of the coordinates of ``one``, by its fit."""
    back = np.linalg.inv(slopes_of(coordinates(one.constants)))
    return np.diag(back @ one.covariance @ back.T)
