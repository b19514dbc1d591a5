"""Print how well each propeller is predicted from the others, without its own rows.

Usage: python -m tools.left_out LOADS

LOADS is the UIUC database's loads.csv; the constants are the bundled ones.  Errors are root mean
squares over those of what was measured, over all rows of a propeller.  "Blade too" is without its
geometry: chord and twist are the means of the others.  "Never measured" are those without geometry
in the database, whose loads play no part in any constants.  The figures go into
benchmarks/results/left_out.json as well.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

from propmap.arrays.types import Floats
from propmap.catalogue.identified import all_identified
from propmap.fit.population.left_out import by_designation, left_out
from propmap.fit.population.misfiled import refiled
from propmap.io.atomic_file import replacing
from propmap.io.uiuc_database import read_uiuc_database

RESULTS = Path(__file__).resolve().parent.parent / "benchmarks" / "results" / "left_out.json"
ROWS = {
    "own": "own",
    "family": "family",
    "population": "population",
    "family_blade": "family, blade too",
    "population_blade": "population, blade too",
    "family_label": "family, never measured",
    "population_label": "population, never measured",
}
"""Fields of ``LeftOut``, two groups of ``by_designation``, and what they are called."""


def main(loads: Path) -> None:
    """Print medians and 90th percentiles over propellers, in per cent, and write them."""
    every = refiled(read_uiuc_database(loads))
    groups: dict[str, list[Floats]] = {name: [] for name in ROWS}
    for one in left_out(all_identified(), every):
        for name in ROWS:
            errors = getattr(one, name, None)
            if errors is not None:
                groups[name].append(errors)
    for label in by_designation(every):
        groups["family_label" if label.family else "population_label"].append(label.errors)
    results = {}
    print("constants from              propellers   C_T median, 90 %   C_P median, 90 %")
    for name, told in ROWS.items():
        half, most = np.quantile(groups[name], (0.5, 0.9), axis=0)
        cells = [f"{a:6.1%}, {b:6.1%}" for a, b in zip(half, most, strict=True)]
        count = len(groups[name])
        print(f"{told:<27} {count:>10}   {cells[0]:>16}   {cells[1]:>16}")
        results[name] = {
            "propellers": count,
            "median": np.round(half, 5).tolist(),
            "nine_in_ten": np.round(most, 5).tolist(),
        }
    with replacing(RESULTS) as path:
        path.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
