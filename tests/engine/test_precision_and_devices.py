"""Loads in float32, and by the blocks of an accelerator, against those of every day."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import propmap as pm
from propmap.arrays import namespace
from propmap.engine import evaluation, lanes
from propmap.loads import LOADS

SETS = ("paper-soft", "paper-stiff", "paper-apc")
NUMBERS = tuple(LOADS)


def _points(count: int, steepest: float) -> tuple[NDArray[np.float64], ...]:
    rng = np.random.default_rng(7)
    omega, speed = rng.uniform(200.0, 1050.0, count), rng.uniform(0.0, 20.0, count)
    beta = rng.uniform(0.0, steepest, count)
    speed[0::20], beta[1::20], beta[2::20] = 0.0, 0.0, steepest
    return omega, speed, beta


@pytest.mark.slow
@pytest.mark.parametrize("name", SETS)
def test_float32_keeps_its_promise(name: str) -> None:
    """0.3 % of static loads against "standard" in float64, at nearly all points 0.05 %; no point
    lost; descent included."""
    blade, law = pm.propeller("apc-8x6e"), pm.airfoil(name)
    points = _points(400, np.pi)
    want = pm.Rotor(pm.Model(blade, law)).loads(*points)
    got = pm.Rotor(pm.Model(blade, law), precision="float32").loads(*points)
    still = np.zeros_like(points[0])
    static = pm.Rotor(pm.Model(blade, law)).loads(points[0], still, still)
    assert np.isfinite(got.thrust).all()
    for field in NUMBERS:
        scale = static.thrust if field in ("thrust", "drag") else static.torque
        error = np.abs(getattr(got, field) - getattr(want, field)) / scale
        assert error.max() < 3e-3
        assert np.quantile(error, 0.99) < 5e-4
    assert got.thrust.dtype == np.float64  # what comes out is for NumPy, whatever it was made in
    assert not np.array_equal(got.thrust, want.thrust)  # it was float32 indeed


def test_float32_asks_for_what_it_can_do() -> None:
    blade, law = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")
    with pytest.raises(pm.InputError, match="precision is 'half'"):
        pm.Rotor(pm.Model(blade, law), precision="half")
    with pytest.raises(pm.InputError, match="float32"):
        pm.Rotor(pm.Model(blade, law), precision="float32", compiled=False)
    with pytest.raises(pm.InputError, match="float32"):
        pm.Rotor(pm.Model(blade, law), precision="float32", accuracy="fine")


@pytest.mark.slow
def test_blocks_and_programs_of_an_accelerator_give_the_same_loads(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Run on the CPU: large blocks, and no branches that are always taken."""
    blade, law = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")
    points = _points(1500, 0.5 * np.pi)
    want = pm.Rotor(pm.Model(blade, law)).loads(*points)
    sizes = []
    program = evaluation.compiled_search

    def noted(panels: tuple[int, ...], *, axial: bool, lanes: bool):  # type: ignore[no-untyped-def]
        def call(rotor, flow, nodes, used):  # type: ignore[no-untyped-def]
            sizes.append(flow.omega.size)
            return program.__wrapped__(panels, axial=axial, lanes=lanes)(rotor, flow, nodes, used)

        return call

    monkeypatch.setattr(evaluation, "compiled_search", noted)
    for module in (evaluation, namespace, lanes):
        monkeypatch.setattr(module, "on_accelerator", lambda: True)
    got = pm.Rotor(pm.Model(blade, law)).loads(*points)
    assert min(sizes) >= 1024
    for field in NUMBERS:
        expected = getattr(want, field)
        np.testing.assert_allclose(
            getattr(got, field), expected, rtol=1e-9, atol=1e-9 * np.max(np.abs(expected))
        )
