"""Whether a fit can be trusted, and where."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from propmap.fit.fit_record import FitRecord, FittedLoad
from propmap.loads import LOADS
from propmap.report.page import number

GOOD, CARE = 0.05, 0.15
"""Rms error as a share of what was measured, up to which a load is trusted, or with care."""

WORDS = {"good": "Yes", "caution": "With care", "bad": "No"}
"""Levels of trust, from best to worst, in words."""

FORCES = {
    "vertical_force": "vertical force",
    "force_x": "force forward",
    "force_y": "force to the side",
    "force_z": "force up",
}
"""What is fitted in flight, in words."""

NARROW = 2.0
"""Range of speeds [m/s] below which the data are from one speed."""

OVERFITTED = 1.5
"""Cross-validated error over the error left, above which parameters follow the noise."""


@dataclass(frozen=True)
class Judged:
    """One load: its typical error and the hover model's, as shares of ``reference`` [unit]."""

    load: FittedLoad
    reference: float
    error: float
    hover: float

    @property
    def label(self) -> str:
        """The load in words."""
        return label_of(self.load.name)

    @property
    def level(self) -> str:
        """By the error, and never better than "caution" where the hover model is as good."""
        found = level_of(self.error)
        return "caution" if found == "good" and not self.error < self.hover else found

    def both(self, rms: float, hover_rms: float) -> str:
        """Errors [unit] of this model and of the hover model as shares of the reference [%]."""
        own, hover = (number(100.0 * value / self.reference, 2) for value in (rms, hover_rms))
        return f"{own} / {hover}"


def overall(fit: FitRecord) -> str:
    """The level of trust in a fit, one of ``WORDS``, by the errors on its data."""
    levels = [one.level for one in judged(fit)]
    return worst_of([*levels, "caution"] if warnings(fit) else levels)


def judged(fit: FitRecord) -> list[Judged]:
    """Every fitted load; its error is the cross-validated one where there is one.

    Forces on a vehicle are compared with the largest of them, which is about the weight: across
    the flight there is next to nothing to compare with.
    """
    sizes = [one.measured_rms for one in fit.loads]
    if fit.kind != "tunnel":
        sizes = len(sizes) * [max(filter(math.isfinite, sizes), default=math.nan)]
    found = []
    for one, size in zip(fit.loads, sizes, strict=True):
        error = one.cross_validated if math.isfinite(one.cross_validated) else one.rms
        found.append(Judged(one, size, error / size, one.hover_rms / size))
    return found


def label_of(name: str) -> str:
    """A load or a force in words."""
    return LOADS[name].label if name in LOADS else FORCES.get(name, name)


def level_of(share: float) -> str:
    """The level of trust for a relative error; NaN is bad."""
    if share <= GOOD:
        return "good"
    return "caution" if share <= CARE else "bad"


def worst_of(levels: Iterable[str]) -> str:
    """The worst of several levels."""
    return max(levels, key=list(WORDS).index)


def shown_band(band: str) -> str:
    """A band of speed with a dash and without a line break."""
    return band.replace("-", "\N{EN DASH}").replace(" ", "\N{NO-BREAK SPACE}")


def where(fit: FitRecord) -> str:
    """Speeds, rotational speeds and angles of the data."""
    covered = fit.covered
    (slow, fast), (low, high) = covered.speed, covered.rpm
    speeds = f"{slow:.1f} m/s" if fast - slow < 0.05 else f"{slow:.1f} to {fast:.1f} m/s"
    ends = [end for one in covered.main_angles for end in one.beta]
    if not ends:
        angles = "at rest only"
    elif max(ends) - min(ends) < 0.5:
        angles = f"β = {min(ends):.0f}°"
    else:
        angles = f"β from {min(ends):.0f}° to {max(ends):.0f}°"
    return f"{speeds}, {low:.0f} to {high:.0f} rpm, {angles}"


def speed_rows(fit: FitRecord) -> list[tuple[str, ...]]:
    """Speed, rows, both models' errors by load [%], and a word; a row per band of speed."""
    loads, rows = judged(fit), []
    for band in dict.fromkeys(band for one in fit.loads for band in one.by_speed):
        found = [one.load.by_speed.get(band) for one in loads]
        pairs = list(zip(loads, found, strict=True))
        cells = ["" if e is None else one.both(e.rms, e.hover_rms) for one, e in pairs]
        level = worst_of(level_of(e.rms / one.reference) for one, e in pairs if e)
        count = max(e.rows for e in found if e)
        rows.append((shown_band(band), str(count), *cells, WORDS[level]))
    return rows


def warnings(fit: FitRecord) -> list[str]:
    """What takes trust away."""
    found = []
    if fit.covered.speed[1] - fit.covered.speed[0] < NARROW:
        found.append("the data are from one speed: the fit has hardly been tested against speed")
    for one in judged(fit):
        if not one.error < one.hover:
            found.append(f"{one.label}: the hover model is no worse")
        ratio = one.load.cross_validated / one.load.rms if one.load.rms > 0.0 else math.nan
        if math.isfinite(ratio) and ratio > OVERFITTED:
            found.append(
                f"{one.label}: on rows left out the error is {ratio:.1f} times as large, so that "
                "some parameters follow the noise"
            )
    if fit.unsolved:
        found.append(f"of {fit.rows} rows, {fit.unsolved} have no solution in the model")
    return found


def notes(fit: FitRecord) -> list[str]:
    """What is worth knowing besides."""
    found = list(fit.remarks)
    if fit.minima > 1:
        found.append(
            f"{len(fit.starts)} starts ended in {fit.minima} different minima; the best is used"
        )
    if not any(math.isfinite(one.cross_validated) for one in fit.loads):
        found.append("no cross-validation was done: the errors are those on the fitted data")
    return found


def unfitted(fit: FitRecord) -> list[str]:
    """Loads that a fit of tunnel data did not see, in words."""
    names = [one.name for one in fit.loads]
    return [load.label for name, load in LOADS.items() if name not in names]
