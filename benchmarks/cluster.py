"""Sweeps and fits on a cluster of this machine: `make bench ONLY=cluster`.

Writes results/cluster.json: wall and processor time of one sweep with and without workers, whether
its results are the same, and memory; overheads of a task; efficiency by number of workers, measured
and simulated (``benchmarks.scheduler_simulation``); what a propeller of the catalogue and a design
of a study take.  With arguments, only those parts: sweep, scheduler, designs, catalogue; with
`some`, one in five of the catalogue.
"""

from __future__ import annotations

import json
import sys

from benchmarks.cluster_catalogue import DATA, catalogue
from benchmarks.cluster_designs import designs
from benchmarks.cluster_sweeps import sweeps
from benchmarks.cluster_workers import scheduler
from benchmarks.results_file import RESULTS, machine, write_results

PARTS = {"sweep": sweeps, "scheduler": scheduler, "designs": designs, "catalogue": catalogue}

SOME = 5
"""With the argument `some`, one propeller in so many stands for the catalogue."""


def main(wanted: list[str]) -> None:
    """Measure the parts ``wanted``, all if none is named, and keep the others' results."""
    path = RESULTS / "cluster.json"
    some = "some" in wanted
    for name in [name for name in wanted if name != "some"] or PARTS:
        if name == "catalogue" and not DATA.exists():
            print("the UIUC database is not at hand: no catalogue")
            continue
        told = {"machine": machine()}
        told |= catalogue(SOME) if some and name == "catalogue" else PARTS[name]()
        print(name, json.dumps(told), flush=True)
        found = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        print(f"wrote {write_results(path.name, found | {name: told})}")


if __name__ == "__main__":
    main(sys.argv[1:])
