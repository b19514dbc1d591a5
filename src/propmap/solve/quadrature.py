"""Radial nodes: Gauss-Legendre on panels, crowded towards the panels' edges."""

from __future__ import annotations

import functools

import numpy as np

from propmap.arrays.namespace import Array, xp
from propmap.physics.loads import RadialNodes

TAIL = 4
"""Number of Legendre polynomials of a panel, those of highest degree, that make up its tail."""

CROWDING = 0.5
"""Share of crowding in the rule of split panels, from 0 for none to 1.

At 1 the outermost nodes would be so close to a fold that their roots take twice as many steps."""


gauss_legendre = functools.cache(np.polynomial.legendre.leggauss)
"""Nodes and weights on [-1, 1]; made once, as hundreds of them take longer than a search."""


def crowded_rule(nodes: int, *, inner: bool) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on [0, 1], each of shape (nodes,) [-], crowded towards the edges.

    Gauss-Legendre in t, with the radius at s = t (2 - t), which crowds the nodes towards the outer
    edge; if ``inner``, at a mean of t and t^2 (3 - 2 t), which crowds them towards both.  At a fold
    the inflow varies like a square root of the distance, and so does the chord at the tip; as
    functions of t both are smoother.
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
    """Size of the last coefficients of the integrand's Legendre series, an estimate of the error.

    The nodes of a panel determine as many coefficients as there are nodes.  For a smooth integrand
    they fall off quickly; at a kink or a step, which the nodes resolve badly, the last ones are
    still large.

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
        last = xp.asarray(_last_polynomials(nodes), dtype=values.dtype)
        # Of each load by itself: XLA computes the operands of a product of matrices once.
        parts = [load[start : start + nodes] for load in values]
        total = total + xp.stack([xp.sum(xp.matmul(last, part) ** 2, axis=0) for part in parts])
        start += nodes
    return xp.sqrt(total)


@functools.cache
def _last_polynomials(nodes: int) -> np.ndarray:
    """2 k + 1 times P_k at a panel's Gauss nodes for its ``TAIL`` highest k, (TAIL, nodes)."""
    x, _ = gauss_legendre(nodes)
    degrees = np.arange(nodes - TAIL, nodes)
    polynomials: np.ndarray = np.polynomial.legendre.legvander(x, nodes - 1).T[degrees]
    return (2 * degrees + 1)[:, None] * polynomials
