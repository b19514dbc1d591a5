"""The blade to expect of a propeller that is known by diameter, pitch and number of blades alone.

Propellers of one series are alike: chord over radius, and the twist less that of a screw with the
labelled pitch, hardly change with the size.  Their means over the measured blades of the series,
or over all series with one vote each, make a blade of any size.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from propmap import catalogue
from propmap.arrays.types import Floats
from propmap.catalogue.designation import Designation, designation, same_size, series_named
from propmap.catalogue.identified import Identified, all_identified, identified_without_blade
from propmap.model.propeller import Propeller

SHARES = np.linspace(0.15, 1.0, 18)
"""Radii over the tip radius at which blades are averaged, those of most measured blades."""

ERRORS = {
    "family_blade": ((0.09, 0.08), (0.23, 0.21)),
    "siblings_label": ((0.09, 0.10), (0.18, 0.22)),
    "population_blade": ((0.20, 0.19), (0.40, 0.41)),
}
"""Of C_T and C_P of propellers that were left out, blade and section constants alike, rms over rms,
by ``python -m tools.left_out``: half of them err less than the first two, nine in ten less than the
others; by the group there."""


class MeasuredShape(NamedTuple):
    """A blade without its size.

    Attributes
    ----------
    family : str
        Code of its series.
    size : tuple of float
        Labelled diameter and pitch [m]; blades of one series and size are one propeller.
    chord : ndarray, shape (18,)
        Over the tip radius at ``SHARES`` [-]; NaN inward of the first measured station.
    offset : ndarray, shape (18,)
        Twist less ``screw_angle`` there [rad]; NaN likewise.
    """

    family: str
    size: tuple[float, float]
    chord: Floats
    offset: Floats


@dataclass(frozen=True, eq=False)
class MeanBlade:
    """Mean chord and twist of a series or of several, with their spread.

    Attributes
    ----------
    families : tuple of str
        The series that were averaged, each with one vote.
    propellers : int
        Number of measured propellers in them.
    share : ndarray, shape (n,)
        Radii over the tip radius [-], from where most members' blades begin to 1.
    chord : ndarray, shape (n,)
        Over the tip radius [-].
    offset : ndarray, shape (n,)
        Twist less that of a screw with the labelled pitch [rad].
    chord_within, offset_within : ndarray, shape (n,)
        Standard deviations between the propellers of a series, over all series [-], [rad].
    chord_between, offset_between : ndarray, shape (n,)
        Standard deviations between the means of series, over all series [-], [rad]; these and
        those within are NaN where there are too few blades.
    """

    families: tuple[str, ...]
    propellers: int
    share: Floats
    chord: Floats
    offset: Floats
    chord_within: Floats
    offset_within: Floats
    chord_between: Floats
    offset_between: Floats

    def propeller(self, name: str, diameter: float, pitch: float, blades: int) -> Propeller:
        """A propeller of this shape.

        Parameters
        ----------
        name : str
            What it is called.
        diameter, pitch : float
            As labelled [m].
        blades : int
            Number of blades.
        """
        radius = 0.5 * diameter
        of = self.families[0] if len(self.families) == 1 else f"{len(self.families)} series"
        return Propeller(
            name=name,
            blades=blades,
            station=self.share * radius,
            chord=self.chord * radius,
            twist=self.offset + screw_angle(self.share, pitch / diameter),
            source=f"not measured: chord over radius, and twist less that of a screw of the "
            f"labelled pitch, are the means of {self.propellers} propellers of {of}",
            citation="geometry: that of the propellers of the catalogue",
        )


@dataclass(frozen=True, eq=False)
class ExpectedBlade:
    """What a designation means that no measured propeller has.

    Attributes
    ----------
    text : str
        The designation as it was given.
    wanted : Designation
        What it says.
    families : tuple of str
        Codes of the series that its words name, or of the series of the maker.
    unknown : tuple of str
        Its words that name no series.
    shape : MeanBlade
        Of the measured blades of these series, or of all.
    own : Identified or None
        Constants that were identified with this blade, from the propeller's own loads.
    alike : tuple of str
        Names of other propellers of this size that it may be.
    """

    text: str
    wanted: Designation
    families: tuple[str, ...]
    unknown: tuple[str, ...]
    shape: MeanBlade
    own: Identified | None = None
    alike: tuple[str, ...] = ()

    @property
    def family(self) -> str | None:
        """Code of the series; None where it is not known."""
        return self.families[0] if len(self.families) == 1 else None

    @property
    def geometry(self) -> str:
        """Whose mean the blade is, "family" or "population", as ``expected_constants`` takes it."""
        return "family" if self.shape.families == self.families[:1] else "population"

    @property
    def propeller(self) -> Propeller:
        """The blade; two of them where the designation does not say how many."""
        size = self.wanted
        name = "".join(c for c in " ".join(self.text.split()) if c.isprintable())
        return self.shape.propeller(name, size.diameter, size.pitch, size.blades or 2)

    @property
    def told(self) -> str:
        """In one line: what the blade rests on, and how far loads may err."""
        shape = self.shape
        of = f"{len(shape.families)} families"
        if self.geometry == "family":
            of = f"its family, {self.family}"
        some = f"{shape.propellers} propellers" if shape.propellers > 1 else "one propeller"
        reason = "no measured blade of this size"
        if self.own is not None:
            reason = f"the blade of {self.own.tested!r} was not measured"
        elif not self.wanted.words:
            reason = "no maker is named"
        elif self.unknown:
            reason += f" ({' '.join(self.unknown)} names no series known here)"
        if self.alike:
            reason += f" (known of this size: {', '.join(self.alike)})"
        geometry = f"{reason}: geometry by the means of {some} of {of}"
        if self.own is not None:
            return geometry
        half, most = ERRORS[self._group]
        return (
            f"{geometry}; with section constants expected "
            f"likewise, half of such propellers err in thrust and torque by less than "
            f"{half[0]:.0%} and {half[1]:.0%} (rms) in axial flow, nine in ten by less than "
            f"{most[0]:.0%} and {most[1]:.0%}"
        )

    @property
    def _group(self) -> str:
        # Where none of the family was identified, its constants are as little known as any's.
        if self.geometry == "family" and _identified(all_identified(), self.family):
            return "family_blade"
        if self.geometry != "family" and _identified(identified_without_blade(), self.family):
            return "siblings_label"
        return "population_blade"


def _identified(entries: Sequence[Identified], family: str | None) -> bool:
    return any(one.family == family for one in entries)


def expected_blade(text: str, wanted: Designation, measured: Sequence[str] = ()) -> ExpectedBlade:
    """The blade to expect of ``wanted``, by the series that its words name or by all.

    Parameters
    ----------
    text : str
        The designation.
    wanted : Designation
        What it says.
    measured : sequence of str
        Names of measured propellers of the same size, to be told.
    """
    families, unknown = series_named(wanted.words)
    known = [
        one
        for one in identified_without_blade()
        if one.family in families and same_size((wanted.diameter, wanted.pitch), one.size)
    ]
    if len(known) == 1 and wanted.blades in (None, known[0].blades):
        return blade_of(text, wanted, known[0])
    names = (*measured, *(one.propeller for one in known))
    return ExpectedBlade(
        text, wanted, tuple(families), unknown, _shape_of(families), alike=tuple(names)
    )


def blade_of(text: str, wanted: Designation, own: Identified) -> ExpectedBlade:
    """The blade with which ``own`` was identified, for what is called ``text``."""
    return ExpectedBlade(text, wanted, (own.family,), (), _shape_of([own.family]), own)


def _shape_of(families: Sequence[str]) -> MeanBlade:
    """The mean of those of the ``families`` that were measured, of all where none was."""
    return bundled_mean(tuple(f for f in families if f in families_measured()))


def screw_angle(share: Floats, pitch_ratio: float) -> Floats:
    """Angle [rad] of a screw at a ``share`` of the radius, atan(P / (2 pi r)).

    Parameters
    ----------
    share : ndarray
        Radii over the tip radius [-].
    pitch_ratio : float
        Pitch over diameter [-].
    """
    return np.arctan(pitch_ratio / (math.pi * share))


def shapes_without(entry: catalogue.Entry) -> list[MeasuredShape]:
    """``measured_shapes`` but that of the propeller of which ``entry`` is a blade."""
    label = designation(entry.title)
    own = label and (entry.family, _size(label))
    return [one for one in measured_shapes() if (one.family, one.size) != own]


@lru_cache(maxsize=1)
def measured_shapes() -> tuple[MeasuredShape, ...]:
    """The propellers of the catalogue, one for each series and size: the mean of its blades."""
    alike: dict[tuple[str, tuple[float, float]], list[tuple[Floats, Floats]]] = {}
    for entry in catalogue.entries():
        label = designation(entry.title)
        assert label is not None  # a test reads all titles
        blade = catalogue.load(entry.name)
        share = blade.station / blade.radius
        # A first station that is rounded lies on the grid all the same.
        begun = share[0] - 1e-6 <= SHARES
        chord, twist = (
            np.where(begun, np.interp(SHARES, share, values), np.nan)
            for values in (blade.chord / blade.radius, blade.twist)
        )
        offset = twist - screw_angle(SHARES, label.pitch / label.diameter)
        alike.setdefault((entry.family, _size(label)), []).append((chord, offset))
    return tuple(
        MeasuredShape(family, size, *np.mean(blades, axis=0))
        for (family, size), blades in alike.items()
    )


def families_measured() -> set[str]:
    """Codes of the series of which a blade was measured."""
    return {one.family for one in measured_shapes()}


@lru_cache(maxsize=32)
def bundled_mean(families: tuple[str, ...] = ()) -> MeanBlade:
    """``mean_blade`` of the catalogue."""
    return mean_blade(measured_shapes(), families)


def mean_blade(shapes: Sequence[MeasuredShape], families: Collection[str] = ()) -> MeanBlade:
    """The mean of some series, with the spread over all.

    Parameters
    ----------
    shapes : sequence of MeasuredShape
        Measured propellers.
    families : collection of str
        Codes of the series to average, which are among the ``shapes``; none for all.
    """
    by_family: dict[str, list[Floats]] = {}
    for one in shapes:
        by_family.setdefault(one.family, []).append(np.stack([one.chord, one.offset]))
    means = {family: _mean(np.stack(some)) for family, some in by_family.items()}
    chosen = tuple(families) or tuple(by_family)
    counted = sum(len(by_family[family]) for family in chosen)
    about = np.stack([one - means[f] for f, some in by_family.items() for one in some])
    freedom = np.isfinite(about).sum(axis=0) - np.isfinite(list(means.values())).sum(axis=0)
    within = np.sqrt(np.nansum(about**2, axis=0) / np.where(freedom > 0, freedom, np.nan))
    between = _deviation(np.stack(list(means.values())))
    begun = np.mean([np.isfinite(means[family][0]) for family in chosen], axis=0) >= 0.5
    mean = _mean(np.stack([means[family] for family in chosen])[..., begun])
    return MeanBlade(chosen, counted, SHARES[begun], *mean, *within[:, begun], *between[:, begun])


def _size(label: Designation) -> tuple[float, float]:
    return round(label.diameter, 5), round(label.pitch, 5)


def _mean(some: Floats) -> Floats:
    """Over the first axis, of those that are not NaN; NaN where all are."""
    known = np.isfinite(some)
    count = known.sum(axis=0)
    total = np.where(known, some, 0.0).sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _deviation(some: Floats) -> Floats:
    """Standard deviation over the first axis, NaN where fewer than two are known."""
    count = np.isfinite(some).sum(axis=0)
    squares = np.nansum((some - _mean(some)) ** 2, axis=0)
    return np.sqrt(squares / np.where(count > 1, count - 1, np.nan))
