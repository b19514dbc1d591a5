"""Tables of the documentation on flights: terms of a fit, flights unseen, throttle, and wakes."""

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


def unseen_moments(found: dict[str, Any]) -> str:
    """Errors of moments on flights that were not fitted, beside simpler models and none."""
    lines = [
        "| fitted, predicted | axis | measured | propmap | arms, thrust | linear | in the band |",
        "|---|---|---:|---:|---:|---:|---:|",
    ]
    for row in (one for one in found["rows"] if one["linear"] is not None):
        # Three models and none, which errs by all that was measured.
        models = [1e3 * row[key] for key in ("measured", "propmap", "hover_model", "linear")]
        cells = [f"**{x:.2f}**" if x == min(models) else f"{x:.2f}" for x in models]
        lines.append(
            f"| {_short(row['fitted'])}, {_short(row['unseen'])} | {row['load'][-1]} | "
            f"{' | '.join(cells)} | {100.0 * row['in_band']:.0f} % |"
        )
    return "\n".join(lines)


def unseen_forces(found: dict[str, Any]) -> str:
    """Errors of forces on flights that were not fitted, and the share in the stated band."""
    lines = [
        "| fitted, predicted | axis | measured | propmap | in the band |",
        "|---|---|---:|---:|---:|",
    ]
    for row in (one for one in found["rows"] if one["linear"] is None):
        lines.append(
            f"| {_short(row['fitted'])}, {_short(row['unseen'])} | {row['load'][-1]} | "
            f"{row['measured']:.2f} | {row['propmap']:.3f} | {100.0 * row['in_band']:.0f} % |"
        )
    return "\n".join(lines)


def responses(found: dict[str, Any]) -> str:
    """How a difference of thrust turns a vehicle, by frequency."""
    rows = found["responses"]
    columns = list(dict.fromkeys((row["flight"], row["axis"]) for row in rows))
    heads = " | ".join(f"{_short(flight)}, {axis}" for flight, axis in columns)
    lines = [f"| frequency [Hz] | {heads} |", f"|---|{len(columns) * '---|'}"]
    for band in dict.fromkeys((row["from_Hz"], row["to_Hz"]) for row in rows):
        cells = [
            f"{row['gain']:.2f}, {row['lag_deg']:.0f}°, {row['coherence']:.2f}"
            for row in rows
            if (row["from_Hz"], row["to_Hz"]) == band
        ]
        lines.append(f"| {band[0]:g} to {band[1]:g} | {' | '.join(cells)} |")
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
    """Thrust and power of a coaxial pair, measured and computed, by rotor speed."""
    heads = "rpm|thrust, measured [N]|computed|power, measured [W]|computed|upper's share|computed"
    lines = [f"| {heads.replace('|', ' | ')} |", "|---:|" + "---:|" * 6]
    for row in found["rows"]:
        rpm, upper, upper_power, _, lower, lower_power = row["measured"]
        thrust, power = upper + lower, upper_power + lower_power
        lines.append(
            f"| {rpm:.0f} | {thrust:.1f} | {_beside(sum(row['thrust']), thrust)} | {power:.0f} "
            f"| {_beside(sum(row['power']), power)} | {upper / thrust:.3f} "
            f"| {row['thrust'][0] / sum(row['thrust']):.3f} |"
        )
    return "\n".join(lines)


def _beside(value: float, measured: float) -> str:
    return f"{value / measured - 1.0:+.1%}".replace("%", " %")


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
