"""The constants of all propellers in one picture, with error bars and predictions."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import NamedTuple

import numpy as np

from propmap.catalogue.expected import (
    POPULATION,
    Population,
    bundled_population,
    coordinate_covariance,
    coordinates,
    expected_prior,
)
from propmap.catalogue.identified import PARAMETERS, Identified
from propmap.typing import Floats
from tools.propeller_pages.plot import figure
from tools.propeller_pages.words import fixed, series_title, title

ROW, COLUMN, GAP = 22.0, 80.0, 24.0
"""Height of the row of a family; width of the column of a constant, and the gap between columns."""

LEFT, TOP, BOTTOM = 185.0, 58.0, 8.0

BOX, SPREAD = 18.0, 15.0
"""Height of the box of a family, and of the strip with the points of its propellers."""


class Axis(NamedTuple):
    """The axis of one coordinate of the constants."""

    name: str
    unit: str
    logarithmic: bool  # whether the coordinate is the logarithm of the constant
    marks: tuple[float, ...]  # labeled values, omitted outside the data

    def coordinate(self, value: float) -> float:
        """Return the coordinate of a value."""
        return float(np.log(value)) if self.logarithmic else value


AXES = (
    Axis("c_l1", "1/rad", True, (3.0, 5.0, 10.0)),
    Axis("c_l2", "-", True, (1.5, 2.0, 3.0)),
    Axis("c_d", "-", True, (1.0, 2.0, 5.0, 10.0)),
    Axis("alpha_0", "rad", True, (0.2, 0.3, 0.4)),
    Axis("zero_lift_angle", "rad", False, (-0.1, 0.0)),
    Axis("c_d0", "-", True, (0.01, 0.03, 0.1)),
    Axis("reynolds_camber", "rad", False, (-0.05, 0.0, 0.05)),
    Axis("reynolds_lift", "-", False, (0.0, 0.1, 0.2)),
    Axis("reynolds_drag", "-", False, (-0.6, -0.4, -0.2, 0.0)),
    Axis("least drag", "rad", False, (-0.05, 0.0, 0.05, 0.1)),
)
"""Axes in the order of ``PARAMETERS``.  The last is ``zero_lift_angle`` + ``drag_angle``, the angle
of least pressure drag from the chord line."""


class Column:
    """The column of constant number ``k``, whose range includes all values and error bars."""

    def __init__(self, k: int, place: Floats, error: Floats) -> None:
        self.left = LEFT + k * (COLUMN + GAP)
        self.low, self.high = float((place - error).min()), float((place + error).max())

    def at(self, coordinate: float) -> float:
        """Return the position of a coordinate."""
        return self.left + COLUMN * (coordinate - self.low) / (self.high - self.low)

    def ends(self, mean: float, deviation: float) -> tuple[float, float]:
        """Return the positions of mean ± standard deviation, limited to the column."""
        low, high = self.at(mean - deviation), self.at(mean + deviation)
        return max(low, self.left), min(high, self.left + COLUMN)


def picture(entries: Sequence[Identified]) -> str:
    """Draw the picture as SVG: a column for each constant, a row for each family."""
    found = bundled_population("measured")
    place = coordinates(np.stack([one.constants for one in entries]))
    error = np.sqrt(
        [np.diag(coordinate_covariance(one.constants, one.covariance)) for one in entries]
    )
    columns = [Column(k, place[:, k], error[:, k]) for k in range(len(AXES))]
    family = np.array([one.family for one in entries])
    families = sorted(set(family.tolist()), key=lambda f: series_title(f).lower())
    height = TOP + ROW * len(families) + BOTTOM
    parts = [_frame(column, k, found, height) for k, column in enumerate(columns)]
    for row, code in enumerate(families):
        which = np.flatnonzero(family == code).tolist()
        members = [entries[n] for n in which]
        middle = TOP + (row + 0.5) * ROW
        parts.append(
            f'<text class="y" x="{LEFT - 12.0:g}" y="{middle + 4.0:g}">'
            f"{escape(series_title(code))} ({len(which)})</text>"
        )
        expected = expected_prior(code)
        for column, mean, sd in zip(columns, expected.mean, expected.deviation, strict=True):
            parts.append(_expected(column, mean, sd, middle))
        for n, one in enumerate(members):
            # The points of a family are stacked in the order of the list.
            height_of_one = middle + SPREAD * ((n + 0.5) / len(which) - 0.5)
            parts.append(_member(one, columns, place[which[n]], error[which[n]], height_of_one))
    width = LEFT + len(AXES) * (COLUMN + GAP)
    told = "Constants of all propellers by family, with error bars, and the prior"
    return figure(width, height, told, parts, "population")


def table() -> str:
    """Tabulate the prior of the fits, and the mean and spread of their results."""
    found = bundled_population("measured")
    between, within = (np.sqrt(np.diag(part)) for part in (found.between, found.within))
    rows = [
        "| constant | prior of the fits | mean of the fits | between families | within families |",
        "|---|---:|---:|---:|---:|",
    ]
    for k, axis in enumerate(AXES):
        name = f"`{axis.name}`" if axis.name in PARAMETERS else axis.name
        first, *apart = (_apart(axis, s[k]) for s in (POPULATION.deviation, between, within))
        before, middle = (_value(axis, m[k]) for m in (POPULATION.mean, found.mean))
        rows.append(f"| {name} | {before} {first} | {middle} | {' | '.join(apart)} |")
    return "\n".join(rows)


def _value(axis: Axis, coordinate: float) -> str:
    return fixed(float(np.exp(coordinate)) if axis.logarithmic else coordinate, 3)


def _apart(axis: Axis, deviation: float) -> str:
    """Return a standard deviation of a coordinate as a factor or as a difference."""
    if axis.logarithmic:
        return f"\u00d7\u00f7 {fixed(float(np.exp(deviation)), 2)}"
    return f"± {fixed(deviation, 3)}"


def _frame(column: Column, k: int, found: Population, height: float) -> str:
    """Return heading, labeled values, and the band of a propeller of an unknown family."""
    axis, foot = AXES[k], height - BOTTOM
    spread = float(np.sqrt(found.between[k, k] + found.within[k, k]))
    low, high = column.ends(found.mean[k], spread)
    parts = [
        f'<rect class="band" x="{low:.1f}" y="{TOP:g}" width="{high - low:.1f}" '
        f'height="{foot - TOP:g}"/>',
        f'<text class="title" x="{column.left:g}" y="14">{axis.name}</text>'
        f'<text x="{column.left:g}" y="28">[{axis.unit}]</text>',
    ]
    for value in axis.marks:
        if column.low <= axis.coordinate(value) <= column.high:
            at = column.at(axis.coordinate(value))
            text = f"{value:g}".replace("-", "\N{MINUS SIGN}")
            parts.append(f'<path class="grid" d="M{at:.1f} {TOP:g}V{foot:g}"/>')
            parts.append(f'<text class="x" x="{at:.1f}" y="{TOP - 8.0:g}">{text}</text>')
    prior = column.at(POPULATION.mean[k])
    parts.append(f'<path class="zero" d="M{prior:.1f} {TOP:g}V{foot:g}"/>')
    return "".join(parts)


def _expected(column: Column, mean: float, deviation: float, middle: float) -> str:
    low, high = column.ends(mean, deviation)
    top, tall = middle - 0.5 * BOX, f"{BOX:g}"
    return (
        f'<rect class="family" x="{low:.1f}" y="{top:g}" width="{high - low:.1f}" '
        f'height="{tall}"/><path class="family" d="M{column.at(mean):.1f} {top:g}v{tall}"/>'
    )


def _member(
    one: Identified, columns: Sequence[Column], place: Floats, error: Floats, height: float
) -> str:
    """Return the points of one propeller with error bars, and its name as a tooltip."""
    bars = dots = ""
    for column, value, deviation in zip(columns, place, error, strict=True):
        low, high = column.ends(value, deviation)
        bars += f"M{low:.1f} {height:.1f}H{high:.1f}"
        dots += f"M{column.at(value):.1f} {height:.1f}h0"
    return (
        f'<g><title>{escape(title(one))}</title><path class="bar" d="{bars}"/>'
        f'<path class="dots c0" d="{dots}"/></g>'
    )
