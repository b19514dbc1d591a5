"""Prandtl and Glauert's rule: its factor, its derivatives, its bounds, and the solver with it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import propmap as pm
from propmap.arrays.namespace import by_numpy
from propmap.engine.rotor_arrays import rotor_arrays
from propmap.physics.element import annulus, element_forces
from propmap.physics.sections.compressible import (
    LARGEST_BEND,
    LARGEST_FACTOR,
    LARGEST_SLOPE,
    mach_factor,
)
from propmap.physics.sections.law import SectionFlow
from propmap.physics.velocities import azimuth_nodes
from propmap.solve.problem import Case, annulus_problem, residual
from propmap.solve.root import MAX_STEPS, search

BLADE, LAW = pm.propeller("apc-8x6e"), pm.airfoil("paper-soft")


def model(*texts: str, law: Any = LAW) -> pm.Model:
    return pm.Model(BLADE, law, corrections=tuple(pm.correction(text) for text in texts))


def lift_at(law: Any, angle: np.ndarray, speed: np.ndarray) -> np.ndarray:
    ones = np.ones_like(angle)
    flow = SectionFlow(angle, np.sin(angle), np.cos(angle), 1e3 * speed, ones, speed=speed)
    with by_numpy():
        return np.asarray(law.coefficients(flow).lift)


def test_lift_is_divided_by_the_root_of_one_minus_mach_squared() -> None:
    plain, raised = (
        rotor_arrays(model()).law,
        rotor_arrays(model("prandtl-glauert:sound_mps=340")).law,
    )
    for mach in (0.0, 0.3, 0.6):
        angle, speed = np.linspace(-3.0, 3.0, 61), np.full(61, 340.0 * mach)
        want = lift_at(plain, angle, speed) / np.sqrt(1.0 - mach**2)
        np.testing.assert_allclose(lift_at(raised, angle, speed), want, rtol=1e-12)
    fast, angle = np.array([0.8, 1.5, 9.0]) * 340.0, np.full(3, 0.1)
    want = lift_at(plain, angle, fast) / np.sqrt(1.0 - 0.7**2)
    np.testing.assert_allclose(lift_at(raised, angle, fast), want, rtol=1e-12)


def test_the_factor_is_smooth_and_within_its_bounds() -> None:
    log = np.linspace(np.log(0.02), np.log(3.0), 20001)
    with by_numpy():
        factor, slope = (np.asarray(part) for part in mach_factor(np.exp(log)))
    np.testing.assert_allclose(np.gradient(factor, log)[1:-1], slope[1:-1], atol=2e-3)
    bend = np.abs(np.gradient(slope, log))
    assert factor.max() <= LARGEST_FACTOR * (1.0 + 1e-12)
    assert 0.9 * LARGEST_SLOPE < slope.max() <= LARGEST_SLOPE
    assert 0.9 * LARGEST_BEND < bend.max() <= LARGEST_BEND
    assert (slope >= 0.0).all()


def test_with_sound_infinitely_fast_loads_are_the_papers() -> None:
    points = (600.0, np.array([0.0, 5.0, 12.0]), np.array([0.0, 0.4, 1.5]))
    slow = pm.Rotor(model(), compiled=False).loads(*points)
    fast = pm.Rotor(model("prandtl-glauert:sound_mps=1e9"), compiled=False).loads(*points)
    np.testing.assert_allclose(fast.thrust, slow.thrust, rtol=1e-3)
    np.testing.assert_allclose(fast.torque, slow.torque, rtol=1e-3)


def test_a_fast_tip_lifts_more() -> None:
    plain, raised = (pm.Rotor(model(*t), compiled=False) for t in ((), ("prandtl-glauert",)))
    gain = [
        float(raised.loads(omega, 8.0, 0.2).thrust / plain.loads(omega, 8.0, 0.2).thrust)
        for omega in (700.0, 1500.0)
    ]
    assert 1.0 < gain[0] < 1.03 < gain[1] < 1.15


@pytest.mark.parametrize("sound", ["0", "-340", "inf", "nan"])
def test_a_speed_of_sound_that_cannot_be_is_refused(sound: str) -> None:
    with pytest.raises(pm.InputError, match="give the speed of sound"):
        pm.correction(f"prandtl-glauert:sound_mps={sound}")


def stations(count: int, seed: int) -> tuple[Any, ...]:
    """Radii [m] (1, n), and the flow; at these speeds of sound the tip passes Mach 0.8."""
    random = np.random.default_rng(seed)
    radius = random.uniform(BLADE.root, BLADE.radius, (1, count))
    omega = random.uniform(100.0, 1500.0, count)
    along, across = random.uniform(0.0, 15.0, count), random.uniform(0.0, 30.0, count)
    across[::4], along[1::4] = 0.0, 0.0
    return radius, omega, along, across


def test_slopes_of_the_forces_are_their_derivatives() -> None:
    arrays = rotor_arrays(model("prandtl-glauert:sound_mps=150"))
    radius, *flow = stations(300, 3)
    with by_numpy():
        at = annulus(arrays.blade, arrays.law, arrays.medium, radius, *flow)
        inflow = np.random.default_rng(4).uniform(-5.0, 20.0, (1, 300))
        for sine in (-1.0, 0.3, 1.0):
            here = element_forces(at, inflow, np.float64(sine))
            up, down = (
                element_forces(at, inflow + step, np.float64(sine)) for step in (1e-5, -1e-5)
            )
            for force, slope in ((0, 2), (1, 3)):
                want = (up[force] - down[force]) / 2e-5
                off = np.abs(here[slope] - want)
                assert off.max() < 1e-6 * np.abs(want).max()


def test_bounds_hold_in_the_angle_and_in_the_speed() -> None:
    law = rotor_arrays(model("prandtl-glauert:sound_mps=150")).law
    with by_numpy():
        bounds = law.bounds()
    angle, log = np.linspace(-np.pi, np.pi, 3001), np.linspace(np.log(20.0), np.log(200.0), 401)
    h, k = angle[1] - angle[0], log[1] - log[0]
    grid = np.meshgrid(angle, np.exp(log), indexing="ij")
    lift = lift_at(law, *(values.ravel() for values in grid)).reshape(grid[0].shape)
    bend = np.diff(lift, 2, axis=0)[:, 1:-1] / h**2
    first = np.gradient(lift, k, axis=1)[1:-1, 1:-1]
    both = np.gradient(np.gradient(lift, h, axis=0), k, axis=1)[1:-1, 1:-1]
    second = np.diff(lift, 2, axis=1)[1:-1] / k**2
    rest = np.abs(first) + np.abs(both) + np.abs(second)
    assert np.abs(lift).max() <= bounds.lift
    assert (np.abs(bend) + rest).max() <= bounds.lift_bend
    inner = angle[1:-1]
    upwards = np.maximum(bend, 0.0) + rest
    assert upwards[inner > bounds.attached_from].max() <= bounds.foot_bend
    attached = (inner > bounds.attached_from) & (inner < bounds.attached_to)
    assert upwards[attached].max() <= bounds.attached_bend
    rising = (angle > 0.0) & (angle < bounds.attached_to)
    assert (lift[rising] <= bounds.attached_slope * angle[rising, None] + 1e-9).all()


def test_the_search_finds_the_largest_root() -> None:
    arrays = rotor_arrays(model("prandtl-glauert:sound_mps=150"))
    radius, *flow = stations(120, 8)
    nodes = azimuth_nodes(16)
    with by_numpy():
        case: Case = Case(arrays, *flow, None)
        problem = annulus_problem(case, radius)
        ended = search(problem, np.array(MAX_STEPS), nodes)
        assert ended.found.all()
        size = flow[0] * radius[0] + flow[1] + flow[2]
        step = 1e-6 * size
        found = np.asarray(ended.inflow)
        assert (np.asarray(residual(problem, found - step, nodes)) >= 0.0).all()
        # Above it the momentum prevails everywhere, in fine steps up to twice the speed.
        for share in np.geomspace(1e-6, 2.0, 1200):
            assert (np.asarray(residual(problem, found + share * size, nodes)) <= 0.0).all()
