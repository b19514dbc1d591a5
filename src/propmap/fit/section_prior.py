"""What propellers in general tell of the section constants of one that is being fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from propmap.catalogue.identified import PARAMETERS
from propmap.catalogue.prior import (
    LOGARITHMIC,
    PopulationPrior,
    constants_of,
    coordinates,
    slopes_of,
)
from propmap.model.airfoil import Airfoil
from propmap.typing import Floats

SMALLEST = 1e-6
"""Taken for a constant at its bound of 0, which is infinitely far in coordinates that are logs."""

LEAST_ERROR = 0.03
"""Standard deviation of residuals at least, as a share of their scale, where such a prior is
weighed against them: no stand and no model is better, however well few rows are fitted.  With it,
after a fit to static rows, a propeller's rows in flight lie within their intervals as often as they
should: ``python -m tools.after_static``."""


@dataclass(frozen=True, eq=False)
class SectionPrior:
    """A distribution of section constants over propellers, as what is known of one beforehand.

    The constants are not independent of each other: it is the angle of least drag from the chord
    line that propellers have in common, so that ``drag_angle`` falls as ``zero_lift_angle`` rises.

    Attributes
    ----------
    distribution : PopulationPrior
        Of the coordinates of the constants.
    airfoil : Airfoil
        The most likely constants.
    told : str
        In one line, of which propellers this is.
    """

    distribution: PopulationPrior
    airfoil: Airfoil
    told: str

    def apart(self, values: Mapping[str, float]) -> tuple[Floats, Floats]:
        """How many standard deviations each coordinate is from its mean.

        Parameters
        ----------
        values : mapping of str to float
            The constants by name.

        Returns
        -------
        tuple of ndarray
            (7,) in the order of ``PARAMETERS``, and the derivatives by the constants (7, 7).
        """
        constants = np.array([values[name] for name in PARAMETERS])
        inside = np.where(LOGARITHMIC, np.maximum(constants, SMALLEST), constants)
        place = coordinates(inside)
        deviation = self.distribution.deviation
        slopes = np.linalg.inv(slopes_of(place)) / deviation[:, None]
        return (place - self.distribution.mean) / deviation, slopes

    def penalty(self, values: Mapping[str, float], kept: Sequence[int]) -> tuple[Floats, Floats]:
        """Numbers that are independent and of variance 1 beforehand, for least squares.

        Parameters
        ----------
        values : mapping of str to float
            The constants by name.
        kept : sequence of int
            Which K coordinates are known beforehand by this prior.

        Returns
        -------
        tuple of ndarray
            The numbers (K,), and their derivatives by the constants (K, 7).
        """
        apart, slopes = self.apart(values)
        own = list(kept)
        root = np.linalg.cholesky(self.distribution.correlation[np.ix_(own, own)])
        return np.linalg.solve(root, apart[own]), np.linalg.solve(root, slopes[own])

    def of_constant(self, name: str) -> tuple[float, float] | None:
        """Mean and standard deviation of the constant ``name``; None where there is none."""
        if name not in PARAMETERS:
            return None
        k = PARAMETERS.index(name)
        place = self.distribution.mean
        slopes = slopes_of(place)[k]
        variance = slopes @ self.distribution.covariance @ slopes
        return float(constants_of(place)[k]), float(np.sqrt(variance))
