"""Documentation tables on aircraft, from benchmarks/results/aircraft.json."""

from __future__ import annotations

from typing import Any


def measured_power(found: dict[str, Any]) -> str:
    """Tabulate the errors of predicted power on the held-out half of a tunnel's states."""
    halves = found["halves"]
    kinds = {
        "shaft": "shaft power, taken as 0.874 of the electrical power",
        "electrical_by_a_motor": "electrical power, three fitted constants of motor and controller",
    }
    rows = ["| | rms error / rms power | rms of relative error |", "|---|---:|---:|"]
    unfitted = found["unfitted_shaft"]
    cells = [f"{100.0 * unfitted[k]:.0f} %" for k in ("rms_of_rms", "rms_relative")]
    rows.append(f"| shaft power, mean constants of all propellers, no fit | {' | '.join(cells)} |")
    for kind, words in kinds.items():
        cells = [
            " and ".join(f"{100.0 * half[kind][k]:.1f}" for half in halves) + " %"
            for k in ("rms_of_rms", "rms_relative")
        ]
        rows.append(f"| {words} | {' | '.join(cells)} |")
    states = " and ".join(str(half["states"]) for half in halves)
    shares = " and ".join(f"{100.0 * half['motor_explains']:.0f} %" for half in halves)
    rows += [
        "",
        f"The states are divided into two halves ({states}); each half is predicted from a fit to "
        "the other half. High power dominates the first column. In the second column, all states "
        "have the same weight. The motor model "
        f"explains {shares} of the mean squared relative error, but nothing of the error in the "
        "first column.",
    ]
    return "\n".join(rows)


def times(found: dict[str, Any]) -> str:
    """State the computation times of a trim and of a ranking."""
    rotor, table = found["trim"]["rotor"], found["trim"]["table"]
    chosen = found["choose"]
    return (
        f"{rotor['speeds']} speeds take {rotor['processor_s']:.2f} s of processor time with a "
        f"rotor and {table['processor_s']:.3f} s with a table. A ranking of "
        f"{chosen['propellers']} propellers takes {chosen['processor_s']:.0f} s on all cores."
    )


def study(found: list[dict[str, Any]]) -> str:
    """Tabulate propellers of the delivery quadcopter: hover, cruise and cruise in a headwind."""
    rows = [
        "| propeller | hover power | longest endurance | least energy per km "
        "| least energy per km, 5 m/s headwind | top speed |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for one in found:
        hover, least, best = (one[key] for key in ("hover", "least_power", "best_range"))
        wind, top = one["against_wind"], one["fastest"]
        cells = [
            one["propeller"],
            f"{hover['power']:.0f} ± {hover['power_std']:.0f} W",
            f"{least['endurance'] / 60.0:.0f} min at {least['speed']:.1f} m/s",
            f"{_per_km(best)} at {best['speed']:.1f} m/s",
            f"{_per_km(wind)} at {wind['speed']:.1f} m/s",
            f"{top['speed']:.0f} ± {top['speed_std']:.0f} m/s",
        ]
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows)


def _per_km(state: dict[str, float]) -> str:
    energy = state["power"] / state["ground_speed"] / 3.6
    std = energy * state["power_std"] / state["power"]
    return f"{energy:.1f} ± {std:.1f} Wh"


def transition(found: list[dict[str, Any]]) -> str:
    """Tabulate the tailsitter from hover to cruise."""
    rows = [
        "| V [m/s] | β [deg] | pitch [deg] | rpm | shaft power [W] | weight carried by the wing |",
        "|---:|---:|---:|---:|---:|---:|",
    ]
    for one in found:
        beta = "-" if one["beta_deg"] is None else f"{one['beta_deg']:.0f}"
        rows.append(
            f"| {one['speed']:g} | {beta} | {round(one['pitch_deg'])} | {one['rpm']:.0f} "
            f"| {one['power']:.0f} ± {one['power_std']:.0f} | {100.0 * one['wing_share']:.0f} % |"
        )
    return "\n".join(rows)
