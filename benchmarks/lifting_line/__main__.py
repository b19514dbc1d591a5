"""Check the lifting line, compare inflow theories with it, and say why they differ.

Writes results/lifting_line.json and lifting_line_causes.json.
"""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import numpy as np

from benchmarks.lifting_line import causes, checks, compare
from benchmarks.lifting_line.compare import CONSTANTS, FREE, OMEGA, Point
from benchmarks.lifting_line.rotor import RotorLoads
from benchmarks.lifting_line.wake import Resolution
from benchmarks.results_file import machine, write_results

MAIN = Resolution(stations=12, phases=24, turns=6)

FREE_WAKE = Resolution(stations=8, phases=24, turns=4)
"""That of the free wake, and of the rigid one that it starts from."""

FOUR = [Point(10.0, 30.0), Point(5.0, 60.0), Point(10.0, 75.0), Point(15.0, 90.0)]
"""Where the comparison counts; chosen before it was made."""

GRID = [Point(speed, beta) for speed in (5.0, 10.0, 15.0) for beta in (30.0, 60.0, 75.0, 90.0)]

AXIAL = [Point(0.0, 0.0), Point(5.0, 0.0), Point(10.0, 0.0)]

DIVISIONS = {
    "as used": MAIN,
    "8 stations": replace(MAIN, stations=8),
    "18 stations": replace(MAIN, stations=18),
    "36 steps a turn": replace(MAIN, phases=36),
    "48 steps a turn": replace(MAIN, phases=48),
    "4 turns of wake": replace(MAIN, turns=4),
    "12 turns of wake": replace(MAIN, turns=12),
    "cores of 0.5 % of R": replace(MAIN, first_core=0.005),
    "cores of 2 % of R": replace(MAIN, first_core=0.02),
}
"""What the loads at a point are found with besides."""


def known_answers() -> dict[str, Any]:
    """The checks: what was found and what is known."""
    cylinder = Resolution(stations=2, phases=24, turns=20)
    found: dict[str, Any] = {"elliptic wing, lift slope": checks.elliptic_wing()}
    for k in (0.05, 0.15, 0.3):
        real, imaginary = checks.heaving_section(k)
        found[f"heaving section, Re C({k})"] = real
        found[f"heaving section, Im C({k})"] = imaginary
    for degrees in (0, 40, 75):
        mean, slope = checks.skewed_cylinder(float(np.radians(degrees)), cylinder)
        found[f"vortex cylinder skewed by {degrees} degrees, mean inflow"] = mean
        found[f"vortex cylinder skewed by {degrees} degrees, slope"] = slope
    return {
        name: {"found": float(one.found), "known": float(one.known)} for name, one in found.items()
    }


def convergence(point: Point) -> list[dict[str, Any]]:
    """Loads at a ``point`` by other divisions and cores."""
    rows = []
    for name, division in DIVISIONS.items():
        found = compare.by_rigid_wake(CONSTANTS, point, division)
        rows.append({"name": name, "left": found.left, "loads": found.loads._asdict()})
        print(f"{name:20}", _text(found.loads), flush=True)
    return rows


def main() -> None:
    """Check, compare, print, and write the results."""
    answers = known_answers()
    for name, one in answers.items():
        print(f"{name:50} {one['found']:9.4f} {one['known']:9.4f}", flush=True)
    hover = checks.hover(compare.model(), OMEGA, MAIN)
    print(f"hover: thrust {hover.thrust:.3f} N, power factor {hover.power_factor:.3f}")
    divisions = convergence(FOUR[2])
    everywhere = [*AXIAL, *GRID]
    theories = compare.by_theory(everywhere)
    own = compare.identified(everywhere, theories["pitt_peters"], MAIN)
    print("constants of the lifting line", {name: getattr(own, name) for name in FREE})
    rows = []
    for number, point in enumerate(everywhere):
        row: dict[str, Any] = {"speed": point.speed, "beta_deg": point.beta_deg}
        row |= {name: loads[number]._asdict() for name, loads in theories.items()}
        for ending, constants in (("", CONSTANTS), ("_own_constants", own)):
            rigid = compare.by_rigid_wake(constants, point, MAIN)
            row[f"rigid_wake{ending}"] = rigid.loads._asdict()
            row[f"same_all_around{ending}"] = rigid.same_all_around._asdict()
            row[f"left{ending}"] = rigid.left
            if point in FOUR:
                free = compare.by_free_wake(constants, point, rigid.loads.thrust, FREE_WAKE)
                row[f"start_of_free_wake{ending}"] = free.start._asdict()
                row[f"free_wake{ending}"] = free.end._asdict()
                row[f"moved{ending}"] = free.moved
        rows.append(row)
        print(f"{point.speed:g} m/s, {point.beta_deg:g} degrees")
        for name, loads in row.items():
            if isinstance(loads, dict):
                print(f"  {name:35}", _text(RotorLoads(**loads)), flush=True)
    four = [{"speed": point.speed, "beta_deg": point.beta_deg} for point in FOUR]
    results = {
        "omega": OMEGA,
        "constants": {"source": CONSTANTS.source, **_numbers(CONSTANTS)},
        "own_constants": _numbers(own),
        "resolution": asdict(MAIN),
        "free_wake_resolution": asdict(FREE_WAKE),
        "known_answers": answers,
        "hover": hover._asdict(),
        "convergence": {"at": four[2], "rows": divisions},
        "four": four,
        "points": rows,
        "machine": machine(),
    }
    print(write_results("lifting_line.json", results))


def _numbers(constants: Any) -> dict[str, float]:
    return {name: getattr(constants, name) for name in ("c_l2", *FREE)}


def _text(loads: RotorLoads) -> str:
    return " ".join(f"{name} {value:.5f}" for name, value in loads._asdict().items())


if __name__ == "__main__":
    main()
    causes.main()
