"""Trust: a table's certificate as pictures: errors, cells, and where data were."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from propmap.errors import InputError
from propmap.explore import view
from propmap.explore.session import Session, rotor_of
from propmap.explore.view import Answer, Choice, Control, Download, Graph, Slider, Table, Values
from propmap.io.csv import RPM
from propmap.loads import LOADS
from propmap.report.html import COLOURS
from propmap.report.table_page import KINDS, cell_ranks, table_cells
from propmap.table.certificate import quasi_random
from propmap.table.query import LoadTable

NAME = "cells.csv"

SAMPLE = 256
"""Points at which table and model are compared here."""


class TrustView:
    """A table's certificate."""

    name, title = "trust", "Trust"
    question = "Where can this table be trusted, and where not?"
    downloads = (Download(NAME, "cells that are not certified, as CSV"),)

    def controls(self, session: Session) -> Sequence[Control]:
        """What can be set."""
        table = _table(session)
        (low, high), _, _ = table.envelope.values()
        loads = tuple((name, load.label) for name, load in LOADS.items())
        data = tuple((name, name) for name in session.measurements())
        return [
            Choice("load", "Error of", (("worst", "the worst load"), *loads), "worst"),
            Choice("data", "Measured", (("none", "none"), *data), data[0][0] if data else "none"),
            Slider(
                "at", "Limit of speed at", "rpm", round(low / RPM), round(high / RPM), 10.0,
                round(float(np.sqrt(low * high)) / RPM),
            ),
        ]  # fmt: skip

    def graphs(self, session: Session) -> Sequence[Graph]:  # noqa: ARG002 - the same for all
        """Cells, errors."""
        return [
            Graph("cells", "cells over advance ratio and angle", wide=True),
            Graph("errors", "largest and rms errors by load"),
            Graph("sample", "table against the model, at points of the envelope"),
        ]

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """Cells at once, errors at a sample of points when all stands still."""
        table = _table(session)
        certificate = table.certificate
        shown = {"cells": _cells(session, table, values)}
        remarks = []
        if certificate:
            shown["errors"] = _by_load(certificate)
            holds = "holds" if certificate.get("holds") else "does NOT hold"
            remarks.append(
                f"Its tolerance of {100.0 * certificate['tolerance']:g} % of static loads {holds} "
                f"at {certificate['points']} points outside unresolved cells."
            )
        else:
            remarks.append("This table has no certificate: build it again with `propmap table`.")
        if settled:
            sample = _sample(session, table, values)
            if sample is None:
                remarks.append(
                    "It was built from another model than the one explored: no errors at a sample."
                )
            else:
                shown["sample"] = sample
        tables = [_told(table)] if settled else []
        found = set(np.unique(cell_ranks(table)[1]).tolist())
        key = [
            (label, colour if colour.startswith("#") else view.GREY)
            for code, (label, colour) in KINDS.items()
            if code in found
        ]
        return Answer(shown, tables, remarks, key)

    def shell(self, session: Session, values: Values) -> str:  # noqa: ARG002 - of the table alone
        """What the table tells of itself, and a report on it."""
        import shlex

        given = session.files["table"]
        path = shlex.quote(given.path or given.name)
        return f"propmap show {path}\npropmap report {path} -o report"

    def python(self, session: Session, values: Values) -> str:  # noqa: ARG002 - of the table alone
        """The certificate."""
        given = session.files["table"]
        return (
            "from propmap.table import LoadTable\n\n"
            f"table = LoadTable.load({given.path or given.name!r})\n"
            "print(table.envelope)\nprint(table.certificate)\n"
        )

    def text(self, session: Session, values: Values, file: str) -> str:  # noqa: ARG002 - one file
        """What `propmap report` files of the cells."""
        return table_cells(_table(session)).csv()


def _table(session: Session) -> LoadTable:
    if session.table is None:
        raise InputError(
            "there is no table",
            "open a file of `propmap table PROP --rpm 3000:9000 --speed 0:20 -o map.npz` here",
        )
    return session.table


