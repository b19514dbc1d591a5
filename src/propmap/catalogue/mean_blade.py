"""The mean blade of a series of propellers, or of many.

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
from propmap.catalogue.designation import Designation, designation
from propmap.model.model import Propeller
from propmap.typing import Floats

SHARES = np.linspace(0.15, 1.0, 18)
"""Radii over the tip radius at which blades are averaged, those of most measured blades."""


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
