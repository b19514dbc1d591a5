"""Points whose nodes do not suffice are found out and evaluated again."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import propmap as pm
from propmap.engine.accuracy import ACCURACIES, STALL_WIDTH, Accuracy
from propmap.engine.evaluation import evaluate, evaluate_flow, prepare, tail_share
from propmap.engine.forecast import LEAST_LIFT, static_loads
from propmap.engine.programs import Flow
from propmap.engine.rotor_arrays import rotor_arrays

STANDARD = ACCURACIES["standard"]
ONCE = replace(STANDARD, largest_tail=np.inf)
FIT = pm.Airfoil(c_l1=4.03, c_l2=0.0, c_d=1.44, alpha_0=0.584, zero_lift_angle=-0.078)
BLADE = pm.propeller("apc-8x6e")

Floats = NDArray[np.float64]


def points(count: int) -> tuple[Floats, Floats, Floats]:
    """The issue's worst point, then random ones between climb and edgewise flight."""
    rng = np.random.default_rng(9)
    omega = rng.uniform(250.0, 900.0, count)
    speed, beta = rng.uniform(5.0, 20.0, count), np.radians(rng.uniform(50.0, 90.0, count))
    omega[0], speed[0], beta[0] = 3578.0 * np.pi / 30.0, 9.6, np.radians(88.0)
    return omega, speed * np.cos(beta), speed * np.sin(beta)


def panels_of(rotor: pm.Model, flow: tuple[Floats, ...], *, compiled: bool) -> list[Any]:
    """Of each point, the panels of all its evaluations."""
    told: list[list[tuple[int, ...]]] = [[] for _ in flow[0]]

    def solved(block: Any, _: Any) -> None:
        for point in block.points:
            told[point].append(block.panels)

    prepared = prepare(rotor_arrays(rotor), compiled=compiled)
    evaluate_flow(prepared, STANDARD, Flow(*flow, None), solved=solved)
    return [sorted(one) for one in told]


def test_the_error_of_a_badly_resolved_point_falls() -> None:
    rotor, flow = prepare(rotor_arrays(pm.Model(BLADE, FIT)), compiled=False), points(1)
    once, again, fine = (evaluate(rotor, s, *flow) for s in (ONCE, STANDARD, ACCURACIES["fine"]))
    static = rotor.static[0] * flow[0] ** 2
    before, after = (abs(one.loads.thrust - fine.loads.thrust) / static for one in (once, again))
    assert before[0] > 2e-3
    assert after[0] < 5e-4
    share = [tail_share(rotor, *flow, one)[0] for one in (once, again)]
    assert share[0] > STANDARD.largest_tail
    assert share[1] < 0.5 * share[0]


def test_loads_do_not_depend_on_what_else_is_asked() -> None:
    flow = points(24)
    model = pm.Model(BLADE, FIT)
    again = [len(one) > 1 for one in panels_of(model, flow, compiled=False)]
    assert 2 <= sum(again) < len(again)
    rotor = prepare(rotor_arrays(model), compiled=False)
    together = evaluate(rotor, STANDARD, *flow)
    chosen = [*np.flatnonzero(again)[:2], again.index(False)]
    for k in chosen:
        alone = evaluate(rotor, STANDARD, *(one[k : k + 1] for one in flow))
        for load, of_all in zip(alone.rows, together.rows, strict=True):
            assert load[0] == pytest.approx(of_all[k], rel=1e-9, abs=1e-12)


@pytest.mark.slow
def test_numpy_and_the_compiler_evaluate_the_same_points_again() -> None:
    flow, model = points(200), pm.Model(BLADE, FIT)
    by_numpy, compiled = (panels_of(model, flow, compiled=c) for c in (False, True))
    assert by_numpy == compiled
    assert sum(len(one) > 1 for one in compiled) > 5


