"""Print the errors of fits with two laws of lift past stall: the paper's and that of a plate.

Usage: python -m tools.catalogue.past_stall LOADS

LOADS is the loads.csv of the UIUC database.  Every propeller with a measured blade is identified
with each law.  Errors are rms errors over the rows of a propeller.  The tool prints their median
over propellers of steep pitch, which stall at rest, and their 90th percentile over all propellers.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np

from propmap import catalogue
from propmap.catalogue.identified import Identified, all_identified, one_of_each
from tools.catalogue import identification
from tools.catalogue.database import MeasuredPropeller, read_uiuc_database, refiled

STEEP = 0.75
"""Pitch over diameter above which blades stall at rest."""


def errors(
    entries: Sequence[Identified], rows: dict[str, MeasuredPropeller], law: str
) -> np.ndarray:
    """Return the rms errors (n, 2) of C_T and C_P [-] of n propellers with a lift ``law``."""
    found = []
    with mock.patch.object(identification, "LIFT_LAW", law):
        for one in entries:
            blade = replace(catalogue.load(one.propeller), blades=one.blades)
            test = identification.AxialTest(blade, rows[one.tested])
            result = identification.identify(test)
            found.append((result.thrust_rms, result.power_rms))
    return np.array(found)


def main(loads: Path) -> None:
    """Print the table."""
    rows = {one.name: one for one in refiled(read_uiuc_database(loads))}
    entries = [one for one in one_of_each(all_identified()) if one.tested in rows]
    steep = np.array([one.pitch_m > STEEP * one.diameter_m for one in entries])
    print(f"median of {steep.sum()} steep propellers; 90th percentile of all {steep.size}")
    print("lift law   C_T     C_P      C_T     C_P")
    for law in ("blended", "plate"):
        found = errors(entries, rows, law)
        half = [*np.median(found[steep], axis=0), *np.quantile(found, 0.9, axis=0)]
        print(f"{law:<8} ", "  ".join(f"{value:.4f}" for value in half))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
