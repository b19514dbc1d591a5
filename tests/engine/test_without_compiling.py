"""Loads by NumPy, without compiling, are those of the compiled programs."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import propmap as pm
from propmap.engine.batch import cut
from propmap.engine.plan import Job
from propmap.loads import LOADS

SETS = ("paper-soft", "paper-stiff", "paper-apc")
NUMBERS = (*LOADS, "mean_inflow")


def _points(count: int) -> tuple[NDArray[np.float64], ...]:
    """Anywhere, descent and rest included."""
    rng = np.random.default_rng(6)
    omega, speed = rng.uniform(0.0, 1200.0, count), rng.uniform(0.0, 30.0, count)
    beta = rng.uniform(0.0, np.pi, count)
    omega[0::20], speed[1::20], beta[2::20], beta[3::20] = 0.0, 0.0, 0.0, np.pi
    return omega, speed, beta


@pytest.mark.parametrize(
    "count",
    [
        pytest.param(300, id="small blocks"),
        pytest.param(600, id="large blocks", marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("name", SETS)
def test_numpy_and_the_compiler_agree(name: str, count: int) -> None:
    """Also guards the compiler's options: jaxlib miscompiles one function for wide vectors."""
    blade, law = pm.propeller("apc-8x6e"), pm.airfoil(name)
    points = _points(count)
    compiled = pm.Rotor(pm.Model(blade, law)).loads(*points)
    by_numpy = pm.Rotor(pm.Model(blade, law), compiled=False).loads(*points)
    assert (compiled.status == by_numpy.status).all()
    assert (compiled.roots == by_numpy.roots).all()
    for field in NUMBERS:
        want, got = getattr(compiled, field), getattr(by_numpy, field)
        assert (np.isnan(want) == np.isnan(got)).all()
        np.testing.assert_allclose(got, want, rtol=1e-9, atol=1e-9 * np.nanmax(np.abs(want)))


def test_inflow_over_the_disk_agrees() -> None:
    blade, law = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")
    flow = (628.0, 12.0, np.radians(70.0))
    want = pm.Rotor(pm.Model(blade, law)).inflow(*flow)
    got = pm.Rotor(pm.Model(blade, law), compiled=False).inflow(*flow)
    for field in ("inflow", "alpha", "thrust_per_radius", "torque_per_radius"):
        expected = getattr(want, field)
        np.testing.assert_allclose(
            getattr(got, field), expected, atol=1e-9 * np.max(np.abs(expected))
        )


@pytest.mark.slow
def test_one_set_of_programs_gives_the_same_loads() -> None:
    """But for the nodes: panels that follow stall have those of a further evaluation."""
    rotor = pm.Rotor(pm.Model(pm.propeller("apc-8x6e"), pm.airfoil("paper-soft")))
    points = _points(150)
    want, got = rotor.loads(*points), rotor.for_all_sizes().loads(*points)
    assert (want.status == got.status).all()
    for field in NUMBERS:
        expected = getattr(want, field)
        np.testing.assert_allclose(
            getattr(got, field), expected, rtol=0.0, atol=1e-3 * np.nanmax(np.abs(expected))
        )


def test_blocks_are_not_filled_up_where_no_program_asks_for_it() -> None:
    """What a block is filled up with NumPy would compute too."""
    points = np.arange(700)
    job = Job(points, (24,), np.full(points.size, 8), 8)
    blocks = cut([job], compiled=False)
    np.testing.assert_array_equal(np.concatenate([b.padded for b in blocks]), points)
