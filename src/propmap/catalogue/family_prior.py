"""What identified propellers say of one that is not: of its family, or of any."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from propmap.catalogue.identified import Identified
from propmap.catalogue.prior import PopulationPrior, coordinates
from propmap.catalogue.spread import Spread, variance_of

LEAST_WITHIN = 0.3
"""Least spread within families, as a share of that between them: by moments it may come out 0."""


def family_prior(members: Sequence[Identified], spread: Spread) -> PopulationPrior:
    """The distribution of a further propeller of the family of which ``members`` are known.

    Each coordinate by itself: the family's mean has the normal distribution of families' means
    before, and each member is a draw about it with an error of its fit.  Without members this is
    the distribution over all propellers.

    Parameters
    ----------
    members : sequence of Identified
        Other propellers of the family.
    spread : Spread
        Of families and within them, from ``spread.spread``.
    """
    between = spread.between**2
    within = np.maximum(spread.within, LEAST_WITHIN * spread.between) ** 2
    precision, pull = 1.0 / between, spread.mean / between
    for one in members:
        weight = 1.0 / (within + variance_of(one))
        precision, pull = precision + weight, pull + weight * coordinates(one.constants)
    return PopulationPrior(pull / precision, np.sqrt(1.0 / precision + within))
