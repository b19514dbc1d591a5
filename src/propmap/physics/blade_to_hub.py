"""The blade continued from its first measured station inwards to the hub."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from propmap.arrays.namespace import by_numpy
from propmap.errors import InputError
from propmap.physics.geometry import Blade, blade_shape, make_blade

if TYPE_CHECKING:
    from propmap.physics.rotor import RotorArrays

HUB_SHARE = 0.08
"""Radius of a hub whose size is not given, over that of the tip [-]: 16 mm across on an 8-inch
propeller."""

TAPER_SPAN = 0.1
"""Stretch beside the first station that tells how the chord goes on, over the tip's radius [-]: two
stations alone are too close to each other on some measured blades."""

LEAST_CHORD = 0.5
"""Least chord of the continued blade over that of the first station [-]."""

INTERVALS = 12
"""Of the continued blade; chord and twist are within 1e-4 of their rule between them."""


def continued_to(blade: Blade, hub: float) -> Blade:
    """The ``blade`` continued to a radius ``hub`` [m] inside its first station.

    The chord line keeps the geometric pitch of the first station, 2 pi y tan(theta), as it does on
    blades whose pitch is constant.  The chord goes on with its mean slope over the first
    ``TAPER_SPAN``, but no wider than at the first station and no narrower than ``LEAST_CHORD`` of
    it.  The measured part stays as it is.
    """
    first, widest, twist, tip = (
        float(value) for value in (blade.station[0], blade.chord[0], blade.twist[0], blade.tip)
    )
    further: Any = np.array(min(first + TAPER_SPAN * tip, tip))
    with by_numpy():
        taper = (float(blade_shape(blade, further)[0]) - widest) / (float(further) - first)
        y = np.linspace(hub, first, INTERVALS + 1)
        chord = np.clip(widest + taper * (y - first), LEAST_CHORD * widest, widest)
        pitch_line = np.arctan2(first * math.sin(twist), y * math.cos(twist))
        inner = make_blade(y, chord, pitch_line, blade.blades, np.float64(hub))

    def joined(inside: Any, outside: Any) -> Any:
        return np.concatenate([inside, outside])

    return Blade(
        station=joined(inner.station[:-1], blade.station),
        chord=joined(inner.chord[:-1], blade.chord),
        twist=joined(inner.twist[:-1], blade.twist),
        cubics=joined(inner.cubics, blade.cubics),
        blades=blade.blades,
        root=inner.root,
    )


@dataclass(frozen=True)
class BladeToHub:
    """The blade continued to the hub, as a correction of a ``Model``; see ``continued_to``.

    Geometry files begin where the blade leaves the hub's fairing.  What lies inside stands steeply
    in the in-plane flow: on the APC 8x6E it is a hundredth or two of the thrust and more than a
    tenth of the rotor drag.  A blade that reaches the hub stays as it is.

    Attributes
    ----------
    radius_m : float or None
        Radius of the hub [m]; None for ``HUB_SHARE`` of the tip's radius.

    Raises
    ------
    InputError
        For a radius that is no positive number; when applied, for one outside the first station
        and for a blade that a root cut-out shortens.
    """

    radius_m: float | None = None

    def __post_init__(self) -> None:
        if self.radius_m is not None and not 0.0 < self.radius_m < math.inf:
            raise InputError(f"radius_m is {self.radius_m}: give the hub's radius in metres")

    def applied(self, rotor: RotorArrays) -> RotorArrays:
        """The ``rotor`` with its blade continued to the hub."""
        blade = rotor.blade
        first, root, tip = (float(y) for y in (blade.station[0], blade.root, blade.tip))
        if root > first * (1.0 + 1e-9):
            raise InputError(
                f"blade-to-hub continues the blade inwards, but its root is cut out at {root:g} m",
                "leave out one of the two",
            )
        hub = HUB_SHARE * tip if self.radius_m is None else self.radius_m
        if self.radius_m is not None and hub > first * (1.0 + 1e-9):
            raise InputError(
                f"radius_m of blade-to-hub is {hub:g} m, but the blade begins at {first:g} m",
                "give a smaller radius in metres, or leave the correction out",
            )
        if hub >= first * (1.0 - 1e-9):
            return rotor
        return rotor._replace(blade=continued_to(blade, hub))
