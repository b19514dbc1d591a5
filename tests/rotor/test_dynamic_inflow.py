"""The inflow as a state: its steady value, its rates, its motion."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import propmap as pm
from propmap.loads import LOADS
from propmap.operating_points import along_and_across
from tests.oracle.literal_harmonics import _element
from tests.oracle.literal_rotor import LiteralRotor, literal_rotor, radial_nodes
from tests.oracle.points import MU, RHO

BLADE = pm.propeller("apc-8x6e")
R = BLADE.radius
OMEGA = 600.0
STILL = [0.0, 0.0, 0.0]
PSI = 2.0 * np.pi * np.arange(24) / 24
DISK, TILT = 8.0 / 3.0 * R**3, 16.0 / 45.0 * R**4
"""Apparent masses per density: 8/(3 pi) of A R, and 16/(45 pi) of A R^2."""

ATTACHED = {"c_l1": 4.2, "c_l2": 2.0, "c_d": 1.3, "alpha_0": 1.2}
"""A section law that does not stall on this blade."""
OBLIQUE = np.array([[7.0, 3.0, 2.0], [-10.0, 2.0, 0.0], [0.0, 5.0, -4.0], [12.0, 0.0, -15.0]])
"""Climb, edgewise flight, vortex ring and windmill."""


def dynamic(law: str | pm.Airfoil = "paper-stiff", spin: Any = "ccw") -> pm.DynamicInflow:
    airfoil = pm.airfoil(law) if isinstance(law, str) else law
    model = pm.Model(BLADE, airfoil, corrections=(pm.correction("pitt-peters"),))
    return pm.DynamicInflow(pm.Rotor(model), spin=spin)


@pytest.fixture(scope="module")
def attached() -> pm.DynamicInflow:
    return dynamic(pm.Airfoil(**ATTACHED, name="attached"))


@pytest.fixture(scope="module")
def literal() -> LiteralRotor:
    """The rotor in hover by the literal reference, with which no code is shared."""
    given = (BLADE.station, BLADE.chord, BLADE.twist, BLADE.blades, ATTACHED, RHO, MU)
    rotor: LiteralRotor = literal_rotor(*given, OMEGA, 0.0, 0.0)
    return rotor


def radii_of_nodes(rotor: pm.Rotor) -> np.ndarray:
    return np.asarray(rotor._core.solution(along_and_across(OMEGA, 0.0, 0.0).rows)["nodes"][0])


def rates_of_annuli(literal: LiteralRotor, radii: np.ndarray, inflow: np.ndarray) -> np.ndarray:
    found = [
        literal.residual(y, np.array([v]), literal.azimuth)[0] / RHO
        for y, v in zip(radii, inflow, strict=True)
    ]
    return np.array(found) / (16.0 / 3.0 * R * radii)


def test_annuli_move_by_the_residual_over_their_mass(
    attached: pm.DynamicInflow, literal: LiteralRotor
) -> None:
    """m dv/dt = residual of (11), from far below the steady inflow and from far above."""
    radii = radii_of_nodes(attached.rotor)
    steady = attached.steady(OMEGA, STILL)
    roots = [literal.inflow_root(y)[0] for y in radii]
    np.testing.assert_allclose(steady[3:], roots, rtol=1e-6)
    for share in (0.4, 1.6):
        begin, end, count = share * steady, 4e-3, 80
        np.testing.assert_allclose(
            attached.rates(begin, OMEGA, STILL)[3:],
            rates_of_annuli(literal, radii, begin[3:]),
            rtol=1e-5,
        )
        want = solve_ivp(
            lambda _, v: rates_of_annuli(literal, radii, v), (0.0, end), begin[3:], rtol=1e-7
        ).y[:, -1]
        state = begin
        for _ in range(count):
            state = attached.step(state, end / count, OMEGA, STILL)
        assert (abs(want - begin[3:]) > 0.2 * steady[3:]).mean() > 0.8
        np.testing.assert_allclose(state[3:], want, atol=3e-3 * steady[3:].max())
        assert abs(state[:3]).max() < 1e-12


def test_eigenvalues_in_hover_are_those_of_annuli_mean_and_gradients(
    attached: pm.DynamicInflow, literal: LiteralRotor
) -> None:
    radii = radii_of_nodes(attached.rotor)
    steady = attached.steady(OMEGA, STILL)[3:]
    step = 1e-3
    slopes = [rates_of_annuli(literal, radii, steady + by) / (2.0 * step) for by in (step, -step)]
    annuli = slopes[0] - slopes[1]
    y, weights = radial_nodes(literal, BLADE.station[0], R)
    inflow = np.array([literal.inflow_root(one)[0] for one in y])
    mean = float((weights * y) @ inflow / (weights @ y))

    def forces(more: float, gradient: float) -> np.ndarray:
        """Thrust and the moment that lifts the advancing side with a changed inflow."""
        found = np.zeros(2)
        for one, weight, v_i in zip(y, weights, inflow, strict=True):
            local = v_i + more + one / R * gradient * np.sin(PSI)
            lift, drag, phi = _element(literal, one, local, PSI)
            up = lift * np.cos(phi) - drag * np.sin(phi)
            found += weight * BLADE.blades * np.array([up.mean(), one * (up * np.sin(PSI)).mean()])
        return found

    by_mean = (forces(step, 0.0)[0] - forces(-step, 0.0)[0]) / (2.0 * step * RHO)
    by_gradient = (forces(0.0, step)[1] - forces(0.0, -step)[1]) / (2.0 * step * RHO)
    area = np.pi * R**2
    harmonics = [
        (by_mean - 4.0 * area * mean) / DISK,
        (by_gradient - area * R * mean) / TILT,
        (by_gradient - area * R * mean) / TILT,
    ]
    linear = attached.linearize(OMEGA, STILL)
    found = np.linalg.eigvals(linear.a)
    assert abs(found.imag).max() < 1e-6 * abs(found).max()
    np.testing.assert_allclose(np.sort(found.real), np.sort([*annuli, *harmonics]), rtol=2e-3)


@pytest.mark.parametrize("spin", ["ccw", "cw"])
def test_the_steady_state_of_attached_blades_is_the_static_solution(spin: str) -> None:
    inflow = dynamic(pm.Airfoil(**ATTACHED, name="attached"), spin)
    velocity = np.vstack([OBLIQUE[:2], [0.0, 0.0, 3.0], STILL])
    state = inflow.steady(OMEGA, velocity)
    wrench = inflow.wrench(state, OMEGA, velocity)
    static = inflow.rotor.wrench(OMEGA, velocity, spin)
    np.testing.assert_allclose(wrench.force, static.force, rtol=3e-6, atol=1e-9)
    np.testing.assert_allclose(wrench.moment, static.moment, rtol=3e-6, atol=1e-9)
    assert abs(inflow.rates(state, OMEGA, velocity)).max() < 2e-3
    loads = inflow.loads(state, OMEGA, velocity)
    own = inflow.rotor.loads_at_velocity(OMEGA, velocity)
    for name in (*LOADS, "power", "mean_inflow"):
        np.testing.assert_allclose(getattr(loads, name), getattr(own, name), rtol=3e-6, atol=1e-9)
    assert (loads.status == own.status).all()
    # In descent, the static solution uses more nodes.
    loads = inflow.loads(inflow.steady(OMEGA, OBLIQUE[2:]), OMEGA, OBLIQUE[2:])
    own = inflow.rotor.loads_at_velocity(OMEGA, OBLIQUE[2:])
    np.testing.assert_allclose(loads.thrust, own.thrust, rtol=2e-3)
    assert loads.status.tolist() == own.status.tolist()


@pytest.mark.parametrize("name", ["paper-soft", "paper-stiff", "paper-apc", "APC 8x6E", "16x8E"])
def test_steady_states_of_stalled_blades_are_close_to_the_static_solution(name: str) -> None:
    """Nodes do not follow the radius of stall, so their number limits the error."""
    paper = name.startswith("paper")
    inflow = dynamic(name) if paper else pm.DynamicInflow(pm.Rotor(pm.catalogue_model(name)))
    random, count = np.random.default_rng(2), 300
    tip = inflow.rotor.model.propeller.radius
    omega = 60.0 / tip * random.uniform(0.5, 1.5, count)
    velocity = (omega * tip)[:, None] * random.uniform([0, 0, -0.01], [0.2, 0, 0.15], (count, 3))
    velocity[::3, 0] = 0.0
    found = inflow.loads(inflow.steady(omega, velocity), omega, velocity).thrust
    exact = inflow.rotor.loads_at_velocity(omega, velocity).thrust
    error = abs(found - exact) / abs(inflow.rotor.loads(omega, 0.0, 0.0).thrust)
    assert np.quantile(error, 0.95) < (2e-3 if paper else 2e-4)
    assert error.max() < (5e-3 if paper else 3e-4)


def test_steps_follow_the_rates() -> None:
    inflow, velocity = dynamic("paper-apc"), OBLIQUE[0]
    start, end = 0.7 * inflow.steady(OMEGA, velocity), 3e-3
    start[:3] += [0.5, 2.0, -2.0]
    want = solve_ivp(
        lambda _, x: inflow.rates(x, OMEGA, velocity), (0.0, end), start, rtol=1e-6, atol=1e-7
    ).y[:, -1]
    errors = []
    for count in (4, 16):
        state = start
        for _ in range(count):
            state = inflow.step(state, end / count, OMEGA, velocity)
        errors.append(abs(state - want).max())
    assert errors[0] < 0.15 and errors[1] < 0.4 * errors[0]  # of the first order
    slope = (inflow.step(start, 1e-7, OMEGA, velocity) - start) / 1e-7
    rates = inflow.rates(start, OMEGA, velocity)
    np.testing.assert_allclose(slope, rates, atol=1e-4 * abs(rates).max())


def test_a_step_of_the_rotor_overshoots_and_settles(attached: pm.DynamicInflow) -> None:
    """Carpenter and Fridovich, NACA TN 3044: thrust overshoots, because the inflow lags."""
    state = attached.steady(500.0, STILL)
    thrust = []
    for _ in range(60):
        wrench, state = attached.advance(state, 1e-3, OMEGA, STILL)
        thrust.append(wrench.force[2])
    first, end = (attached.rotor.loads(w, 0.0, 0.0).thrust for w in (500.0, OMEGA))
    assert first < end < thrust[0]
    assert 1.05 < thrust[0] / end < 1.25
    assert (np.diff(thrust) < 1e-12).all()
    assert thrust[-1] == pytest.approx(float(end), rel=1e-6)


@pytest.mark.parametrize("dt", [5e-4, 0.02, 1e9])
def test_free_responses_end_at_the_steady_state(attached: pm.DynamicInflow, dt: float) -> None:
    random, count = np.random.default_rng(7), 40
    omega = random.uniform(300.0, 900.0, count)
    velocity = random.uniform([-12.0, -12.0, 0.0], [12.0, 12.0, 12.0], (count, 3))
    velocity[::4, :2] = 0.0
    steady = attached.steady(omega, velocity)
    state = steady + 3.0 * random.standard_normal(steady.shape)
    for _ in range(min(int(0.4 / dt), 800) + 40):
        state = attached.step(state, dt, omega, velocity)
    # At the tip, almost unloaded annuli in slow flow settle slowly.
    np.testing.assert_allclose(state, steady, atol=0.1)
    found, want = (attached.wrench(x, omega, velocity).force for x in (state, steady))
    np.testing.assert_allclose(found, want, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("law", ["paper-soft", "paper-apc"])
def test_no_disturbance_in_any_flight_grows(law: str) -> None:
    """Stalled blades, the vortex ring and the windmill state, with noise of single precision."""
    inflow, random, count = dynamic(law), np.random.default_rng(8), 48
    omega = random.uniform(250.0, 1000.0, count)
    velocity = random.uniform(-12.0, 12.0, (count, 3))
    velocity[::3, :2] = 0.0
    velocity[0] = 0.0
    steady = inflow.steady(omega, velocity)
    assert np.isfinite(steady).all()
    most = 10.0 * abs(steady).max(axis=1)[:, None] + 12.0
    state = steady + random.uniform(-4.0, 4.0, steady.shape)
    for dt in np.geomspace(5e-4, 0.05, 120):
        state = inflow.step(state.astype(np.float32), float(dt), omega, velocity)
        assert (abs(state) < most).all()
    # Each annulus is at a solution, not always at the largest one.
    rates = inflow.rates(state, omega, velocity)[:, 3:]
    assert np.quantile(abs(rates), 0.99) < 1.0


def test_a_decayed_gradient_in_axial_flow_leaves_no_trace() -> None:
    inflow = pm.DynamicInflow(pm.Rotor(pm.catalogue_model("apc-8x6e")))
    state = inflow.steady(OMEGA, [0.1, 0.0, 0.0])
    for _ in range(400):
        state = inflow.step(state, 0.005, OMEGA, STILL)
    np.testing.assert_array_equal(state[1:3], 0.0)
    np.testing.assert_allclose(state, inflow.steady(OMEGA, STILL), atol=1e-3)


def test_a_mirrored_rotor_moves_as_a_mirror_image() -> None:
    """About the plane y = 0: gradients (x, -y), forces (x, -y, z), moments (-x, y, -z)."""
    ccw, cw = dynamic("paper-apc"), dynamic("paper-apc", "cw")
    flip = np.ones(ccw.size)
    flip[2] = -1.0
    velocity, image = np.array([7.0, 3.0, 2.0]), np.array([7.0, -3.0, 2.0])
    state = 0.8 * ccw.steady(OMEGA, velocity)
    state[:3] += [0.5, 1.0, -2.0]
    mirrored = ccw.step(state, 1e-3, OMEGA, velocity) * flip
    np.testing.assert_allclose(cw.step(state * flip, 1e-3, OMEGA, image), mirrored, rtol=1e-9)
    one, other = ccw.wrench(state, OMEGA, velocity), cw.wrench(state * flip, OMEGA, image)
    np.testing.assert_allclose(other.force, one.force * [1.0, -1.0, 1.0], rtol=1e-9)
    np.testing.assert_allclose(other.moment, one.moment * [-1.0, 1.0, -1.0], rtol=1e-9)
    both, later = cw.advance(state * flip, 1e-3, OMEGA, image)
    np.testing.assert_array_equal(later, cw.step(state * flip, 1e-3, OMEGA, image))
    np.testing.assert_array_equal((both.force, both.moment), (other.force, other.moment))
    # Both rotors in one call.
    pair = dynamic("paper-apc", ["ccw", "cw"])
    states, velocities = np.array([state, state * flip]), np.array([velocity, image])
    wrenches, laters = pair.advance(states, 1e-3, OMEGA, velocities)
    np.testing.assert_array_equal(wrenches.moment, [one.moment, other.moment])
    np.testing.assert_array_equal(laters[1], later)


def test_points_broadcast_over_leading_axes() -> None:
    inflow = dynamic()
    omega, velocity = np.array([[500.0], [700.0]]), OBLIQUE[:3]
    state = inflow.steady(OMEGA, STILL)
    all_at_once = inflow.step(state, 1e-3, omega, velocity)
    assert all_at_once.shape == (2, 3, inflow.size)
    assert inflow.loads(state, omega, velocity).thrust.shape == (2, 3)
    one = inflow.step(state, 1e-3, omega[1, 0], velocity[2])
    np.testing.assert_allclose(all_at_once[1, 2], one, rtol=1e-9)


def test_the_linear_model_predicts_small_changes(attached: pm.DynamicInflow) -> None:
    velocity = np.array([6.0, -2.0, 1.0])
    steady = attached.steady(OMEGA, velocity)
    linear = attached.linearize(OMEGA, velocity)
    assert linear.b.shape == (attached.size, 4) and linear.d.shape == (6, 4)
    random, small = np.random.default_rng(4), 1e-4
    x, u = random.standard_normal(attached.size), random.standard_normal(4)
    ends = [
        (
            attached.rates(steady + by * x, OMEGA + by * u[0], velocity + by * u[1:]),
            attached.wrench(steady + by * x, OMEGA + by * u[0], velocity + by * u[1:]),
        )
        for by in (small, -small)
    ]
    rates = (ends[0][0] - ends[1][0]) / (2.0 * small)
    np.testing.assert_allclose(linear.a @ x + linear.b @ u, rates, rtol=1e-6, atol=1e-3)
    for part, name in ((slice(3), "force"), (slice(3, 6), "moment")):
        change = (getattr(ends[0][1], name) - getattr(ends[1][1], name)) / (2.0 * small)
        predicted = (linear.c @ x + linear.d @ u)[part]
        np.testing.assert_allclose(predicted, change, rtol=1e-6, atol=1e-7)


def test_impossible_arguments_are_refused() -> None:
    coleman = pm.Model(BLADE, pm.airfoil("paper-apc"), corrections=(pm.correction("coleman"),))
    with pytest.raises(pm.InputError, match="'coleman' has no dynamics"):
        pm.DynamicInflow(pm.Rotor(coleman))
    with pytest.raises(pm.InputError, match="must be 'ccw' or 'cw'"):
        pm.DynamicInflow(dynamic().rotor, spin="left")
    with pytest.raises(pm.InputError, match="its last axis must have"):
        dynamic().rates([1.0, 2.0], OMEGA, STILL)
    inflow = dynamic()
    masked, ragged = np.ma.masked_less(np.zeros(inflow.size), 0.5), [[1.0, 2.0], [3.0]]
    for wrong in (np.full(inflow.size, 1.0j), masked, ragged):
        with pytest.raises(pm.InputError, match=r"state (is .*: give a real|has masked points)"):
            inflow.rates(wrong, OMEGA, STILL)  # type: ignore[arg-type]
    with pytest.raises(pm.InputError, match="dt is negative"):
        inflow.step(np.zeros(inflow.size), -1e-3, OMEGA, STILL)
    with pytest.raises(pm.InputError, match="a single operating point of a single rotor"):
        inflow.linearize(OMEGA, STILL, np.zeros((2, inflow.size)))
    states = np.zeros((3, inflow.size))
    with pytest.raises(pm.InputError, match=r"broadcast together: .*state has shape \(3, 51\)"):
        inflow.step(states, 1e-3, [OMEGA, OMEGA], STILL)
    for name, given in {"omega": (None, STILL), "velocity": (OMEGA, None)}.items():
        with pytest.raises(pm.InputError, match=f"{name} contains a value that is not finite"):
            inflow.rates(states, *given)
    with pytest.raises(pm.InputError, match="dt contains a value that is not finite"):
        inflow.step(states, None, OMEGA, STILL)  # type: ignore[arg-type]


def test_states_of_any_layout_and_type_have_the_same_step() -> None:
    inflow = dynamic(spin=["ccw", "cw"])
    state = inflow.steady(OMEGA, OBLIQUE[:2]).astype(np.float32).astype(np.float64)
    want = inflow.step(state, 1e-3, OMEGA, OBLIQUE[:2])
    strided = np.repeat(state, 2, axis=1)[:, ::2]
    for one in (state.astype(np.float32), np.asfortranarray(state), strided, state.tolist()):
        np.testing.assert_array_equal(inflow.step(one, 1e-3, 600, OBLIQUE[:2].tolist()), want)
    again = pickle.loads(pickle.dumps(inflow))
    np.testing.assert_array_equal(again.step(state, 1e-3, OMEGA, OBLIQUE[:2]), want)


@pytest.mark.parametrize("name", ["APC 8x6E", "paper-soft"])
def test_the_vortex_ring_is_that_of_the_static_solution(name: str) -> None:
    """In slow descent, in the vortex ring and beyond it, at low and high rotational speeds."""
    soft = name == "paper-soft"
    inflow = dynamic(name) if soft else pm.DynamicInflow(pm.Rotor(pm.catalogue_model(name)))
    random, count = np.random.default_rng(11), 400
    omega = np.geomspace(5.0, 300.0, count) / R
    hover = inflow.rotor.hover_inflow(omega)[:, None]
    velocity = hover * random.uniform([0.0, 0.0, -2.2], [1.6, 0.0, 0.0], (count, 3))
    found = inflow.loads(inflow.steady(omega, velocity), omega, velocity)
    static = inflow.rotor.loads_at_velocity(omega, velocity)
    assert 0.2 < (static.vortex_ring > 0.0).mean() < 0.9
    np.testing.assert_allclose(found.vortex_ring, static.vortex_ring, rtol=1e-9)
    at_rest = inflow.rotor.loads(omega, 0.0, 0.0).thrust
    assert np.quantile(abs(found.thrust - static.thrust) / at_rest, 0.95) < 5e-3


def test_a_rotor_at_rest_does_not_depend_on_the_previous_point() -> None:
    inflow = dynamic()
    ends = []
    for before in (0.0, 600.0):
        inflow.steady(before, (8.0, 0.0, 2.0))
        state = np.full(inflow.size, 1.0)
        ends.append(inflow.step(state, 0.01, 0.0, STILL))
        np.testing.assert_allclose(inflow.steady(0.0, STILL), 0.0, atol=1e-6)
    np.testing.assert_array_equal(*ends)
    assert (abs(ends[0]) < 1.0).all()
