"""Constants: section constants from sliders or a fit, and their errors on measured loads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from dash import ALL, Input, Output, State, html, no_update, set_props
from dash.exceptions import PreventUpdate

from propmap.errors import InputError
from propmap.explore import view
from propmap.explore.app import Job
from propmap.explore.session import CONSTANTS_FILE, Recipe, Session, rotor_of
from propmap.explore.view import Answer, Control, Download, Graph, Several, Slider, Table, Values
from propmap.fit.least_squares import Rows, rms_known
from propmap.fit.parameters import SECTION, Choice
from propmap.fit.tunnel import TunnelData
from propmap.model.airfoil import CONSTANTS, Airfoil
from propmap.model.model import Model
from propmap.report.html import COLORS
from propmap.typing import Floats
from propmap.units import RPM

SET = tuple(SECTION)  # constants with a slider
FREE = ("c_l1", "c_d", "alpha_0", "zero_lift_angle")
MOST = 400  # maximum number of measured points in the comparison
NAME = "errors.csv"
SHOWN = ("thrust", "drag", "torque", "roll_moment")
ALPHA = np.radians(np.linspace(-20.0, 60.0, 161))
BEFORE, AFTER = ("initial constants", view.GRAY, "dash"), ("current constants", COLORS[0])


class ConstantsView(view.View):
    """Comparison of section constants with measured loads."""

    name, title = "constants", "Constants"
    question = "Which section constants fit the measured loads, and how uncertain are they?"
    downloads = (Download(CONSTANTS_FILE, "constants as TOML"), Download(NAME, "errors as CSV"))

    def controls(self, session: Session) -> Sequence[Control]:
        """Return the controls."""
        law = law_at_first(session)
        known = session.model.uncertainty
        deviations = {}
        if known is not None:
            variances = np.diag(known.covariance.matrix)
            deviations = dict(zip(known.covariance.names, np.sqrt(variances), strict=True))
        sliders = []
        for name in SET:
            here, about = float(getattr(law, name)), SECTION[name]
            low, high = min(about.lower, here), max(about.upper, here)
            sure = deviations.get(name, np.nan)
            marked = (here - 1.96 * sure, here + 1.96 * sure) if np.isfinite(sure) else None
            coarse = about.unit != "rad" and high > 0.5
            step = (0.001, 0.01)[coarse]
            label = f"{name}, {about.meaning}"
            sliders.append(Slider(name, label, about.unit, low, high, step, here, marked))
        free = tuple((name, name) for name in SET)
        return [
            *sliders,
            view.data_choice(session),
            Several("free", "Free in the fit", free, FREE),
            *view.point_controls(session),
        ]

    def graphs(self, session: Session) -> Sequence[Graph]:
        """Return the places of the section curves, and of modeled against measured loads."""
        data = session.measured(next(iter(session.measurements()), "none"))
        names = [n for n in SHOWN if data is not None and n in data.loads] or ["thrust", "torque"]
        return [
            Graph("lift", "lift coefficient of the section"),
            Graph("section-drag", "drag coefficient of the section"),
            *(Graph(name, f"{view.LABELS[name]}, modeled against measured") for name in names),
        ]

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """Draw the section curves, and the errors on the data."""
        old, new = law_at_first(session), law_of(session, values)
        shown = _of_section(session.model, old, new)
        key = [(BEFORE[0], f"-{view.GRAY}"), AFTER]
        data = session.measured(values["data"])
        if data is None:
            return Answer(shown, (), ["Select or open measured loads to see the errors."], key)
        remarks, tables, part = [], [], data
        if len(data) > MOST:
            part = data.picked(np.unique(np.linspace(0, len(data) - 1, MOST).astype(int)))
            remarks.append(f"{data.source}: {len(part)} of {len(data)} points, evenly selected")
        flow = part.omega, part.speed, part.beta
        now = rotor_of(model_of(session, values)).loads(*flow)
        for name in (n for n in SHOWN if n in data.loads):
            shown[name] = _measured_and_modeled(name, part, getattr(now, name))
        if settled:
            tables = [_errors(part, rotor_of(session.model).loads(*flow), now)]
        return Answer(shown, tables, remarks, key)

    def shell(self, session: Session, values: Values) -> str:
        """Return commands for loads with these constants, and for a fit that starts from them."""
        recipe = self._recipe(session, values)
        lines = [recipe.predict(values)]
        if values["data"] != "none" and values["free"]:
            data = recipe.file("data") if values["data"] == "file" else values["data"]
            fit = ["fit", "tunnel", recipe.prop, data, *recipe.options, "--free"]
            fit += [",".join(values["free"]), "--starts", "1", "--folds", "0", "-o", "fit.toml"]
            lines.append(fit)
        return recipe.shell(*lines)

    def python(self, session: Session, values: Values) -> str:
        """Return code that prints the loads with these constants."""
        lines = f"print(rotor.loads({view.point_python(values)}))"
        return self._recipe(session, values).python(lines)

    def text(self, session: Session, values: Values, file: str) -> str:
        """Return the constants as TOML, or the CSV of measured loads from `propmap report`."""
        if file == CONSTANTS_FILE:
            return law_of(session, values).to_toml()
        data = session.measured(values["data"])
        if data is None:
            raise InputError("there are no measured loads", "select or open measured loads")
        from propmap.report.fit_curves import tunnel_fit

        return tunnel_fit(data, rotor_of(model_of(session, values))).csv()

    def more(self) -> list[Any]:
        """Return the button for a fit and a line for its progress."""
        button = html.Button("fit now", id="fit", n_clicks=0)
        return [button, html.P("", id="progress", role="status")]

    def register(self, application: view.Host) -> None:
        """Register the start of a fit and the display of its progress."""
        app = application.dash

        @app.callback(
            Output("job", "data"),
            Output("progress", "children", allow_duplicate=True),
            Input("fit", "n_clicks"),
            State({"control": ALL}, "value"),
            State({"control": ALL}, "id"),
            State("here", "data"),
            prevent_initial_call=True,
        )
        def _fit(clicks: Any, values: Any, ids: Any, here: Any) -> Any:
            if not clicks:
                raise PreventUpdate
            given = {one["control"]: value for one, value in zip(ids, values, strict=True)}
            try:
                session = application.session(here)
                found, _ = view.values_of(self.controls(session), given)
                task = fit_of(session, found)
                return application.jobs.begin(task.run), "the fit starts"
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
                return "The server no longer stores this fit: start it again.", None
            for constant, value in job.found.items():
                set_props({"control": constant}, {"value": value})
                set_props({"number": constant}, {"value": value})
            return job.line, None if job.done else no_update

    def _recipe(self, session: Session, values: Values) -> Recipe:
        law = law_of(session, values)
        return Recipe(session, constants=None if law is law_at_first(session) else law)


# --- Figures and table: section curves, and measured and modeled loads ---------------------------


def _of_section(model: Model, old: Airfoil, new: Airfoil) -> dict[str, view.Figure]:
    """Draw C_L and C_D over the angle of attack, at the Reynolds number of 0.75 R."""
    blade, air = model.propeller, model.air
    omega = 60.0 / blade.radius
    chord = np.interp(0.75 * blade.radius, blade.station, blade.chord)
    reynolds = np.full_like(
        ALPHA, air.density * 0.75 * blade.radius * omega * chord / air.viscosity
    )
    both = [law.coefficients(ALPHA, reynolds) for law in (old, new)]
    return {
        name: view.curves(
            np.degrees(ALPHA),
            [(both[0][k], *BEFORE), (both[1][k], *AFTER)],
            f"angle of attack [deg], Re = {reynolds[0]:.2g}",
            title,
            zero=True,
        )
        for k, name, title in (
            (0, "lift", "lift coefficient C_L [-]"),
            (1, "section-drag", "drag coefficient C_D [-]"),
        )
    }


def _measured_and_modeled(name: str, data: TunnelData, modeled: Floats) -> view.Figure:
    """Draw modeled against measured values (n,) of a load."""
    measured = data.loads[name]
    both = view.span(measured, modeled)
    ends = both["range"]
    words = [
        f"{w / RPM:.0f} rpm, {v:.3g} m/s, β {np.degrees(b):.3g}°"
        for w, v, b in zip(data.omega, data.speed, data.beta, strict=True)
    ]
    return view.figure(
        [
            view.line(ends, ends, "equal", view.GRAY, "dash", hoverinfo="skip"),
            view.points(
                measured,
                modeled,
                data.source,
                COLORS[0],
                text=words,
                hovertemplate="%{text}<br>measured %{x:.4g}, modeled %{y:.4g}<extra></extra>",
            ),
        ],
        f"measured {view.TITLES[name]}",
        "modeled",
        xaxis=both,
        yaxis=both,
    )


def _errors(data: TunnelData, before: Any, now: Any) -> Table:
    """Return a table of the rms errors of two sets of loads on the data."""
    rows = []
    for name, measured in data.loads.items():
        cells, size = [], rms_known(measured)
        for loads in (before, now):
            off = rms_known(getattr(loads, name) - measured)
            share = 100.0 * off / size if size else np.nan
            cells.append(f"{view.digits(off)} ({share:.1f} %)")
        rows.append([view.LABELS[name], *cells, view.UNITS[name]])
    caption = f"Rms errors on {data.source}; in brackets: relative to the rms of the load"
    return Table(("", BEFORE[0], AFTER[0], "unit"), rows, caption)


# --- Constants from the sliders, and their fit in the background ---------------------------------


def law_at_first(session: Session) -> Airfoil:
    """Return the initial constants of a session; raise ``InputError`` for a section table."""
    law = session.model.airfoil
    if not isinstance(law, Airfoil):
        raise InputError("a section table has no constants", "select a set of constants")
    return law


def law_of(session: Session, values: Values) -> Airfoil:
    """Return the constants of the sliders."""
    law = law_at_first(session)
    moved = [name for name in SET if values[name] != getattr(law, name)]
    changes = {name: float(np.clip(values[name], *CONSTANTS[name].limits)) for name in moved}
    if not changes:
        return law
    own = tuple(session.model.correction_texts)
    words = {"name": f"{law.name} changed"[:80], "source": "changed in propmap explore"}
    return law.with_parameters(**changes, **words, corrections=own)


def model_of(session: Session, values: Values) -> Model:
    """Return the model with the constants of the sliders."""
    law = law_of(session, values)
    return session.model if law is session.model.airfoil else session.model.with_airfoil(law)


class SliderFit(NamedTuple):
    """A fit to the data of a session that starts from the constants of the sliders."""

    model: Model
    data: TunnelData
    choice: Choice

    def run(self, job: Job) -> Mapping[str, float]:
        """Run the fit and report its progress to ``job``."""
        from propmap.fit.fit import Settings, fit
        from propmap.fit.tunnel import tunnel_rows

        rows = _reporting(tunnel_rows(self.model, self.data, self.choice), job)
        fitted = fit(rows, self.choice, Settings(starts=1, folds=0))
        errors = []
        for k, name in enumerate(fitted.rows.names):
            modeled, measured = fitted.compared(k)
            off = rms_known(modeled - measured) / rms_known(measured)
            errors.append(f"{name} {100.0 * off:.1f} %")
        half = 1.96 * np.sqrt(np.diag(fitted.uncertainty.covariance))
        constants = [
            f"{name} = {value:.4g} ± {one:.2g}"
            for name, value, one in zip(self.choice.free, fitted.x, half, strict=True)
        ]
        job.message = f"Fitted: {'; '.join(constants)}. Rms errors: {', '.join(errors)}."
        return dict(zip(self.choice.free, map(float, fitted.x), strict=True))


def fit_of(session: Session, values: Values) -> SliderFit:
    """Return the requested fit; raise ``InputError`` without data or free constants."""
    data, free = session.measured(values["data"]), tuple(values["free"])
    if data is None:
        raise InputError("there are no measured loads to fit", "select or open measured loads")
    if not free:
        raise InputError("no constant is free", "select the free constants")
    law = law_of(session, values)
    given = {name: float(getattr(law, name)) for name in SECTION}
    fixed = {name: value for name, value in given.items() if name not in free}
    start = {name: value for name, value in given.items() if name in free}
    return SliderFit(model_of(session, values), data, Choice(free, fixed, {}, start))


def _reporting(rows: Rows, job: Job) -> Rows:
    """Return rows that report the number of evaluations and the error to ``job``."""
    count = 0

    def model(values: Mapping[str, float], free: tuple[str, ...]) -> tuple[Floats, Floats]:
        nonlocal count
        found = rows.model(values, free)
        count += 1
        off = 100.0 * np.sqrt(np.nanmean(((found[0] - rows.measured) / rows.scale) ** 2))
        job.message = f"fitting: {count} evaluations, error {off:.2f} %"
        return found

    return replace(rows, model=model)
