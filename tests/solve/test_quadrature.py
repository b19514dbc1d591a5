"""Radial nodes and weights."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from propmap.solve.quadrature import TAIL, crowded_rule, panel_nodes, tail


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


COUNTS = (12, 16, 16)


def weighted(values: np.ndarray) -> np.ndarray:
    """Values (S,) at the nodes of three panels as ``tail`` takes them, (1, S, 1)."""
    weights = np.concatenate([np.polynomial.legendre.leggauss(n)[1] for n in COUNTS])
    return (weights * values)[None, :, None]


def position() -> np.ndarray:
    """From -1 to 1 on each panel, (S,)."""
    return np.concatenate([np.polynomial.legendre.leggauss(n)[0] for n in COUNTS])


@pytest.mark.parametrize("degree", range(min(COUNTS) - TAIL))
def test_no_tail_where_the_rest_of_the_polynomials_serve(degree: int) -> None:
    assert tail(weighted(position() ** degree), COUNTS) == pytest.approx(0.0, abs=1e-13)


def test_each_polynomial_of_a_tail_counts_with_its_coefficient() -> None:
    """Of all panels together: root of the sum of squares."""
    x = position()
    one = np.polynomial.legendre.Legendre.basis(min(COUNTS) - 1)(x) * (np.arange(x.size) < 12)
    # The series of the weighted sum has (2 k + 1)/2 times the integral: 2 P_k has that of P_k.
    assert tail(weighted(one), COUNTS) == pytest.approx(2.0, rel=1e-12)
    both = one + np.concatenate([np.zeros(12), np.polynomial.legendre.Legendre.basis(15)(x[12:])])
    assert tail(weighted(both), COUNTS) == pytest.approx(2.0 * np.sqrt(3.0), rel=1e-12)


def test_a_step_and_a_kink_have_a_tail_and_a_smooth_bump_has_none() -> None:
    x = position()
    step, kink, bump = (
        float(tail(weighted(f), COUNTS)[0, 0])
        for f in ((x > 0.1) * 1.0, np.abs(x - 0.1), np.exp(-(x**2) / 4.0))
    )
    assert step > 0.3
    assert 0.01 < kink < step
    assert bump < 1e-4


def test_tails_are_in_the_unit_of_what_they_are_of() -> None:
    rng = np.random.default_rng(1)
    values = rng.normal(size=(3, sum(COUNTS), 2))
    np.testing.assert_allclose(tail(-7.0 * values, COUNTS), 7.0 * tail(values, COUNTS), rtol=1e-13)
    # Loads and points do not mix.
    np.testing.assert_allclose(tail(values[1:2, :, 1:], COUNTS)[0, 0], tail(values, COUNTS)[1, 1])
