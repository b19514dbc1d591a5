"""A few points at a time, as one function: the same loads as from programs made of kernels."""

import numpy as np
import pytest

import propmap as pm
from propmap.engine import batch, lanes, programs
from propmap.loads import LOADS

FIELDS = (*LOADS, "mean_inflow")


def _points(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Hover, climb, edgewise and oblique flight, and descent with the windmill branch."""
    rng = np.random.default_rng(11)
    omega = rng.uniform(200.0, 1000.0, count)
    speed, beta = rng.uniform(0.0, 20.0, count), rng.uniform(0.0, np.pi, count)
    speed[:20], beta[20:60], beta[60:80] = 0.0, 0.0, 0.5 * np.pi
    return omega, speed, beta


def _rotor(precision: str = "float64") -> pm.Rotor:
    return pm.Rotor(
        pm.Model(pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")), precision=precision
    )


def test_the_installed_jaxlib_is_one_that_compiles_them() -> None:
    assert lanes.use_lanes((24,))
    assert lanes.use_lanes((12, 18, 18))
    assert not lanes.use_lanes((11,) * 5)  # islands are sorted along the blade


def test_no_program_for_an_unknown_jaxlib_or_an_accelerator(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(lanes, "on_accelerator", lambda: True)
        assert not lanes.use_lanes((24,))
    lanes.known_jaxlib.cache_clear()
    monkeypatch.setattr(lanes.importlib.metadata, "version", lambda _: "0.11.0")
    try:
        assert not lanes.use_lanes((24,))
    finally:
        lanes.known_jaxlib.cache_clear()


@pytest.mark.slow
@pytest.mark.parametrize("count", [45, 701])
def test_the_loads_are_those_of_programs_made_of_kernels(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = _points(count)  # not a multiple of anything: some groups are filled up
    few_at_a_time = _rotor().loads(*points)
    for module in (batch, lanes):
        monkeypatch.setattr(module, "use_lanes", lambda _panels: False)
    programs.compiled_search.cache_clear()
    try:
        by_kernels = _rotor().loads(*points)
    finally:
        programs.compiled_search.cache_clear()
    np.testing.assert_array_equal(few_at_a_time.status, by_kernels.status)
    for field in FIELDS:
        want = getattr(by_kernels, field)
        largest = 1e-12 * np.nanmax(np.abs(want))
        np.testing.assert_allclose(getattr(few_at_a_time, field), want, rtol=0.0, atol=largest)


@pytest.mark.slow
def test_no_load_depends_on_the_points_beside_it() -> None:
    omega, speed, beta = _points(100)
    beta = np.minimum(beta, 0.5 * np.pi)
    rotor = _rotor()
    together = rotor.loads(omega, speed, beta)
    which = np.random.default_rng(3).permutation(100)[:37]
    apart = rotor.loads(omega[which], speed[which], beta[which])
    for field in FIELDS:
        want = getattr(together, field)
        largest = 1e-12 * np.nanmax(np.abs(want))
        np.testing.assert_allclose(getattr(apart, field), want[which], rtol=0.0, atol=largest)


def test_only_groups_that_are_asked_for_are_computed() -> None:
    """A block is as large as its program, and takes as long as its points."""
    import jax
    import jax.numpy as jnp

    seen = jnp.arange(32.0)
    with jax.enable_x64(True):
        program = jax.jit(
            lambda some, used: lanes.in_lanes(lambda two, a: a * two[0] + 1.0, [2.0], some, used, 1)
        )
        for used in (0, 1, 8, 9, 32):
            groups = -(-used // lanes.LANES) * lanes.LANES
            want = np.where(np.arange(32) < groups, 2.0 * np.arange(32) + 1.0, 0.0)
            np.testing.assert_array_equal(program(seen, used), want)


@pytest.mark.slow
def test_nothing_in_a_program_keeps_its_loops_from_vectors() -> None:
    """XLA on a CPU has no reciprocal root of a vector, and one keeps the whole loop from them."""
    import jax

    rotor, points = _rotor(), 16
    flow = programs.Flow(*(np.full(points, value) for value in (500.0, -1.0, 5.0, 4.0)))
    nodes = batch.nodes_of_each(np.full(points, 8), 8)
    with jax.enable_x64(True):
        search = programs.compiled_search((6, 6, 6), axial=False, lanes=True).lower(
            rotor.arrays, flow, nodes, points
        )
        text = search.compile().as_text()
    assert "sqrt(" in text
    assert "rsqrt(" not in text
