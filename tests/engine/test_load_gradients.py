"""Derivatives by section parameters, and the loads that come with them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.engine.accuracy import accuracy
from propmap.engine.evaluation import prepare
from propmap.engine.gradients import LoadGradients, load_gradients
from propmap.fit.tunnel import rotor_with
from propmap.loads import LOADS, error_scales

PROPELLER = propmap.propeller("apc-8x6e")
MODEL = propmap.Model(PROPELLER, propmap.airfoil("paper-apc"))
VALUES = {
    "c_l1": 5.0,
    "c_l2": 1.6,
    "c_d": 1.7,
    "alpha_0": 0.38,
    "zero_lift_angle": -0.05,
    "c_d0": 0.012,
    "drag_factor": 1.4,
}
NAMES = tuple(VALUES)
STEPS = dict(zip(NAMES, (1e-3, 1e-3, 1e-3, 1e-5, 1e-5, 1e-5, 1e-3), strict=True))
OMEGA = np.array([6000.0, 5000.0]) * np.pi / 30.0

# Two points each, so that every kind of flow is one block.
FLOWS = {
    "static": (np.zeros(2), np.zeros(2)),
    "axial, 10 m/s": (np.full(2, 10.0), np.zeros(2)),
    "beta 40 degrees, 10 m/s": (np.full(2, 10.0 * np.cos(0.7)), np.full(2, 10.0 * np.sin(0.7))),
    "fast climb": (np.full(2, 18.0), np.full(2, 2.0)),
    "descent": (np.full(2, -2.0), np.full(2, 4.0)),
    # From about -5 m/s on, loads have small kinks: derivatives are off by up to 0.6 % there.
    "steep descent": (np.full(2, -3.0), np.full(2, 1.0)),
}
SETTING = accuracy("standard")


def at(values: dict[str, float]) -> LoadGradients:
    """All flows in one batch."""
    axial, inplane = (np.concatenate(parts) for parts in zip(*FLOWS.values(), strict=True))
    rotor = rotor_with(MODEL, values, "standard")
    omega = np.tile(OMEGA, len(FLOWS))
    return load_gradients(prepare(rotor.arrays), SETTING, NAMES, omega, axial, inplane)


@pytest.fixture(scope="module")
def found() -> LoadGradients:
    return at(VALUES)


@pytest.fixture(scope="module")
def differences() -> np.ndarray:
    """(4, P, N) by central differences."""
    parts = []
    for name, step in STEPS.items():
        up, down = (at({**VALUES, name: VALUES[name] + h}).loads for h in (step, -step))
        parts.append((up - down) / (2.0 * step))
    return np.stack(parts, axis=1)


@pytest.mark.parametrize("flow", FLOWS)
@pytest.mark.parametrize("name", NAMES)
def test_derivatives_are_those_of_the_loads(
    found: LoadGradients, differences: np.ndarray, flow: str, name: str
) -> None:
    first = 2 * list(FLOWS).index(flow)
    mine, row = slice(first, first + 2), NAMES.index(name)
    derivative, difference = found.slopes[:, row, mine], differences[:, row, mine]
    # Over each load's own range of derivatives, as some of them are zero by symmetry.  What
    # differs is the curvature that a difference over a step does not see: most for alpha_0.
    size = np.max(np.abs(differences[:, row]), axis=1, keepdims=True) + 1e-12
    np.testing.assert_allclose(derivative / size, difference / size, atol=5e-4)


def test_every_parameter_acts_where_it_should(found: LoadGradients) -> None:
    oblique = 2 * list(FLOWS).index("beta 40 degrees, 10 m/s")
    slope = dict(zip(NAMES, found.slopes[:, :, oblique].T, strict=True))
    thrust, drag, torque, roll, *_ = range(len(LOADS))
    assert slope["c_l1"][thrust] > 0.0
    assert slope["zero_lift_angle"][thrust] < 0.0
    assert slope["c_d0"][torque] > 0.0 and slope["c_d"][torque] > 0.0
    # The factor multiplies the drag and nothing else.
    factor = found.loads[drag, oblique] / VALUES["drag_factor"]
    assert slope["drag_factor"][drag] == pytest.approx(factor, rel=1e-9)
    np.testing.assert_allclose(slope["drag_factor"][[thrust, torque, roll]], 0.0, atol=1e-12)


def test_the_descents_depend_on_the_static_inflow(found: LoadGradients) -> None:
    """So that the differences above see the derivative's way through v_h of eq. (12)."""
    still = np.sqrt(found.loads[0, 0] / (2.0 * MODEL.air.density * np.pi * PROPELLER.radius**2))
    for flow in ("descent", "steep descent"):
        # No windmill, for which v_h plays no part.
        assert -2.0 * still < FLOWS[flow][0][0] < 0.0


def test_loads_are_those_of_the_rotor(found: LoadGradients) -> None:
    rotor = rotor_with(MODEL, VALUES, "standard")
    axial, inplane = (np.concatenate(parts) for parts in zip(*FLOWS.values(), strict=True))
    velocity = np.stack([inplane, np.zeros_like(axial), axial], axis=-1)
    loads = rotor.loads_at_velocity(np.tile(OMEGA, len(FLOWS)), velocity)
    thrust, torque = float(loads.thrust[0]), float(loads.torque[0])
    radius = PROPELLER.radius
    # Where stall is followed here and not foreseen there, by the 0.1 % of either.
    scales = error_scales({"thrust": thrust, "torque": torque}, radius)
    for k, (name, size) in enumerate(scales.items()):
        np.testing.assert_allclose(
            found.loads[k],
            getattr(loads, name),
            atol=1e-3 * size,
            err_msg=name,
        )


@pytest.mark.slow
def test_a_point_without_a_solution_is_lost_with_its_derivatives() -> None:
    rotor = rotor_with(MODEL, VALUES, "standard")
    omega, bad = np.tile(OMEGA, 2), np.array([10.0, 10.0, np.nan, 10.0])
    lost = load_gradients(prepare(rotor.arrays), SETTING, NAMES, omega, bad, np.zeros(4))
    assert np.isnan(lost.loads[:, 2]).all()
    assert np.isfinite(lost.loads[:, [0, 1, 3]]).all()


@pytest.mark.slow
def test_each_program_of_a_few_points_is_traced_once() -> None:
    """One is compiled ahead, beside the other; were it not the one that is run afterwards, all
    fits would start that much later."""
    import jax.monitoring

    traced: list[str] = []

    def note(event: str, _: float, **of: Any) -> None:
        if event == "/jax/core/compile/jaxpr_to_mlir_module_duration":
            traced.append(of["fun_name"])

    # A number of stations that no other test has, so that nothing is compiled yet.
    one_less = {a: getattr(PROPELLER, a)[1:] for a in ("station", "chord", "twist")}
    rotor = rotor_with(replace(MODEL, propeller=replace(PROPELLER, **one_less)), VALUES, "standard")
    jax.monitoring.register_event_duration_secs_listener(note)
    try:
        # Of a tunnel's points, and of a flight's, whose rotors are ready for batches of any size.
        for uniform in (False, True):
            prepared = prepare(rotor.arrays, uniform=uniform)
            load_gradients(prepared, SETTING, NAMES, OMEGA, *FLOWS["axial, 10 m/s"])
    finally:
        jax.monitoring.unregister_event_duration_listener(note)
    assert traced.count("jit(_search_in_lanes)") == 1
    assert traced.count("jit(slopes)") == 1
