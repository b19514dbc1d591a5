"""Disk: angle of attack, inflow, force, stall and reverse flow over the disk."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from contourpy import contour_generator

from propmap.errors import InputError
from propmap.explore import view
from propmap.explore.session import Recipe, Session, rotor_of
from propmap.explore.view import Answer, Control, Download, Graph, OneOf, Slider, Values
from propmap.io.csv import disk_csv
from propmap.report.html import COLORS
from propmap.results import Inflow
from propmap.table.interpolation import bilinear
from propmap.typing import Floats
from propmap.units import MM

STATIONS, AZIMUTHS = 40, 73  # number of radii and azimuths of the computed field
PIXELS = 161  # number of pixels along each side of the picture
ALPHA = "\u03b1"
FIELDS = {
    "alpha": (f"angle of attack {ALPHA} [deg]", "Viridis"),
    "inflow": ("inflow v_i [m/s]", "Cividis"),
    "force": ("axial force of a blade dT/dy [N/m]", "Viridis"),
    "margin": ("angle of attack beyond stall [deg]", "RdBu"),
}  # fields over the disk: title and color scale
NAME = "disk.csv"


class DiskView(view.View):
    """The flow over the disk at one operating point."""

    name, title = "disk", "Disk"
    question = "Where on the disk do stall and reverse flow occur?"
    downloads = (Download(NAME, "disk as CSV"),)
    places = (
        Graph("disk", "disk from above, flight upward", tall=True),
        Graph("angle", "angle of attack along the blade"),
        Graph("inflow", "inflow along the blade"),
        Graph("force", "axial force along the blade"),
    )

    def controls(self, session: Session) -> Sequence[Control]:
        """Return the controls."""
        options = tuple((key, title.partition(" [")[0]) for key, (title, _) in FIELDS.items())
        return [
            *view.point_controls(session),
            OneOf("field", "Field over the disk", options, "alpha"),
            Slider("psi", "Azimuth ψ of the blade", "deg", 0.0, 360.0, 5.0, 90.0),
        ]

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """Draw the field at the operating point."""
        rotor = rotor_of(session.model)
        radius = np.linspace(*rotor.model.span, STATIONS)
        azimuth = np.linspace(0.0, 2.0 * np.pi, AZIMUTHS)
        field = rotor.inflow(*_si(values), radius=radius, azimuth=azimuth)
        if not np.isfinite(field.alpha).all():
            raise InputError("the inflow did not converge everywhere", "choose another point")
        psi = round(values["psi"] / 5.0) % (AZIMUTHS - 1)
        mean = (field.inflow, "mean", view.GRAY, "dash")
        shown = {"disk": _disk(field, values)}
        for name, along, title, *more in (
            ("angle", np.degrees(field.alpha[:, psi]), FIELDS["alpha"][0]),
            ("inflow", field.local_inflow[:, psi], FIELDS["inflow"][0], mean),
            ("force", field.normal_force[:, psi], "dT/dy of a blade [N/m]"),
        ):
            lines, whole = [(along, title, COLORS[0]), *more], [0.0, float(MM * radius[-1])]
            axis = {"range": whole}
            shown[name] = view.curves(MM * radius, lines, "radius y [mm]", title, xaxis=axis)
        share = {"stalled": field.stalled, "in reverse flow": field.reverse}
        words = ", ".join(
            f"{name} {100.0 * field.share_of_disk(at):.2g} %" for name, at in share.items()
        )
        key = [
            (f"at ψ = {5 * psi}°", COLORS[0]),
            ("mean over azimuth", f"-{view.GRAY}"),
            ("outline of stall", COLORS[1]),
            ("outline of reverse flow", f"-{COLORS[3]}"),
        ]
        tables = [view.point_table(session, values)] if settled else []
        return Answer(shown, tables, [f"{view.point_words(values)}: {words} of the disk"], key)

    def shell(self, session: Session, values: Values) -> str:
        """Return commands for the field as CSV and as a picture, and for the loads."""
        recipe = Recipe(session)
        prop, *point = recipe.predict(values)[1:]
        plot = ["plot", "disk", prop, *point, "-o"]
        return recipe.shell([*plot, NAME], [*plot, "disk.png"], recipe.predict(values))

    def python(self, session: Session, values: Values) -> str:
        """Return code that prints the field."""
        return Recipe(session).python(
            f"point = {view.point_python(values)}\n"
            "field = rotor.inflow(*point)\n"
            "print(np.degrees(field.alpha), field.local_inflow, field.normal_force)\n"
            "print(rotor.loads(*point))"
        )

    def text(self, session: Session, values: Values, file: str) -> str:  # noqa: ARG002 - one file
        """Return the same CSV as `propmap plot disk -o disk.csv`."""
        return disk_csv(rotor_of(session.model), *_si(values))


def _si(values: Values) -> tuple[float, float, float]:
    omega, speed, beta = (float(part[0]) for part in view.point_of(values).si)
    return omega, speed, beta


def _disk(field: Inflow, values: Values) -> view.Figure:
    which = values["field"]
    title, colors = FIELDS[which]
    root, tip = MM * field.radius[0], MM * field.radius[-1]
    side = np.linspace(-tip, tip, PIXELS)
    x, y = np.meshgrid(side, side)
    # Seen from above with the flight upward: psi = 0 is at the bottom, 90 degrees on the right.
    away, psi = np.hypot(x, y), np.mod(np.arctan2(x, -y), 2.0 * np.pi)
    outside = (away > tip) | (away < root)
    drawn: Floats = {
        "alpha": np.degrees(field.alpha),
        "inflow": field.local_inflow,
        "force": field.normal_force,
        "margin": np.degrees(field.past_stall),
    }[which]
    rest = drawn[~field.reverse] if not field.reverse.all() else drawn
    low, high = np.percentile(rest, 1.0), np.percentile(rest, 99.0)
    if which == "margin":
        low, high = -max(abs(low), abs(high)), max(abs(low), abs(high))

    over = bilinear(field.radius, field.azimuth, drawn, away / MM, psi)
    over[outside] = np.nan
    words = {"text": title, "side": "right", "font": {"size": 12}}
    traces: list[dict[str, Any]] = [
        {
            "type": "heatmap",
            "x": view.array(side),
            "y": view.array(side),
            "z": view.array(over.astype(np.float32)),
            "zmin": low,
            "zmax": max(high, low + 1e-6),
            "colorscale": colors,
            "reversescale": which == "margin",
            "hovertemplate": f"%{{z:.4g}}<extra>{title}</extra>",
            "colorbar": {"title": words, "thickness": 12, "len": 0.9},
        }
    ]
    if field.stalled.any():
        traces += _outline(field, field.past_stall, COLORS[1], "solid")
    if field.reverse.any():
        traces += _outline(field, field.u_tangential, COLORS[3], "dash")
    sine, cosine = np.sin(np.radians(values["psi"])), np.cos(np.radians(values["psi"]))
    ends = {"x0": root * sine, "y0": -root * cosine, "x1": tip * sine, "y1": -tip * cosine}
    blade = {"type": "line", **ends, "line": {"color": COLORS[0], "width": 2}}
    word = {"xref": "paper", "yref": "paper", "x": 0.5, "xanchor": "center", "showarrow": False}
    names = [
        {**word, "y": 1.0, "yanchor": "bottom", "text": "ψ = 180°, flight ↑"},
        {**word, "y": 0.0, "yanchor": "top", "text": "ψ = 0°"},
    ]
    bare = {"visible": False, "range": [-1.03 * tip, 1.03 * tip]}
    return view.figure(
        traces,
        "",
        "",
        revision=which,
        shapes=[blade],
        xaxis={**bare, "constrain": "domain"},
        yaxis={**bare, "scaleanchor": "x", "constrain": "domain"},
        margin={"l": 8, "r": 8, "t": 26, "b": 24},
        annotations=names,
    )


def _outline(field: Inflow, values: Floats, color: str, dash: str) -> list[dict[str, Any]]:
    """Return the zero contour of ``values`` (S, P); contours by Plotly are ten times slower."""
    along: list[float] = []
    across: list[float] = []
    for line in contour_generator(field.azimuth, MM * field.radius, values).lines(0.0):
        psi, radius = np.asarray(line).T
        along += [*(radius * np.sin(psi)).tolist(), np.nan]
        across += [*(-radius * np.cos(psi)).tolist(), np.nan]
    return [view.line(along, across, "", color, dash, hoverinfo="skip")]