def test_what_no_nodes_resolve_is_said() -> None:
    """A blade stalled at rest, whose annuli attach and stall by turns in slow climb."""
    law = pm.Airfoil(
        c_l1=5.86, c_l2=0.04, c_d=1.24, alpha_0=0.23, zero_lift_angle=-0.12, sharpness=110.0
    )
    model = pm.Model(replace(pm.propeller("apc-9x6e"), blades=3), law)
    rotor = pm.Rotor(model, compiled=False)
    found = rotor.loads(600.0, [3.0508, 12.0], 0.0)
    assert found.status.tolist() == ["coarse", "ok"]
    assert np.isfinite(found.thrust).all()
    slow = tuple(np.array([v]) for v in (600.0, 3.0508, 0.0))
    once = evaluate(prepare(rotor_arrays(model), compiled=False), ONCE, *slow).loads.thrust
    assert found.thrust[0] == pytest.approx(float(once[0]), rel=0.02)
    # Each further evaluation is asked for before that is said.
    told = panels_of(model, slow, compiled=False)
    assert len(told[0]) == 1 + len(STANDARD.finer)


def test_a_sharper_stall_gets_more_azimuths_and_smaller_tails() -> None:
    sharp = STANDARD.for_stall(0.5 * STALL_WIDTH)
    wanted = [(limit, 2 * count) for limit, count in STANDARD.azimuths]
    assert [limit for limit, _ in sharp.azimuths] == [limit for limit, _ in wanted]
    assert all(got >= want for (_, got), (_, want) in zip(sharp.azimuths, wanted, strict=True))
    assert all(
        got <= 1.5 * want for (_, got), (_, want) in zip(sharp.azimuths, wanted, strict=True)
    )
    assert sharp.largest_tail == pytest.approx(0.25 * STANDARD.largest_tail)
    assert sharp.finer[0][1] == pytest.approx(0.25 * STANDARD.finer[0][1])
    assert [nodes for nodes, _ in sharp.finer] == [nodes for nodes, _ in STANDARD.finer]
    # What is left at last is not judged by the sharpness.
    assert sharp.finer[-1] == STANDARD.finer[-1]
    assert STANDARD.for_stall(2.0 * STALL_WIDTH) is STANDARD


@pytest.mark.parametrize("name", ACCURACIES)
def test_each_further_evaluation_has_more_nodes(name: str) -> None:
    setting: Accuracy = ACCURACIES[name]
    stations = [setting.fast, *(nodes for nodes, _ in setting.finer)]
    assert stations == sorted(set(stations))
    advance = np.array([0.01, 0.1, 0.4, 2.0])
    first = setting.azimuths_at(advance)
    assert (setting.azimuths_again(advance, 1) >= first).all()
    assert (setting.azimuths_again(advance, 2) >= setting.azimuths_again(advance, 1)).all()


def test_tails_are_shares_of_the_load_at_rest() -> None:
    arrays = rotor_arrays(pm.Model(BLADE, pm.airfoil("paper-apc")))
    omega, still = np.array([600.0]), np.zeros(1)
    rest = evaluate(prepare(arrays, compiled=False), STANDARD, omega, still, still).loads
    thrust, torque = static_loads(arrays)
    assert thrust * omega**2 == pytest.approx(rest.thrust, rel=0.02)
    assert torque * omega**2 == pytest.approx(rest.torque, rel=0.05)


def test_a_blade_without_lift_is_not_judged_by_it() -> None:
    """Nor are tails of a rotor at rest in a wind divided by nothing."""
    flat = replace(BLADE, twist=np.zeros_like(BLADE.twist))
    arrays = rotor_arrays(pm.Model(flat, pm.airfoil("paper-apc")))
    lift = np.trapezoid(BLADE.chord * BLADE.station**2, BLADE.station)
    least = LEAST_LIFT * 0.5 * pm.Air().density * BLADE.blades * lift
    assert static_loads(arrays)[0] == pytest.approx(least)
    rotor, wind = prepare(arrays, compiled=False), (np.zeros(2), np.zeros(2), np.array([0.0, 9.0]))
    share = tail_share(rotor, *wind, evaluate(rotor, STANDARD, *wind))
    assert share[0] == 0.0
    assert 0.0 <= share[1] < 1.0
