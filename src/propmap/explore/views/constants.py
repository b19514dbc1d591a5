"""Constants: the section law by hand or by a fit, with its curves and its error on data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from dash import Input, Output, State, html, no_update, set_props
from dash.exceptions import PreventUpdate

from propmap.errors import InputError
from propmap.explore import constants_panels, figures
from propmap.explore.constants_fit import CONSTANTS, Fit, law_at_first, law_of, model_of
from propmap.explore.controls import Choice, Control, Several, Slider, Values, values_of
from propmap.explore.point import point_controls, point_lines
from propmap.explore.reproduce import CONSTANTS_FILE, Recipe
from propmap.explore.rotors import rotor_of
from propmap.explore.session import Session
from propmap.explore.view import Answer, Download, Graph
from propmap.fit.parameters import SECTION
from propmap.fit.tunnel import TunnelData
from propmap.io.csv_text import csv_text
from propmap.io.operating_points import RPM
from propmap.loads import LOADS
from propmap.report.html import COLOURS

if TYPE_CHECKING:
    from propmap.explore.application import Application

FREE = ("c_l1", "c_d", "alpha_0", "zero_lift_angle")

MOST = 400
"""Measured points that are predicted."""

NAME = "errors.csv"

SHOWN = ("thrust", "drag", "torque", "roll_moment")


class ConstantsView:
    """Constants of the section law beside measured loads."""

    name, title = "constants", "Constants"
    question = "Which constants does the data want, and how well does it know them?"
    downloads = (Download(CONSTANTS_FILE, "constants as TOML"), Download(NAME, "errors as CSV"))

    def controls(self, session: Session) -> Sequence[Control]:
        """What can be set."""
        law = law_at_first(session)
        known = session.model.uncertainty
        deviations = {}
        if known is not None:
            variances = np.diag(known.covariance.matrix)
            deviations = dict(zip(known.covariance.names, np.sqrt(variances), strict=True))
        sliders = []
        for name in CONSTANTS:
            here, about = float(getattr(law, name)), SECTION[name]
            low, high = min(about.lower, here), max(about.upper, here)
            sure = deviations.get(name, np.nan)
            marked = (here - 1.96 * sure, here + 1.96 * sure) if np.isfinite(sure) else None
            step = 0.001 if about.unit == "rad" or high <= 0.5 else 0.01
            unit = about.unit
            sliders.append(
                Slider(name, f"{name}, {about.meaning}", unit, low, high, step, here, marked)
            )
        data = tuple((name, name) for name in session.measurements())
        chosen = data[0][0] if data else "none"
        free = tuple((name, name) for name in CONSTANTS)
        return [
            *sliders,
            Choice("data", "Measured", (("none", "none"), *data), chosen),
            Several("free", "Free in a fit", free, FREE),
            *point_controls(session),
        ]

    def graphs(self, session: Session) -> Sequence[Graph]:
        """The section's curves, and loads measured and modelled."""
        data = session.measured(next(iter(session.measurements()), "none"))
        names = [n for n in SHOWN if data is not None and n in data.loads] or ["thrust", "torque"]
        return [
            Graph("lift", "lift of the section"),
            Graph("section-drag", "drag of the section"),
            *(Graph(name, f"{figures.LABELS[name]}, modelled and measured") for name in names),
        ]

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """Curves of the section, and errors on the data."""
        old, new = law_at_first(session), law_of(session, values)
        shown = constants_panels.of_section(session.model, old, new)
        key = [("as they were", f"-{figures.GREY}"), ("as they are", COLOURS[0])]
        data = session.measured(values["data"])
        if data is None:
            return Answer(shown, (), ["Choose or drop measured loads to see errors."], key)
        remarks, tables = [], []
        part = _some(data)
        if len(part) < len(data):
            remarks.append(f"{len(part)} of {len(data)} points of {data.source}, evenly chosen")
        model = model_of(session, values)
        now = rotor_of(model).loads(part.omega, part.speed, part.beta)
        for name in (n for n in SHOWN if n in data.loads):
            shown[name] = constants_panels.measured_and_modelled(name, part, getattr(now, name))
        if settled:
            before = rotor_of(session.model).loads(part.omega, part.speed, part.beta)
            tables = [constants_panels.errors(part, before, now)]
        return Answer(shown, tables, remarks, key)

    def shell(self, session: Session, values: Values) -> str:
        """Loads with these constants, and the fit from them."""
        recipe = self._recipe(session, values)
        lines = [["predict", recipe.prop, *point_lines(values), *recipe.options]]
        if values["data"] != "none" and values["free"]:
            data = values["data"]
            if data == "file":
                data = recipe.file("data")
            lines.append(
                [
                    *("fit", "tunnel", recipe.prop, data, *recipe.options),
                    *("--free", ",".join(values["free"]), "--starts", "1", "--folds", "0"),
                    *("-o", "fit.toml"),
                ]
            )
        return recipe.shell(*lines)

    def python(self, session: Session, values: Values) -> str:
        """Loads with these constants."""
        omega = f"{values['rpm']:.10g} * np.pi / 30.0"
        return self._recipe(session, values).python(
            f"print(rotor.loads({omega}, {values['speed']:.10g}, "
            f"np.radians({values['beta']:.10g})))"
        )

    def text(self, session: Session, values: Values, file: str) -> str:
        """The constants, or measured and modelled loads."""
        if file == CONSTANTS_FILE:
            return law_of(session, values).to_toml()
        data = session.measured(values["data"])
        if data is None:
            raise InputError("there are no measured loads", "choose or drop some")
        found = rotor_of(model_of(session, values)).loads(data.omega, data.speed, data.beta)
        columns = {
            "rpm": data.omega / RPM,
            "speed_mps": data.speed,
            "beta_deg": np.degrees(data.beta),
        }
        for name, measured in data.loads.items():
            columns[LOADS[name].column_of("measured")] = measured
            columns[LOADS[name].column_of("modelled")] = getattr(found, name)
        flat = [column.tolist() for column in columns.values()]
        rows = [dict(zip(columns, row, strict=True)) for row in zip(*flat, strict=True)]
        cells = [{k: v if np.isfinite(v) else None for k, v in row.items()} for row in rows]
        return csv_text(list(columns), cells)

    def more(self) -> list[Any]:
        """The button for a fit, and how far it is."""
        return [
            html.Button("fit now", id="fit", n_clicks=0),
            html.P("", id="progress", role="status"),
        ]

    def register(self, application: Application) -> None:
        """What the button does."""
        app = application.dash

        @app.callback(
            Output("job", "data"),
            Output("progress", "children", allow_duplicate=True),
            Input("fit", "n_clicks"),
            State({"control": _all()}, "value"),
            State({"control": _all()}, "id"),
            State("here", "data"),
            prevent_initial_call=True,
        )
        def _fit(clicks: Any, values: Any, ids: Any, here: Any) -> Any:
            if not clicks:
                raise PreventUpdate
            given = {one["control"]: value for one, value in zip(ids, values, strict=True)}
            try:
                session = application.session(here)
                found, _ = values_of(self.controls(session), given)
                task = Fit.of(session, found)
                return application.jobs.begin(task.run), "the fit begins"
            except InputError as error:
                return no_update, str(error)

        @app.callback(
            Output("progress", "children", allow_duplicate=True),
            Output("job", "data", allow_duplicate=True),
            Input("tick", "n_intervals"),
            State("job", "data"),
            prevent_initial_call=True,
        )
        def _tick(_: Any, name: Any) -> Any:
            if not isinstance(name, str):
                raise PreventUpdate
            job = application.jobs.get(name)
            if job is None:
                return "That fit is not known any more: begin it again.", None
            for constant, value in job.found.items():
                set_props({"control": constant}, {"value": value})
                set_props({"number": constant}, {"value": value})
            return job.line, None if job.done else no_update

    def _recipe(self, session: Session, values: Values) -> Recipe:
        same = law_of(session, values) is law_at_first(session)
        return Recipe(session) if same else Recipe(session, constants=law_of(session, values))


def _all() -> Any:
    from dash import ALL

    return ALL


def _some(data: TunnelData) -> TunnelData:
    if len(data) <= MOST:
        return data
    which = np.unique(np.linspace(0, len(data) - 1, MOST).astype(int))
    loads = {name: values[which] for name, values in data.loads.items()}
    return TunnelData(data.source, data.omega[which], data.speed[which], data.beta[which], loads)
