"""Small plots as SVG text, in the colors of the surrounding page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from matplotlib.ticker import MaxNLocator

from propmap.typing import Floats

WIDTH, HEIGHT = 360.0, 230.0
LEFT, RIGHT, TOP, BOTTOM = 50.0, 10.0, 24.0, 36.0
"""Margins of a plot; all lengths are in the units of its view box."""

COLORS = 7
"""Number of colors in the style sheet; further series repeat them."""


@dataclass(frozen=True, eq=False)
class Series:
    """Points or a line in one color."""

    x: Floats  # (n,): positions; points with a y that is not finite are omitted
    y: Floats
    line: bool  # whether to draw a line instead of points
    color: int = 0


def plot(
    title: str,
    across: str,
    series: Sequence[Series],
    band: float | None = None,
    least: tuple[float, float] | None = None,
) -> str:
    """Draw a plot with its axes.

    ``across`` is the label of the horizontal axis, ``band`` half the height of a shaded band about
    0, and ``least`` the minimum range of the vertical axis, by default 0.
    """
    x = np.concatenate([one.x[np.isfinite(one.y)] for one in series])
    y = np.concatenate([one.y[np.isfinite(one.y)] for one in series])
    marks_x, low_x, high_x = _ticks([*x, 0.0])
    marks_y, low_y, high_y = _ticks([*y, *(least or (0.0,))])

    def place(x: Floats, y: Floats) -> tuple[Floats, Floats]:
        along = (x - low_x) / (high_x - low_x)
        up = (y - low_y) / (high_y - low_y)
        return (
            LEFT + along * (WIDTH - LEFT - RIGHT),
            HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM),
        )

    parts = [f'<text class="title" x="{LEFT:g}" y="14">{escape(title)}</text>']
    if band is not None:
        (left, right), (top, below) = place(np.array([low_x, high_x]), np.array([band, -band]))
        parts.append(
            f'<rect class="band" x="{left:.1f}" y="{top:.1f}" width="{right - left:.1f}" '
            f'height="{below - top:.1f}"/>'
        )
    for value, text in marks_x:
        at, foot = place(np.array(value), np.array(low_y))
        parts.append(f'<path class="grid" d="M{at:.1f} {TOP:g}V{foot:.1f}"/>')
        parts.append(f'<text class="x" x="{at:.1f}" y="{foot + 14.0:.1f}">{text}</text>')
    for value, text in marks_y:
        left, at = place(np.array(low_x), np.array(value))
        look = "zero" if value == 0.0 and low_y < 0.0 else "grid"
        parts.append(f'<path class="{look}" d="M{left:.1f} {at:.1f}H{WIDTH - RIGHT:g}"/>')
        parts.append(f'<text class="y" x="{left - 5.0:.1f}" y="{at + 4.0:.1f}">{text}</text>')
    parts.append(
        f'<text class="x" x="{0.5 * (LEFT + WIDTH - RIGHT):g}" y="{HEIGHT - 5.0:g}">'
        f"{escape(across)}</text>"
    )
    parts += [_drawn(one, *place(one.x, one.y)) for one in series]
    return figure(WIDTH, HEIGHT, f"{title} over {across}", parts)


def figure(width: float, height: float, told: str, parts: Iterable[str], look: str = "") -> str:
    """Return an SVG element; ``told`` is its description for screen readers."""
    return (
        f'<svg class="plot {look}" viewBox="0 0 {width:g} {height:g}" role="img" '
        f'aria-label="{escape(told)}">{"".join(parts)}</svg>'
    ).replace('plot "', 'plot"')


def path(x: Floats, y: Floats) -> str:
    """Return the data of an SVG path through the points (n,), rounded to a tenth of a unit."""
    return "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y, strict=True))


def _drawn(one: Series, x: Floats, y: Floats) -> str:
    seen = np.isfinite(y)
    color = f"c{one.color % COLORS}"
    if one.line:
        return f'<path class="curve {color}" d="{path(x[seen], y[seen])}"/>'
    # A line of zero length with round ends is a disk, in a dozen characters.
    dots = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(x[seen], y[seen], strict=True))
    return f'<path class="dots {color}" d="{dots}"/>'


def _ticks(values: Sequence[float]) -> tuple[list[tuple[float, str]], float, float]:
    """Return round values with their labels, and the ends of an axis around all ``values``."""
    low, high = min(values), max(values)
    if low == high:
        high = low + 1.0
    marks = MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    step = marks[1] - marks[0]
    digits = max(0, int(np.ceil(-np.log10(step) - 1e-9)))
    if round(step * 10.0**digits, 6) % 1.0:
        digits += 1
    told = [(0.0 if abs(m) < 1e-9 * step else float(m)) for m in marks]
    texts = [f"{m:.{digits}f}".replace("-", "\N{MINUS SIGN}") for m in told]
    return list(zip(told, texts, strict=True)), told[0], told[-1]
