"""The search for the largest root of (11) skips none, wherever it starts."""

import functools

import jax
import numpy as np
import pytest

import propmap
from propmap.arrays.namespace import by_numpy
from propmap.engine.evaluation import prepare
from propmap.physics.velocities import azimuth_nodes
from propmap.solve.bounds import find_bounds
from propmap.solve.disk import solve_disk
from propmap.solve.problem import Case, annulus_problem, residual
from propmap.solve.quadrature import panel_nodes
from propmap.solve.root import LANES_TOGETHER, MAX_STEPS, find_root

POINTS = 150
FOLLOWING = (12, 18, 18)
STEPS = np.array(MAX_STEPS)


def climb(rotor, axial, seed, advance=(0.02, 0.2)):
    """Omega [rad/s], V cos(beta) and V sin(beta) [m/s] of random points in climb."""
    rng = np.random.default_rng(seed)
    omega = rng.uniform(2000.0, 10000.0, POINTS) * np.pi / 30.0
    tip = float(rotor.arrays.blade.tip)
    along = rng.uniform(0.0, 12.0, POINTS)
    across = 0.0 * along if axial else omega * tip * rng.uniform(*advance, POINTS)
    return omega, along, across


def followed(rotor, flow, azimuths):
    """Radial nodes, (11) there and its roots as the batches find them, with stall followed."""
    with by_numpy():
        case = Case(rotor.arrays, *flow, None)
        return solve_disk(case, FOLLOWING, azimuth_nodes(azimuths))[1]


@pytest.mark.parametrize(
    "name",
    [
        "apc-8x6e",
        *(pytest.param(n, marks=pytest.mark.slow) for n in ("uiuc-apce-19x12", "uiuc-grcp-11x8")),
    ],
)
@pytest.mark.parametrize("azimuths", [1, 24])
def test_no_root_lies_above(name, azimuths):
    rotor = propmap.Rotor(propmap.Model(propmap.propeller(name), propmap.airfoil("paper-stiff")))
    disk = followed(rotor, climb(rotor, azimuths == 1, 6, (0.02, 1.2)), azimuths)
    with by_numpy():
        # Also past the place from which the search comes down.
        start = find_bounds(disk.problem.at, disk.problem.wake).start
        highest = start + 2.0 * (disk.problem.at.turning + disk.problem.at.v_inplane)
        assert (disk.inflow <= start).all()
        for share in np.linspace(1e-3, 1.0, 400 if azimuths == 1 else 200) ** 2:
            v = disk.inflow + share * (highest - disk.inflow)
            value = residual(disk.problem, v, azimuth_nodes(azimuths))
            assert (value <= 1e-9 * np.abs(value).max()).all()


@pytest.mark.parametrize("count", [17, pytest.param(20, marks=pytest.mark.slow)])
def test_groups_of_stations_find_what_all_together_find(count):
    """Compiled, stations search four at a time; NumPy searches at all at once."""
    rotor = propmap.Rotor(
        propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-stiff"))
    )
    flow = climb(rotor, axial=False, seed=9)
    some = followed(rotor, flow, 16).problem.stations(slice(count))
    nodes = azimuth_nodes(16)
    assert some.at.radius.shape == (count, POINTS)
    assert count * POINTS > 2 * LANES_TOGETHER
    with by_numpy():
        together = find_root(some, STEPS, nodes)
    with jax.enable_x64():
        in_groups = jax.jit(find_root)(some, STEPS, nodes)
    np.testing.assert_allclose(in_groups, together, rtol=1e-9, atol=1e-9)


def attached(rotor, flow):
    """(11) at 24 stations of one panel."""
    blade = rotor.arrays.blade
    ends = np.array([[blade.root], [blade.tip]])
    with by_numpy():
        case = Case(rotor.arrays, *flow, None)
        return annulus_problem(case, panel_nodes(ends, (24,)).radius)


@pytest.fixture(scope="module")
def fast_climb():
    """A rotor and points where nothing stalls, some of them with negative thrust."""
    rotor = propmap.Rotor(
        propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))
    )
    rpm = np.linspace(5000.0, 9500.0, 40)
    flow = (rpm * np.pi / 30.0, np.full(40, 12.0), np.zeros(40))
    assert not prepare(rotor.arrays).forecast.may_stall(*flow).any()
    return rotor, flow


def test_unstalled_flow_takes_few_evaluations_also_with_negative_thrust(fast_climb):
    ask = attached(*fast_climb)
    find = functools.partial(find_root, ask)
    with by_numpy():
        two, three, patient = (find(n, azimuth_nodes(1)) for n in (np.array(2), np.array(3), STEPS))
    assert (patient < 0.0).any()
    np.testing.assert_array_equal(three, patient)
    assert np.isfinite(two).mean() > 0.95


@pytest.mark.parametrize("law", ["paper-apc", "paper-soft", "paper-stiff"])
@pytest.mark.parametrize("axial", [True, False])
def test_the_forecast_of_stall_holds(law, axial):
    rotor = propmap.Rotor(propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil(law)))
    flow = climb(rotor, axial, 7)
    foreseen = prepare(rotor.arrays).forecast.may_stall(*flow)
    with by_numpy():
        disk = followed(rotor, flow, 1 if axial else 16)
        at = disk.problem.at
        u_t, u_p = at.turning, at.v_axial + disk.inflow
        alpha = np.arctan2(
            at.station.sine * u_t - at.station.cosine * u_p,
            at.station.cosine * u_t + at.station.sine * u_p,
        )
    section = rotor.arrays.law
    stalled = (np.abs(alpha) > section.alpha_0 - 2.0 / section.sharpness).any(axis=0)
    assert stalled.any()
    assert (stalled & ~foreseen).sum() <= 0.02 * POINTS
    # Nor is it foreseen where every element is far from stall.
    calm = (np.abs(alpha) < section.alpha_0 - 8.0 / section.sharpness).all(axis=0)
    assert not (calm & foreseen).any()
