"""Operating points of a fit's data, and which points lie beyond them by which quantity."""

from __future__ import annotations

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.fit.fit import coverage
from propmap.model.envelope import MAIN_PART, Envelope
from propmap.units import RPM

RADIUS = 0.1
OMEGA = np.array([500.0, 400.0, 600.0, 0.0])
FOUND = Envelope.of(OMEGA, np.array([0.0, 4.0, -3.0, 1.0]), np.array([0.0, 3.0, 6.0, 9.0]), RADIUS)


def test_the_ranges_are_those_of_the_rotors_that_turn() -> None:
    assert FOUND.edgewise_ratio == pytest.approx((0.0, 0.1))
    assert FOUND.advance_ratio == pytest.approx((0.0, 0.125))
    assert FOUND.climb_ratio == pytest.approx((-0.05, 0.1))
    assert FOUND.rpm == pytest.approx((400.0 / RPM, 600.0 / RPM))
    # Single samples do not widen the main part.
    inplane = np.append(np.linspace(0.0, 5.0, 999), 40.0)
    flow = np.full(1000, 500.0), np.zeros(1000), inplane
    assert Envelope.of(*flow, RADIUS).edgewise_ratio[1] == pytest.approx(0.8)
    main = Envelope.of(*flow, RADIUS, MAIN_PART)
    assert main.edgewise_ratio[1] == pytest.approx(0.1, abs=0.002)


@pytest.mark.parametrize(
    ("point", "leaves"),
    [
        ((500.0, 0.0, 3.0), set()),
        ((500.0, -3.6, 0.0), {"climb_ratio"}),
        ((500.0, 0.0, 7.0), {"edgewise_ratio", "advance_ratio"}),
        ((700.0, 0.0, 0.0), set()),
        ((730.0, 0.0, 0.0), {"rpm"}),
    ],
)
def test_the_quantity_that_leaves_is_named(
    point: tuple[float, float, float], leaves: set[str]
) -> None:
    beyond = FOUND.beyond(*(np.array([v]) for v in point), RADIUS)
    assert {name for name, excess in beyond.excess.items() if excess.any()} == leaves
    assert beyond.points.tolist() == [bool(leaves)]
    assert bool(beyond.sentences()) == bool(leaves)


def test_a_sample_is_beyond_where_one_rotor_is_and_its_excess_is_told() -> None:
    omega, axial = np.full((4, 2), 500.0), np.zeros((4, 2))
    inplane = np.zeros((4, 2))
    inplane[3, 1] = 10.0
    beyond = FOUND.beyond(omega, axial, inplane, RADIUS)
    assert beyond.samples.tolist() == [False, False, False, True]
    assert beyond.excess["edgewise_ratio"][3, 1] == pytest.approx(0.1)
    (told,) = beyond.sentences("samples")
    assert told.startswith("25.0% of the samples are outside the fitted data: V sin(beta)")
    assert "up to 0.2 (data 0 to 0.1; 25.0% outside)" in told


def test_points_are_grouped_by_angle_and_rest_apart() -> None:
    omega = np.array([500.0, 400.0, 600.0, 500.0, 0.0])
    speed = np.array([0.0, 5.0, 10.0, 2.0, 3.0])
    beta = np.radians([70.0, 84.0, 95.0, 10.0, 90.0])
    found = coverage(omega, speed, beta, RADIUS)
    # A rotor that stands still has no advance ratio.
    assert found.points == 4
    assert found.rpm == pytest.approx((400.0 / RPM, 600.0 / RPM))
    assert found.speed == (0.0, 10.0)
    assert found.at_rest is not None and found.at_rest.points == 1
    steep, edgewise = found.angles
    assert (steep.points, edgewise.points) == (1, 2)
    assert edgewise.beta == pytest.approx((84.0, 95.0))
    assert edgewise.typical_beta == pytest.approx(89.5)
    assert edgewise.speed == (5.0, 10.0)
    assert edgewise.advance == pytest.approx((5.0 / 40.0, 10.0 / 60.0))

    rest = coverage(np.array([300.0, 500.0]), np.zeros(2), np.zeros(2), RADIUS)
    assert rest.angles == [] and rest.at_rest is not None and rest.at_rest.points == 2
    with pytest.raises(InputError, match="stands still at all points"):
        coverage(np.zeros(2), np.ones(2), np.zeros(2), RADIUS)
