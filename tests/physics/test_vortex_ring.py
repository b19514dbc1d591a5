"""Where the static inflow (12) and the windmill branch take over."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from propmap.physics.vortex_ring import (
    on_windmill_branch,
    vortex_ring_inflow,
    vortex_ring_weight,
)

V_H = 6.0
Z = np.linspace(-2.5, 1.0, 141)  # V cos(beta)/v_h, in steps of 0.025


def weight(z: np.ndarray, x: np.ndarray | float, v_h: float = V_H) -> np.ndarray:
    z, x = np.broadcast_arrays(np.asarray(z, float), np.asarray(x, float))
    v = (jnp.asarray(z * v_h), jnp.asarray(x * v_h), jnp.full(z.shape, v_h))
    return np.asarray(vortex_ring_weight(*v))


def expected_rise(t: np.ndarray) -> np.ndarray:
    """The integral of t^2 (1 - t)^2 from 0, scaled to end at 1."""
    t = np.clip(t, 0.0, 1.0)
    return 30.0 * (t**3 / 3.0 - t**4 / 2.0 + t**5 / 5.0)


@pytest.mark.parametrize("x", [0.0, 0.3, 0.7])
def test_no_vortex_ring_in_climb_edgewise_flight_or_slow_descent(x: float) -> None:
    np.testing.assert_array_equal(weight(Z[Z >= -0.2], x), 0.0)


@pytest.mark.parametrize("x", [0.0, 0.3, 0.7])
def test_no_vortex_ring_in_fast_descent(x: float) -> None:
    np.testing.assert_array_equal(weight(Z[Z <= -2.0], x), 0.0)


@pytest.mark.parametrize("x", [0.95, 1.0, 4.0])
def test_the_inplane_flow_sweeps_the_vortex_ring_away(x: float) -> None:
    # At the very edge the smooth step's own rounding remains, 1 - (10 - 15 + 6).
    np.testing.assert_allclose(weight(Z, x), 0.0, atol=1e-15 if x == 0.95 else 0.0)


def test_axial_descent_inside_the_vortex_ring_uses_the_static_inflow_alone() -> None:
    inside = np.linspace(-1.5, -0.45, 43)
    np.testing.assert_allclose(weight(inside, 0.0), 1.0, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(weight(inside, 0.5), 1.0, rtol=0.0, atol=1e-15)


def test_the_edges_are_blended_by_a_smooth_step() -> None:
    # Onset 0.2 to 0.45 v_h, exit 1.5 to 2 v_h of descent, fade 0.5 to 0.95 v_h in the plane.
    onset = np.linspace(-0.45, -0.2, 11)
    np.testing.assert_allclose(weight(onset, 0.0), expected_rise(-(onset + 0.2) / 0.25), atol=1e-13)
    leave = np.linspace(-2.0, -1.5, 11)
    np.testing.assert_allclose(weight(leave, 0.0), expected_rise((leave + 2.0) / 0.5), atol=1e-13)
    fade = np.linspace(0.5, 0.95, 11)
    expected = 1.0 - expected_rise((fade - 0.5) / 0.45)
    np.testing.assert_allclose(weight(np.full(11, -1.0), fade), expected, atol=1e-13)


@pytest.mark.parametrize("along", ["axial", "inplane"])
def test_weight_and_its_slope_are_continuous(along: str) -> None:
    n = 4001
    if along == "axial":
        line = np.linspace(-2.5, 0.5, n)
        values = weight(line, 0.2)
    else:
        line = np.linspace(0.0, 1.5, n)
        values = weight(np.full(n, -0.9), line)
    h = line[1] - line[0]
    # The smooth step's slope is at most 15/8 and its second derivative 10/sqrt(3), over the
    # narrowest blend of 0.25.  A jump would show as 1/h, a kink as 1/h in the second.
    assert np.max(np.abs(np.diff(values))) / h < 1.01 * 1.875 / 0.25
    assert np.max(np.abs(np.diff(values, 2))) / h**2 < 1.01 * 10.0 / np.sqrt(3.0) / 0.25**2
    assert values.min() == 0.0
    assert values.max() == 1.0


def test_weight_depends_on_the_ratios_alone() -> None:
    np.testing.assert_allclose(weight(Z, 0.6, 1.3), weight(Z, 0.6, 17.0), atol=1e-13)


@pytest.mark.parametrize(("v_axial", "v_inplane"), [(-5.0, 3.0), (0.0, 0.0), (0.0, 4.0), (3.0, 0)])
def test_without_static_thrust_there_is_no_ring_and_all_is_finite(
    v_axial: float, v_inplane: float
) -> None:
    point = jnp.asarray(v_axial), jnp.asarray(float(v_inplane)), jnp.asarray(0.0)
    value, slopes = jax.value_and_grad(vortex_ring_weight, (0, 1, 2))(*point)
    assert float(value) == 0.0
    assert np.all(np.isfinite(slopes))


@pytest.mark.parametrize("v_h", [0.0, V_H])
def test_the_windmill_branch_is_for_descent_only(v_h: float) -> None:
    up = jnp.asarray([0.0, 1e-12, 3.0])
    np.testing.assert_array_equal(on_windmill_branch(up, jnp.full(3, v_h)), 0.0)
    down = jnp.asarray([-0.9, -1.0, -3.0]) * V_H
    expected = [0.0, 1.0, 1.0] if v_h else [1.0, 1.0, 1.0]
    np.testing.assert_array_equal(on_windmill_branch(down, jnp.full(3, v_h)), expected)


def test_branches_are_switched_where_neither_or_both_are_used() -> None:
    # Either (12) has replaced both, or (10) has no falling stretch and the two are one.
    z = np.linspace(-2.5, 0.5, 60001)
    windmill = np.asarray(on_windmill_branch(jnp.asarray(z * V_H), jnp.full(z.shape, V_H)))
    changes = np.flatnonzero(np.diff(windmill))
    assert len(changes) == 1
    switch = z[changes[0]]
    x = np.linspace(0.0, 3.0, 601)
    both = (weight(np.full(601, switch), x) == 1.0) | (x > abs(switch) / np.sqrt(8.0))
    assert both.all()


def test_vortex_ring_inflow_is_the_static_one_in_hover_and_peaks_in_descent() -> None:
    z = np.linspace(-2.0, 0.0, 201)
    v = np.asarray(vortex_ring_inflow(jnp.asarray(z * V_H), jnp.full(z.shape, V_H))) / V_H
    assert v[-1] == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose(v, np.polyval([-0.655, -1.718, -1.372, -1.125, 1.0], z), rtol=1e-12)
    # Measured rotors: about twice the static inflow between one and two v_h of descent.
    assert 1.6 < v.max() < 2.1
    assert -1.7 < z[v.argmax()] < -1.0
