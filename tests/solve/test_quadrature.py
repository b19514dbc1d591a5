"""Radial nodes and weights."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from propmap.solve.quadrature import crowded_rule, panel_nodes


@pytest.mark.parametrize("nodes", [4, 12, 24, 48])
@pytest.mark.parametrize("inner", [False, True])
def test_rule_integrates_polynomials_exactly(nodes: int, inner: bool) -> None:
    s, w = crowded_rule(nodes, inner=inner)
    assert len(s) == len(w) == nodes
    assert np.all(w > 0.0)
    assert np.all(np.diff(s) > 0.0)
    assert s[0] > 0.0
    assert s[-1] < 1.0
    # A power p of s is a polynomial in t of degree 2p + 1 (3p + 2 on an inner panel), and
    # Gauss-Legendre takes degree 2n - 1 exactly.
    highest = (2 * nodes - 3) // 3 if inner else nodes - 1
    for power in range(highest + 1):
        assert np.sum(w * s**power) == pytest.approx(1.0 / (power + 1), rel=1e-12)


def test_outer_rule_takes_a_rounded_tip_exactly() -> None:
    # With s = t (2 - t), sqrt(1 - s) is 1 - t: the integral over [0, 1] is 2/3.
    s, w = crowded_rule(4, inner=False)
    assert np.sum(w * np.sqrt(1.0 - s)) == pytest.approx(2.0 / 3.0, rel=1e-14)


@pytest.mark.parametrize("nodes", [12, 18])
def test_inner_rule_takes_a_square_root_at_either_end_better_than_gauss(nodes: int) -> None:
    s, w = crowded_rule(nodes, inner=True)
    t, v = np.polynomial.legendre.leggauss(nodes)
    plain = abs(np.sum(0.5 * v * np.sqrt(0.5 - 0.5 * t)) - 2.0 / 3.0)
    at_outer = abs(np.sum(w * np.sqrt(1.0 - s)) - 2.0 / 3.0)
    at_inner = abs(np.sum(w * np.sqrt(s)) - 2.0 / 3.0)
    # Half crowded, the nodes at the ends lie half as far from them: sqrt(1/8) of the error.
    assert max(at_outer, at_inner) < 0.5 * plain
    assert max(at_outer, at_inner) < 1e-4
    assert at_inner == pytest.approx(at_outer, rel=1e-6)  # the rule is symmetric


def test_weights_sum_to_the_panel_lengths() -> None:
    edges = np.array([[0.02, 0.03], [0.035, 0.03], [0.06, 0.07], [0.1, 0.1]])
    counts = (5, 7, 9)
    nodes = panel_nodes(jnp.asarray(edges), counts)
    assert nodes.radius.shape == nodes.weight.shape == (21, 2)
    begin = 0
    for p, count in enumerate(counts):
        part = slice(begin, begin + count)
        begin += count
        # Rounding of radii of 0.1 m; the second point's first panel is empty.
        lengths = np.sum(np.asarray(nodes.weight[part]), axis=0)
        np.testing.assert_allclose(lengths, edges[p + 1] - edges[p], atol=1e-16)
        assert np.all(np.asarray(nodes.radius[part]) >= edges[p] - 1e-16)
        assert np.all(np.asarray(nodes.radius[part]) <= edges[p + 1] + 1e-16)


def test_panels_integrate_over_the_whole_blade() -> None:
    edges = np.array([[0.02], [0.041], [0.08], [0.1]])
    nodes = panel_nodes(jnp.asarray(edges), (4, 6, 6))
    got = np.sum(np.asarray(nodes.weight) * np.asarray(nodes.radius))
    assert got == pytest.approx(0.5 * (0.1**2 - 0.02**2), rel=1e-13)


def test_one_panel_takes_a_rounded_tip_exactly() -> None:
    nodes = panel_nodes(jnp.asarray([[0.02], [0.1]]), (16,))
    got = np.sum(np.asarray(nodes.weight) * np.sqrt(0.1 - np.asarray(nodes.radius)))
    assert got == pytest.approx(2.0 / 3.0 * 0.08**1.5, rel=1e-13)
