"""What is known of a propeller's section constants before its own data are looked at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.arrays.types import Floats
from propmap.catalogue.identified import PARAMETERS

HELD = {"c_l2": 2.0}
"""Held at one value for all: its value after stall and ``alpha_0`` would trade for each other."""

LOGARITHMIC = np.array([True, True, True, False, True, False, False])
"""Whose logarithm is the coordinate (7,)."""

_DRAG_ANGLE, _ZERO_LIFT = PARAMETERS.index("drag_angle"), PARAMETERS.index("zero_lift_angle")


@dataclass(frozen=True, eq=False)
class PopulationPrior:
    """Independent normal distributions of coordinates of the constants.

    Coordinates are logarithms of c_l1, c_d, alpha_0 and c_d0, the zero-lift angle and Reynolds
    camber themselves, and the angle of least pressure drag from the chord line, which is
    ``zero_lift_angle`` + ``drag_angle``.

    Attributes
    ----------
    mean, deviation : ndarray, shape (7,)
        Of each coordinate.
    """

    mean: Floats
    deviation: Floats


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
