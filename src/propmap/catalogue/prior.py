"""What is known of a propeller's section constants before its own data are looked at."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from propmap.catalogue.identified import PARAMETERS
from propmap.typing import Floats

HELD = {"c_l2": 2.0}
"""Held at one value for all: its value after stall and ``alpha_0`` would trade for each other."""

LOGARITHMIC = np.array([True, True, True, False, True, False, False])
"""Whose logarithm is the coordinate (7,)."""

_DRAG_ANGLE, _ZERO_LIFT = PARAMETERS.index("drag_angle"), PARAMETERS.index("zero_lift_angle")


@dataclass(frozen=True, eq=False)
class PopulationPrior:
    """A normal distribution of coordinates of the constants.

    Coordinates are logarithms of c_l1, c_d, alpha_0 and c_d0, the zero-lift angle and Reynolds
    camber themselves, and the angle of least pressure drag from the chord line, which is
    ``zero_lift_angle`` + ``drag_angle``.

    Attributes
    ----------
    mean, deviation : ndarray, shape (7,)
        Of each coordinate.
    correlation : ndarray, shape (7, 7)
        Of the coordinates; independent ones unless given.
    """

    mean: Floats
    deviation: Floats
    correlation: Floats = field(default_factory=lambda: np.eye(len(PARAMETERS)))

    @classmethod
    def of(cls, mean: Floats, covariance: Floats) -> PopulationPrior:
        """The distribution with this ``mean`` (7,) and ``covariance`` (7, 7)."""
        deviation = np.sqrt(np.diag(covariance))
        return cls(mean, deviation, covariance / np.outer(deviation, deviation))

    @property
    def covariance(self) -> Floats:
        """Of the coordinates, (7, 7)."""
        return np.outer(self.deviation, self.deviation) * self.correlation

    @property
    def whitening(self) -> Floats:
        """W (7, 7), with which W (place - ``mean``) has independent parts of variance 1."""
        return np.linalg.inv(np.linalg.cholesky(self.correlation)) / self.deviation


def _population() -> PopulationPrior:
    mean = np.array([5.31, 2.45, 0.290, -0.045, 0.024, -0.019, 0.025])
    between = np.array([0.16, 0.38, 0.10, 0.024, 0.43, 0.014, 0.019])
    within = np.array([0.09, 0.17, 0.10, 0.014, 0.16, 0.007, 0.012])
    centre = np.where(LOGARITHMIC, np.log(np.where(LOGARITHMIC, mean, 1.0)), mean)
    return PopulationPrior(centre, np.hypot(between, within))


POPULATION = _population()
"""Small propellers: means of 129 of them, and their spread between and within families, put
together; a first identification of the UIUC database gave them."""


def coordinates(constants: Floats) -> Floats:
    """Coordinates (..., 7) of constants (..., 7) in the order of ``PARAMETERS``."""
    found = np.where(LOGARITHMIC, np.log(np.where(LOGARITHMIC, constants, 1.0)), constants)
    found[..., _DRAG_ANGLE] = constants[..., _DRAG_ANGLE] + constants[..., _ZERO_LIFT]
    return found


def constants_of(place: Floats) -> Floats:
    """Constants (..., 7) at coordinates, the inverse of ``coordinates``."""
    found = np.where(LOGARITHMIC, np.exp(np.where(LOGARITHMIC, place, 0.0)), place)
    found[..., _DRAG_ANGLE] = place[..., _DRAG_ANGLE] - place[..., _ZERO_LIFT]
    return found


def slopes_of(place: Floats) -> Floats:
    """Derivatives (7, 7) of the constants by the coordinates ``place`` (7,)."""
    slopes = np.diag(np.where(LOGARITHMIC, constants_of(place), 1.0))
    slopes[_DRAG_ANGLE, _ZERO_LIFT] = -1.0
    return slopes


def coordinate_covariance(constants: Floats, covariance: Floats) -> Floats:
    """Covariance (7, 7) of the coordinates, by that of the ``constants`` (7,)."""
    back = np.linalg.inv(slopes_of(coordinates(constants)))
    return np.asarray(back @ covariance @ back.T)
