"""Write the axial loads on the pages of propellers to docs/measured/uiuc-axial.csv.

Usage: python -m tools.measured_rows LOADS

LOADS is the UIUC database's table of loads.  The file contains the rows of all propellers with
bundled constants, with rounded values and with corrected numbers of blades.  Its first line cites
the source.  Run the tool again after adding propellers.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from propmap.catalogue.identified import all_identified
from propmap.io.csv import replacing
from tools.catalogue.database import MeasuredPropeller, read_uiuc_database, refiled

FILE = Path(__file__).resolve().parent.parent / "docs" / "measured" / "uiuc-axial.csv"

SOURCE = (
    "Brandt, Deters, Ananda, Dantsker, Selig, UIUC Propeller Database, vols 1-3, University of "
    "Illinois"
)

COLUMNS = ("tested", "family", "blades", "run", "rpm", "J", "C_T", "C_P")


def main(loads: Path) -> None:
    """Write the file."""
    wanted = {one.tested for one in all_identified()}
    every = [one for one in refiled(read_uiuc_database(loads)) if one.name in wanted]
    with replacing(FILE) as part:
        part.write_text(as_text(every), encoding="utf-8", newline="")


def as_text(every: Iterable[MeasuredPropeller]) -> str:
    """The file's text; a propeller's name, family and blades stand in its first row alone."""
    lines = [f"# {SOURCE}; rounded", ",".join(COLUMNS)]
    for one in every:
        head = f"{one.name},{one.family},{one.blades}"
        _, runs = np.unique(one.run, return_inverse=True)
        for row in zip(runs, one.rpm, one.advance, one.thrust, one.power, strict=True):
            run, rpm, *rest = row
            numbers = ",".join(
                _short(value, digits) for value, digits in zip(rest, (4, 5, 5), strict=True)
            )
            lines.append(f"{head},{run},{rpm:.0f},{numbers}")
            head = ",,"
    return "\n".join([*lines, ""])


def read(path: Path = FILE) -> dict[str, MeasuredPropeller]:
    """The propellers of a file that ``as_text`` wrote, by their name in the database."""
    with path.open(encoding="utf-8", newline="") as file:
        lines = [line for line in file if not line.startswith("#")]
    found: dict[str, list[dict[str, str]]] = {}
    for row in csv.DictReader(lines):
        if row["tested"]:
            found[row["tested"]] = []
        # A row without a name belongs to the propeller before it.
        found[next(reversed(found))].append(row)
    return {name: _propeller(name, rows) for name, rows in found.items()}


def _propeller(name: str, rows: Sequence[dict[str, str]]) -> MeasuredPropeller:
    first = rows[0]
    rpm, advance, thrust, power = (
        np.array([float(row[column]) for row in rows]) for column in COLUMNS[4:]
    )
    return MeasuredPropeller(
        name=name,
        blade=name.rpartition(" - ")[0],
        family=first["family"],
        blades=int(first["blades"]),
        rpm=rpm,
        advance=advance,
        thrust=thrust,
        power=power,
        run=np.array([int(row["run"]) for row in rows]),
    )


def _short(value: float, digits: int) -> str:
    """To so many digits after the point, without zeros at the end."""
    return f"{value:.{digits}f}".rstrip("0").rstrip(".")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
