"""Table I: the parameter sets, the blades, and the identified constants."""

from __future__ import annotations

from typing import Any

import numpy as np

from papers.gill_dandrea_2017.level_circles import BLADE, SetFlown
from papers.gill_dandrea_2017.paper import RADIUS, TABLE_1, TUNNEL_PROPELLER, blade
from papers.gill_dandrea_2017.tunnel import FIVE, TunnelFits
from propmap.catalogue.lookup import propeller
from propmap.fit.fit import Fitted
from propmap.fit.least_squares import rms
from propmap.model.airfoil import PAPER_FOUR, parameter_set
from propmap.model.propeller import Propeller
from propmap.report.html import csv_of_rows, number

COLUMNS = {
    "c_l1": "c_l1_per_rad",
    "c_l2": "c_l2",
    "c_d": "c_d",
    "alpha_0": "alpha_0_deg",
    "zero_lift_angle": "zero_lift_angle_deg",
}
"""Columns of the constants in CSV files, with angles in degrees."""


def printed_rows() -> list[tuple[Any, ...]]:
    """Return propeller, set and four constants for each row of Table I."""
    return [(title, *_printed(name)) for name, title in TABLE_1.items()]


def blade_rows() -> list[tuple[Any, ...]]:
    """Return name, use, lengths [mm], angles [deg] and solidity for each blade."""
    return [
        _shape(propeller(TUNNEL_PROPELLER), "APC 8x6 in the tunnel"),
        _shape(blade(BLADE, RADIUS), "both flown propellers"),
    ]


def identified_rows(fits: TunnelFits, flown: dict[str, SetFlown]) -> list[tuple[str, ...]]:
    """Return points, five constants with half their intervals, and residual for each fit."""
    rows = []
    for label, _, fitted in _fits(fits, flown):
        cells = []
        for name in FIVE:
            if name not in fitted.choice.free:
                cells.append("0, fixed" if name == "zero_lift_angle" else "fixed")
                continue
            value, low, high, identified, _ = _interval(fitted, name)
            half = number(0.5 * (high - low), 2)
            cells.append(
                f"{number(value)} ± {half}" if identified else f"{number(round(value, 4))}*"
            )
        points = str(len(set(fitted.rows.point.tolist())))
        rows.append((label, points, *cells, number(100.0 * rms(fitted.minimum.residual))))
    return rows


def sheets(fits: TunnelFits, flown: dict[str, SetFlown]) -> dict[str, str]:
    """Return the CSV files by name."""
    return {
        "table-1-sets": csv_of_rows(
            " ".join(("set", *(COLUMNS[name] for name in PAPER_FOUR), "radius_m", "blades")),
            [(*_printed(name), RADIUS, 2) for name in TABLE_1],
        ),
        "table-1-blades": csv_of_rows(
            "blade used_for radius_mm largest_chord_mm chord_at_075R_mm largest_twist_deg "
            "twist_at_075R_deg twist_at_tip_deg solidity",
            blade_rows(),
        ),
        "table-1-identified": csv_of_rows(
            "fit data parameter value low_95 high_95 verdict",
            [
                (label, data, COLUMNS[name], value, low, high, verdict)
                for label, data, fitted in _fits(fits, flown)
                for name in fitted.choice.free
                for value, low, high, _, verdict in (_interval(fitted, name),)
            ],
        ),
    }


def _printed(name: str) -> tuple[Any, ...]:
    law = parameter_set(name)
    return (name, *(_shown(p, getattr(law, p)) for p in PAPER_FOUR))


def _shape(b: Propeller, used_for: str) -> tuple[Any, ...]:
    at = 0.75 * b.radius
    chord, twist = (float(np.interp(at, b.station, v)) for v in (b.chord, b.twist))
    area = b.blades * float(np.trapezoid(b.chord, b.station))
    return (
        b.name,
        used_for,
        1e3 * b.radius,
        1e3 * float(b.chord.max()),
        1e3 * chord,
        *(float(np.degrees(angle)) for angle in (b.twist.max(), twist, b.twist[-1])),
        area / (np.pi * b.radius**2),
    )


def _fits(fits: TunnelFits, flown: dict[str, SetFlown]) -> list[tuple[str, str, Fitted]]:
    """Return label, data and fit of each tunnel fit and each fit of simulated flights."""
    tunnel = (fits.axial_four, fits.axial, fits.oblique)
    return [(one.label, one.data, one.fitted) for one in tunnel] + [
        (f"{TABLE_1[name].split(':')[0]}, level flights", "simulated flights", one.twin.fitted)
        for name, one in flown.items()
    ]


def _interval(fitted: Fitted, name: str) -> tuple[float, float, float, bool, str]:
    """Return value, limits of the 95 % interval, whether it is identified, and the verdict."""
    k, found = fitted.choice.free.index(name), fitted.uncertainty
    value, low, high = (_shown(name, float(v[k])) for v in (fitted.x, found.low, found.high))
    return value, low, high, bool(found.identified[k]), found.verdicts[k]


def _shown(parameter: str, value: float) -> float:
    return float(np.degrees(value)) if COLUMNS[parameter].endswith("deg") else value
