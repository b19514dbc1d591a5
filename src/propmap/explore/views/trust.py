"""Trust: certificate of a table with its cells, largest errors and measured points."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import Any

import numpy as np

from propmap.errors import InputError
from propmap.explore import view
from propmap.explore.session import Session
from propmap.explore.view import Answer, Control, Download, Graph, Slider, Table, Values
from propmap.export.files import origin
from propmap.loads import LOADS
from propmap.report.html import COLORS
from propmap.report.table_page import KINDS, cell_ranks, table_cells, table_errors
from propmap.table.certificate import claims
from propmap.table.query import LoadTable
from propmap.units import RPM

NAME = "cells.csv"
UNKNOWN = "This table has no certificate: rebuild it with `propmap table`."
# Labels and colors of the kinds of cells.
SHADES = [(label, c if c.startswith("#") else view.GRAY) for label, c in KINDS.values()]
PLACE = "V/(ΩR) %{x:.3g}, β %{y:.3g}°: %{text}<extra></extra>"  # hover text


class TrustView(view.View):
    """Certificate of a table."""

    name, title = "trust", "Trust"
    question = "Where is this table accurate?"
    downloads = (Download(NAME, "cells with a status other than ok, as CSV"),)
    places = (Graph("cells", "cells over advance ratio and angle", wide=True),)

    def controls(self, session: Session) -> Sequence[Control]:
        """Return the controls."""
        table = _table(session)
        (low, high), _, _ = table.envelope.values()
        return [
            view.data_choice(session),
            Slider(
                "at", "Show maximum airspeed at", "rpm", round(low / RPM), round(high / RPM), 10.0,
                round(float(np.sqrt(low * high)) / RPM),
            ),
        ]  # fmt: skip

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:  # noqa: ARG002 - fast
        """Draw the cells and show the certificate."""
        table = _table(session)
        certificate = table.certificate
        tables, remarks = [_origin(table)], list(claims(certificate)) if certificate else [UNKNOWN]
        if certificate:
            errors, heads = table_errors(certificate, table.info.get("parameter_uncertainty") or {})
            tables.append(Table(heads.split("|"), errors.cells, "Errors by load"))
        key = [SHADES[rank] for rank in np.unique(cell_ranks(table)[0]).tolist()]
        return Answer({"cells": _cells(session, table, values)}, tables, remarks, key)

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
    for k, name in enumerate(worst):
        advance = where["max_speed"][name] / (worst[name] * content.radius)
        at = [advance], [np.degrees(where["max_beta"][name])]
        label = f"largest error of {LOADS[name].label}"
        traces.append(view.points(*at, label, "#000000", view.MARKS[k % 7]))
    fastest = table.envelope["speed"][1] / (values["at"] * RPM * content.radius)
    return view.figure(
        traces,
        "advance ratio V/(ΩR) [-]",
        view.AXES["beta"],
        shapes=[view.upright(fastest)],
        xaxis={"range": [float(content.advance[0]), float(content.advance[-1])]},
        yaxis={"range": [float(beta[0]), float(beta[-1])]},
    )


def _origin(table: LoadTable) -> Table:
    """Return the lines of ``propmap show`` on the inputs of the table."""
    lines = "\n".join(origin(table)).replace("\n  ", " ").splitlines()  # one line per input
    return Table(("", "value"), [line.split(": ", 1) for line in lines], "Contents of the table")
