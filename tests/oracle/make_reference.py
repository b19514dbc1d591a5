"""Compute the reference loads at every reference point and section; write them as a table.

Run from the repository root, with the package importable (about ten minutes on one core):

    python -m tests.oracle.make_reference

The package lends the blade geometry and nothing else.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path

from numpy.typing import ArrayLike

from tests.oracle.frozen import COLUMNS, TABLE, ReferenceLoads
from tests.oracle.literal_rotor import literal_loads
from tests.oracle.points import MU, RHO, SECTIONS, Point, reference_points

PROPELLER = "apc-8x6e"

Solve = Callable[[str, Point], dict[str, float]]


def solver(station: ArrayLike, chord: ArrayLike, twist: ArrayLike, blades: int) -> Solve:
    """A function of a section's name and a point that gives the literal loads [SI]."""
    blade = partial(literal_loads, station, chord, twist, blades)

    @cache
    def solve(name: str, point: Point) -> dict[str, float]:
        return blade(SECTIONS[name], RHO, MU, point.omega, point.v_axial, point.v_inplane)

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


def reference_rows(solve: Solve) -> Iterator[ReferenceLoads]:
    """All rows of the table: every section at every reference point."""
    for name in SECTIONS:
        for point in reference_points():
            yield reference_row(solve, name, point)


def write_table(path: Path, solve: Solve) -> None:
    """Write all rows to `path`; str() of a float gives every digit needed to read it back."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(reference_rows(solve))


def main() -> None:
    """Compute the table for the catalogue's propeller."""
    from propmap.catalogue.lookup import propeller

    blade = propeller(PROPELLER)
    write_table(TABLE, solver(blade.station, blade.chord, blade.twist, blade.blades))


if __name__ == "__main__":
    main()
