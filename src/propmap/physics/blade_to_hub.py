"""The blade continued from its first measured station inwards to the hub."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from propmap.arrays.namespace import by_numpy
from propmap.physics.geometry import Blade, blade_shape, make_blade

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
