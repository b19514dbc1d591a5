"""Compute the literal loads of random laws on ten blades; write them as a table.

Run from the repository root, with the package importable (a second or two a row):

    python -m tests.oracle.make_other_reference

The package lends the blades' geometry and nothing else.
"""

from __future__ import annotations

import csv
import multiprocessing
from pathlib import Path
from typing import NamedTuple

from tests.oracle.literal_rotor import literal_loads
from tests.oracle.points import MU, RHO
from tests.other_laws import OtherRotor, other_flow, other_rotors

TABLE = Path(__file__).with_name("reference_loads_other_laws.csv")
ROTORS, POINTS = 60, 5
LAW = ("c_l1", "c_l2", "c_d", "alpha_0", "zero_lift_angle", "c_d0", "sharpness")
LOADS = ("thrust", "drag", "torque", "roll_moment")


class OtherRow(NamedTuple):
    """Loads of one rotor at one point, and its thrust and torque at rest; SI, angles in rad."""

    blade: str
    blades: int
    c_l1: float
    c_l2: float
    c_d: float
    alpha_0: float
    zero_lift_angle: float
    c_d0: float
    sharpness: float
    omega: float
    v_axial: float
    v_inplane: float
    thrust: float
    drag: float
    torque: float
    roll_moment: float
    static_thrust: float
    static_torque: float


def other_row(rotor: OtherRotor, omega: float, v_axial: float, v_inplane: float) -> OtherRow:
    """One row of the table."""
    blade, law = rotor.propeller(), {name: getattr(rotor.airfoil, name) for name in LAW}
    section = {"M" if name == "sharpness" else name: value for name, value in law.items()}
    zero_lift = section.pop("zero_lift_angle")

    def loads(*motion: float) -> dict[str, float]:
        shape = (blade.station, blade.chord, blade.twist, blade.blades)
        return literal_loads(*shape, section, RHO, MU, *motion, zero_lift_angle=zero_lift)

    static, found = loads(omega, 0.0, 0.0), loads(omega, v_axial, v_inplane)
    return OtherRow(
        rotor.blade,
        rotor.blades,
        *law.values(),
        omega,
        v_axial,
        v_inplane,
        *(found[name] for name in LOADS),
        static["thrust"],
        static["torque"],
    )


def questions() -> list[tuple[OtherRotor, float, float, float]]:
    """Every rotor with its points, in the table's order."""
    return [
        (rotor, *map(float, point))
        for k, rotor in enumerate(other_rotors(ROTORS, seed=2025))
        for point in zip(*other_flow(POINTS, seed=k), strict=True)
    ]


def frozen_rows() -> list[OtherRow]:
    """All rows of the table."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert tuple(header) == OtherRow._fields, "run make_other_reference again"
    return [OtherRow(row[0], int(row[1]), *map(float, row[2:])) for row in rows]


def main() -> None:
    """Compute the table on all cores."""
    with (
        multiprocessing.Pool() as pool,
        TABLE.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(OtherRow._fields)
        writer.writerows(pool.starmap(other_row, questions(), chunksize=4))


if __name__ == "__main__":
    main()
