"""Coordinates of the constants, and the prior over propellers."""

from __future__ import annotations

import numpy as np

from propmap.catalogue.expected import POPULATION, constants_of, coordinates, slopes_of
from propmap.catalogue.identified import PARAMETERS

CONSTANTS = np.array([5.3, 2.4, 2.6, 0.23, -0.045, 0.024, -0.019, 0.07])


def test_coordinates_and_constants_are_each_other_s_inverse() -> None:
    many = CONSTANTS * np.random.default_rng(1).uniform(0.5, 1.5, (20, CONSTANTS.size))
    np.testing.assert_allclose(constants_of(coordinates(many)), many, rtol=1e-14)


def test_the_drag_angle_s_coordinate_is_from_the_chord_line() -> None:
    place = coordinates(CONSTANTS)
    assert np.isclose(place[PARAMETERS.index("drag_angle")], -0.045 + 0.07)
    np.testing.assert_allclose(place[0], np.log(5.3))


def test_slopes_are_central_differences() -> None:
    place, step = coordinates(CONSTANTS), 1e-6
    for k, row in enumerate(np.eye(CONSTANTS.size)):
        change = constants_of(place + step * row) - constants_of(place - step * row)
        np.testing.assert_allclose(slopes_of(place)[:, k], change / (2.0 * step), atol=1e-8)


def test_the_population_is_that_of_cambered_sections_at_low_reynolds_numbers() -> None:
    mean = dict(zip(PARAMETERS, constants_of(POPULATION.mean), strict=True))
    assert mean["zero_lift_angle"] < 0.0 and mean["reynolds_camber"] < 0.0
    # Least drag above zero lift, and lift below that of an ideal section.
    assert mean["drag_angle"] > 0.0 and 4.0 < mean["c_l1"] < 2.0 * np.pi
    assert (POPULATION.deviation > 0.0).all()
