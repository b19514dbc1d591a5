"""A blade: its outline, chord and twist."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from propmap.report.style import COLOURS, new_figure, style

if TYPE_CHECKING:
    from propmap.model.propeller import Propeller

WIDTH = 7.2
"""Of the figure [inches]."""


@style()
def planform(propeller: Propeller) -> Figure:
    """The outline drawn about mid-chord (sweep plays no part in the model), chord and twist."""
    station, chord, root = 1e3 * propeller.station, 1e3 * propeller.chord, 1e3 * propeller.root
    tip = 1e3 * propeller.radius
    loaded = np.union1d(station[station > root], [root])
    half = 0.5 * np.interp(loaded, station, chord)
    # Heights [inches] such that the outline, to scale, fills its panel's width.
    height = 1.2 * WIDTH * chord.max() / station[-1]
    figure = new_figure(WIDTH, height + 4.4)
    outline, chords, twists = figure.subplots(3, 1, sharex=True, height_ratios=(height, 1.7, 1.7))
    outline.fill_between(station, -0.5 * chord, 0.5 * chord, color="0.9", linewidth=0.0)
    outline.fill_between(loaded, -half, half, color=COLOURS[5], alpha=0.6, linewidth=0.0)
    for side in (-0.5, 0.5):
        outline.plot(station, side * chord, color="0.2", linewidth=1.0)
    outline.axvline(root, color="0.4", linewidth=1.0, linestyle=":")
    outline.set_ylim(-0.55 * chord.max(), 0.55 * chord.max())
    outline.set_aspect("equal", adjustable="box")
    outline.set_ylabel("outline [mm]")
    points = {"marker": "o", "markersize": 3.0}
    chords.plot(station, chord, color=COLOURS[0], **points)
    chords.set_ylabel("chord c [mm]")
    chords.set_ylim(bottom=0.0)
    twists.plot(station, np.degrees(propeller.twist), color=COLOURS[1], **points)
    twists.set_ylabel("twist θ [deg]")
    twists.set_xlabel("radius y [mm]")
    twists.set_xlim(0.0, 1.02 * station[-1])
    upper = outline.secondary_xaxis("top", functions=(lambda y: y / tip, lambda x: x * tip))
    upper.set_xlabel("y/R")
    number = f"{propeller.blades} blades" if propeller.blades > 1 else "1 blade"
    figure.suptitle(f"{propeller.name}: {number}, R = {tip:.4g} mm, loaded from {root:.4g} mm")
    return figure
