"""Tables of the documentation on flights: terms of a fit, throttle, and the rotors' wakes."""

from __future__ import annotations

from typing import Any

AXES = ("x_rms_N", "y_rms_N", "z_rms_N")


def terms(found: dict[str, Any]) -> str:
    """Errors on each flight as terms are added, where it was not fitted and where it was."""
    flights = list(dict.fromkeys(row["flight"] for row in found["errors"]))
    verdicts = {row["step"]: _verdict(row) for row in found["worth"]}
    heads = [f"{_short(flight)}, {kind}" for flight in flights for kind in ("unseen", "fitted")]
    lines = [
        f"| model | {' | '.join(heads)} | mean square falls by [N²] |",
        f"|---|{len(heads) * '---|'}---|",
    ]
    for model in dict.fromkeys(row["model"] for row in found["errors"]):
        cells = [
            _errors(found, model, flight, "low-passed", fitted)
            for flight in flights
            for fitted in ("no", "yes")
        ]
        lines.append(f"| {model} | {' | '.join(cells)} | {verdicts.get(model, '')} |")
    return "\n".join(lines)


def terms_as_recorded(found: dict[str, Any]) -> str:
    """Errors of signals that were not low-passed, on flights that were not fitted."""
    flights = list(dict.fromkeys(row["flight"] for row in found["errors"]))
    lines = [
        f"| model | {' | '.join(f'{_short(f)}, unseen' for f in flights)} |",
        f"|---|{len(flights) * '---|'}",
    ]
    for model in dict.fromkeys(row["model"] for row in found["errors"]):
        cells = [_errors(found, model, flight, "as recorded", "no") for flight in flights]
        lines.append(f"| {model} | {' | '.join(cells)} |")
    return "\n".join(lines)


def throttle(found: dict[str, Any]) -> str:
    """Errors and shares in the bands of flights without rotor speeds."""
    lines = [
        "| flight | fitted | rms x, y, z [N] | bias [N] | in the 95 % bands | hover model's rms |",
        "|---|---|---:|---:|---:|---:|",
    ]
    for row in found["flights"]:
        shares = ", ".join(f"{100.0 * share:.0f}" for share in row["in_band"])
        rms, hover = (", ".join(f"{x:.2f}" for x in row[key]) for key in ("rms", "hover_rms"))
        bias = ", ".join(f"{x:+.2f}" for x in row["bias"])
        fitted = "yes" if row["fitted"] else "no"
        lines.append(f"| {row['flight']} | {fitted} | {rms} | {bias} | {shares} % | {hover} |")
    return "\n".join(lines)


def throttle_without(found: dict[str, Any]) -> str:
    """Cross-validated errors of fits that lack something."""
    lines = ["| fit | x, y, z [N] |", "|---|---:|"]
    for name, errors in found["without"].items():
        lines.append(f"| {name} | {', '.join(f'{x:.2f}' for x in errors)} |")
    return "\n".join(lines)


def throttle_twins(found: dict[str, Any]) -> str:
    """How a fit from throttle differs from one from rotor speeds, in a sentence."""
    twins = found["twins"]
    return (
        f"On a flight that neither had seen their forces differ by {100.0 * twins['force']:.1f} % "
        f"of the largest, the bands from throttle are {twins['band']:.2f} times as wide, and "
        f"{100.0 * twins['inside']:.0f} % of the samples or more differ by less than that."
    )


def wakes_cost(found: dict[str, Any]) -> str:
    """Processor time with the wakes over that without."""
    names = {"fit": "a step of a fit, with derivatives", "forces": "forces and moments alone"}
    lines = ["| what | samples | with over without |", "|---|---:|---:|"]
    for row in found["rows"]:
        lines.append(f"| {names[row['what']]} | {row['samples']} | {row['ratio']:.2f} |")
    return "\n".join(lines)


def coaxial(found: dict[str, Any]) -> str:
    """Ideal power of two coaxial rotors over that of two apart, by separation."""
    lines = ["| separation, radii | gain 1 | gain 0.5 |", "|---:|---:|---:|"]
    for row in found["coaxial"]:
        lines.append(f"| {row['height']:g} | {row['cylinder']:.3f} | {row['halved']:.3f} |")
    return "\n".join(lines)


def _errors(found: dict[str, Any], model: str, flight: str, signals: str, fitted: str) -> str:
    for row in found["errors"]:
        asked = (row["model"], row["flight"], row["signals"], row["fitted_to_it"])
        if asked == (model, flight, signals, fitted):
            return ", ".join(f"{row[axis]:.2f}" for axis in AXES)
    return ""


def _verdict(row: dict[str, Any]) -> str:
    return f"{row['fall_N2']:.3f} ± {row['standard_deviation_N2']:.3f}, {row['verdict']}"


def _short(flight: str) -> str:
    """The time of day in a flight's name."""
    return flight[-6:]
