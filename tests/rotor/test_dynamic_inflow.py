"""The inflow as a state: its steady value, its time constants, its motion."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import propmap as pm
from propmap.loads import LOADS
from tests.oracle.literal_harmonics import _element
from tests.oracle.literal_rotor import LiteralRotor, literal_rotor, radial_nodes
from tests.oracle.points import MU, RHO, SECTIONS

BLADE = pm.propeller("apc-8x6e")
R = BLADE.radius
OMEGA = 600.0
PSI = 2.0 * np.pi * np.arange(24) / 24
MASSES = RHO * np.array([8.0 / 3.0 * R**3, 16.0 / 45.0 * R**4, 16.0 / 45.0 * R**4])
"""[kg], [kg m], [kg m]: 8/(3 pi) of rho A R, and 16/(45 pi) of rho A R^2."""

OBLIQUE = np.array([[7.0, 3.0, 2.0], [-10.0, 2.0, 0.0], [0.0, 5.0, -4.0], [12.0, 0.0, -15.0]])
"""Climb, edgewise flight, vortex ring and windmill."""


def dynamic(law: str = "paper-stiff", spin: str = "ccw") -> pm.DynamicInflow:
    corrections = (pm.correction("pitt-peters"),)
    model = pm.Model(BLADE, pm.airfoil(law), corrections=corrections)
    return pm.DynamicInflow(pm.Rotor(model), spin=spin)


class Hover:
    """Solve the rotor in hover by the literal reference, and SciPy: no code is shared."""

    def __init__(self, omega: float = OMEGA) -> None:
        given = (BLADE.station, BLADE.chord, BLADE.twist, BLADE.blades, SECTIONS["stiff"], RHO, MU)
        self.rotor: LiteralRotor = literal_rotor(*given, omega, 0.0, 0.0)
        self.radii, self.weights = radial_nodes(self.rotor, BLADE.station[0], R)
        self.annuli = np.array([self.rotor.inflow_root(y)[0] for y in self.radii])
        rings = self.weights * self.radii
        self.mean = float(rings @ self.annuli / rings.sum())

    def forces(self, mean: float, gradient: float) -> np.ndarray:
        """Thrust and the moment that lifts the advancing side with a changed inflow."""
        found = np.zeros(2)
        for y, weight, v_i in zip(self.radii, self.weights, self.annuli, strict=True):
            local = v_i + mean + y / R * gradient * np.sin(PSI)
            lift, drag, phi = _element(self.rotor, y, local, PSI)
            up = lift * np.cos(phi) - drag * np.sin(phi)
            found += weight * BLADE.blades * np.array([up.mean(), y * (up * np.sin(PSI)).mean()])
        return found

    def eigenvalues(self) -> np.ndarray:
        """Rates of mean inflow and gradient [1/s]: M dv/dt + 2 rho pi R^2 (2 v) dv = (dT/dv) dv,
        and likewise with rho pi R^3 v, which is 1/2 rho pi R^3 times the mass-flow parameter."""
        step = 0.02
        ends = [self.forces(by, 0.0)[0] for by in (step, -step)]
        rolls = [self.forces(0.0, by)[1] for by in (step, -step)]
        by_mean, by_gradient = ((a - b) / (2.0 * step) for a, b in (ends, rolls))
        area = np.pi * R**2
        own = 4.0 * RHO * area * self.mean, RHO * area * R * self.mean
        return np.array([by_mean - own[0], by_gradient - own[1]]) / MASSES[:2]


@pytest.fixture(scope="module")
def hover() -> Hover:
    return Hover()


def test_time_constants_in_hover_are_those_of_the_closed_form(hover: Hover) -> None:
    found = dynamic().time_constants(OMEGA, [0.0, 0.0, 0.0])
    mean, gradient = -1.0 / hover.eigenvalues()
    # Quadratures and differences of two codes.
    np.testing.assert_allclose(found, [mean, gradient, gradient], rtol=1e-3)
    # Those that docs/theory.md tells.
    told = dynamic("paper-apc").time_constants(OMEGA, [0.0, 0.0, 0.0])
    np.testing.assert_allclose(told, [3.0e-3, 1.6e-3, 1.6e-3], rtol=0.03)


def test_a_jump_of_the_rotor_is_followed_as_carpenter_and_fridovich_have_it(hover: Hover) -> None:
    """m dv/dt = T(v) - 2 rho pi R^2 v^2, from far below the steady inflow and from far above."""
    changes = np.linspace(-0.8, 0.8, 17) * hover.mean
    thrust = CubicSpline(changes, [hover.forces(by, 0.0)[0] for by in changes])
    static = float(thrust(0.0))

    def rate(_: float, v: np.ndarray) -> np.ndarray:
        momentum = 2.0 * RHO * np.pi * R**2 * (v**2 - hover.mean**2)
        return np.asarray(thrust(v - hover.mean) - static - momentum) / MASSES[0]

    inflow, still = dynamic(), [0.0, 0.0, 0.0]
    for share in (0.4, 1.6):
        begin, end, count = share * hover.mean, 4e-3, 40
        want = solve_ivp(rate, (0.0, end), [begin], rtol=1e-9, atol=1e-9).y[0, -1]
        assert abs(want - begin) > 0.3 * hover.mean
        state = np.array([begin, 0.0, 0.0])
        for _ in range(count):
            state = inflow.step(state, end / count, OMEGA, still)
        assert state[0] == pytest.approx(want, abs=2e-3 * hover.mean)
        assert abs(state[1:]).max() < 1e-12


@pytest.mark.parametrize("spin", ["ccw", "cw"])
def test_the_steady_state_is_the_static_solution(spin: str) -> None:
    inflow = dynamic("paper-apc", spin)
    state = inflow.steady(OMEGA, OBLIQUE)
    wrench, static = inflow.wrench(state, OMEGA, OBLIQUE), inflow.rotor.wrench(OMEGA, OBLIQUE, spin)
    np.testing.assert_allclose(wrench.force, static.force, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(wrench.moment, static.moment, rtol=1e-12, atol=1e-13)
    rates = inflow.rates(state, OMEGA, OBLIQUE)
    assert abs(rates).max() < 1e-9
    loads, own = inflow.loads(state, OMEGA, OBLIQUE), inflow.rotor.loads_at_velocity(OMEGA, OBLIQUE)
    for name in (*LOADS, "power"):
        np.testing.assert_allclose(getattr(loads, name), getattr(own, name), rtol=1e-12, atol=1e-12)
    assert (loads.status == own.status).all()
    # Their means differ by what the harmonics take off.
    np.testing.assert_allclose(loads.mean_inflow, own.mean_inflow, rtol=0.03)


def test_steps_follow_the_rates() -> None:
    inflow, velocity = dynamic("paper-apc"), OBLIQUE[0]
    start, end = np.array([1.0, 2.0, -2.0]), 3e-3
    want = solve_ivp(
        lambda _, x: inflow.rates(x, OMEGA, velocity), (0.0, end), start, rtol=1e-7, atol=1e-9
    ).y[:, -1]
    errors = []
    for count in (4, 16):
        state = start
        for _ in range(count):
            state = inflow.step(state, end / count, OMEGA, velocity)
        errors.append(abs(state - want).max())
    assert errors[0] < 0.1 and errors[1] < 0.35 * errors[0]  # of the first order
    at = (start, OMEGA, velocity)
    slope = (inflow.step(start, 1e-7, OMEGA, velocity) - start) / 1e-7
    rates = inflow.rates(*at)
    np.testing.assert_allclose(slope, rates, atol=1e-4 * abs(rates).max())


@pytest.mark.parametrize("dt", [1e-3, 0.02, 1e9])
def test_free_responses_decay_for_any_step(dt: float) -> None:
    """In hover the energy of the deviation does not grow at any step."""
    inflow, random = dynamic(), np.random.default_rng(7)
    still = np.zeros(3)
    steady = inflow.steady(OMEGA, still)
    weights = 0.5 * MASSES / np.array([1.0, R, R])  # a moment does work on a gradient over R
    state = steady + random.uniform(-1.5, 1.5, (40, 3)) * steady[0]
    energy = (state - steady) ** 2 @ weights
    for _ in range(4):
        state = inflow.step(state, dt, OMEGA, still)
        now = (state - steady) ** 2 @ weights
        assert (now <= energy * (1.0 + 1e-12)).all()
        energy = now
    if dt >= 10.0:
        np.testing.assert_allclose(state, np.broadcast_to(steady, state.shape), atol=1e-12)


def test_free_responses_decay_in_any_flight() -> None:
    """Random states at random points, in stall and descent too: nothing of them is left."""
    inflow, random = dynamic("paper-apc"), np.random.default_rng(8)
    count = 16
    omega = random.uniform(250.0, 1000.0, count)
    velocity = random.uniform(-12.0, 12.0, (count, 3))
    steady = inflow.steady(omega, velocity)
    assert np.isfinite(steady).all()
    first = state = steady + random.uniform(-4.0, 4.0, (count, 3))
    largest = abs(first - steady).max(axis=1)[:, None]
    # The gradient that thrust drives may grow for a while, with the thrust.
    for dt in (1e-3, 4e-3, 0.02, 0.1, 0.5, 0.5):
        state = inflow.step(state, dt, omega, velocity)
        assert (abs(state - steady) < 2.0 * largest).all()
    assert abs(state - steady).max() < 1e-3
    np.testing.assert_allclose(inflow.step(first, 1e6, omega, velocity), steady, atol=1e-9)


def test_more_downwash_on_one_side_lifts_it_less() -> None:
    inflow, still = dynamic(), [0.0, 0.0, 0.0]
    steady = inflow.steady(OMEGA, still)
    more, towards_x, towards_y = (inflow.wrench(steady + one, OMEGA, still) for one in np.eye(3))
    # Less lift at +x turns about +y, less lift at +y about -x.
    assert towards_x.moment[1] > 1e-3 > abs(towards_x.moment[0])
    assert towards_y.moment[0] < -1e-3 < -abs(towards_y.moment[1])
    assert more.force[2] < inflow.wrench(steady, OMEGA, still).force[2]


def test_a_mirrored_rotor_moves_as_a_mirror_image() -> None:
    """About the plane y = 0: states (mean, x, -y), forces (x, -y, z), moments (-x, y, -z)."""
    ccw, cw = dynamic("paper-apc"), dynamic("paper-apc", "cw")
    flip, state = np.array([1.0, 1.0, -1.0]), np.array([3.0, 1.0, -2.0])
    velocity, image = np.array([7.0, 3.0, 2.0]), np.array([7.0, -3.0, 2.0])
    mirrored = ccw.step(state, 1e-3, OMEGA, velocity) * flip
    np.testing.assert_allclose(cw.step(state * flip, 1e-3, OMEGA, image), mirrored, rtol=1e-9)
    one, other = ccw.wrench(state, OMEGA, velocity), cw.wrench(state * flip, OMEGA, image)
    np.testing.assert_allclose(other.force, one.force * [1.0, -1.0, 1.0], rtol=1e-9)
    np.testing.assert_allclose(other.moment, one.moment * [-1.0, 1.0, -1.0], rtol=1e-9)
    # Both by one solution.
    both, later = cw.advance(state * flip, 1e-3, OMEGA, image)
    np.testing.assert_array_equal(later, cw.step(state * flip, 1e-3, OMEGA, image))
    np.testing.assert_array_equal((both.force, both.moment), (other.force, other.moment))


def test_points_broadcast_over_leading_axes() -> None:
    inflow = dynamic()
    state, omega = np.array([3.0, 1.0, 0.0]), np.array([[500.0], [700.0]])
    velocity = OBLIQUE[:3]
    all_at_once = inflow.step(state, 1e-3, omega, velocity)
    assert all_at_once.shape == (2, 3, 3)
    assert inflow.loads(state, omega, velocity).thrust.shape == (2, 3)
    one = inflow.step(state, 1e-3, omega[1, 0], velocity[2])
    np.testing.assert_allclose(all_at_once[1, 2], one, rtol=1e-9)


def test_what_it_cannot_do_is_refused() -> None:
    plain = pm.Rotor(pm.Model(BLADE, pm.airfoil("paper-apc")))
    with pytest.raises(pm.InputError, match=r"add propmap\.correction"):
        pm.DynamicInflow(plain)
    with pytest.raises(pm.InputError, match="must be 'ccw' or 'cw'"):
        pm.DynamicInflow(dynamic().rotor, spin="left")
    with pytest.raises(pm.InputError, match="its last axis must be the mean inflow"):
        dynamic().rates([1.0, 2.0], OMEGA, [0.0, 0.0, 0.0])
    for wrong in ([1.0 + 1.0j, 0.0, 0.0], np.ma.masked_less([1.0, 0.0, 0.0], 0.5)):
        with pytest.raises(pm.InputError, match=r"state (is .*: give a real|has masked points)"):
            dynamic().rates(wrong, OMEGA, [0.0, 0.0, 0.0])
    with pytest.raises(pm.InputError, match="dt is negative"):
        dynamic().step([1.0, 0.0, 0.0], -1e-3, OMEGA, [0.0, 0.0, 0.0])


def test_a_rotor_at_rest_knows_nothing_of_the_point_before() -> None:
    inflow = dynamic()
    still, alone = (0.0, 0.0, 0.0), None
    for before in (0.0, 600.0):
        inflow.steady(before, (8.0, 0.0, 2.0))
        found = inflow.step((1.0, 0.3, -0.2), 0.01, 0.0, still)
        np.testing.assert_array_equal(inflow.steady(0.0, still), still)
        alone = found if alone is None else alone
        np.testing.assert_array_equal(found, alone)
    barely = inflow.step((1.0, 0.3, -0.2), 0.01, 1e-9, still)
    np.testing.assert_allclose(alone, barely, atol=1e-5)
