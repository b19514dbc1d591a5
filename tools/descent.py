"""Print measured thrust, catalogue prediction and 95 % bands in axial descent.

Usage: python -m tools.descent ROWS

ROWS is the file descent_shetty_selig.csv of the reference data: mean thrust coefficients of three
propellers (Shetty, Selig, AIAA 2011-1254), digitized from a secondary source.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

import propmap
from tools.catalogue.left_out import BAND


class Descent(NamedTuple):
    """One row: thrust coefficients [-], and the weight of the vortex ring state."""

    propeller: str
    advance: float
    measured: float
    predicted: float
    deviation: float
    ring: float

    @property
    def inside(self) -> bool:
        """Whether the measured value is inside the 95 % band."""
        return abs(self.predicted - self.measured) <= BAND * self.deviation


def descents(path: Path) -> Iterator[Descent]:
    """Compute the catalogue prediction of each row."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line[:1] != "#"]
    for row in csv.DictReader(lines):
        model = propmap.catalogue_model(f"APC {row['prop'].split()[-1]}E")
        turns = float(row["rpm"]) / 60.0
        loads = propmap.Rotor(model).loads(2.0 * np.pi * turns, float(row["speed_mps"]), np.pi)
        per = model.air.density * turns**2 * model.propeller.diameter**4
        found = float(loads.thrust) / per, float(loads.std.thrust) / per, float(loads.vortex_ring)
        yield Descent(model.propeller.name, float(row["J"]), float(row["ct_mean"]), *found)


def main(path: Path) -> None:
    """Print the table and the rms error in the vortex ring state."""
    found = list(descents(path))
    print("propeller            J      measured  predicted  half width  inside")
    for one in found:
        half = BAND * one.deviation
        print(
            f"{one.propeller:<18}{one.advance:>6.2f}  {one.measured:9.3f}  {one.predicted:9.3f}",
            end="",
        )
        print(f"  {half:10.3f}  {'yes' if one.inside else 'no'}")
    rings = [one.predicted / one.measured - 1.0 for one in found if one.ring > 0.0]
    print(
        f"{sum(one.inside for one in found)} of {len(found)} inside; relative error in the vortex "
    )
    print(f"ring state: mean {np.mean(rings):+.3f}, rms {np.sqrt(np.mean(np.square(rings))):.3f}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
