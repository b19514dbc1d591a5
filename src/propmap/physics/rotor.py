"""A rotor in air, as the arrays that its loads depend on."""

from __future__ import annotations

from typing import NamedTuple

from propmap.physics.added_loads import AddedLoads
from propmap.physics.element import Medium
from propmap.physics.geometry import Blade
from propmap.physics.inflow_harmonics import InflowShape
from propmap.physics.mount_drag import Mounted
from propmap.physics.sections.law import SectionLaw
from propmap.physics.wake import WakeFactor


class RotorArrays(NamedTuple):
    """A rotor in air, as arrays that can be differentiated; a pytree.

    Attributes
    ----------
    blade : Blade
        Geometry.
    law : SectionLaw
        Lift and drag of its sections.
    medium : Medium
        The air.
    factors : tuple of WakeFactor
        Corrections that multiply the momentum thrust.
    shape : InflowShape or None
        How the inflow varies around the disk; None where it does not, as in the paper.
    mount : Mounted or None
        What is mounted in the slipstream; None for nothing, as in the paper.
    added : tuple of AddedLoads
        Corrections that add to the loads and leave the inflow alone.
    """

    blade: Blade
    law: SectionLaw
    medium: Medium
    factors: tuple[WakeFactor, ...] = ()
    shape: InflowShape | None = None
    mount: Mounted | None = None
    added: tuple[AddedLoads, ...] = ()
