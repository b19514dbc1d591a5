"""Whether a fit can be trusted, and where: figures first, then words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from propmap.fit.fit_record import FitRecord, FittedLoad
from propmap.fit.residuals import Errors
from propmap.loads import LOADS
from propmap.report.page import Points, Table, Verdict, number, percent

GOOD, CARE = 0.05, 0.15
"""Rms error as a share of what was measured, up to which a load is trusted, or with care."""

LEVELS = ("good", "caution", "bad")
WORDS = {"good": "Yes", "caution": "With care", "bad": "No"}

NAMES = {
    **{name: load.label for name, load in LOADS.items()},
    "vertical_force": "vertical force",
    "force_x": "force forward",
    "force_y": "force to the side",
    "force_z": "force up",
}

NARROW = 2.0
"""Range of speeds [m/s] below which the data are from one speed."""

OVERFITTED = 1.5
"""Cross-validated error over the error left, above which parameters follow the noise."""


@dataclass(frozen=True)
class Judged:
    """One load: typical error, and the hover model's, as shares of ``reference`` [unit]."""

    load: FittedLoad
    reference: float
    error: float
    hover: float

    @property
    def level(self) -> str:
        """By the error, and never better than "caution" where the hover model is as good."""
        found = level_of(self.error)
        return "caution" if found == "good" and not self.error < self.hover else found


def judged(fit: FitRecord) -> list[Judged]:
    """Every fitted load; the error is the cross-validated one where there is one.

    Forces on a vehicle are compared with the largest of them, which is about the weight: across
    the flight there is next to nothing to compare with.
    """
    forces = [one.measured_rms for one in fit.loads] if fit.kind != "tunnel" else []
    largest = max((size for size in forces if math.isfinite(size)), default=math.nan)
    found = []
    for one in fit.loads:
        reference = largest if forces else one.measured_rms
        crossed = one.cross_validated
        error = crossed if math.isfinite(crossed) else one.rms
        found.append(Judged(one, reference, error / reference, one.hover_rms / reference))
    return found


def level_of(share: float) -> str:
    """One of ``LEVELS`` for an error; no number is no good."""
    if share <= GOOD:
        return "good"
    return "caution" if share <= CARE else "bad"


def worst_of(levels: Sequence[str]) -> str:
    """The worst of several levels."""
    return max(levels, key=LEVELS.index)


def lead(fit: FitRecord) -> tuple[Verdict | Table | Points, ...]:
    """The answer: overall, by load, by speed, and what is against it."""
    loads = judged(fit)
    warnings, notes = _warnings(fit, loads), _notes(fit, loads)
    level = worst_of([*(one.level for one in loads), *(["caution"] if warnings else [])])
    errors = ", ".join(
        f"{NAMES.get(j.load.name, j.load.name)} within {percent(j.error)} (hover model "
        f"{percent(j.hover)})"
        for j in loads
    )
    text = f"Where there were data, {where(fit)}, the typical error is: {errors}. "
    text += {
        "good": "Use it there.",
        "caution": "Use it there with these errors in mind.",
        "bad": "These errors are too large to rely on it.",
    }[level]
    verdict = Verdict(level, WORDS[level], text)
    outside = Verdict(
        "caution",
        "Outside the data",
        "Every number is an extrapolation by the theory, which nothing here has tested. "
        + _not_fitted(fit),
    )
    blocks: list[Verdict | Table | Points] = [verdict, outside, speed_table(fit, loads)]
    if warnings or notes:
        blocks.append(Points(tuple(_sentence(text) for text in (*warnings, *notes))))
    return tuple(blocks)


def where(fit: FitRecord) -> str:
    """Speeds, rotational speeds and angles of the data in words."""
    speeds = f"{fit.covered.speed[0]:.1f} to {fit.covered.speed[1]:.1f} m/s"
    if fit.covered.speed[1] - fit.covered.speed[0] < 0.05:
        speeds = f"{fit.covered.speed[0]:.1f} m/s"
    told = f"{speeds}, {fit.covered.rpm[0]:.0f} to {fit.covered.rpm[1]:.0f} rpm"
    ends = [end for one in fit.covered.main_angles for end in one.beta]
    if not ends:
        return f"{told}, at rest only"
    if max(ends) - min(ends) < 0.5:
        return f"{told}, β = {min(ends):.0f}°"
    return f"{told}, β from {min(ends):.0f}° to {max(ends):.0f}°"


