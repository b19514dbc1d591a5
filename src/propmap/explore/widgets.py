"""What is set and chosen on a page: fields, sliders, choices."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import dash

from propmap.catalogue import names
from propmap.explore.controls import Choice, Control, Slider, Text, Values
from propmap.explore.session import KNOWN, PHYSICS, Session
from propmap.model.airfoil import airfoil_names

html: Any = dash.html
dcc: Any = dash.dcc

KINDS = {
    "geometry": "propeller",
    "constants": "constants",
    "fit": "fit",
    "table": "table",
    "vehicle": "vehicle",
    "data": "measured loads",
}


def subject(session: Session | None) -> Any:
    """What is explored, to be changed."""
    session = session or Session()
    files = [
        html.Li(
            [
                f"{KINDS[kind]}: {given.name} ",
                html.Button("remove", id={"remove": kind}, className="quiet", n_clicks=0,
                            **{"aria-label": f"remove {given.name}"}),
            ]
        )
        for kind, given in session.files.items()
    ]  # fmt: skip
    laws = ((KNOWN, "best known"), *((name, name) for name in airfoil_names()))
    physics = (("", "as the constants"), *((name, name) for name in PHYSICS))
    return html.Div(
        [
            html.Div(
                [
                    html.Label("Propeller", htmlFor="prop"),
                    dcc.Input(id="prop", type="text", value=session.name, debounce=True,
                              list="props", maxLength=80, autoComplete="off", className="text"),
                    html.Datalist([html.Option(value=name) for name in names()], id="props"),
                ],
                className="field",
            ),
            radio("law", "Constants", laws, session.law),
            radio("physics", "Physics", physics, session.physics),
            html.Div(
                dcc.Upload(
                    html.Button("Open a file, or drop it here", className="quiet", type="button"),
                    id="upload",
                    max_size=-1,
                    className="drop",
                ),
                className="field",
            ),
            html.Ul(files, className="files") if files else html.Span(),
            html.P("", id="trouble", role="alert", className="trouble"),
        ],
        className="subject",
    )  # fmt: skip


def radio(name: str, label: str, options: Sequence[tuple[str, str]], value: str) -> Any:
    """A choice behind a heading that says what is chosen."""
    told = dict(options).get(value, value)
    return html.Details(
        [
            html.Summary([f"{label}: ", html.Em(told)]),
            dcc.RadioItems(
                id=name,
                options=[{"value": key, "label": text} for key, text in options],
                value=value,
                className="options",
            ),
        ],
        className="field",
    )


def settings(controls: Sequence[Control], values: Values) -> list[Any]:
    """The controls, in their groups."""
    found: list[Any] = []
    groups: dict[str, list[Any]] = {}
    for control in controls:
        one = setting(control, values[control.name])
        if control.group:
            if control.group not in groups:
                groups[control.group] = []
                found.append((control.group, groups[control.group]))
            groups[control.group].append(one)
        else:
            found.append(one)
    return [
        html.Fieldset([html.Legend(item[0]), *item[1]]) if isinstance(item, tuple) else item
        for item in found
    ]


def setting(control: Control, value: Any) -> Any:
    """A control with its label."""
    key = {"control": control.name}
    target = json.dumps(key, separators=(",", ":"))
    if isinstance(control, Slider):
        number = {"number": control.name}
        unit = f" [{control.unit}]" if control.unit else ""
        parts: list[Any] = [
            html.Label(f"{control.label}{unit}", htmlFor=target),
            html.Div(
                [
                    dcc.Input(id=key, type="range", min=control.low, max=control.high,
                              step=control.step, value=value, className="range"),
                    html.Label(f"{control.label}, as a number", className="unseen",
                               htmlFor=json.dumps(number, separators=(",", ":"))),
                    dcc.Input(id=number, type="number", min=control.low, max=control.high,
                              step="any", value=value, debounce=True, className="number"),
                ],
                className="slider",
            ),
        ]  # fmt: skip
        if control.marked is not None:
            parts.append(_mark(control))
        return html.Div(parts, className="field")
    if isinstance(control, Text):
        return html.Div(
            [
                html.Label(control.label, htmlFor=target),
                dcc.Input(id=key, type="text", value=value, debounce=True, className="text"),
            ],
            className="field",
        )
    options = [{"value": key_, "label": text} for key_, text in control.options]
    make = dcc.RadioItems if isinstance(control, Choice) else dcc.Checklist
    return html.Fieldset(
        [
            html.Legend(control.label),
            make(id=key, options=options, value=value, className="options"),
        ],
        className="field",
    )


def _mark(control: Slider) -> Any:
    """The marked range under a slider."""
    assert control.marked is not None
    low, high = (
        100.0 * min(max((end - control.low) / (control.high - control.low), 0.0), 1.0)
        for end in control.marked
    )
    return html.Div(
        [
            html.Div(
                html.Span(style={"left": f"{low:.2f}%", "width": f"{max(high - low, 0.6):.2f}%"}),
                className="interval",
            ),
            html.Small(f"95 %: {control.marked[0]:.4g} to {control.marked[1]:.4g}"),
        ]
    )
