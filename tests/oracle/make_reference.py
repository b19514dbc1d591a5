"""Compute the reference loads at every reference point and section; write them as tables.

Run from the repository root, with the package importable (about ten minutes on one core for each
of the two tables):

    python -m tests.oracle.make_reference

The package lends the blade geometry and nothing else.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Iterator
from functools import cache, partial
from pathlib import Path

from numpy.typing import ArrayLike

from tests.oracle.frozen import COLUMNS, EXTENDED_TABLE, TABLE, ReferenceLoads
from tests.oracle.literal_rotor import literal_loads
from tests.oracle.literal_wake import static_inflow
from tests.oracle.naca_0015 import naca_0015
from tests.oracle.points import MU, RHO, SECTIONS, Point, extended_points, reference_points

PROPELLER = "apc-8x6e"

Solve = Callable[[str, Point], dict[str, float]]

EXTENDED = ("naca-0015", "tip-loss", "hub-loss", "both-losses")
"""Extensions of the paper's rotor; the losses with a section of Table I."""

SECTION_OF = {"tip-loss": "apc", "hub-loss": "soft", "both-losses": "stiff"}


def solver(station: ArrayLike, chord: ArrayLike, twist: ArrayLike, blades: int) -> Solve:
    """A function of a set's or extension's name and a point that gives the literal loads [SI]."""
    blade = partial(literal_loads, station, chord, twist, blades)
    root, tip = float(min(station)), float(max(station))  # type: ignore[type-var,arg-type]

    @cache
    def solve(name: str, point: Point) -> dict[str, float]:
        section = naca_0015() if name == "naca-0015" else SECTIONS[SECTION_OF.get(name, name)]
        hub = root if name in ("hub-loss", "both-losses") else None
        losses = {"tip_loss": name in ("tip-loss", "both-losses"), "hub_radius": hub}
        v_hover = None
        if point.v_axial < 0.0:
            static = solve(name, Point(point.rpm, 0.0, 0.0))["thrust"]
            v_hover = static_inflow(static, RHO, tip)
        motion = (point.omega, point.v_axial, point.v_inplane)
        return blade(section, RHO, MU, *motion, **losses, v_hover=v_hover)

    return solve


def reference_row(solve: Solve, name: str, point: Point) -> ReferenceLoads:
    """One row of the table: the loads at `point` and in hover at the same speed of rotation."""
    loads = solve(name, point)
    static = solve(name, Point(point.rpm, 0.0, 0.0))
    return ReferenceLoads(
        set=name,
        rpm=point.rpm,
        v_axial=point.v_axial,
        v_inplane=point.v_inplane,
        thrust=loads["thrust"],
        drag=loads["drag"],
        torque=loads["torque"],
        roll_moment=loads["roll_moment"],
        static_thrust=static["thrust"],
        static_torque=static["torque"],
    )


def reference_rows(
    solve: Solve, names: Iterable[str], points: list[Point]
) -> Iterator[ReferenceLoads]:
    """All rows of a table: every name at every point."""
    for name in names:
        for point in points:
            yield reference_row(solve, name, point)


def write_table(path: Path, rows: Iterable[ReferenceLoads]) -> None:
    """Write all rows to `path`; str() of a float gives every digit needed to read it back."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)


def main() -> None:
    """Compute both tables for the catalogue's propeller."""
    from propmap.catalogue.lookup import propeller

    blade = propeller(PROPELLER)
    solve = solver(blade.station, blade.chord, blade.twist, blade.blades)
    write_table(TABLE, reference_rows(solve, SECTIONS, reference_points()))
    write_table(EXTENDED_TABLE, reference_rows(solve, EXTENDED, extended_points()))


if __name__ == "__main__":
    main()
