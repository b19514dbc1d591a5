"""The note beside an autopilot's parameters, in Markdown: definitions, errors, ranges."""

from __future__ import annotations

import math

import propmap
from propmap.aircraft.steady import Aircraft
from propmap.aircraft.steady_states import STATUSES
from propmap.export.drag_fit import CLOSE, Comparison
from propmap.export.inplane_drag import AXES
from propmap.export.parameter_set import AutopilotParameters, Explained, ParameterSet
from propmap.rotor import Rotor

SHOWN = 4
"""Numbers in a cell of a table, at most."""


def note(found: AutopilotParameters, aircraft: Aircraft) -> str:
    """The text of a note on what was ``found`` of an ``aircraft``."""
    vehicle = aircraft.vehicle
    lines = [f"# {vehicle.name}: parameters for {found.firmware}", ""]
    for part in found.sets:
        lines += _set(part)
    lines += ["## The drag model beside the full model", ""]
    lines += [
        "Level flight through still air, all forces and moments balanced. Force against the motion "
        "along the body axis, by the full model with its standard deviation, by the filter's "
        "equation with the parameters above; the last column is the error that the filter makes "
        "of the wind. All speeds count alike in the fit, so that slow ones, with little force, "
        "have the larger share of error. Backwards and to the right are taken to be alike.",
        "",
    ]
    for comparison in found.comparisons:
        lines += _table(comparison)
    if found.left_out:
        lines += ["## Not written", ""]
        lines += [f"- {left.name}: {left.why}." for left in found.left_out]
        lines.append("")
    lines += ["## To know", "", *(f"- {remark}" for remark in found.remarks), ""]
    lines += ["## Where the numbers come from", "", *_origin(aircraft), ""]
    return "\n".join(lines)


def holds(comparisons: list[Comparison]) -> str:
    """Where the drag model of a filter is close to the full model, in words."""
    told = []
    for comparison in comparisons:
        run = comparison.holds
        where = AXES[comparison.flight.axis]
        worst = float(abs(comparison.filtered - comparison.full).max())
        if run is None:
            told.append(f"{where}: nowhere within {CLOSE:.0%}, the error is up to {worst:.2g} N")
        else:
            told.append(
                f"{where} within {CLOSE:.0%} of the force from {run[0]:g} to {run[1]:g} m/s, over "
                f"all speeds within {worst:.2g} N"
            )
    return f"In level flight, {'; '.join(told)}."


def _set(part: ParameterSet) -> list[str]:
    lines = [f"## `{part.suffix}`: {part.purpose}", ""]
    lines += ["| parameter | value | standard deviation | unit |", "|---|---|---|---|"]
    lines += [_row(kind) for kind in part.kinds]
    lines.append("")
    for kind in part.kinds:
        lines += [f"**{kind.title}**: {kind.meaning} {kind.holds}".rstrip(), ""]
        lines += [f"Source: {kind.source}.", ""]
    return lines


def _row(kind: Explained) -> str:
    values = [f"{value:.5g}" for value in kind.values.values()]
    alike = len(set(values)) == 1
    std = "-" if kind.std is None or math.isnan(kind.std) else f"{kind.std:.2g}"
    unit = "" if kind.unit == "-" else kind.unit
    shown = values[0] if alike else ", ".join(values) if len(values) <= SHOWN else "see the file"
    return f"| {kind.title} | {shown} | {std} | {unit} |"


def _table(comparison: Comparison) -> list[str]:
    flight = comparison.flight
    lines = [f"### Along {flight.axis}, {AXES[flight.axis]}", ""]
    lines += [
        "| V [m/s] | lean [deg] | full [N] | std [N] | filter [N] | error [N] | [%] | wind [m/s] |",
        "|---|---|---|---|---|---|---|---|",
    ]
    rows = zip(
        flight.speed.tolist(),
        flight.pitch.tolist(),
        comparison.full.tolist(),
        comparison.std.tolist(),
        comparison.filtered.tolist(),
        comparison.share.tolist(),
        comparison.wind.tolist(),
        strict=True,
    )
    for v, pitch, full, std, filtered, share, wind in rows:
        spread = "-" if math.isnan(std) else f"{std:.3f}"
        lines.append(
            f"| {v:g} | {math.degrees(pitch):.2f} | {full:.3f} | {spread} | {filtered:.3f} | "
            f"{filtered - full:+.3f} | {100.0 * share:+.1f} | {wind:+.2f} |"
        )
    lines.append("")
    lines += [f"{v:g} m/s is not flown: {STATUSES[why]}." for v, why in flight.lost]
    return lines + [""] * bool(flight.lost)


def _origin(aircraft: Aircraft) -> list[str]:
    vehicle, loads = aircraft.vehicle, aircraft.loads
    areas = ", ".join(f"{area:g}" for area in vehicle.body.drag_area)
    lines = [
        f"vehicle: {vehicle.name}, {vehicle.mass:g} kg, {len(vehicle.mounts)} x "
        f"{vehicle.propeller.name}; air {vehicle.air.density:g} kg/m^3; drag areas of the body "
        f"{areas} m^2, taken as known",
    ]
    if isinstance(loads, Rotor):
        lines.append(f"rotors: {loads.model.law_title}")
        known = loads.model.uncertainty is not None
    else:
        law = (loads.info.get("airfoil") or {}).get("name", "not stated")
        lines.append(f"rotors: a map of the section law {law}")
        known = loads.content.deviations is not None
    lines.append(
        "standard deviations: constants of the section law, the model itself and another tunnel, "
        "as `Loads.std`; mass, drag areas and motor are taken as known"
        if known
        else "standard deviations: none, as the section law says nothing of its errors"
    )
    return [f"- {line}" for line in (*lines, f"written by propmap {propmap.__version__}")]
