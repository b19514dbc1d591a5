"""Loads that a correction adds to those of the blade elements, once the inflow is known."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from propmap.arrays.namespace import Array
from propmap.physics.element import Annulus, AnnulusLoads
from propmap.physics.velocities import AzimuthNodes


class AddedLoads(Protocol):
    """A correction that leaves the inflow alone, such as friction along the blade."""

    def annulus_loads(self, at: Annulus, inflow: Array, azimuth: AzimuthNodes) -> AnnulusLoads:
        """What it adds to the loads per radius and density, as ``element.annulus_loads``.

        The arguments are those of ``element.annulus_loads``: ``at``, ``inflow``, ``azimuth``.
        """
        ...


def with_added(
    loads: AnnulusLoads,
    added: Sequence[AddedLoads],
    at: Annulus,
    inflow: Array,
    azimuth: AzimuthNodes,
) -> AnnulusLoads:
    """Loads of annuli with those that corrections add.

    Parameters
    ----------
    loads : AnnulusLoads
        Of the blade elements, per radius and density.
    added : sequence of AddedLoads
        The corrections.
    at, inflow, azimuth
        Annuli, their inflow and azimuths, as in ``element.annulus_loads``.
    """
    for one in added:
        more = one.annulus_loads(at, inflow, azimuth)
        loads = AnnulusLoads(*(a + b for a, b in zip(loads, more, strict=True)))
    return loads
