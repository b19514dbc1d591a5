"""The card of one propeller."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from propmap.catalogue.expected import POPULATION, coordinate_covariance
from propmap.catalogue.identified import PARAMETERS, Identified
from propmap.catalogue.lookup import propeller
from propmap.loads import LOADS
from propmap.model.airfoil import CONSTANTS
from propmap.model.corrections import model_corrections
from propmap.model.model import Model
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.units import INCH, RPM
from tools.catalogue.database import MeasuredPropeller
from tools.measured_rows import SOURCE
from tools.propeller_pages import blade_picture, fit_pictures
from tools.propeller_pages.comparison import Comparison, compare, error_parts, reynolds
from tools.propeller_pages.words import fixed, flagged, page_name, title

EDGEWISE = 0.15
"""Advance ratio of the edgewise flow on a card."""


def card(one: Identified, tested: MeasuredPropeller | None) -> str:
    """Return the card as Markdown; without ``tested`` it states that the rows are missing."""
    blade = propeller(one.propeller, blades=one.blades)
    parts = [
        f"# {title(one)}",
        f"`{one.propeller}`, {one.blades} blades, diameter {2e3 * blade.radius:.1f} mm "
        f"({blade.diameter / INCH:.2f} in).",
        verdict(one),
        "## Blade",
        raw(_side_by_side(blade_picture.pictures(blade))),
        "Outline of the blade with a straight mid-chord line; the rotor axis is at the left. "
        "Dotted: start of the loaded part.",
        "## Fit",
    ]
    if tested is None:
        parts.append(
            "The measured rows are missing; `python -m tools.measured_rows LOADS` writes them."
        )
    else:
        compared = compare(one, tested)
        parts += [
            raw(fit_pictures.keys(compared), _side_by_side(fit_pictures.pictures(compared))),
            "Points: measured. Lines: the model with the constants below. A line over J is "
            "computed at the mean rotor speed of its points. Shaded: rms error of all measured "
            "points. The last four columns of the table are shares of the sum of squared errors.",
            _errors(one, compared),
        ]
    parts += [
        "## Loads with 95 % bands",
        _bands(one, blade),
        "## Constants",
        _constants(one),
        "## Data of the fit",
        _data(one, blade),
        f"Blade: {blade.source}. {blade.citation}.",
        f"Loads: {SOURCE}.",
        "[All propellers](../propellers.md)",
    ]
    return "\n\n".join(parts) + "\n"


def raw(*parts: str) -> str:
    """Return a Markdown block with raw HTML."""
    return "\n".join(["```{raw} html", *parts, "```"])


def _side_by_side(pictures: Sequence[str]) -> str:
    """Return the pictures in a block that places them side by side if the screen is wide."""
    return "\n".join(['<div class="plots">', *pictures, "</div>"])


def verdict(one: Identified) -> str:
    """Return the verdict in a box whose color depends on ``flagged``."""
    kind = "flagged" if flagged(one) else "good"
    head = "Limits of this fit" if kind == "flagged" else "Fit"
    parts = sorted(one.verdict.split("; "), key=lambda part: part != "good")
    text = "; ".join(parts).replace("the prior", "the prior (not determined by the data)")
    return raw(f'<p class="verdict {kind}"><strong>{head}:</strong> {escape(text)}.</p>')


def _errors(one: Identified, found: Comparison) -> str:
    measured = np.stack([found.tested.thrust, found.tested.power])
    rows = [
        "| | rms error | rms error / measured rms | rms error at rest | share: rows at rest "
        "| share: mean error of each run | share: slope of error over J | share: scatter |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    errors = (
        ("C_T", one.thrust_rms, one.static_thrust_rms),
        ("C_P", one.power_rms, one.static_power_rms),
    )
    for k, (name, rms, still) in enumerate(errors):
        share = rms / np.sqrt(np.mean(measured[k] ** 2))
        parts = error_parts(found.tested, found.error[k])
        cells = [fixed(rms, 4), f"{100.0 * share:.1f}\u00a0%", fixed(still, 4)]
        cells += [f"{100.0 * part:.0f}\u00a0%" for part in parts]
        rows.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(rows)


def _constants(one: Identified) -> str:
    deviation = np.sqrt(np.diag(one.covariance))
    fitted = coordinate_covariance(one.constants, one.covariance)
    left = np.sqrt(np.diag(fitted)) / POPULATION.deviation
    rows = [
        "| constant | meaning | value | standard deviation | ratio to prior std |",
        "|---|---|---:|---:|---:|",
    ]
    for k, name in enumerate(PARAMETERS):
        value, spread = one.constants[k], deviation[k]
        unit, meaning, *_ = CONSTANTS[name]
        degrees = f" ({fixed(np.degrees(value), 2)}°)" if unit == "rad" else ""
        cells = [f"`{name}`", f"{meaning} [{unit}]", fixed(value, 4) + degrees, fixed(spread, 4)]
        cells.append(f"{100.0 * left[k]:.0f}\u00a0%")
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(
        [
            *rows,
            "",
            "The last column is the standard deviation of the constant divided by its standard "
            "deviation in the prior. For `zero_lift_angle` and the three terms of the Reynolds "
            "number, both refer to the constant itself. For `drag_angle`, they refer to the sum "
            "`zero_lift_angle` + `drag_angle`. For all other constants, they refer to the "
            "logarithm of the constant. "
            "Near 100 % the data do not determine the constant, and the value is that of the "
            "prior. The covariance matrix is in "
            f"`propmap.catalogue.identified.identified({one.propeller!r}, {one.blades})`.",
        ]
    )


def _bands(one: Identified, blade: Propeller) -> str:
    """Tabulate the loads of the installed rotor in three flows, with half the 95 % band."""
    rpm = 0.5 * (one.rpm_low + one.rpm_high)
    along, across = 0.5 * one.advance_high * rpm / 60.0 * blade.diameter, EDGEWISE * rpm * RPM
    speed = np.array([0.0, along, across * blade.radius])
    corrections = model_corrections("recommended", installed=True)
    loads = Rotor(Model(blade, one.airfoil, corrections=corrections)).loads(
        rpm * RPM, speed, np.array([0.0, 0.0, 0.5 * np.pi])
    )
    flows = ["at rest", f"axial, {speed[1]:.1f} m/s", f"edgewise, {speed[2]:.1f} m/s"]
    rows = [f"| at {rpm:.0f} rpm | {' | '.join(flows)} |", "|---|---:|---:|---:|"]
    _, high = loads.interval(0.95)
    for name, load in LOADS.items():
        value, end = getattr(loads, name), getattr(high, name)
        cells = [
            f"{v:.3g} ± {e - v:.2g}" if e > v else "0" for v, e in zip(value, end, strict=True)
        ]
        rows.append(f"| {load.label} [{load.unit}] | {' | '.join(cells)} |")
    return "\n".join(
        [
            *rows,
            "",
            "The rotor is modeled as installed on a motor. ± is half the width of the 95 % band. "
            "See [Uncertainty of the loads](../how-to/uncertainty.md).",
        ]
    )


def _data(one: Identified, blade: Propeller) -> str:
    low, high = (f"{1e3 * round(number / 1e3, 1):.0f}" for number in reynolds(one, blade))
    blades = f" --blades {one.blades}" if page_name(one) != one.propeller else ""
    rpm = 0.5 * (one.rpm_low + one.rpm_high)
    speed = 0.5 * one.advance_high * rpm / 60.0 * 2.0 * blade.radius
    return "\n".join(
        [
            "| | |",
            "|---|---|",
            f"| tested as | {one.tested} |",
            f"| rows | {one.rows}, of which {one.static_rows} at rest |",
            f"| rotational speed | {one.rpm_low:.0f} to {one.rpm_high:.0f} rpm |",
            f"| J | up to {one.advance_high:.2f} |",
            f"| Re at 3/4 of the radius | {low} to {high} |",
            f"| example command | `propmap predict {one.propeller}{blades} --rpm {rpm:.0f} "
            f"--speed {speed:.1f} --beta 0` |",
        ]
    )
