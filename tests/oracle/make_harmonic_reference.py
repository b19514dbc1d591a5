"""Compute the literal loads with harmonic inflow; write them as a table.

Run from the repository root, with the package importable (five seconds a row):

    python -m tests.oracle.make_harmonic_reference

The package lends the blade's geometry and nothing else.
"""

from __future__ import annotations

import csv
import multiprocessing
from pathlib import Path
from typing import NamedTuple

import numpy as np

import propmap
from tests.oracle.literal_harmonics import harmonic_loads
from tests.oracle.literal_rotor import literal_loads, literal_rotor
from tests.oracle.literal_wake import static_inflow
from tests.oracle.points import MU, RHO

TABLE = Path(__file__).with_name("reference_loads_harmonic.csv")
BLADE = "apc-8x6e"
SECTIONS = {
    "soft": {"c_l1": 6.9, "c_l2": 2.0, "c_d": 3.7, "alpha_0": np.radians(20.4)},
    "stiff": {"c_l1": 4.2, "c_l2": 2.0, "c_d": 1.3, "alpha_0": np.radians(27.5)},
    "apc": {"c_l1": 5.3, "c_l2": 1.7, "c_d": 1.8, "alpha_0": np.radians(20.6)},
}
"""Table I of the paper."""
POINTS = 200
LOADS = ("thrust", "drag", "torque", "roll_moment", "side_force", "pitch_moment")


class HarmonicRow(NamedTuple):
    """Loads of one rotor at one point, and its thrust and torque at rest; SI."""

    set: str
    omega: float
    v_axial: float
    v_inplane: float
    thrust: float
    drag: float
    torque: float
    roll_moment: float
    side_force: float
    pitch_moment: float
    static_thrust: float
    static_torque: float


def questions() -> list[tuple[str, float, float, float]]:
    """Sets and random flows, an eighth of them in descent, in the table's order."""
    random = np.random.default_rng(1981)
    omega = random.uniform(2000.0, 10000.0, POINTS) * np.pi / 30.0
    speed = random.uniform(0.0, 20.0, POINTS)
    beta = np.radians(np.resize([90.0, 90.0, 90.0, 180.0], POINTS) * random.uniform(size=POINTS))
    names = [tuple(SECTIONS)[k % len(SECTIONS)] for k in range(POINTS)]
    flow = (omega, speed * np.cos(beta), speed * np.sin(beta))
    return [(name, *map(float, point)) for name, *point in zip(names, *flow, strict=True)]


def harmonic_row(question: tuple[str, float, float, float]) -> HarmonicRow:
    """One row of the table."""
    name, omega, v_axial, v_inplane = question
    blade = propmap.propeller(BLADE)
    rotor = (blade.station, blade.chord, blade.twist, blade.blades, SECTIONS[name], RHO, MU)
    static = literal_loads(*rotor, omega, 0.0, 0.0)
    v_hover = static_inflow(static["thrust"], RHO, blade.radius)
    literal = literal_rotor(*rotor, omega, v_axial, v_inplane, v_hover=v_hover)
    found = harmonic_loads(literal, float(blade.station[0]))
    loads = (found[load] for load in LOADS)
    return HarmonicRow(*question, *loads, static["thrust"], static["torque"])


def main() -> None:
    """Write the table."""
    with multiprocessing.Pool() as pool:
        rows = pool.map(harmonic_row, questions(), chunksize=1)
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(HarmonicRow._fields)
        for row in rows:
            writer.writerow([row.set, *(f"{value:.9g}" for value in row[1:])])


if __name__ == "__main__":
    main()
