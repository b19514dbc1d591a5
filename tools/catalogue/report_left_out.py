"""Print how well each propeller is predicted from the others, without its own rows.

Usage: python -m tools.left_out LOADS

LOADS is the UIUC database's loads.csv; the constants are the bundled ones.  Errors are root mean
squares over those of what was measured, over the rows of a propeller; bands are those of 95 %, and
what they hold is the mean over propellers of the share of rows.  Nothing of the bands is fitted to
what they hold: their width is that of the distribution over the other propellers, and of the errors
that own constants leave.  The figures go into benchmarks/results/left_out.json as well.
"""

from __future__ import annotations

import itertools
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from propmap.catalogue.identified import all_identified, identified_without_blade
from propmap.fit.population.foretold import Foretold
from propmap.fit.population.left_out import GROUPS, left_out, never_measured
from propmap.fit.population.misfiled import refiled
from propmap.fit.population.populations import populations_of
from propmap.io.csv import replacing
from propmap.io.uiuc import read_uiuc_database
from propmap.typing import Floats

RESULTS = Path(__file__).resolve().parent.parent / "benchmarks" / "results" / "left_out.json"


def main(loads: Path) -> None:
    """Print medians and 90th percentiles over propellers, and what bands hold, and write them."""
    every = refiled(read_uiuc_database(loads))
    measured = all_identified()
    found: dict[str, list[Foretold]] = {name: [] for name in GROUPS}
    populations = populations_of(measured)
    for each in itertools.chain(
        left_out(measured, every),
        never_measured(measured, identified_without_blade(), every, populations),
    ):
        found[each.group].append(each.found)
    results = {name: _summary(some) for name, some in found.items()}
    print(f"{'':<37}errors, median (90 %)           bands hold, C_T and C_P")
    print(f"{'constants from':<34}n  C_T            C_P            at rest      moving")
    for name, told in GROUPS.items():
        one = results[name]
        shown = [
            *(
                f"{half:5.1%} ({most:5.1%})"
                for half, most in zip(one["median"], one["nine_in_ten"], strict=True)
            ),
            *(" ".join(map(_percent, one[key])) for key in ("at_rest", "moving")),
        ]
        print(f"{told:<32}{one['propellers']:>3}  {'  '.join(shown)}")
    with replacing(RESULTS) as path:
        path.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")


def _summary(some: list[Foretold]) -> dict[str, Any]:
    half, most = np.quantile([one.errors for one in some], (0.5, 0.9), axis=0)
    held = {name: _mean([getattr(one, name) for one in some]) for name in ("at_rest", "moving")}
    return {
        "propellers": len(some),
        "median": np.round(half, 5).tolist(),
        "nine_in_ten": np.round(most, 5).tolist(),
        **held,
    }


def _percent(share: float | None) -> str:
    return "    -" if share is None else f"{share:5.1%}"


def _mean(shares: list[Floats]) -> list[float | None]:
    """Over propellers that have such rows; None where none has."""
    known = [share for share in shares if np.isfinite(share).all()]
    if not known:
        return [None, None]
    return [round(float(share), 4) for share in np.mean(known, axis=0)]


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
