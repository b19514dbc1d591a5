"""The operating point that all views share, and what is told of it."""

from __future__ import annotations

import numpy as np

from propmap.explore import figures
from propmap.explore.controls import Slider, Values
from propmap.explore.reproduce import number
from propmap.explore.rotors import fastest, hover_model, rotor_of
from propmap.explore.session import Session
from propmap.explore.view import Table
from propmap.io.operating_points import RPM, OperatingPoints


def point_controls(session: Session) -> list[Slider]:
    """Sliders for rpm, speed and angle."""
    blade = session.model.propeller
    usual = 60.0 / blade.radius / RPM
    found = session.measured(next(iter(session.measurements()), "none"))
    if found is not None and len(found):
        # Where measured points are.
        measured = found.omega / RPM
        usual = float(measured[np.argmin(np.abs(measured - usual))])
    usual = round(usual / 10.0) * 10.0
    highest = round(fastest(session.model) / RPM)
    return [
        Slider("rpm", "Rotational speed", "rpm", 100.0, highest, 10.0, max(usual, 100.0)),
        Slider("speed", "Flight speed V", "m/s", 0.0, 60.0, 0.5, 8.0),
        Slider("beta", "Angle β, 0 climb, 90 edgewise", "deg", 0.0, 180.0, 1.0, 60.0),
    ]


def point_of(values: Values) -> OperatingPoints:
    """The operating point."""
    rpm, speed, beta = (np.array([values[key]]) for key in ("rpm", "speed", "beta"))
    return OperatingPoints(rpm, speed, beta)


def point_lines(values: Values) -> list[str]:
    """Options of a command for it."""
    return [part for key in ("rpm", "speed", "beta") for part in (f"--{key}", number(values[key]))]


def point_words(values: Values) -> str:
    """The operating point in words."""
    return f"{values['rpm']:g} rpm, {values['speed']:g} m/s, β {values['beta']:g}°"


def point_table(session: Session, values: Values) -> Table:
    """Loads at the operating point as `propmap predict` tells them, and how sure they are."""
    rotor = rotor_of(session.model)
    point = point_of(values)
    loads = point.loads(rotor)
    still = hover_model(session.model).loads(point.si[0])
    hover = {**still, "power": still["torque"] * point.si[0]}
    known = loads.std if session.model.uncertainty is not None else None
    rows = []
    for name, label in figures.LABELS.items():
        std = "" if known is None else f"± {2.0 * float(getattr(known, name)[0]):.2g}"
        found = figures.digits(float(getattr(loads, name)[0]))
        rows.append([label, found, std, figures.digits(float(hover[name][0])), figures.UNITS[name]])
    rows += [
        ["mean inflow", figures.digits(float(loads.mean_inflow[0])), "", "", "m/s"],
        ["reverse flow", figures.digits(100.0 * float(loads.reverse_flow[0])), "", "", "% of disk"],
        ["status", str(loads.status[0]), "", "", ""],
    ]
    caption = f"At {point_words(values)}"
    if known is not None:
        caption += "; ± two standard deviations, 95 %"
    return Table(("", "value", "±", "hover model", "unit"), rows, caption)
