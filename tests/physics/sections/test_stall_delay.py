"""Snel's stall delay: what it gives back, its bounds, and the solver with it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import propmap as pm
from propmap.arrays.namespace import by_numpy
from propmap.engine.rotor_arrays import rotor_arrays
from propmap.physics.element import annulus, element_forces
from propmap.physics.sections.law import SectionFlow
from propmap.physics.velocities import azimuth_nodes
from propmap.solve.problem import Case, annulus_problem, residual
from propmap.solve.root import MAX_STEPS, search
from tests.physics.paper_physics import TABLE_I, lift

BLADE, LAW = pm.propeller("apc-8x6e"), pm.airfoil("paper-soft")
STRONG = "stall-delay:strength=12"


def model(*texts: str, law: Any = LAW, blade: pm.Propeller = BLADE) -> pm.Model:
    return pm.Model(blade, law, corrections=tuple(pm.correction(text) for text in texts))


def lift_at(law: Any, angle: np.ndarray, ratio: float) -> np.ndarray:
    ones = np.ones_like(angle)
    flow = SectionFlow(angle, np.sin(angle), np.cos(angle), ones, ones, chord=ratio, radius=1.0)
    with by_numpy():
        return np.asarray(law.coefficients(flow).lift)


def test_a_share_of_the_attached_lift_comes_back() -> None:
    """3 (c/y)^2 of what is missing to the straight line, up to 30 degrees on either side."""
    law, angle = rotor_arrays(model("stall-delay")).law, np.radians(np.linspace(-30.0, 30.0, 61))
    flat, straight = lift(angle, TABLE_I["soft"]), 6.9 * angle
    for ratio, share in ((0.0, 0.0), (0.3, 0.27), (0.5, 0.75), (0.9, 1.0)):
        want = flat + share * (straight - flat)
        np.testing.assert_allclose(lift_at(law, angle, ratio), want, rtol=1e-9, atol=1e-12)


def test_nothing_comes_back_beyond_sixty_degrees() -> None:
    law, plain = rotor_arrays(model("stall-delay")).law, rotor_arrays(model()).law
    angle = np.radians([-170.0, -90.0, -60.0, 60.0, 100.0, 179.0])
    np.testing.assert_array_equal(lift_at(law, angle, 0.6), lift_at(plain, angle, 0.6))
    inside = np.radians([45.0])
    assert lift_at(plain, inside, 0.6) < lift_at(law, inside, 0.6) < 6.9 * inside


def test_without_strength_loads_are_the_papers() -> None:
    points = (600.0, np.array([0.0, 5.0, 12.0]), np.array([0.0, 0.4, 1.5]))
    plain = pm.Rotor(model(), compiled=False).loads(*points)
    none = pm.Rotor(model("stall-delay:strength=0"), compiled=False).loads(*points)
    np.testing.assert_allclose(none.thrust, plain.thrust, rtol=1e-3)
    np.testing.assert_allclose(none.torque, plain.torque, rtol=1e-3)


def test_a_stalled_root_lifts_more() -> None:
    plain, delayed = (
        pm.Rotor(model(*texts), compiled=False).inflow(600.0, 0.0, 0.0, radius=[0.026, 0.09])
        for texts in ((), ("stall-delay",))
    )
    gain = delayed.thrust_per_radius / plain.thrust_per_radius
    assert plain.past_stall[0, 0] > 0.0
    assert gain[0] > 1.2
    assert gain[1] == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("strength", ["-1", "inf", "nan"])
def test_a_strength_that_cannot_be_is_refused(strength: str) -> None:
    with pytest.raises(pm.InputError, match="3 in Snel's form"):
        pm.correction(f"stall-delay:strength={strength}")


def test_a_law_without_attached_lift_is_refused() -> None:
    simple = pm.Airfoil(0.0, 5.0, 1.8, 0.36, lift_law="simplified")
    with pytest.raises(pm.InputError, match="no attached lift"):
        model("stall-delay", law=simple)


def stations(count: int, seed: int) -> tuple[Any, ...]:
    """Radii [m] (1, n), most of them near the hub, and the flow."""
    random = np.random.default_rng(seed)
    radius = BLADE.root + 0.07 * random.uniform(0.0, 1.0, (1, count)) ** 2
    omega = random.uniform(100.0, 900.0, count)
    along, across = random.uniform(0.0, 15.0, count), random.uniform(0.0, 20.0, count)
    across[::4], along[1::4] = 0.0, 0.0
    return radius, omega, along, across


def test_slopes_of_the_forces_are_their_derivatives() -> None:
    arrays = rotor_arrays(model("stall-delay"))
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
                assert np.abs(here[slope] - want).max() < 1e-6 * np.abs(want).max()


@pytest.mark.parametrize("alpha_0", [0.2, 0.356, 0.8])
def test_bounds_hold_for_any_share(alpha_0: float) -> None:
    law = rotor_arrays(model("stall-delay", law=LAW.with_parameters(alpha_0=alpha_0))).law
    with by_numpy():
        bounds = law.bounds()
    angle = np.linspace(-np.pi, np.pi, 40001)
    inner = angle[1:-1]
    for ratio in (0.0, 0.2, 0.4, 0.577, 2.0):
        values = lift_at(law, angle, ratio)
        bend = np.diff(values, 2) / (angle[1] - angle[0]) ** 2
        assert np.abs(values).max() <= bounds.lift
        assert np.abs(bend).max() <= bounds.lift_bend
        assert bend[inner > bounds.attached_from].max() <= bounds.foot_bend
        attached = (inner > bounds.attached_from) & (inner < bounds.attached_to)
        assert bend[attached & (inner > 0.0)].max() <= bounds.attached_bend + 1e-4
        rising = (angle > 0.0) & (angle < bounds.attached_to)
        assert (values[rising] <= bounds.attached_slope * angle[rising] * (1.0 + 1e-12)).all()


@pytest.mark.parametrize("texts", [("stall-delay",), (STRONG,), (STRONG, "prandtl-glauert")])
def test_the_search_finds_the_largest_root(texts: tuple[str, ...]) -> None:
    arrays = rotor_arrays(model(*texts))
    radius, *flow = stations(120, 8)
    nodes = azimuth_nodes(16)
    with by_numpy():
        case: Case = Case(arrays, *flow, None)
        problem = annulus_problem(case, radius)
        ended = search(problem, np.array(MAX_STEPS), nodes)
        assert ended.found.all()
        size = flow[0] * radius[0] + flow[1] + flow[2]
        found = np.asarray(ended.inflow)
        assert (np.asarray(residual(problem, found - 1e-6 * size, nodes)) >= 0.0).all()
        # Above it the momentum prevails everywhere, in fine steps up to twice the speed.
        for share in np.geomspace(1e-6, 2.0, 1200):
            assert (np.asarray(residual(problem, found + share * size, nodes)) <= 0.0).all()