def speed_table(fit: FitRecord, loads: Sequence[Judged]) -> Table:
    """A line per band of speed: errors of both models, and a word."""
    bands = list(dict.fromkeys(band for one in fit.loads for band in one.by_speed))
    rows = []
    for band in bands:
        cells, levels, count = [], [], 0
        for j in loads:
            e = j.load.by_speed.get(band)
            if e is None:
                cells.append("")
                continue
            count = max(count, e.rows)
            cells.append(_both(e, j.reference))
            levels.append(level_of(e.rms / j.reference))
        rows.append((shown_band(band), str(count), *cells, WORDS[worst_of(levels)]))
    columns = [("speed", ""), ("rows", "-")]
    columns += [(NAMES.get(j.load.name, j.load.name), "%") for j in loads]
    kind = (
        "the load's own root mean square over all data"
        if fit.kind == "tunnel"
        else "the largest force, about the weight"
    )
    return Table(
        "Can I trust it at my speeds? Rms error of this model / of the hover model, as a share of "
        f"{kind}.",
        (*columns, ("trust it", "")),
        tuple(rows),
        f"Yes: all errors up to {100 * GOOD:.0f} %. With care: up to {100 * CARE:.0f} %. No: more. "
        "These are errors on the fitted data; speeds without a line had no data.",
    )


def shown_band(band: str) -> str:
    """A band of speed in one piece, with a dash."""
    return band.replace("-", "\N{EN DASH}").replace(" ", "\N{NO-BREAK SPACE}")


def _both(e: Errors, reference: float) -> str:
    return f"{number(100.0 * e.rms / reference, 2)} / {number(100.0 * e.hover_rms / reference, 2)}"


def _not_fitted(fit: FitRecord) -> str:
    if fit.kind != "tunnel":
        return (
            "The fit saw sums of forces over all rotors: torque and moments were not "
            "measured at all."
        )
    fitted = [one.name for one in fit.loads]
    missing = [load.label for name, load in LOADS.items() if name not in fitted]
    if not missing:
        return ""
    told = f"So are {' and '.join(missing)} at any speed: no data of these were fitted."
    if len(missing) == 1:
        told = f"So is {missing[0]} at any speed: no data of it were fitted."
    drag = " Published sources of rotor drag differ by a factor of two." if _no_drag(fit) else ""
    return told + drag


def _no_drag(fit: FitRecord) -> bool:
    return "drag" not in [one.name for one in fit.loads]


def _warnings(fit: FitRecord, loads: Sequence[Judged]) -> list[str]:
    """What takes trust away, a sentence each."""
    told = []
    if fit.covered.speed[1] - fit.covered.speed[0] < NARROW:
        told.append("the data are from one speed: the fit has hardly been tested against speed")
    for j in loads:
        name = NAMES.get(j.load.name, j.load.name)
        if not j.error < j.hover:
            told.append(f"{name}: the hover model is no worse")
        crossed = j.load.cross_validated
        if math.isfinite(crossed) and crossed > OVERFITTED * j.load.rms:
            told.append(
                f"{name}: on rows left out the error is {crossed / j.load.rms:.1f} times as "
                "large, so that some parameters follow the noise"
            )
    if fit.unsolved:
        told.append(f"of {fit.rows} rows, {fit.unsolved} have no solution in the model")
    return told


def _notes(fit: FitRecord, loads: Sequence[Judged]) -> list[str]:
    """What is worth knowing besides, a sentence each."""
    told = list(fit.remarks)
    if fit.minima > 1:
        told.append(
            f"{len(fit.starts)} starts ended in {fit.minima} different minima; the best is used"
        )
    if not any(math.isfinite(j.load.cross_validated) for j in loads):
        told.append("no cross-validation was done: the errors are those on the fitted data")
    return told


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")
