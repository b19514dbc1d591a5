"""Print the measured thrust ratio near the ground, the factor of propmap and its constants.

Usage: python -m tools.ground_effect ROWS

ROWS is the file ground_ceiling_wall.csv of the reference data: thrust of 10-inch and 12-inch
propellers by throttle and height.  Each thrust is divided by that at the largest height and the
same throttle, and by the squared ratio of the rotational speeds.  The constants are fitted to the
medians over the throttles by least squares.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import curve_fit

from propmap.typing import Floats


def read_rows(path: Path, effect: str = "ground") -> dict[tuple[float, float], Floats]:
    """Return the thrust ratios by diameter [in] and height over radius."""
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


def factor(height: Floats, gain: float, reach: float) -> Floats:
    """Return the factor on the thrust at n heights in radii."""
    return np.asarray(1.0 + gain * np.exp(-((height / reach) ** 2)))


def constants(ratios: dict[tuple[float, float], Floats]) -> tuple[float, float]:
    """Fit gain and reach of ``factor`` to the medians."""
    height = np.array([height for _, height in ratios])
    medians = np.array([np.median(values) for values in ratios.values()])
    gain, reach = curve_fit(factor, height, medians, (0.3, 1.0))[0]
    return float(gain), float(reach)


def main(path: Path) -> None:
    """Print the table and the constants."""
    ratios = read_rows(path)
    gain, reach = constants(ratios)
    print("diameter, in   h/R   measured: median, lowest, highest   factor")
    for (size, height), values in ratios.items():
        own = float(factor(np.array(height), gain, reach))
        print(
            f"{size:>8.0f}  {height:8.2f}      {np.median(values):.3f}  {values.min():.3f}", end=""
        )
        print(f"  {values.max():.3f}        {own:.3f}")
    print(f"GROUND_GAIN = {gain:.3f}, GROUND_REACH = {reach:.3f} R")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
