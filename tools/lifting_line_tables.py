"""Tables of docs/validation.md on the lifting line, from benchmarks/results/lifting_line.json."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from propmap.catalogue.lookup import measurement

WAKES = {
    "rigid_wake": "rigid, same constants",
    "free_wake": "free, same constants",
    "rigid_wake_own_constants": "rigid, refitted constants",
    "free_wake_own_constants": "free, refitted constants",
}
LOADS = ("thrust", "torque", "drag", "roll_moment", "pitch_moment")


def known_answers(found: dict[str, Any]) -> str:
    """Tabulate the lifting line and the known solutions."""
    rows = ["| | lifting line | known |", "|---|---:|---:|"]
    for name, one in found["known_answers"].items():
        cells = (f"{round(one[which], 3) + 0.0:.3f}" for which in ("found", "known"))
        rows.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(rows)


def four_points(found: dict[str, Any]) -> str:
    """Tabulate loads with ``pitt-peters`` relative to the lifting line, at the four points."""
    rows = [
        "| V [m/s], β | wake | thrust | torque | rotor drag | pitch | roll | roll over thrust "
        "| annulus: roll | annulus: roll over thrust | polynomials: roll |",
        "|---|---|" + "---:|" * 9,
    ]
    for point in _four(found):
        theory, annulus = point["pitt_peters"], point["annulus"]
        published = published_roll(found["omega"], point["speed"], point["beta_deg"])
        for wake, name in WAKES.items():
            line = point[wake]
            cells = [theory[load] / line[load] for load in ("thrust", "torque", "drag")]
            cells.append(theory["pitch_moment"] / line["pitch_moment"])
            cells += [*_roll(theory, line), *_roll(annulus, line)]
            cells.append(published / line["roll_moment"])
            numbers = " | ".join(f"{cell:.2f}" for cell in cells)
            rows.append(f"| {point['speed']:g}, {point['beta_deg']:g}° | {name} | {numbers} |")
    return "\n".join(rows)


def everywhere(found: dict[str, Any]) -> str:
    """Tabulate roll over thrust relative to the lifting line, rigid wake and same constants."""

    def ratios(point: dict[str, Any]) -> tuple[float, ...]:
        theories = (point["pitt_peters"], point["annulus"])
        return tuple(_roll(theory, point["rigid_wake"])[1] for theory in theories)

    return _by_speed_and_angle(found, ratios)


def variation(found: dict[str, Any]) -> str:
    """Tabulate the roll with varying over that with mean inflow: lifting line, harmonics."""
    return _by_speed_and_angle(found, _left_of_roll)


def causes(found: dict[str, Any]) -> str:
    """Tabulate the ratios of ``variation`` without stall and with more blades."""
    points = [(row["speed"], row["beta_deg"]) for row in found["rows"]]
    places = list(dict.fromkeys(points))
    rows = [
        "| | " + " | ".join(f"{speed:g} m/s, {angle:g}°" for speed, angle in places) + " |",
        "|---|" + "---:|" * len(places),
    ]
    for name in dict.fromkeys(row["name"] for row in found["rows"]):
        cells = (_left_of_roll(row) for row in found["rows"] if row["name"] == name)
        texts = (" / ".join(f"{one:.2f}" for one in cell) for cell in cells)
        rows.append(f"| {name} | {' | '.join(texts)} |")
    return "\n".join(rows)


def published_roll(omega: float, speed: float, beta_deg: float) -> float:
    """Return the roll moment [N m] of the 2019 polynomials, proportional to Omega V sin(beta)."""
    data = measurement("gill-dandrea-2019-8x6e")
    advance = data.omega * data.speed * np.sin(data.beta)
    slope = (advance @ data.loads["roll_moment"]) / (advance @ advance)
    return float(slope * omega * speed * np.sin(np.radians(beta_deg)))


def _by_speed_and_angle(
    found: dict[str, Any], ratios: Callable[[dict[str, Any]], tuple[float, ...]]
) -> str:
    points = [point for point in found["points"] if point["beta_deg"]]
    angles = sorted({point["beta_deg"] for point in points})
    rows = [
        "| V [m/s] | " + " | ".join(f"β = {angle:g}°" for angle in angles) + " |",
        "|---:|" + "---:|" * len(angles),
    ]
    for speed in sorted({point["speed"] for point in points}):
        at = {point["beta_deg"]: ratios(point) for point in points if point["speed"] == speed}
        cells = (" / ".join(f"{one:.2f}" for one in at[angle]) for angle in angles)
        rows.append(f"| {speed:g} | {' | '.join(cells)} |")
    return "\n".join(rows)


def convergence(found: dict[str, Any]) -> str:
    """Tabulate changes of the lifting line's loads with its resolution and vortex cores."""
    first, *others = found["convergence"]["rows"]
    names = " | ".join(load.removesuffix("_moment") for load in LOADS)
    rows = [f"| | {names} |", "|---|" + "---:|" * len(LOADS)]
    for row in others:
        changes = (row["loads"][load] / first["loads"][load] - 1.0 for load in LOADS)
        cells = " | ".join(f"{100.0 * change:+.1f} %" for change in changes)
        rows.append(f"| {row['name']} | {cells} |")
    return "\n".join(rows)


def _four(found: dict[str, Any]) -> list[dict[str, Any]]:
    places = [(four["speed"], four["beta_deg"]) for four in found["four"]]
    return [point for point in found["points"] if (point["speed"], point["beta_deg"]) in places]


def _left_of_roll(point: dict[str, Any]) -> tuple[float, ...]:
    pairs = (("rigid_wake", "same_all_around"), ("pitt_peters", "annulus"))
    return tuple(point[a]["roll_moment"] / point[b]["roll_moment"] for a, b in pairs)


def _roll(theory: dict[str, float], line: dict[str, float]) -> tuple[float, float]:
    ratio = theory["roll_moment"] / line["roll_moment"]
    return ratio, ratio / (theory["thrust"] / line["thrust"])
