"""Documentation tables on flights: terms of a fit, held-out flights, throttle, and wakes."""

from __future__ import annotations

from typing import Any

AXES = ("x_rms_N", "y_rms_N", "z_rms_N")


def terms(found: dict[str, Any]) -> str:
    """Tabulate errors on held-out and fitted flights as terms are added."""
    flights = list(dict.fromkeys(row["flight"] for row in found["errors"]))
    verdicts = {row["step"]: _verdict(row) for row in found["worth"]}
    heads = [f"{_short(flight)}, {kind}" for flight in flights for kind in ("held-out", "fitted")]
    lines = [
        f"| model | {' | '.join(heads)} | decrease of the mean square error [N²] |",
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
    """Tabulate errors of the recorded signals, without low-pass, on held-out flights."""
    flights = list(dict.fromkeys(row["flight"] for row in found["errors"]))
    lines = [
        f"| model | {' | '.join(f'{_short(f)}, held-out' for f in flights)} |",
        f"|---|{len(flights) * '---|'}",
    ]
    for model in dict.fromkeys(row["model"] for row in found["errors"]):
        cells = [_errors(found, model, flight, "as recorded", "no") for flight in flights]
        lines.append(f"| {model} | {' | '.join(cells)} |")
    return "\n".join(lines)


def unseen_moments(found: dict[str, Any]) -> str:
    """Tabulate errors of the moments on held-out flights, of propmap and of simpler models."""
    lines = [
        "| fitted, held-out | axis | measured | propmap | arms, thrust | linear | in the band |",
        "|---|---|---:|---:|---:|---:|---:|",
    ]
    for row in (one for one in found["rows"] if one["linear"] is not None):
        # Without a model, the error is the measured moment itself.
        models = [1e3 * row[key] for key in ("measured", "propmap", "hover_model", "linear")]
        cells = [f"**{x:.2f}**" if x == min(models) else f"{x:.2f}" for x in models]
        lines.append(
            f"| {_short(row['fitted'])}, {_short(row['unseen'])} | {row['load'][-1]} | "
            f"{' | '.join(cells)} | {100.0 * row['in_band']:.0f} % |"
        )
    return "\n".join(lines)


def unseen_forces(found: dict[str, Any]) -> str:
    """Tabulate errors of the forces on held-out flights, and the share in the 95 % band."""
    lines = [
        "| fitted, held-out | axis | measured | propmap | in the band | quadratic in v_z |",
        "|---|---|---:|---:|---:|---:|",
    ]
    for row in (one for one in found["rows"] if one["linear"] is None):
        lines.append(
            f"| {_short(row['fitted'])}, {_short(row['unseen'])} | {row['load'][-1]} | "
            f"{row['measured']:.2f} | {row['propmap']:.3f} | {100.0 * row['in_band']:.0f} % | "
            f"{row['quadratic_along_z']:.3f} |"
        )
    return "\n".join(lines)


def responses(found: dict[str, Any]) -> str:
    """Tabulate the frequency response of a vehicle to differential thrust."""
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
    """Tabulate errors, and shares in the bands, of flights without rotor speeds."""
    lines = [
        "| flight | fitted | rms x, y, z [N] | bias [N] | in the 95 % bands | hover, rms [N] |",
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
    """Tabulate cross-validated errors of fits without one part each."""
    lines = ["| fit | rms x, y, z [N] |", "|---|---:|"]
    for name, errors in found["without"].items():
        lines.append(f"| {name} | {', '.join(f'{x:.2f}' for x in errors)} |")
    return "\n".join(lines)


def throttle_twins(found: dict[str, Any]) -> str:
    """State how a fit from throttle differs from a fit from rotor speeds."""
    twins = found["twins"]
    inside = twins["inside"]  # of the axis with the smallest share [-]
    share = "all" if inside == 1.0 else f"at least {100.0 * inside:.0f} % of the"
    return (
        "On a held-out flight, the forces of the two fits differ by "
        f"{100.0 * twins['force']:.1f} % of the largest force. The bands of the fit from throttle "
        f"are {twins['band']:.2f} times as wide. On each axis, {share} differences are smaller "
        "than these bands."
    )


def wind(rows: list[dict[str, Any]]) -> str:
    """Tabulate errors of the estimated wind east, north and up, and shares in the bands."""
    fits = ["fit"] if "fit" in rows[0] else []
    heads = [
        *fits,
        *("flight", "mean error [m/s]", "95 % band of the mean [m/s]", "rms [m/s]"),
        *("95 % band [m/s]", "in the band"),
    ]
    lines = [f"| {' | '.join(heads)} |", f"|{len(heads) * '---|'}"]

    def cell(values: list[float | None], form: str = ".2f") -> str:
        return ", ".join("none" if value is None else f"{value:{form}}" for value in values)

    for row in rows:
        cells = [
            *(row[name] for name in fits),
            *(row["flight"], cell(row["mean_error"]), f"± {cell(row['mean_half_width'])}"),
            *(cell(row["rms"]), f"± {cell(row['half_width'])}", cell(row["in_band"], ".0%")),
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def wakes_cost(found: dict[str, Any]) -> str:
    """Tabulate the ratio of the processor times with and without wakes."""
    names = {"fit": "a step of a fit, with derivatives", "forces": "forces and moments alone"}
    lines = ["| computation | samples | time with wakes / without |", "|---|---:|---:|"]
    for row in found["rows"]:
        lines.append(f"| {names[row['what']]} | {row['samples']} | {row['ratio']:.2f} |")
    return "\n".join(lines)


def coaxial(found: dict[str, Any]) -> str:
    """Tabulate thrust and power of a coaxial pair, measured and computed, by rotor speed."""
    heads = "rpm|measured thrust [N]|error|measured power [W]|error|upper's share|computed"
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
    """Return the time of day in a flight's name."""
    return flight[-6:]
