"""Loads of the whole rotor from those of its annuli, eqs. (13)-(15)."""

from __future__ import annotations

from typing import NamedTuple

from propmap.arrays.namespace import Array, xp
from propmap.physics.element import AnnulusLoads


class RadialNodes(NamedTuple):
    """Radii y [m] and quadrature weights dy [m] along the blade, both (S, B) or (S, 1)."""

    radius: Array
    weight: Array


def integrate(per_radius: AnnulusLoads, nodes: RadialNodes, density: Array) -> AnnulusLoads:
    """Integrals along the blade, eqs. (13)-(15), (B,): thrust, drag [N], torque, moment [N m].

    Parameters
    ----------
    per_radius : AnnulusLoads
        Loads of the annuli per radius and density, (S, B).
    nodes : RadialNodes
        Radii of the annuli, and weights.
    density : Array
        rho [kg/m^3].
    """
    totals = density * xp.sum(nodes.weight * xp.stack(per_radius), axis=1)
    return AnnulusLoads(*totals)  # Eqs. (13)-(15)


def mean_over_disk(values: Array, nodes: RadialNodes) -> Array:
    """The mean of ``values`` (S, B) over the disk's area; (B,)."""
    area = nodes.weight * nodes.radius
    return xp.sum(area * values, axis=0) / xp.sum(area, axis=0)
