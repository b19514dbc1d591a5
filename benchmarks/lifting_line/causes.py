"""Why lifting line and harmonic inflow differ: without stall, and with more and narrower blades.

Writes results/lifting_line_causes.json.
"""

from __future__ import annotations

from typing import Any

import propmap
from benchmarks.lifting_line.circulation import averaged_flow
from benchmarks.lifting_line.compare import CONSTANTS, OMEGA, Point
from benchmarks.lifting_line.rotor import consistent
from benchmarks.lifting_line.wake import Resolution
from benchmarks.results_file import machine, write_results

POINTS = [Point(10.0, 30.0), Point(5.0, 60.0), Point(10.0, 75.0), Point(15.0, 90.0)]

WITHOUT_STALL = CONSTANTS.with_parameters(alpha_0=1.5)
"""Lift in proportion to the angle of attack, as far as the blade's angles go."""


def with_blades(count: int) -> propmap.Propeller:
    """The 8x6E with ``count`` blades of the same area together."""
    own = propmap.propeller("apc-8x6e")
    chord = own.chord * own.blades / count
    return propmap.Propeller(f"{count} blades", count, own.station, chord, own.twist)


CASES = {
    "as it is": (with_blades(2), CONSTANTS, 24),
    "without stall": (with_blades(2), WITHOUT_STALL, 24),
    "without stall, 6 blades": (with_blades(6), WITHOUT_STALL, 36),
}
"""Propeller, section law, and steps of a turn."""


def row(name: str, point: Point) -> dict[str, Any]:
    """Compare loads with and without variation of the inflow around the disk, in a case by name."""
    blade, constants, phases = CASES[name]
    paper = propmap.Model(blade, constants)
    harmonic = propmap.Model(blade, constants, corrections=(propmap.correction("pitt-peters"),))
    line, solution = consistent(paper, point.flight, Resolution(10, phases, 6))
    found: dict[str, Any] = {
        "rigid_wake": line.loads(solution.flow),
        "same_all_around": line.loads(averaged_flow(line.sections, line.law, solution.flow)),
    }
    for theory, model in (("annulus", paper), ("pitt_peters", harmonic)):
        found[theory] = propmap.Rotor(model).loads(OMEGA, point.speed, point.beta)
    told: dict[str, Any] = {
        "name": name,
        "speed": point.speed,
        "beta_deg": point.beta_deg,
        "left": solution.left,
    }
    for title, loads in found.items():
        told[title] = {
            load: float(getattr(loads, load)) for load in ("thrust", "drag", "roll_moment")
        }
    return told


def main() -> None:
    """Compute, print, and write the results."""
    rows = []
    for name in CASES:
        for point in POINTS:
            found = row(name, point)
            rows.append(found)
            left = [
                found[varied]["roll_moment"] / found[same]["roll_moment"]
                for varied, same in (("rigid_wake", "same_all_around"), ("pitt_peters", "annulus"))
            ]
            print(f"{name:24} {point.speed:g} m/s {point.beta_deg:g} degrees", left, flush=True)
    print(write_results("lifting_line_causes.json", {"rows": rows, "machine": machine()}))
