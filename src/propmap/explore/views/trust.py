"""Trust: certificate of a table with its cells, errors and measured points."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import Any

import numpy as np

from propmap.errors import InputError
from propmap.explore import view
from propmap.explore.session import Session, rotor_of
from propmap.explore.view import Answer, Control, Download, Graph, OneOf, Slider, Table, Values
from propmap.loads import LOADS, error_scales
from propmap.report.html import COLORS
from propmap.report.table_page import KINDS, cell_ranks, table_cells
from propmap.table.query import LoadTable
from propmap.table.verification import quasi_random
from propmap.units import RPM

NAME = "cells.csv"
SAMPLE = 256  # number of points for the comparison of table and model
# Labels and colors of the kinds of cells.
SHADES = [(label, c if c.startswith("#") else view.GRAY) for label, c in KINDS.values()]
PLACE = "V/(ΩR) %{x:.3g}, β %{y:.3g}°: %{text}<extra></extra>"  # hover text
ADVANCE, ANGLE = "advance ratio V/(ΩR) [-]", "angle β [deg]"


class TrustView(view.View):
    """Certificate of a table."""

    name, title = "trust", "Trust"
    question = "Where is this table accurate?"
    downloads = (Download(NAME, "cells with a status other than ok, as CSV"),)
    places = (
        Graph("cells", "cells over advance ratio and angle", wide=True),
        Graph("errors", "largest and rms errors by load"),
        Graph("sample", "errors with respect to the model at points of the envelope"),
    )

    def controls(self, session: Session) -> Sequence[Control]:
        """Return the controls."""
        table = _table(session)
        (low, high), _, _ = table.envelope.values()
        loads = tuple((name, load.label) for name, load in LOADS.items())
        return [
            OneOf("load", "Error of", (("worst", "all loads, largest"), *loads), "worst"),
            view.data_choice(session),
            Slider(
                "at", "Show maximum airspeed at", "rpm", round(low / RPM), round(high / RPM), 10.0,
                round(float(np.sqrt(low * high)) / RPM),
            ),
        ]  # fmt: skip

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """Draw the cells at once, and the errors at sample points when settled."""
        table = _table(session)
        certificate = table.certificate
        shown = {"cells": _cells(session, table, values)}
        remarks = []
        if certificate:
            shown["errors"] = _by_load(certificate)
            holds = certificate.get("holds")
            remarks.append(
                f"At {'all' if holds else 'some'} of the {certificate['points']} points outside "
                f"unresolved cells, the error {'is within' if holds else 'EXCEEDS'} the tolerance "
                f"of {100.0 * certificate['tolerance']:g} % of static loads."
            )
        else:
            remarks.append("This table has no certificate: rebuild it with `propmap table`.")
        if settled:
            sample = _sample(session, table, values)
            if sample is None:
                remarks.append(
                    "Errors at new points are not shown: the table was built with another model."
                )
            else:
                shown["sample"] = sample
        tables = [_facts(table)] if settled else []
        key = [SHADES[rank] for rank in np.unique(cell_ranks(table)[0]).tolist()]
        return Answer(shown, tables, remarks, key)

    def shell(self, session: Session, values: Values) -> str:  # noqa: ARG002 - of the table alone
        """Return commands that show the table and write a report."""
        given = session.files["table"]
        path = shlex.quote(given.path or given.name)
        return f"propmap show {path}\npropmap report {path} -o report"

    def python(self, session: Session, values: Values) -> str:  # noqa: ARG002 - of the table alone
        """Return code that prints the certificate."""
        given = session.files["table"]
        return (
            "from propmap.table import LoadTable\n\n"
            f"table = LoadTable.load({given.path or given.name!r})\n"
            "print(table.envelope)\nprint(table.certificate)\n"
        )

    def text(self, session: Session, values: Values, file: str) -> str:  # noqa: ARG002 - one file
        """Return the CSV of the cells from `propmap report`."""
        return table_cells(_table(session)).csv()


def _table(session: Session) -> LoadTable:
    if session.table is None:
        found = "there is no table"
        remedy = "write it with `propmap table PROP --rpm 3000:9000 --speed 0:20 -o map.npz`"
        remedy += " and open it here"
        raise InputError(found, remedy)
    return session.table


def _cells(session: Session, table: LoadTable, values: Values) -> view.Figure:
    content, (rank, _) = table.content, cell_ranks(table)
    beta, count = np.degrees(content.beta), len(SHADES)
    stops = [[(k + end) / count, shade] for k, (_, shade) in enumerate(SHADES) for end in (0, 1)]
    traces: list[dict[str, Any]] = [
        {
            "type": "heatmap",
            "x": view.array(content.advance),
            "y": view.array(beta),
            "z": view.array(rank.T),
            "text": [[SHADES[k][0] for k in row] for row in rank.T.tolist()],
            "hovertemplate": PLACE,
            "zmin": -0.5,
            "zmax": count - 0.5,
            "colorscale": stops,
            "showscale": False,
        }
    ]
    data = session.measured(values["data"])
    if data is not None:
        advance = data.speed / (data.omega * content.radius)
        traces.append(
            view.points(
                advance, np.degrees(data.folded_beta), f"measured: {data.source}", COLORS[0],
                "circle-open",
            )
        )  # fmt: skip
    where = table.certificate
    worst = where.get("max_omega") or {}
    for k, name in enumerate(n for n in worst if values["load"] in ("worst", n)):
        advance = where["max_speed"][name] / (worst[name] * content.radius)
        at = [advance], [np.degrees(where["max_beta"][name])]
        label = f"largest error of {LOADS[name].label}"
        traces.append(view.points(*at, label, "#000000", view.MARKS[k % 7]))
    fastest = table.envelope["speed"][1] / (values["at"] * RPM * content.radius)
    return view.figure(
        traces,
        ADVANCE,
        ANGLE,
        shapes=[view.upright(fastest)],
        xaxis={"range": [float(content.advance[0]), float(content.advance[-1])]},
        yaxis={"range": [float(beta[0]), float(beta[-1])]},
    )


def _by_load(certificate: dict[str, Any]) -> view.Figure:
    names = [name for name in LOADS if name in certificate["max_error"]]
    bars = [
        {
            "type": "bar",
            "x": [LOADS[name].label for name in names],
            "y": [100.0 * certificate[key][name] for name in names],
            "name": label,
            "marker": {"color": color},
        }
        for key, label, color in (
            ("max_error", "largest", COLORS[1]),
            ("rms_error", "rms", COLORS[0]),
        )
    ]
    level = 100.0 * certificate["tolerance"]
    place = {"xref": "paper", "yref": "y", "x0": 0, "x1": 1, "y0": level, "y1": level}
    line = {**view.upright(0.0), **place}
    return view.figure(
        bars, "", "error / static load [%]", shapes=[line], legend=True, barmode="group",
        margin={"l": 62, "r": 12, "t": 12, "b": 84},
    )  # fmt: skip


def _sample(session: Session, table: LoadTable, values: Values) -> view.Figure | None:
    """Return errors at points of the envelope, or None if the table is from another model."""
    model = session.model
    if table.info.get("model_sha256") != model.fingerprint():
        return None
    omega, speed, beta = quasi_random(table, SAMPLE, seed=3)
    own, found = rotor_of(model).loads(omega, speed, beta), table.loads(omega, speed, beta)
    still = rotor_of(model).loads(omega, 0.0, 0.0)
    radius = model.propeller.radius
    scales = error_scales({name: getattr(still, name) for name in LOADS}, radius)
    names = LOADS if values["load"] == "worst" else [values["load"]]
    errors = [np.abs(getattr(found, n) - getattr(own, n)) / scales[n] for n in names]
    worst = 100.0 * np.max(errors, axis=0)
    bar = {"title": {"text": "log10 of error in %"}, "thickness": 12}
    colors = view.array(np.log10(np.maximum(worst, 1e-6)))
    trace = view.points(speed / (omega * radius), np.degrees(beta), "error", COLORS[0])
    trace["marker"] = {"color": colors, "colorscale": "Viridis", "size": 7, "colorbar": bar}
    trace |= {"text": [f"{value:.3g} %" for value in worst], "hovertemplate": PLACE}
    return view.figure([trace], ADVANCE, ANGLE)


def _facts(table: LoadTable) -> Table:
    (w0, w1), (v0, v1), (b0, b1) = table.envelope.values()
    certificate = table.certificate
    rows = [
        ["rpm", f"{w0 / RPM:.0f} to {w1 / RPM:.0f}"],
        ["airspeed [m/s]", f"{v0:g} to {v1:g}"],
        ["angle β [deg]", f"{np.degrees(b0):.4g} to {np.degrees(b1):.4g}"],
        ["propeller", str(table.info.get("propeller", {}).get("name", ""))],
        ["constants", str(table.info.get("airfoil", {}).get("name", ""))],
    ]
    if certificate:
        rows += [
            ["unresolved cells", str(certificate["unresolved_cells"])],
            ["unresolved part of envelope", f"{100.0 * certificate['unresolved_volume']:.3g} %"],
            ["points in the vortex ring state", str(certificate["vortex_ring"])],
            ["points without a value", str(certificate["no_value"])],
        ]
        for name, error in certificate["max_error"].items():
            rows.append([f"largest error, {LOADS[name].label}", f"{100.0 * error:.3g} %"])
    return Table(("", "value"), rows, "Contents of the table file")
