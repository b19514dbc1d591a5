"""The stored loads of the literal reference, and the command that computes them again.

Run from the repository root, with the package importable (an hour on one core):

    python -m tests.oracle.make_reference

It solves the points of each stored table and replaces the loads.  The package lends the geometry of
the blades and nothing else.
"""

from __future__ import annotations

import csv
import multiprocessing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import propmap
from propmap.units import RPM
from tests.oracle.literal_harmonics import harmonic_loads
from tests.oracle.literal_rotor import literal_loads, literal_rotor
from tests.oracle.literal_wake import static_inflow
from tests.oracle.naca_0015 import naca_0015
from tests.oracle.points import MU, RHO, SECTIONS

BLADE = propmap.propeller("apc-8x6e")
LAW = ("c_l1", "c_l2", "c_d", "alpha_0", "zero_lift_angle", "c_d0", "sharpness")

EXTENDED = ("naca-0015", "tip-loss", "hub-loss", "both-losses")
"""Extensions of the paper's rotor; the losses with a section of Table I."""

SECTION_OF = {"tip-loss": "apc", "hub-loss": "soft", "both-losses": "stiff"}


TABLES = ("loads", "loads_extended", "loads_harmonic", "loads_other_laws")
"""Loads of the reference propeller by the paper, with extensions, and with the inflow of Pitt and
Peters; loads of other blades with random laws.  Each row has its loads at rest; SI and rad, but rpm
in the first two."""


def path_of(table: str) -> Path:
    return Path(__file__).with_name(f"{table}.csv")


def frozen_rows(table: str) -> list[Any]:
    """All rows of a table; the first column names a set of rows, or a blade."""
    with path_of(table).open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    columns = [(row[0], *map(float, row[1:])) for row in rows]
    return [SimpleNamespace(**dict(zip(header, row, strict=True))) for row in columns]


def solved(row: Any) -> Any:
    """The row with loads that are computed here."""
    blade, section = BLADE, SECTIONS["apc"]
    options: dict[str, Any] = {}
    if hasattr(row, "blade"):
        blade = propmap.propeller(row.blade, blades=int(row.blades))
        section = {"M" if name == "sharpness" else name: getattr(row, name) for name in LAW}
        options["zero_lift_angle"] = section.pop("zero_lift_angle")
    else:
        name = SECTION_OF.get(row.set, row.set)
        section = naca_0015() if name == "naca-0015" else SECTIONS[name]
        if row.set in ("tip-loss", "both-losses"):
            options["tip_loss"] = True
        if row.set in ("hub-loss", "both-losses"):
            options["hub_radius"] = float(blade.station[0])
    omega = row.rpm * RPM if hasattr(row, "rpm") else row.omega
    rotor = (blade.station, blade.chord, blade.twist, blade.blades, section, RHO, MU, omega)
    static = literal_loads(*rotor, 0.0, 0.0, **options)
    options["v_hover"] = static_inflow(static["thrust"], RHO, blade.radius)
    moving = (*rotor, row.v_axial, row.v_inplane)
    if hasattr(row, "pitch_moment"):
        found = harmonic_loads(literal_rotor(*moving, **options), float(blade.station[0]))
    else:
        found = literal_loads(*moving, **options)
    found |= {"static_thrust": static["thrust"], "static_torque": static["torque"]}
    return SimpleNamespace(**{name: found.get(name, value) for name, value in vars(row).items()})


def main() -> None:
    """Compute the tables on all cores."""
    for table in TABLES:
        rows = frozen_rows(f"reference_{table}")
        with multiprocessing.Pool() as pool:
            rows = pool.map(solved, rows, chunksize=1)
        with path_of(f"reference_{table}").open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerows([list(vars(rows[0])), *(list(vars(row).values()) for row in rows)])


if __name__ == "__main__":
    main()
