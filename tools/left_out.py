"""Print how well each propeller is predicted from the others, without its own rows.

Usage: python -m tools.left_out LOADS

LOADS is the UIUC database's loads.csv; the constants are the bundled ones.  Errors are root mean
squares over those of what was measured, over all rows of a propeller.  "Blade too" is without its
geometry: chord and twist are the means of the others.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from propmap.catalogue.identified import all_identified
from propmap.fit.population.left_out import left_out
from propmap.fit.population.misfiled import refiled
from propmap.io.uiuc_database import read_uiuc_database


ROWS = {
    "own": "own",
    "family": "family",
    "population": "population",
    "family_blade": "family, blade too",
    "population_blade": "population, blade too",
}
"""Fields of ``LeftOut`` and what they are called."""


def main(loads: Path) -> None:
    """Print medians and 90th percentiles over propellers, in per cent."""
    found = left_out(all_identified(), refiled(read_uiuc_database(loads)))
    print("constants from         propellers   C_T median, 90 %   C_P median, 90 %")
    for name, told in ROWS.items():
        errors = np.stack([value for one in found if (value := getattr(one, name)) is not None])
        cells = [
            f"{np.median(column):6.1%}, {np.quantile(column, 0.9):6.1%}" for column in errors.T
        ]
        print(f"{told:<22} {len(errors):>10}   {cells[0]:>16}   {cells[1]:>16}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
