"""The rotors' wakes on each other: limits, symmetries, derivatives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.hub_flow import HubFlow, hub_flow
from propmap.vehicle.interference import check_apart, glauert_inflow, wake_flow
from propmap.vehicle.vehicle import Mount, Vehicle, Wakes

PROPELLER = propmap.propeller("apc-8x6e")
RADIUS = PROPELLER.radius
DENSITY = propmap.Air().density
DISK = DENSITY * np.pi * RADIUS**2
ONE = Wakes()


def vehicle(*positions: tuple[float, float, float]) -> Vehicle:
    return Vehicle("test", 1.0, PROPELLER, tuple(Mount(p) for p in positions))


def square(arm: float) -> Vehicle:
    return vehicle((arm, arm, 0.0), (arm, -arm, 0.0), (-arm, arm, 0.0), (-arm, -arm, 0.0))


def flow_of(made: Vehicle, velocity: object) -> HubFlow:
    v = np.atleast_2d(np.array(velocity, float))
    still = np.zeros_like(v)
    up = still + np.array([0.0, 0.0, 1.0])
    speeds = np.full((len(v), len(made.mounts)), 600.0)
    return hub_flow(made, FlightLog("test", np.arange(len(v)) * 1.0, v, still, up, up, speeds))


def thrusts(made: Vehicle, samples: int, thrust: float = 2.0) -> np.ndarray:
    return np.full((samples, len(made.mounts)), thrust)


def test_glauert_s_inflow_solves_equation_10() -> None:
    rng = np.random.default_rng(0)
    thrust = rng.uniform(0.5, 5.0, 200)
    axial, inplane = rng.uniform(-2.0, 8.0, 200), rng.uniform(0.0, 15.0, 200)
    v, slope = glauert_inflow(thrust, axial, inplane, DISK)
    np.testing.assert_allclose(2.0 * DISK * v * np.hypot(inplane, axial + v), thrust, rtol=1e-6)
    h = 1e-4
    more, less = (glauert_inflow(thrust + d, axial, inplane, DISK)[0] for d in (h, -h))
    np.testing.assert_allclose(slope, (more - less) / (2.0 * h), rtol=1e-4)
    hover, _ = glauert_inflow(np.array([2.0]), np.zeros(1), np.zeros(1), DISK)
    assert hover[0] == pytest.approx(np.sqrt(2.0 / (2.0 * DISK)), rel=1e-6)


def test_no_inflow_without_thrust_and_a_limit_in_descent() -> None:
    none, slope = glauert_inflow(np.array([0.0, -1.0]), np.zeros(2), np.ones(2), DISK)
    np.testing.assert_array_equal(none, 0.0)
    np.testing.assert_array_equal(slope, 0.0)
    hover = np.sqrt(2.0 / (2.0 * DISK))
    steep, _ = glauert_inflow(np.array([2.0]), np.array([-10.0 * hover]), np.zeros(1), DISK)
    assert steep[0] <= 2.0 * hover


def test_nothing_between_rotors_far_apart() -> None:
    far = square(100.0 * RADIUS)
    found = wake_flow(far, ONE, flow_of(far, [(8.0, 0.0, 0.0), (0.0, 0.0, 0.0)]), thrusts(far, 2))
    np.testing.assert_allclose(found.added, 0.0, atol=5e-3)


def test_a_rotor_far_below_another_meets_twice_its_inflow_the_upper_nothing() -> None:
    pair = vehicle((0.0, 0.0, 15.0 * RADIUS), (0.0, 0.0, 0.0))
    found = wake_flow(pair, ONE, flow_of(pair, (0.0, 0.0, 0.0)), thrusts(pair, 1))
    hover = np.sqrt(2.0 / (2.0 * DISK))
    upper, lower = found.added[0]
    # The sheet's core takes some of it from the points near the rim.
    assert lower == pytest.approx(2.0 * hover, rel=0.06)
    assert abs(upper) < 0.01 * hover


def test_front_rotors_in_upwash_rear_ones_in_downwash() -> None:
    quad = square(0.15)
    found = wake_flow(quad, ONE, flow_of(quad, (10.0, 0.0, 1.0)), thrusts(quad, 1)).added[0]
    assert found[0] < 0.0 and found[2] > 0.0
    np.testing.assert_allclose(found[[0, 2]], found[[1, 3]], rtol=1e-6)


def test_turning_the_flight_by_a_quarter_turns_what_the_rotors_meet() -> None:
    quad = square(0.15)
    forward, left = wake_flow(
        quad, ONE, flow_of(quad, [(9.0, 0.0, 0.5), (0.0, 9.0, 0.5)]), thrusts(quad, 2)
    ).added
    # Forward: 0 and 1 are ahead; to the left: 0 and 2.  The disk's seven points are not turned.
    np.testing.assert_allclose(forward, left[[2, 0, 3, 1]], atol=0.02)


def test_gains_multiply_each_its_own_part() -> None:
    quad, flow = square(0.15), flow_of(square(0.15), [(9.0, 2.0, -1.0)])
    thrust = thrusts(quad, 1)
    parts = [
        wake_flow(quad, replace(Wakes(0.0, 0.0, 0.0), **{name: 1.0}), flow, thrust).added
        for name in ("ahead", "beside", "downwash")
    ]
    mixed = wake_flow(quad, Wakes(2.0, 3.0, 0.5), flow, thrust).added
    np.testing.assert_allclose(mixed, 2.0 * parts[0] + 3.0 * parts[1] + 0.5 * parts[2])
    assert np.all(parts[0] <= 0.0) and np.all(parts[1] <= 0.0) and np.all(parts[2] >= 0.0)


def test_derivatives_against_differences() -> None:
    quad, rng = square(0.15), np.random.default_rng(3)
    flow = flow_of(quad, rng.normal(0.0, 4.0, (30, 3)) + np.array([0.0, 0.0, 3.0]))
    thrust, wakes, h = rng.uniform(1.0, 4.0, (30, 4)), Wakes(2.0, 0.7, 0.4, 0.8), 1e-5
    found = wake_flow(quad, wakes, flow, thrust)
    size = np.max(np.abs(found.added))
    for name, slope in found.by_gain.items():
        both = [replace(wakes, **{name: getattr(wakes, name) + d}) for d in (h, -h)]
        up, down = (wake_flow(quad, w, flow, thrust).added for w in both)
        np.testing.assert_allclose(slope, (up - down) / (2.0 * h), atol=1e-3 * size, err_msg=name)
    for rotor in range(4):
        step = h * np.eye(4)[rotor]
        up, down = (wake_flow(quad, wakes, flow, thrust + d).added for d in (step, -step))
        np.testing.assert_allclose(
            found.by_thrust[:, :, rotor], (up - down) / (2.0 * h), atol=5e-3 * size
        )


def test_a_rotor_whose_thrust_is_not_known_leaves_the_others_not_known() -> None:
    quad, thrust = square(0.15), thrusts(square(0.15), 2)
    thrust[0, 3] = np.nan
    found = wake_flow(quad, ONE, flow_of(quad, [(5.0, 0.0, 0.0)] * 2), thrust)
    assert np.isnan(found.added[0, :3]).all() and np.isfinite(found.added[1]).all()


def test_two_rotors_in_one_place_are_refused() -> None:
    with pytest.raises(InputError, match=r"rotors 1 and 2 are 0\.001 m apart"):
        check_apart(vehicle((0.0, 0.0, 0.0), (0.001, 0.0, 0.0)))
