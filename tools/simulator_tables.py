"""Tables of the simulators' page, from benchmarks/results/cross_check.json."""

from __future__ import annotations

import math
from typing import Any

QUANTITIES = {
    "position": ("position", "m", 1.0),
    "velocity": ("velocity", "m/s", 1.0),
    "attitude": ("attitude", "deg", 57.29577951308232),
    "energy": ("shaft energy", "J", 1.0),
}
READINGS = (
    ("hover: rotor speed [rad/s]", "hover_front", 1),
    ("hover: shaft power [W]", "hover_power", 1),
    ("12 m/s: pitch, nose down [deg]", "cruise_pitch_deg", 2),
    ("12 m/s: front rotor speed [rad/s]", "cruise_front", 1),
    ("12 m/s: rear rotor speed [rad/s]", "cruise_rear", 1),
    ("12 m/s: shaft power [W]", "cruise_power", 1),
    ("braking: largest pitch, nose up [deg]", "braking_nose_up_deg", 1),
    ("descent at 3 m/s: rotor speed [rad/s]", "descent_front", 1),
    ("descent at 3 m/s: shaft power [W]", "descent_power", 1),
    ("largest distance from the course [m]", "largest_error", 3),
    ("shaft energy of the mission [J]", "energy", 1),
)


def convergence(found: dict[str, Any]) -> str:
    """Tabulate the velocity difference from SciPy for each simulator and step size."""
    steps = " | ".join(f"{step:g} ms" for step in found["steps_ms"])
    rows = [
        f"| simulator | integrator | order | {steps} | order from the last two steps |",
        "|---|---|---:|---:|---:|---:|---:|",
    ]
    for name, one in found["propmap"]["integrators"].items():
        errors = [each["velocity"] for each in one["from_scipy"]]
        cells = [*map(_power, errors), f"{math.log2(errors[-2] / errors[-1]):.1f}"]
        rows.append(f"| {name} | {one['method']} | {one['order']} | {' | '.join(cells)} |")
    return "\n".join(rows)


def agreement(found: dict[str, Any]) -> str:
    """Tabulate the largest and the allowed differences of each pair of simulators."""
    names = " | ".join(f"{name} [{unit}]" for name, unit, _ in QUANTITIES.values())
    rows = [f"| | {names} |", "|---|" + "---:|" * len(QUANTITIES)]
    for pair, one in found["propmap"]["pairs"].items():
        cells = [
            f"{_power(scale * one['found'][name])} of {_power(scale * one['allowed'][name])}"
            for name, (_, _, scale) in QUANTITIES.items()
        ]
        rows.append(f"| {pair.replace(' - ', ', ')} | {' | '.join(cells)} |")
    shares = [
        one["found"][name] / one["allowed"][name]
        for model in ("propmap", "hover")
        for one in found[model]["pairs"].values()
        for name in QUANTITIES
    ]
    rows += [
        "",
        "The largest ratio of found to allowed difference, flights with the hover model included, "
        f"is {max(shares):.2f}.",
    ]
    return "\n".join(rows)


def energy(found: dict[str, Any]) -> str:
    """Tabulate the energy gain of each simulator and the work of the air."""
    rows = [
        "| simulator | loads | change of kinetic and potential energy [J] | aerodynamic work [J] "
        "| largest difference during the mission [J] | shaft energy [J] |",
        "|---|---|---:|---:|---:|---:|",
    ]
    for model, words in (("propmap", "propmap"), ("hover", "hover model")):
        for name, one in found[model]["energy"].items():
            values = [f"{one['stored']:.6f}", f"{one['work']:.6f}"]
            values += [_power(one["largest_imbalance"]), f"{one['used']:.4f}"]
            rows.append(f"| {name} | {words} | {' | '.join(values)} |")
    return "\n".join(rows)


def models(found: dict[str, Any]) -> str:
    """Tabulate readings of the mission with propmap's loads and with the hover model."""
    rows = [
        "| | propmap | hover model | error of the hover model | `propmap trim` |",
        "|---|---:|---:|---:|---:|",
    ]
    mine, other = (found[model]["told"]["SciPy"] for model in ("propmap", "hover"))
    for words, name, digits in READINGS:
        leg, _, quantity = name.partition("_")
        trimmed = found["steady"].get(leg, {}).get(quantity)
        change = f"{other[name] - mine[name]:+.{digits}f}"
        if "deg" not in name:
            change += f" ({100.0 * (other[name] / mine[name] - 1.0):+.0f} %)"
        steady = "" if trimmed is None else f"{trimmed:.{digits}f}"
        values = f"{mine[name]:.{digits}f} | {other[name]:.{digits}f}"
        rows.append(f"| {words} | {values} | {change} | {steady} |")
    return "\n".join(rows)


def elsewhere(found: dict[str, Any]) -> str:
    """Summarize the agreement of the simulators, a simulated log and the drag's uncertainty."""
    spread = 0.0
    for model in ("propmap", "hover"):
        told = found[model]["told"]
        for name in told["SciPy"]:
            values = [one[name] for which, one in told.items() if "held" not in which]
            spread = max(spread, (max(values) - min(values)) / max(map(abs, values)))
    log, mine = found["steady"]["simulated_log"], found["propmap"]["told"]["SciPy"]
    mean = 0.5 * (mine["cruise_front"] + mine["cruise_rear"])
    drag = found["steady"]["rotor_drag"]
    return (
        "The relative differences between SciPy, RotorPy, MuJoCo and Drake in these values are at "
        f"most {_power(spread)}. At 12 m/s, `propmap simulate flight` computes a pitch of "
        f"{log['pitch_deg']:.2f}° and {log['rotor_speed']:.1f} rad/s for all rotors; the mean of "
        f"front and rear rotors above is {mean:.1f} rad/s. The standard deviation of the rotor "
        f"drag is {100.0 * drag['relative_std']:.0f} % at this speed, because the mount is "
        f"unknown. With bare blades, the pitch is {drag['pitch_of_bare_blades_deg']:.1f}°."
    )


def _power(value: float) -> str:
    return f"{value:.1e}".replace("e-0", "e-")
