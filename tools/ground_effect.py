"""Fit the factors on thrust near the ground and a ceiling to measured thrust ratios.

Usage: python -m tools.ground_effect ROWS

ROWS is the file ground_ceiling_wall.csv of the reference data: thrust of 10-inch and 12-inch
propellers by throttle and distance.  A thrust ratio is the thrust over the thrust at the largest
distance and the same throttle.  It is divided by the squared ratio of the two rotational speeds.
The constants minimize the largest relative deviation from the medians over the throttles.  About
one radius from a ceiling, the two propellers differ by more than the throttles of one propeller.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from propmap.typing import Floats


def read_rows(path: Path, effect: str) -> dict[tuple[float, float], Floats]:
    """Return the thrust ratios of an effect by diameter [in] and distance over radius."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line[:1] != "#"]
    rows = [row for row in csv.DictReader(lines) if row["effect"] == effect]
    speed = {(r["prop_in"], r["distance_over_radius"], r["pwm"]): float(r["rpm"]) for r in rows}
    farthest = {
        size: max((r["distance_over_radius"] for r in rows if r["prop_in"] == size), key=float)
        for size in {r["prop_in"] for r in rows}
    }
    found: dict[tuple[float, float], list[float]] = {}
    for row in rows:
        size, height, throttle = row["prop_in"], row["distance_over_radius"], row["pwm"]
        if height == farthest[size]:
            continue
        turning = speed[size, height, throttle] / speed[size, farthest[size], throttle]
        ratio = float(row["fz_over_far"]) / turning**2
        found.setdefault((float(size), float(height)), []).append(ratio)
    return {key: np.array(values) for key, values in found.items()}


def factor(distance: Floats, gain: float, reach: float) -> Floats:
    """Return the factor on the thrust at n distances in radii."""
    return np.asarray(1.0 + gain * np.exp(-distance / reach))


def constants(ratios: dict[tuple[float, float], Floats]) -> tuple[float, float]:
    """Fit gain [-] and reach [radii] of an effect to the medians of the ``ratios``."""
    distance = np.array([distance for _, distance in ratios])
    medians = np.array([np.median(values) for values in ratios.values()])

    def largest(constants: Floats) -> float:
        return float(np.abs(factor(distance, *constants) / medians - 1.0).max())

    precise = {"xatol": 1e-6, "fatol": 1e-9, "maxiter": 5000}
    found = minimize(largest, (0.2, 1.0), method="Nelder-Mead", options=precise)
    return float(found.x[0]), float(found.x[1])


def main(path: Path) -> None:
    """Print the tables and the constants."""
    for effect in ("ground", "ceiling"):
        ratios = read_rows(path, effect)
        gain, reach = constants(ratios)
        print(f"{effect}: diameter, in   distance/R   median, lowest, highest   factor")
        for (size, distance), values in ratios.items():
            own = float(factor(np.array(distance), gain, reach))
            print(f"{size:>18.0f}  {distance:12.2f}      {np.median(values):.3f}", end="")
            print(f"  {values.min():.3f}  {values.max():.3f}      {own:.3f}")
        print(f"  gain {gain:.3f}, reach {reach:.3f} R")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
