"""Measure the cost of corrections and section tables: `make bench ONLY=options`.

Writes results/options.json: the processor time per point for each model, and its ratio to the time
of the paper's model.  The points are those of `benchmarks.speed.oblique`.  One run measures all
models alternately.  The tables are sampled from the section law of the paper, so that all blades
carry similar loads.
"""

from __future__ import annotations

import time

import numpy as np

import propmap
from benchmarks.results_file import machine, write_results
from benchmarks.speed import BATCH, oblique
from propmap.model.airfoil import SectionTable, parameter_set

REPEATS = 15


def sampled(name: str, reynolds: tuple[float, ...]) -> SectionTable:
    """Return a parameter set as a section table, one row per Reynolds number, every half degree."""
    angle = np.linspace(-np.pi, np.pi, 721)
    rows = np.array(reynolds)
    lift, drag = parameter_set(name).coefficients(angle, rows[:, None])
    lift[:, -1], drag[:, -1] = lift[:, 0], drag[:, 0]
    return SectionTable(angle, rows, lift, drag)


def models() -> dict[str, propmap.Model]:
    """Return the models, the paper's model first."""
    blade, law = propmap.propeller("apc-8x6e"), parameter_set("paper-apc")
    losses = (propmap.correction("tip-loss"), propmap.correction("hub-loss"))
    recommended = propmap.model_corrections("recommended")
    whole = propmap.model_corrections("recommended", ("blade-to-hub", "radial-friction"))
    return {
        "paper": propmap.Model(blade, law),
        "recommended": propmap.Model(blade, law, corrections=recommended),
        "recommended, blade to hub, radial friction": propmap.Model(blade, law, corrections=whole),
        "tip loss": propmap.Model(blade, law, corrections=losses[:1]),
        "tip and hub loss": propmap.Model(blade, law, corrections=losses),
        "table, one Re": propmap.Model(blade, sampled("paper-apc", (5e4,))),
        "table, four Re": propmap.Model(blade, sampled("paper-apc", (1e4, 3e4, 1e5, 3e5))),
    }


def main() -> None:
    """Measure the times, print them and write the results."""
    points = oblique(BATCH)
    rotors = {name: propmap.Rotor(model) for name, model in models().items()}
    least = dict.fromkeys(rotors, np.inf)
    for turn in range(1 + REPEATS):
        for name, rotor in rotors.items():
            start = time.process_time()
            rotor.loads(*points)
            if turn:  # the first turn builds the rotors
                least[name] = min(least[name], time.process_time() - start)
    found = {name: 1e6 * seconds / BATCH for name, seconds in least.items()}
    for name, cost in found.items():
        print(f"{name:18} {cost:6.1f} us per point, {cost / found['paper']:.2f} of the paper's")
    rows = [
        {"model": name, "microseconds": cost, "ratio": cost / found["paper"]}
        for name, cost in found.items()
    ]
    print(write_results("options.json", {"points": BATCH, "rows": rows, "machine": machine()}))


if __name__ == "__main__":
    main()
