"""Radial nodes: Gauss-Legendre on panels, crowded towards the panels' edges."""

from __future__ import annotations

import functools

import numpy as np

from propmap.arrays.namespace import Array, xp
from propmap.physics.loads import RadialNodes

TAIL = 4
"""How many of a panel's polynomials count as its tail, the highest ones."""

CROWDING = 0.5
"""How far the rule of an inner panel goes from even (0) to fully crowded (1) nodes.

All the way, its outermost nodes come so close to a fold that finding their roots takes
twice the steps of all others."""


gauss_legendre = functools.cache(np.polynomial.legendre.leggauss)
"""Nodes and weights on [-1, 1]; made once, as hundreds of them take longer than a search."""


def crowded_rule(nodes: int, *, inner: bool) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on [0, 1], each of shape (nodes,) [-], crowded towards the edges.

    Gauss-Legendre in t, with the radius at s = t (2 - t), which crowds the nodes towards the
    outer edge, or about s = t^2 (3 - 2 t), which crowds them towards both if ``inner``.  At a
    branch jump the inflow runs into the panel's edge like a square root and at the tip the
    chord does; in t both are smoother.
    """
    t, w = gauss_legendre(nodes)
    t, w = 0.5 * (t + 1.0), 0.5 * w
    if inner:
        s, slope = t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t)
        return CROWDING * s + (1.0 - CROWDING) * t, w * (CROWDING * slope + 1.0 - CROWDING)
    return t * (2.0 - t), w * 2.0 * (1.0 - t)


def panel_nodes(edges: Array, counts: tuple[int, ...]) -> RadialNodes:
    """Nodes of all panels between edges (P + 1, B) [m], counts[p] on each; differentiable."""
    radii, weights = [], []
    for start, end, nodes in zip(edges[:-1], edges[1:], counts, strict=True):
        s, w = crowded_rule(nodes, inner=len(counts) > 1)
        radii.append(start + (end - start) * s[:, None])
        weights.append((end - start) * w[:, None])
    return RadialNodes(xp.concatenate(radii), xp.concatenate(weights))


def tail(values: Array, counts: tuple[int, ...]) -> Array:
    """How much of a sum along the blade the highest polynomials of its panels carry.

    On each panel the nodes determine the Legendre series of the integrand up to the degree of
    their number.  Where the integrand is smooth its coefficients fall off to nothing; at a kink or
    a step, which the nodes resolve badly, the last ones are still large.

    Parameters
    ----------
    values : Array, shape (L, S, B)
        Integrands at the nodes, times the nodes' weights.
    counts : tuple of int
        Nodes on each panel, S in all.

    Returns
    -------
    Array, shape (L, B)
        Root of the sum of squares of the last ``TAIL`` coefficients of all panels, in the unit of
        ``values``.
    """
    start, total = 0, 0.0 * values[:, 0]
    for nodes in counts:
        part = values[:, None, start : start + nodes]
        last = xp.asarray(_last_polynomials(nodes), dtype=values.dtype)
        coefficients = xp.sum(last[None, :, :, None] * part, axis=2)
        total = total + xp.sum(coefficients**2, axis=1)
        start += nodes
    return xp.sqrt(total)


@functools.cache
def _last_polynomials(nodes: int) -> np.ndarray:
    """2 k + 1 times P_k at a panel's Gauss nodes for its ``TAIL`` highest k, (TAIL, nodes)."""
    x, _ = gauss_legendre(nodes)
    degrees = np.arange(nodes - TAIL, nodes)
    polynomials: np.ndarray = np.polynomial.legendre.legvander(x, nodes - 1).T[degrees]
    return (2 * degrees + 1)[:, None] * polynomials
