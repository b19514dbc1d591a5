"""SVG pictures of a blade: outline to scale, chord and twist over the radius."""

from __future__ import annotations

import numpy as np

from propmap.model.propeller import Propeller
from tools.propeller_pages.plot import Series, figure, path, plot

LENGTH, MARGIN = 740.0, 10.0
"""Length of the outline from the axis to the tip, and the margin around it."""

SMALL = 100.0
"""Length of the outline in a list."""


def pictures(blade: Propeller) -> list[str]:
    """Return the outline about mid-chord (the model ignores sweep), then the two plots."""
    half = 0.5 * LENGTH * blade.chord.max() / blade.radius + MARGIN
    axis = f"M0 {half:.1f}H{LENGTH:g}"
    shape = path(*_outline(blade, LENGTH, half))
    root = LENGTH * blade.root / blade.radius
    outline = [
        f'<path class="grid" d="{axis}"/>',
        f'<path class="blade" d="{shape}Z"/>',
        f'<path class="zero" d="M{root:.1f} {MARGIN:g}V{2.0 * half - MARGIN:.1f}"/>',
        f'<circle class="hub" cx="0" cy="{half:.1f}" r="4"/>',
    ]
    share = blade.station / blade.radius
    told = f"Outline of a blade of {blade.name}, the axis at the left, to scale"
    return [
        figure(LENGTH + MARGIN, 2.0 * half, told, outline, "outline"),
        plot("chord c/R", "y/R", _both(share, blade.chord / blade.radius)),
        plot("twist θ [deg]", "y/R", _both(share, np.degrees(blade.twist))),
    ]


def small(blade: Propeller) -> str:
    """Return the outline alone for the list, which names the blade in its text."""
    half = 0.5 * SMALL * blade.chord.max() / blade.radius + 1.0
    shape = path(*_outline(blade, SMALL, half))
    return (
        f'<svg class="plot small" viewBox="0 0 {SMALL:g} {2.0 * half:.1f}" aria-hidden="true">'
        f'<path class="blade" d="{shape}Z"/></svg>'
    )


def _outline(blade: Propeller, length: float, middle: float) -> tuple[np.ndarray, np.ndarray]:
    along = length * blade.station / blade.radius
    across = 0.5 * length * blade.chord / blade.radius
    return np.r_[along, along[::-1]], np.r_[middle - across, (middle + across)[::-1]]


def _both(x: np.ndarray, y: np.ndarray) -> list[Series]:
    return [Series(x, y, line=True), Series(x, y, line=False)]
