"""A ranking as `propmap choose` shows it: a table, what it leaves open, and rows for files."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from typing import TYPE_CHECKING, Any

from propmap.cli.output import WideGrid, grid

if TYPE_CHECKING:
    from propmap.aircraft.ranking import Judged, Task

SHOWN = {"J": ("Wh", 3600.0), "s": ("min", 60.0), "m": ("km", 1000.0)}
"""Units of scores as tables show them, and how much of the unit in files that is."""


SURE = 0.95
"""Probability below which neighbours are said not to be separated."""


def table_of(task: Task, judged: list[Judged]) -> WideGrid:
    """The first of a ranking, ``judged`` for a ``task``, in a table."""
    from propmap.aircraft.ranking import beats

    unit, size = SHOWN.get(task.unit, (task.unit, 1.0))
    times = any(math.isfinite(one.hover_time) for one in judged)
    heads = ["", "<propeller", unit, "+-", "beats next", "1 beats it", "hover [W]"]
    heads += ["hover [min]"] if times else []
    cruise = task.speed is not None
    if cruise:
        heads += [f"{task.speed:g} m/s [W]", *([f"{task.speed:g} m/s [min]"] if times else [])]
    heads += ["margin", "top [m/s]", "<constants"]
    rows = []
    for k, one in enumerate(judged):
        cells = [
            str(k + 1),
            one.candidate.name,
            _digits(one.score / size),
            _digits(one.deviation / size, 2),
            _share(beats(one, judged[k + 1]) if k + 1 < len(judged) else math.nan),
            _share(beats(judged[0], one) if k else math.nan),
            _digits(one.hover_power),
            *([_digits(one.hover_time / 60.0, 3)] if times else []),
        ]
        if cruise:
            cells += [
                _digits(one.cruise_power),
                *([_digits(one.cruise_time / 60.0, 3)] if times else []),
            ]
        cells += [_digits(one.thrust_margin, 3), _digits(one.top_speed, 3)]
        cells.append("good" if one.candidate.verdict == "good" else "doubtful")
        rows.append(cells)
    caption = (
        "+-: one standard deviation, from that of the constants alone; beats next, 1 beats it: "
        "probability of being better than the next, and that the first is better than it, from the "
        "same; margin: thrust at the first limit over weight, in hover; doubtful constants: why, "
        "by --format csv"
    )
    speed = f"{task.speed:g} m/s" if cruise else ""
    spare = ("hover [min]", f"{speed} [min]", "margin", "top [m/s]", "1 beats it", f"{speed} [W]")
    title = f"ranked by {task.words} [{unit}]"
    return WideGrid("|".join(heads), rows, title, caption, spare)


def _share(probability: float) -> str:
    return f"{100.0 * probability:.0f} %" if math.isfinite(probability) else "-"


def told_of(judged: list[Judged], top: int, *, all_: bool) -> list[Any]:
    """What the uncertainty does not separate, and why the rest do not fit.

    Parameters
    ----------
    judged : list of Judged
        The whole ranking.
    top : int
        How many are compared closely.
    all_ : bool
        Whether all are shown.
    """
    from propmap.aircraft.ranking import beats
    from propmap.aircraft.trim import STATUSES

    fit = [one for one in judged if one.feasible]
    rest = [one for one in judged if not one.feasible]
    told: list[Any] = []
    close = [
        f"{k + 1} and {k + 2}"
        for k, (a, b) in enumerate(itertools.pairwise(fit[:top]))
        if beats(a, b) < SURE
    ]
    if close:
        told.append(f"neighbours not separated to {SURE:.0%}: {', '.join(close)}")
    level = [k + 2 for k, one in enumerate(fit[1:top]) if beats(fit[0], one) < SURE]
    if level:
        told.append(f"not separated from the first: {', '.join(map(str, level))}")
    limits = Counter(one.limit for one in fit[:top] if one.limit in STATUSES)
    if limits:
        words = (f"{STATUSES[name].removeprefix('beyond ')} ({n})" for name, n in limits.items())
        told.append(f"top speeds are limited by {', '.join(words)}")
    if len(fit) > top and not all_:
        told.append(f"{len(fit) - top} more fit: all are shown by --all, or --format csv")
    if not fit:
        told.append("no propeller fits; the closest reasons are below")
    if rest and (all_ or not fit):
        rows = [(one.candidate.name, one.why_not) for one in rest]
        told.append(grid("<propeller|<why not", rows, f"{len(rest)} that do not fit"))
    elif rest:
        told.append(f"{len(rest)} do not fit: why is shown by --all")
    return told


def rows_of(task: Task, judged: list[Judged]) -> list[dict[str, Any]]:
    """A mapping for each of a ranking, ``judged`` for a ``task``; None for NaN."""
    from propmap.aircraft.ranking import beats

    name = f"{task.ranked_by}_{task.unit.replace('/', '_per_')}"
    rows = []
    for k, one in enumerate(judged):
        following = judged[k + 1] if k + 1 < len(judged) else None
        sure = beats(one, following) if following is not None else math.nan
        numbers = {
            "diameter_m": one.candidate.propeller.diameter,
            name: one.score,
            "standard_deviation": one.deviation,
            "probability_beats_next": sure,
            "probability_first_beats": beats(judged[0], one) if k else math.nan,
            "hover_power_W": one.hover_power,
            "cruise_power_W": one.cruise_power,
            "hover_time_s": one.hover_time,
            "cruise_time_s": one.cruise_time,
            "thrust_margin": one.thrust_margin,
            "top_speed_mps": one.top_speed,
        }
        rows.append(
            {"propeller": one.candidate.name, "blades": one.candidate.propeller.blades}
            | {key: value if math.isfinite(value) else None for key, value in numbers.items()}
            | {"feasible": one.feasible, "top_speed_limit": one.limit, "why_not": one.why_not}
            | {"constants": one.candidate.verdict}
        )
    return rows


def _digits(value: float, digits: int = 4) -> str:
    return f"{value:.{digits}g}" if math.isfinite(value) else "-"
