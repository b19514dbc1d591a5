"""Print how well each propeller is predicted from the others, without its own rows.

Usage: python -m tools.left_out LOADS

LOADS is the UIUC database's loads.csv; the constants are the bundled ones.  Errors are root mean
squares over those of what was measured, over all rows of a propeller.  "Blade too" is without its
geometry: chord and twist are the means of the others.  The figures go into
benchmarks/results/left_out.json as well.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

from propmap.catalogue.identified import all_identified
from propmap.fit.population.left_out import left_out
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
}
"""Fields of ``LeftOut`` and what they are called."""


def main(loads: Path) -> None:
    """Print medians and 90th percentiles over propellers, in per cent, and write them."""
    found = left_out(all_identified(), refiled(read_uiuc_database(loads)))
    results = {}
    print("constants from         propellers   C_T median, 90 %   C_P median, 90 %")
    for name, told in ROWS.items():
        errors = np.stack([value for one in found if (value := getattr(one, name)) is not None])
        half, most = np.quantile(errors, (0.5, 0.9), axis=0)
        cells = [f"{a:6.1%}, {b:6.1%}" for a, b in zip(half, most, strict=True)]
        print(f"{told:<22} {len(errors):>10}   {cells[0]:>16}   {cells[1]:>16}")
        results[name] = {
            "propellers": len(errors),
            "median": np.round(half, 4).tolist(),
            "nine_in_ten": np.round(most, 4).tolist(),
        }
    with replacing(RESULTS) as path:
        path.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
