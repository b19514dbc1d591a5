"""Panels of the section's constants: its curves, and loads measured and modelled."""

from __future__ import annotations

from typing import Any

import numpy as np

from propmap.explore import figures
from propmap.explore.view import Table
from propmap.fit.tunnel import TunnelData
from propmap.io.operating_points import RPM
from propmap.model.airfoil import Airfoil
from propmap.model.model import Model
from propmap.report.html import COLOURS
from propmap.typing import Floats

ALPHA = np.radians(np.linspace(-20.0, 60.0, 161))


def of_section(model: Model, old: Airfoil, new: Airfoil) -> dict[str, figures.Figure]:
    """C_L and C_D over the angle of attack, at the Reynolds number of three quarters of R."""
    blade, air = model.propeller, model.air
    omega = 60.0 / blade.radius
    chord = np.interp(0.75 * blade.radius, blade.station, blade.chord)
    reynolds = np.full_like(
        ALPHA, air.density * 0.75 * blade.radius * omega * chord / air.viscosity
    )
    both = [law.coefficients(ALPHA, reynolds) for law in (old, new)]
    x = np.degrees(ALPHA)
    found = {}
    for k, key, title in (
        (0, "lift", "lift coefficient C_L [-]"),
        (1, "section-drag", "drag coefficient C_D [-]"),
    ):
        pair = [one[k] for one in both]
        found[key] = figures.figure(
            [
                figures.line(x, pair[0], "as they were", figures.GREY, "dash"),
                figures.line(x, pair[1], "as they are", COLOURS[0]),
            ],
            f"angle of attack [deg], Re = {reynolds[0]:.2g}",
            title,
            xaxis={"range": [float(x[0]), float(x[-1])]},
            yaxis=figures.span(*pair, zero=True),
        )
    return found


def measured_and_modelled(name: str, data: TunnelData, modelled: Floats) -> figures.Figure:
    """A load, modelled over measured (n,)."""
    measured = data.loads[name]
    both = figures.span(measured, modelled)
    ends = both["range"]
    words = [
        f"{w / RPM:.0f} rpm, {v:.3g} m/s, β {np.degrees(b):.3g}°"
        for w, v, b in zip(data.omega, data.speed, data.beta, strict=True)
    ]
    return figures.figure(
        [
            figures.line(ends, ends, "equal", figures.GREY, "dash", hoverinfo="skip"),
            figures.points(
                measured,
                modelled,
                data.source,
                COLOURS[0],
                text=words,
                hovertemplate="%{text}<br>measured %{x:.4g}, modelled %{y:.4g}<extra></extra>",
            ),
        ],
        f"measured {figures.TITLES[name]}",
        "modelled",
        xaxis=both,
        yaxis=both,
    )


def errors(data: TunnelData, before: Any, now: Any) -> Table:
    """Root mean square errors of two sets of loads, such as ``Loads``, on the data."""
    rows = []
    for name, measured in data.loads.items():
        size = np.sqrt(np.nanmean(measured**2))
        cells = []
        for loads in (before, now):
            off = np.sqrt(np.nanmean((getattr(loads, name) - measured) ** 2))
            cells.append(f"{figures.digits(off)} ({100.0 * off / size:.1f} %)")
        rows.append([figures.LABELS[name], *cells, figures.UNITS[name]])
    caption = f"Root mean square errors on {data.source}, in brackets over its rms"
    return Table(("", "as they were", "as they are", "unit"), rows, caption)
