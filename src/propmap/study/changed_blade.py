"""Blades made from another: of another size, pitch, width or twist."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from propmap.errors import InputError
from propmap.model.model import Propeller

PITCH_AT = 0.75
"""Share of the radius at which a blade's pitch is told."""


def pitch_of(blade: Propeller) -> float:
    """The pitch of a ``blade`` at three quarters of the radius, 2 pi r tan(theta) [m]."""
    radius = PITCH_AT * blade.radius
    return 2.0 * math.pi * radius * float(np.interp(radius, blade.station, np.tan(blade.twist)))


def changed_blade(
    blade: Propeller,
    *,
    diameter: float | None = None,
    pitch: float | None = None,
    chord_scale: float = 1.0,
    twist_scale: float = 1.0,
    blades: int | None = None,
) -> Propeller:
    """A propeller made from another.

    Parameters
    ----------
    blade : Propeller
        The one to begin with.
    diameter : float, optional
        [m]; radii and chords grow alike.
    pitch : float, optional
        At three quarters of the radius [m]; the tangents of all twists change by one factor, so
        that the pitch of each station does. By default it grows with the diameter.
    chord_scale : float
        Of all chords, after the diameter [-].
    twist_scale : float
        Of what the twist differs by from that at three quarters of the radius [-]: 0 is a blade
        without twist, 1 leaves it.
    blades : int, optional
        How many.

    Raises
    ------
    InputError
        For a blade that cannot be.
    """
    for name, value in (("diameter", diameter), ("pitch", pitch), ("chord_scale", chord_scale)):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} is {value}", "give a number above 0")
    size = 1.0 if diameter is None else diameter / blade.diameter
    station, twist = size * blade.station, blade.twist
    if pitch is not None:
        own = size * pitch_of(blade)
        if own <= 0.0:
            raise InputError(f"the pitch of {blade.name} is {own:g} m", "begin with another blade")
        twist = np.arctan(np.tan(twist) * (pitch / own))
    middle = np.arctan(np.interp(PITCH_AT * station[-1], station, np.tan(twist)))
    return replace(
        blade,
        blades=blade.blades if blades is None else blades,
        station=station,
        chord=size * chord_scale * blade.chord,
        twist=middle + twist_scale * (twist - middle),
        root_cutout=None if blade.root_cutout is None else size * blade.root_cutout,
    )
