"""The page on what each term of a flight fit is worth, and the files beside it."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from propmap.fit.comparison import (
    AxisErrors,
    FittedStep,
    RecordedFlight,
    gain,
    judged,
    measured_off,
)
from propmap.report.html import (
    DASHED,
    HOVER,
    csv_of_rows,
    key,
    legend_below,
    marked,
    new_figure,
    number,
    report_files,
    style,
)
from propmap.typing import Floats
from propmap.vehicle.vehicle import Vehicle

# -------------------------------------------------------------------------------------------------
# The page on what each term of a flight fit is worth, and the files beside it.

TERMS_FIGURE, VALUES_SHEET, WORTH_SHEET = "fit-terms", "fit-terms-values", "fit-terms-worth"
AXES = ("x", "y", "z")
COLOURS = 7


def terms_pages(
    vehicle: Vehicle,
    flights: Sequence[RecordedFlight],
    found: Sequence[FittedStep],
    *,
    low_pass: float,
    samples: int,
    remarks: Sequence[str],
) -> dict[str, str | bytes]:
    """All files of the page by name.

    Parameters
    ----------
    vehicle : Vehicle
        What flew.
    flights : sequence of RecordedFlight
        What was fitted.
    found : sequence of Fitted
        From ``fit_terms``.
    low_pass : float
        Cut-off of the low-passed signals [Hz].
    samples : int
        That each fit took, at most.
    remarks : sequence of str
        On the flights.
    """
    told, worths = rows(vehicle, flights, found), worth(flights, found)
    alone = len(flights) == 1
    last = steps_of(found)[-1]
    final = [r for r in told if r.model == last]
    return report_files(
        "report/terms_page.html.j2",
        {TERMS_FIGURE: terms_figure(told, flights, found)},
        {
            TERMS_FIGURE: errors_sheet(told),
            VALUES_SHEET: values_sheet(flights, found),
            WORTH_SHEET: csv_of_rows(
                "step verdict fall_N2 standard_deviation_N2",
                [(w.step, w.word, w.fall, w.deviation) for w in worths],
            ),
        },
        name=vehicle.name,
        flights=[f.name for f in flights],
        seconds=[float(np.ptp(f.passed.time)) for f in flights],
        alone=alone,
        tables={f.name: [_cells(r, alone) for r in told if r.flight == f.name] for f in flights},
        raw_tables={
            f.name: [_cells(r, alone, raw=True) for r in told if r.flight == f.name]
            for f in flights
        },
        worths=[(w.step, w.word, number(w.fall, 3), number(w.deviation, 2)) for w in worths],
        pays=[w.step for w in worths if w.word == "pays"],
        worse=[w.step for w in worths if w.word == "makes it worse"],
        unsure=[w.step for w in worths if w.word == "no sure gain"],
        last=last,
        final=[(r.flight, *(number(x, 2) for x in _checked(r))) for r in final],
        below=[text for r in final if (text := _below_prediction(r, told))],
        predicted=any(r.model == PREDICTION for r in told),
        low_pass=low_pass,
        samples=samples,
        remarks=list(remarks),
    )


@style()
def terms_figure(
    told: Sequence[Row], flights: Sequence[RecordedFlight], found: Sequence[FittedStep]
) -> Figure:
    """Errors along each axis as terms are added, on the flights left out.

    Parameters
    ----------
    told : sequence of Row
        Errors.
    flights, found : sequence of RecordedFlight, sequence of Fitted
        As for ``terms_pages``.
    """
    steps = steps_of(found)
    figure = new_figure(9.0, 1.6 + 0.34 * len(steps))
    panels = figure.subplots(1, 3, sharey=True)
    place = np.arange(len(steps))
    for axis, ax in enumerate(panels):
        for k, flight in enumerate(flights):
            look = marked(k % COLOURS)
            mine = {r.model: r for r in told if r.flight == flight.name}
            unseen = [_checked(mine[s])[axis] for s in steps]
            ax.plot(unseen, place, linewidth=1.4, markersize=5.0, **look)
            if len(flights) > 1:
                seen = [_known(mine[s].seen)[axis] for s in steps]
                hollow = {**look, "markerfacecolor": "white"}
                ax.plot(seen, place, linestyle=":", linewidth=0.9, markersize=4.0, **hollow)
            if PREDICTION in mine:
                ax.axvline(
                    _known(mine[PREDICTION].unseen)[axis], **{**DASHED, "color": look["color"]}
                )
        ax.set_xlim(left=0.0)
        ax.set_xlabel("rms error [N]")
        ax.set_title(f"force along {AXES[axis]}")
    panels[0].set_yticks(place, steps)
    panels[0].invert_yaxis()
    keys = [key(f.name, linewidth=1.4, **marked(k % COLOURS)) for k, f in enumerate(flights)]
    if len(flights) > 1:
        keys.append(
            key("fitted to it", color="0.35", linestyle=":", marker="o", markerfacecolor="white")
        )
    if any(r.model == PREDICTION for r in told):
        keys.append(key(PREDICTION, **{**HOVER, "color": "0.35"}))
    legend_below(figure, keys)
    return figure


def errors_sheet(told: Sequence[Row]) -> str:
    """Every error as CSV, one per row."""
    kinds = {
        ("low-passed", "no"): "unseen",
        ("low-passed", "yes"): "seen",
        ("as recorded", "no"): "raw_unseen",
        ("as recorded", "yes"): "raw_seen",
    }
    lines = []
    for row in told:
        for (signals, fitted), name in kinds.items():
            values = getattr(row, name)
            if values is not None:
                lines.append((row.model, row.flight, signals, fitted, *values.tolist()))
    return csv_of_rows("model flight signals fitted_to_it x_rms_N y_rms_N z_rms_N", lines)


def values_sheet(flights: Sequence[RecordedFlight], found: Sequence[FittedStep]) -> str:
    """What each fit found, as CSV."""
    return csv_of_rows(
        "step left_out parameter value",
        [
            (f.step, "" if f.left_out is None else flights[f.left_out].name, name, value)
            for f in found
            for name, value in f.values.items()
        ],
    )


def _checked(row: Row) -> Floats:
    """On the flight left out, or on the only one."""
    return _known(row.unseen if row.unseen is not None else row.seen)


def _known(values: Floats | None) -> Floats:
    return np.full(3, np.nan) if values is None else values


def _cells(row: Row, alone: bool, *, raw: bool = False) -> tuple[str, ...]:
    unseen, seen = (row.raw_unseen, row.raw_seen) if raw else (row.unseen, row.seen)
    if alone:
        unseen = seen if unseen is None else unseen
        return row.model, *(number(x, 3) for x in _known(unseen))
    if row.model in (HOVER_MODEL, PREDICTION):
        return row.model, *(number(x, 3) for x in _known(unseen)), "", "", ""
    return (
        row.model,
        *(number(x, 3) for x in _known(unseen)),
        *(number(x, 3) for x in _known(seen)),
    )


def _below_prediction(row: Row, told: Sequence[Row]) -> str:
    """The flight, and along which axes its errors are below those of the prediction."""
    own = [r for r in told if r.model == PREDICTION and r.flight == row.flight]
    if not own:
        return ""
    below = _checked(row) <= _known(own[0].unseen)
    axes = [axis for axis, one in zip(AXES, below, strict=True) if one]
    return f"{row.flight} along {' and '.join(axes)}" if axes else ""


# -------------------------------------------------------------------------------------------------
# Errors of each step on each flight, as numbers for tables, files and the picture.

HOVER_MODEL, PREDICTION = "hover model", "prediction in the file"


@dataclass(frozen=True, eq=False)
class Row:
    """Errors of one model on one flight, root mean squares along x, y and z [N].

    Attributes
    ----------
    model, flight : str
        Which.
    seen, unseen, raw_seen, raw_unseen : ndarray, shape (3,), or None
        Of fits to the flight and of the fit without it, low-passed and as recorded; None where
        there is none.
    """

    model: str
    flight: str
    seen: Floats | None
    unseen: Floats | None
    raw_seen: Floats | None
    raw_unseen: Floats | None


@dataclass(frozen=True)
class Worth:
    """What one step changes on flights that it has not seen, or on the only one.

    Attributes
    ----------
    step, word : str
        Which, and whether it pays.
    fall, deviation : float
        By how much the mean square of the force's error falls, and its standard deviation [N^2].
    """

    step: str
    word: str
    fall: float
    deviation: float


def rows(
    vehicle: Vehicle, flights: Sequence[RecordedFlight], found: Sequence[FittedStep]
) -> list[Row]:
    """Hover model, steps in order, and the prediction that comes with the data, flight by flight.

    Parameters
    ----------
    vehicle : Vehicle
        What flew.
    flights : sequence of RecordedFlight
        What was fitted.
    found : sequence of Fitted
        From ``fit_terms``.
    """
    told = []
    for k, flight in enumerate(flights):
        hover = _own(found[-1].hover[k])
        told.append(Row(HOVER_MODEL, flight.name, None, hover[0], None, hover[1]))
        for step in steps_of(found):
            fits = [f for f in found if f.step == step]
            seen = [f.off[k] for f in fits if f.left_out != k]
            unseen = [f.off[k] for f in fits if f.left_out == k]
            told.append(
                Row(
                    step,
                    flight.name,
                    _mean([off.rms for off in seen]),
                    _mean([off.rms for off in unseen]),
                    _mean([off.raw_rms for off in seen]),
                    _mean([off.raw_rms for off in unseen]),
                )
            )
        own = measured_off(vehicle, flight)
        if own is not None:
            told.append(Row(PREDICTION, flight.name, None, own.rms, None, own.raw_rms))
    return told


def worth(flights: Sequence[RecordedFlight], found: Sequence[FittedStep]) -> list[Worth]:
    """What each step but the first changes, on flights that its fits have not seen.

    Parameters
    ----------
    flights, found : sequence of RecordedFlight, sequence of Fitted
        As for ``rows``.
    """
    steps = steps_of(found)
    told = []
    for old, new in itertools.pairwise(steps):
        fall, deviation = gain(_unseen(old, found), _unseen(new, found), flights)
        told.append(Worth(new, judged(fall, deviation), fall, deviation))
    return told


def steps_of(found: Sequence[FittedStep]) -> list[str]:
    """Names of the steps of ``found``, in order."""
    return list(dict.fromkeys(f.step for f in found))


def _unseen(step: str, found: Sequence[FittedStep]) -> list[AxisErrors]:
    """One per flight."""
    fits = [f for f in found if f.step == step]
    return [f.off[f.left_out or 0] for f in fits]


def _own(off: AxisErrors) -> tuple[Floats, Floats]:
    return off.rms, off.raw_rms


def _mean(rms: Sequence[Floats]) -> Floats | None:
    """The root of the mean square of several; None of none."""
    if not rms:
        return None
    found: Floats = np.sqrt(np.mean(np.square(rms), axis=0))
    return found