def _cells(session: Session, table: LoadTable, values: Values) -> view.Figure:
    content = table.content
    rank, _ = cell_ranks(table)
    last = len(KINDS) - 1
    stops = []
    for k, (_, colour) in enumerate(KINDS.values()):
        shade = colour if colour.startswith("#") else view.GREY
        stops += [[k / (last + 1), shade], [(k + 1) / (last + 1), shade]]
    beta = np.degrees(content.beta)
    middle = [0.5 * (edge[1:] + edge[:-1]) for edge in (content.advance, beta)]
    names = [label for label, _ in KINDS.values()]
    traces: list[dict[str, Any]] = [
        {
            "type": "heatmap",
            "x": view.array(content.advance),
            "y": view.array(beta),
            "z": view.array(rank.T),
            "text": [[names[int(k)] for k in row] for row in rank.T],
            "hovertemplate": "V/(ΩR) %{x:.3g}, β %{y:.3g}°: %{text}<extra></extra>",
            "zmin": -0.5,
            "zmax": last + 0.5,
            "colorscale": stops,
            "showscale": False,
        }
    ]
    assert middle[0].size == rank.shape[0]
    data = session.measured(values["data"])
    if data is not None:
        advance = data.speed / (data.omega * content.radius)
        traces.append(
            view.points(
                advance, np.degrees(data.folded_beta), f"measured: {data.source}", COLOURS[0],
                "circle-open",
            )
        )  # fmt: skip
    worst = table.certificate.get("max_omega") or {}
    where = table.certificate
    for k, name in enumerate(n for n in worst if values["load"] in ("worst", n)):
        advance = where["max_speed"][name] / (worst[name] * content.radius)
        traces.append(
            view.points(
                [advance], [np.degrees(where["max_beta"][name])],
                f"largest error of {LOADS[name].label}", "#000000", view.MARKS[k % 7],
            )
        )  # fmt: skip
    fastest = table.envelope["speed"][1] / (values["at"] * RPM * content.radius)
    return view.figure(
        traces,
        "advance ratio V/(ΩR) [-]",
        "angle β [deg]",
        shapes=[view.upright(fastest)],
        xaxis={"range": [float(content.advance[0]), float(content.advance[-1])]},
        yaxis={"range": [float(beta[0]), float(beta[-1])]},
    )


def _by_load(certificate: dict[str, Any]) -> view.Figure:
    names = [name for name in LOADS if name in certificate["max_error"]]
    bars = []
    for key, label, colour in (
        ("max_error", "largest", COLOURS[1]),
        ("rms_error", "rms", COLOURS[0]),
    ):
        bars.append(
            {
                "type": "bar",
                "x": [LOADS[name].label for name in names],
                "y": [100.0 * certificate[key][name] for name in names],
                "name": label,
                "marker": {"color": colour},
            }
        )
    level = 100.0 * certificate["tolerance"]
    line = {
        **view.upright(0.0),
        **{"xref": "paper", "yref": "y", "x0": 0, "x1": 1, "y0": level, "y1": level},
    }
    return view.figure(
        bars, "", "error / static load [%]", shapes=[line], legend=True, barmode="group",
        margin={"l": 62, "r": 12, "t": 12, "b": 84},
    )  # fmt: skip


def _sample(session: Session, table: LoadTable, values: Values) -> view.Figure | None:
    """Errors at points of the envelope; None where the model is another one."""
    model = session.model
    if table.info.get("model_sha256") != model.fingerprint():
        return None
    omega, speed, beta = quasi_random(table, SAMPLE, seed=3)
    own, found = rotor_of(model).loads(omega, speed, beta), table.loads(omega, speed, beta)
    still = rotor_of(model).loads(omega, 0.0, 0.0)
    radius, errors = model.propeller.radius, []
    names = LOADS if values["load"] == "worst" else [values["load"]]
    for name in names:
        load = LOADS[name]
        scale = getattr(still, load.scale)
        scale = scale * (radius if load.unit != LOADS[load.scale].unit else 1.0)
        errors.append(np.abs(getattr(found, name) - getattr(own, name)) / scale)
    worst = 100.0 * np.max(errors, axis=0)
    marker = {
        "color": view.array(np.log10(np.maximum(worst, 1e-6))),
        "colorscale": "Viridis",
        "size": 7,
        "colorbar": {"title": {"text": "log10 error [%]"}, "thickness": 12},
    }
    trace = view.points(speed / (omega * radius), np.degrees(beta), "error", COLOURS[0])
    trace |= {
        "marker": marker,
        "text": [f"{value:.3g} %" for value in worst],
        "hovertemplate": "V/(ΩR) %{x:.3g}, β %{y:.3g}°: %{text}<extra></extra>",
    }
    return view.figure([trace], "advance ratio V/(ΩR) [-]", "angle β [deg]")


def _told(table: LoadTable) -> Table:
    (w0, w1), (v0, v1), (b0, b1) = table.envelope.values()
    certificate = table.certificate
    rows = [
        ["rpm", f"{w0 / RPM:.0f} to {w1 / RPM:.0f}"],
        ["speed [m/s]", f"{v0:g} to {v1:g}"],
        ["angle β [deg]", f"{np.degrees(b0):.4g} to {np.degrees(b1):.4g}"],
        ["propeller", str(table.info.get("propeller", {}).get("name", ""))],
        ["constants", str(table.info.get("airfoil", {}).get("name", ""))],
    ]
    if certificate:
        rows += [
            ["unresolved cells", str(certificate["unresolved_cells"])],
            ["their share of the envelope", f"{100.0 * certificate['unresolved_volume']:.3g} %"],
            ["points in the vortex ring", str(certificate["vortex_ring"])],
            ["points without a value", str(certificate["no_value"])],
        ]
        for name, error in certificate["max_error"].items():
            rows.append([f"largest error, {LOADS[name].label}", f"{100.0 * error:.3g} %"])
    return Table(("", "value"), rows, "What the table tells of itself")
