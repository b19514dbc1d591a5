"""The report on the benefit of each term of a flight fit, as a page and files."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from propmap.fit.comparison import FittedStep, RecordedFlight, gain, judged, measured_off
from propmap.report import html
from propmap.typing import Floats
from propmap.vehicle.vehicle import Vehicle

AXES = ("x", "y", "z")
VERDICTS = {"pays": "lower error", "makes it worse": "higher error"}  # page labels
HOVER_MODEL, PREDICTION = "hover model", "prediction in the file"

StepErrors = Mapping[tuple[str, str, bool, bool], Floats]
"""Rms errors along x, y, z (3,) [N] by model, flight, whether unfiltered, whether fitted."""


def terms_pages(
    vehicle: Vehicle,
    flights: Sequence[RecordedFlight],
    found: Sequence[FittedStep],
    *,
    low_pass: float,
    samples: int,
    remarks: Sequence[str],
) -> dict[str, str | bytes]:
    """Return all files of the report by name; ``found`` is the result of ``fit_terms``.

    The signals are low-passed at ``low_pass`` [Hz]; a fit uses at most ``samples`` samples.
    """
    off, worths = step_errors(vehicle, flights, found), worth(flights, found)
    alone, steps = len(flights) == 1, steps_of(found)
    names = [f.name for f in flights]
    models = list(dict.fromkeys(model for model, *_ in off))
    final = {flight: off[steps[-1], flight, False, alone] for flight in names}

    def cells(flight: str, *, raw: bool) -> list[tuple[str, ...]]:
        rows = []
        for model in models:
            unseen, seen = (off.get((model, flight, raw, fitted)) for fitted in (False, True))
            each = [seen if unseen is None else unseen] if alone else [unseen, seen]
            shown = [3 * [""] if e is None else [html.number(x) for x in e] for e in each]
            rows.append((model, *itertools.chain(*shown)))
        return rows

    below = []
    for flight, errors in final.items():
        own = off.get((PREDICTION, flight, False, False), np.full(3, np.nan))
        if axes := [axis for axis, one in zip(AXES, errors <= own, strict=True) if one]:
            below.append(f"{flight} along {' and '.join(axes)}")
    return html.record_files(
        "report/terms_page.html.j2",
        [
            errors_by_step(off, names, steps),
            html.FigureRecord(
                "fit-terms-values",
                html.columns_of(
                    "step left_out parameter value",
                    [
                        (f.step, "" if f.left_out is None else names[f.left_out], name, value)
                        for f in found
                        for name, value in f.values.items()
                    ],
                ),
            ),
            html.FigureRecord(
                "fit-terms-worth",
                html.columns_of("step verdict fall_N2 standard_deviation_N2", worths),
                cells=[
                    (step, VERDICTS.get(word, "not significant"), html.number(a), html.number(b, 2))
                    for step, word, a, b in worths
                ],
            ),
        ],
        name=vehicle.name,
        flights=names,
        seconds=[float(np.ptp(f.passed.time)) for f in flights],
        alone=alone,
        tables={flight: cells(flight, raw=False) for flight in names},
        raw_tables={flight: cells(flight, raw=True) for flight in names},
        pays=[step for step, word, *_ in worths if word == "pays"],
        worse=[step for step, word, *_ in worths if word == "makes it worse"],
        unsure=[step for step, word, *_ in worths if word == "no sure gain"],
        final=[(flight, *(html.number(x, 2) for x in errors)) for flight, errors in final.items()],
        below=below,
        predicted=PREDICTION in models,
        low_pass=low_pass,
        samples=samples,
        remarks=list(remarks),
    )


def errors_by_step(
    off: StepErrors, flights: Sequence[str], steps: Sequence[str]
) -> html.FigureRecord:
    """Return the errors along each axis by step; filled markers are held-out flights."""
    several = len(flights) > 1
    predicted = any(model == PREDICTION for model, *_ in off)

    def draw() -> Figure:
        figure = html.new_figure(9.0, 1.6 + 0.34 * len(steps))
        panels = figure.subplots(1, 3, sharey=True)
        place = np.arange(len(steps))
        for axis, ax in enumerate(panels):
            for k, flight in enumerate(flights):
                look = html.marked(k % len(html.COLORS))
                kept = [off[step, flight, False, not several][axis] for step in steps]
                ax.plot(kept, place, linewidth=1.4, markersize=5.0, **look)
                if several:
                    seen = [off[step, flight, False, True][axis] for step in steps]
                    hollow = {**look, "markerfacecolor": "white"}
                    ax.plot(seen, place, linestyle=":", linewidth=0.9, markersize=4.0, **hollow)
                if (own := off.get((PREDICTION, flight, False, False))) is not None:
                    ax.axvline(own[axis], **{**html.DASHED, "color": look["color"]})
            ax.set(xlim=(0.0, None), xlabel="rms error [N]", title=f"force along {AXES[axis]}")
        panels[0].set_yticks(place, steps)
        panels[0].invert_yaxis()
        keys = [
            html.key(flight, linewidth=1.4, **html.marked(k % len(html.COLORS)))
            for k, flight in enumerate(flights)
        ]
        if several:
            hollow = {"color": "0.35", "marker": "o", "markerfacecolor": "white"}
            keys.append(html.key("fitted flights", linestyle=":", **hollow))
        if predicted:
            keys.append(html.key(PREDICTION, **html.HOVER))
        html.legend_below(figure, keys)
        return figure

    rows = [
        (model, flight, "as recorded" if raw else "low-passed", "yes" if fitted else "no", *errors)
        for (model, flight, raw, fitted), errors in off.items()
    ]
    heads = "model flight signals fitted_to_it x_rms_N y_rms_N z_rms_N"
    return html.FigureRecord("fit-terms", html.columns_of(heads, rows), draw)


def step_errors(
    vehicle: Vehicle, flights: Sequence[RecordedFlight], found: Sequence[FittedStep]
) -> StepErrors:
    """Return the errors by flight: hover model, all steps, prediction in the file."""
    off: dict[tuple[str, str, bool, bool], Floats] = {}
    for k, flight in enumerate(flights):
        hover = found[-1].hover[k]
        off[HOVER_MODEL, flight.name, False, False] = hover.rms
        off[HOVER_MODEL, flight.name, True, False] = hover.raw_rms
        for step in steps_of(found):
            for raw, fitted in itertools.product((False, True), (False, True)):
                mine = [one for one in found if one.step == step and (one.left_out != k) == fitted]
                each = [one.off[k].raw_rms if raw else one.off[k].rms for one in mine]
                if each:
                    mean = np.sqrt(np.mean(np.square(each), axis=0))
                    off[step, flight.name, raw, fitted] = mean
        own = measured_off(vehicle, flight)
        if own is not None:
            off[PREDICTION, flight.name, False, False] = own.rms
            off[PREDICTION, flight.name, True, False] = own.raw_rms
    return off


def worth(
    flights: Sequence[RecordedFlight], found: Sequence[FittedStep]
) -> list[tuple[str, str, float, float]]:
    """Return name, verdict, reduction of the mean square force error and its standard deviation
    [N^2] of each step except the first, on held-out flights or on the only flight."""
    unseen = {
        step: [f.off[f.left_out or 0] for f in found if f.step == step] for step in steps_of(found)
    }
    worths = []
    for old, new in itertools.pairwise(unseen):
        fall, deviation = gain(unseen[old], unseen[new], flights)
        worths.append((new, judged(fall, deviation), fall, deviation))
    return worths


def steps_of(found: Sequence[FittedStep]) -> list[str]:
    """Return the names of the steps in order."""
    return list(dict.fromkeys(f.step for f in found))
