"""Loads of a propeller as a prior foretells them, beside its measurements."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.catalogue.expected import PopulationPrior, constants_of, coordinates, slopes_of
from propmap.fit.population.coefficients import AxialTest
from propmap.typing import Floats

BAND = 1.959964
"""Standard deviations on either side that hold 95 % of a normal distribution."""


class Foretold(NamedTuple):
    """How far C_T and C_P are off, and what their bands of 95 % hold; (2,) each.

    Attributes
    ----------
    errors : ndarray
        Rms over rms of what was measured [-], of all rows or those that were foretold.
    at_rest, moving : ndarray
        Share of the rows inside the band; NaN where there are none.
    """

    errors: Floats
    at_rest: Floats
    moving: Floats


def foretold(
    test: AxialTest, prior: PopulationPrior, errors: Floats, moving_only: bool = False
) -> Foretold:
    """What the mean of ``prior`` and its covariance say of the rows of ``test``.

    Parameters
    ----------
    test : AxialTest
        The measurements.
    prior : PopulationPrior
        Of the constants.
    errors : ndarray, shape (2,)
        Standard deviations of C_T and C_P [-] about the model with the best constants.
    moving_only : bool
        Whether rows at rest are left out.
    """
    value, slope = test.modelled(constants_of(prior.mean))
    by_place = np.einsum("lcn,cp->lpn", slope, slopes_of(prior.mean))
    variance = np.einsum("lpn,pq,lqn->ln", by_place, prior.covariance, by_place)
    apart = value - test.measured
    inside = np.abs(apart) <= BAND * np.sqrt(variance + np.square(errors)[:, None])
    moving = test.tested.advance > 0.0
    counted = moving if moving_only else np.ones_like(moving)
    return Foretold(
        errors=np.sqrt(
            np.nanmean(apart[:, counted] ** 2, axis=1)
            / np.mean(test.measured[:, counted] ** 2, axis=1)
        ),
        at_rest=_share(inside[:, ~moving]),
        moving=_share(inside[:, moving]),
    )


def posterior(constants: Floats, covariance: Floats) -> PopulationPrior:
    """The distribution of constants (7,) with a ``covariance`` (7, 7), in coordinates."""
    place = coordinates(constants)
    back = np.linalg.inv(slopes_of(place))
    return PopulationPrior.of(place, back @ covariance @ back.T)


def _share(inside: NDArray[np.bool_]) -> Floats:
    # Where no inflow was found the band holds nothing.
    return inside.mean(axis=1) if inside.size else np.full(2, np.nan)
