"""The mission, shortened: simulators differ by what their steps say, and energy is kept."""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Callable

import numpy as np
import pytest

import propmap
from benchmarks.cross_check.__main__ import (
    BETA,
    INTEGRATORS,
    PROPELLER,
    SMOOTH,
    SPEED,
    STEADY,
    VEHICLE,
    Problem,
    energies,
    hover_of,
    largest,
)
from benchmarks.cross_check.mission import FASTEST, MISSION, SLOWEST, Course, Flight, Leg
from benchmarks.cross_check.simulators import SciPy
from benchmarks.results_file import RESULTS
from propmap.rotor import Rotor
from propmap.table import build_table

from ..export.needed import package

SHORT = Course((Leg(0.0, 0.0, 0.1, 0.1), Leg(3.0, -1.0, 0.8, 0.2)), heading=0.5)
"""Every axis moves, and the rotors meet forward flight and descent."""

NEEDS = {"RotorPy": "rotorpy", "MuJoCo": "mujoco", "Drake": "pydrake"}
STEPS = (1, 2)


@pytest.fixture(scope="module")
def problem() -> Problem:
    vehicle = propmap.read_vehicle(VEHICLE).vehicle
    table = build_table(
        Rotor(propmap.catalogue_model(PROPELLER)),
        omega=(SLOWEST, FASTEST),
        speed=(0.0, 0.5 * SPEED[1]),
        beta=BETA,
        tolerance=0.03,
        certificate_points=512,
    )
    return Problem(vehicle, table, hover_of(vehicle, table), SHORT)


Flown = Callable[[str], dict[int, Flight]]


@pytest.fixture(scope="module")
def flown(problem: Problem) -> Flown:
    """Flights by steps in a period, of a simulator, each flown once."""

    @functools.cache
    def flights(simulator: str) -> dict[int, Flight]:
        if simulator == "SciPy":
            return {STEPS[-1]: problem.fly(SciPy, STEPS[-1])}
        package(NEEDS[simulator.partition(",")[0]])
        return {n: problem.fly(INTEGRATORS[simulator].made, n) for n in STEPS}

    return flights


@pytest.mark.parametrize("simulator", INTEGRATORS)
def test_a_simulator_converges_to_the_others_by_its_order(flown: Flown, simulator: str) -> None:
    flights, exact = flown(simulator), flown("SciPy")[STEPS[-1]]
    coarse, fine = (largest(flights[steps], exact) for steps in STEPS)
    order = INTEGRATORS[simulator].order
    for quantity in ("position", "velocity", "attitude"):
        # The largest error is not always at the same time.
        found = math.log2(coarse[quantity] / fine[quantity])
        assert found > 0.8 * order, (quantity, coarse, fine)
    before, after = (np.abs(f.stored - f.work).max() for f in flights.values())
    assert math.log2(before / after) > 0.8 * min(order, SMOOTH)


@pytest.mark.parametrize("simulator", ["SciPy", *INTEGRATORS])
def test_the_air_s_work_is_the_energy_that_is_there(flown: Flown, simulator: str) -> None:
    (balance,) = energies({simulator: flown(simulator)[STEPS[-1]]}).values()
    # Half of what the first-order integrator makes by itself in ten times this flight.
    limit = 0.1 if simulator == "MuJoCo, forces held" else 1e-4
    assert balance["largest_imbalance"] < limit
    assert abs(balance["stored"]) > 0.5 and balance["used"] > 100.0


def test_drake_says_that_loads_are_not_known(problem: Problem) -> None:
    package("pydrake")
    fast = problem.start._replace(velocity=np.array([90.0, 0.0, 0.0]))
    vehicle = INTEGRATORS["Drake"].made(problem.vehicle, problem.loads, fast)
    with pytest.raises(ValueError, match=r"no loads at this operating point \(outside\)"):
        vehicle.advance(fast.omega, 0.01)


def test_the_course_is_what_its_legs_say() -> None:
    times = np.linspace(0.0, MISSION.duration, 4001)
    between = 0.5 * (times[1:] + times[:-1])
    ends, middles = (
        [np.array(values) for values in zip(*map(MISSION.at, at), strict=True)]
        for at in (times, between)
    )
    step = times[1] - times[0]
    for value, rate in zip(ends[:2], middles[1:], strict=True):
        np.testing.assert_allclose(np.diff(value, axis=0) / step, rate, atol=1e-3)
    assert np.linalg.norm(MISSION.at(STEADY["cruise"])[1]) == pytest.approx(12.0)
    assert MISSION.at(STEADY["descent"])[1] == pytest.approx([0.0, 0.0, -3.0])
    assert MISSION.at(MISSION.duration)[1] == pytest.approx([0.0, 0.0, 0.0])


def test_the_committed_results_are_within_their_own_tolerances() -> None:
    found = json.loads((RESULTS / "cross_check.json").read_text(encoding="utf-8"))
    for model in ("propmap", "hover"):
        for pair, one in found[model]["pairs"].items():
            assert all(one["found"][q] <= one["allowed"][q] for q in one["found"]), pair
    flown = found["propmap"]["told"]["SciPy"]
    for name in STEADY:
        for quantity, value in found["steady"][name].items():
            # A leg of some seconds is not for ever, which the pitch shows most.
            assert flown[f"{name}_{quantity}"] == pytest.approx(value, rel=2e-3, abs=0.1)
