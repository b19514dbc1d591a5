"""Radial nodes: Gauss-Legendre on panels, crowded towards the panels' edges."""

from __future__ import annotations

import numpy as np

from propmap.arrays.namespace import Array, xp
from propmap.physics.loads import RadialNodes

CROWDING = 0.5
"""How far the rule of an inner panel goes from even (0) to fully crowded (1) nodes.

All the way, its outermost nodes come so close to a fold that finding their roots takes
twice the steps of all others."""


def crowded_rule(nodes: int, *, inner: bool) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on [0, 1], each of shape (nodes,) [-], crowded towards the edges.

    Gauss-Legendre in t, with the radius at s = t (2 - t), which crowds the nodes towards the
    outer edge, or about s = t^2 (3 - 2 t), which crowds them towards both if ``inner``.  At a
    branch jump the inflow runs into the panel's edge like a square root and at the tip the
    chord does; in t both are smoother.
    """
    t, w = np.polynomial.legendre.leggauss(nodes)
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
