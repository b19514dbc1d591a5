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
from propmap.export.files import origin
from propmap.loads import LOADS, error_scales
from propmap.report.html import COLORS
from propmap.report.table_page import KINDS, cell_ranks, table_cells, table_errors
from propmap.table.certificate import claims
from propmap.table.query import LoadTable
from propmap.table.verification import quasi_random
from propmap.units import RPM

NAME = "cells.csv"
UNKNOWN = "This table has no certificate: rebuild it with `propmap table`."
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
        tables, remarks = [_origin(table)], list(claims(certificate)) if certificate else [UNKNOWN]
        if certificate:
            errors, heads = table_errors(certificate, table.info.get("parameter_uncertainty") or {})
            tables.append(Table(heads.split("|"), errors.cells, "Errors by load"))
        if settled:
            sample = _sample(session, table, values)
            if sample is None:
                remarks.append(
                    "Errors at new points are not shown: the table was built with another model."
                )
            else:
                shown["sample"] = sample
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


def _origin(table: LoadTable) -> Table:
    """Return the lines of ``propmap show`` on the inputs of the table."""
    lines = "\n".join(origin(table)).replace("\n  ", " ").splitlines()  # one line per input
    return Table(("", "value"), [line.split(": ", 1) for line in lines], "Contents of the table")
