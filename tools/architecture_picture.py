"""Draw the package's folders in layers, with arrows for the imports in the source.

Usage: python -m tools.architecture_picture FILE.svg

A box is one row above the highest box that it imports.  Arrows that follow from other arrows are
omitted: if ``cli`` imports ``fit`` and ``fit`` imports ``model``, the arrow from ``cli`` to
``model`` is not drawn.
"""

from __future__ import annotations

import pathlib
import sys
from collections import defaultdict
from collections.abc import Collection, Mapping
from itertools import accumulate, pairwise
from statistics import mean

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch
from matplotlib.path import Path

from propmap.report.html import COLORS, new_figure, save, style
from tools.import_graph import lines, room_imports

WIDTH, HEIGHT = 0.8, 0.56
"""Width and height of a box; rows and columns have a distance of 1."""

GAP = 0.3
"""Width reserved for an arrow that passes through a row."""

SWEEPS = 16
"""Number of passes, upward or downward, that move each box to the mean of its neighbors."""

Place = tuple[float, int]
Graph = Mapping[str, Collection[str]]


def picture() -> Figure:
    """Draw a box for each folder and an arrow from each folder to each one that it imports."""
    imports, count = room_imports(), lines()
    imports.pop("__main__")
    row = _rows(imports)
    paths = [
        [name, *(f"{name} to {other} in {k}" for k in range(row[name] - 1, row[other], -1)), other]
        for name, others in without_detours(imports).items()
        for other in others
    ]
    places = _places(paths, row)
    with style():
        figure = new_figure(8.4, 0.68 * len(set(row.values())))
        axes = figure.add_subplot()
        axes.set_axis_off()
        half = {name: 0.5 * WIDTH if name in row else 0.0 for name in places}
        axes.set_xlim(
            min(x - half[name] for name, (x, _) in places.items()) - 0.03,
            max(x + half[name] for name, (x, _) in places.items()) + 0.03,
        )
        axes.set_ylim(-0.4, max(row.values()) + 0.4)
        for path in paths:
            _arrow(axes, [places[point] for point in path])
        for name in row:
            _box(axes, places[name], name, count[name])
    return figure


def without_detours(imports: Graph) -> dict[str, set[str]]:
    """Return the transitive reduction of a graph whose lowest layer comes first."""
    below: dict[str, set[str]] = {}
    for name, others in imports.items():
        below[name] = set(others).union(*(below[other] for other in others))
    return {
        name: {o for o in others if not any(o in below[more] for more in others)}
        for name, others in imports.items()
    }


def _rows(imports: Graph) -> dict[str, int]:
    row: dict[str, int] = {}
    for name, others in imports.items():
        row[name] = 1 + max((row[other] for other in others), default=-1)
    return row


def _places(paths: list[list[str]], row: Mapping[str, int]) -> dict[str, Place]:
    """Return the places of boxes, and of long arrows in each row that they pass.

    A path leads from a box to a lower one, with a separate point in each row between them.  Boxes
    and points are placed near the mean of the boxes and points to which paths join them.
    """
    level, joined = dict(row), defaultdict(set)
    for path in paths:
        for k, (one, other) in enumerate(pairwise(path)):
            level.setdefault(other, row[path[0]] - k - 1)
            joined[one].add(other)
            joined[other].add(one)
    x = dict.fromkeys(level, 0.0)
    for sweep in range(SWEEPS):
        for k in sorted(set(level.values()), reverse=sweep % 2 == 1):
            here = [name for name in level if level[name] == k]
            here.sort(key=lambda name: (mean([x[other] for other in joined[name]] or [0.0]), name))
            widths = [1.0 if name in row else GAP for name in here]
            for name, end, width in zip(here, accumulate(widths), widths, strict=True):
                x[name] = end - 0.5 * (width + sum(widths))
    return {name: (x[name], level[name]) for name in level}


def _box(axes: Axes, place: Place, name: str, count: int) -> None:
    x, y = place
    corner = (x - 0.5 * WIDTH, y - 0.5 * HEIGHT)
    axes.add_patch(
        FancyBboxPatch(
            corner,
            WIDTH,
            HEIGHT,
            boxstyle="round,pad=0,rounding_size=0.06",
            facecolor="white",
            edgecolor=COLORS[0],
            zorder=3,
        )
    )
    axes.text(x, y + 0.03, name, ha="center", fontsize=11, fontweight="bold", zorder=4)
    axes.text(x, y - 0.19, f"{count:,} lines", ha="center", fontsize=9, color="0.3", zorder=4)


def _arrow(axes: Axes, path: list[Place]) -> None:
    """Draw an arrow from the first box down to the last one, vertical within each passed row."""
    half = 0.5 * HEIGHT
    points = [(x, y + side) for x, y in path for side in (half, -half)][1:-1]
    axes.add_patch(
        FancyArrowPatch(
            path=Path(points),
            arrowstyle="-|>",
            mutation_scale=11,
            color="0.35",
            linewidth=1.1,
            shrinkA=0,
            shrinkB=1,
        )
    )


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    save(picture(), pathlib.Path(sys.argv[1]))
