"""The blade and the section constants to expect of a propeller that was not measured."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from propmap import catalogue
from propmap.catalogue import apc
from propmap.catalogue.designation import Designation, designation, same_size, series_named
from propmap.catalogue.identified import (
    LIFT_LAW,
    PARAMETERS,
    Identified,
    all_identified,
    identified_without_blade,
    one_of_each,
)
from propmap.model.airfoil import CONSTANTS, Airfoil, SectionCovariance, SectionUncertainty
from propmap.model.propeller import Propeller
from propmap.typing import Floats

ERRORS = {
    "family_blade": ((0.08, 0.08), (0.22, 0.21)),
    "siblings_label": ((0.085, 0.10), (0.18, 0.22)),
    "population_blade": ((0.19, 0.18), (0.39, 0.41)),
}
"""Errors of C_T and C_P of propellers that were left out, both their blade and constants, rms over
rms, by ``tools.catalogue.left_out``: half of them err less than the first two, nine in ten less
than the others; by the group there."""


@dataclass(frozen=True, eq=False)
class ExpectedBlade:
    """What a designation means that no measured propeller has."""

    text: str  # the designation as it was given
    wanted: Designation
    families: tuple[str, ...]  # codes of the series that its words name, or of its maker's
    unknown: tuple[str, ...]  # its words that name no series
    shape: MeanBlade  # of the measured blades of these series, or of all
    own: Identified | None = None  # constants identified with this blade
    others: tuple[str, ...] = ()  # names of propellers of this size that it may be

    @property
    def family(self) -> str | None:
        """Code of the series; None where it is not known."""
        return self.families[0] if len(self.families) == 1 else None

    @property
    def geometry(self) -> str:
        """Whose mean the blade is, "family", "population", or the latter for a "multirotor", as
        ``expected_constants`` takes it."""
        if not self.families and (self.wanted.maker or self.wanted.blades):
            return "multirotor"
        return "family" if self.shape.families == self.families[:1] else "population"

    @property
    def propeller(self) -> Propeller:
        """The blade; two of them where the designation does not say how many."""
        size, count = self.wanted, self.wanted.blades or 2
        name = "".join(c for c in " ".join(self.text.split()) if c.isprintable())
        blade = self.shape.propeller(name, size.diameter, size.pitch, count)
        factor = chord_factor(count) if self.geometry == "multirotor" else 1.0
        if factor == 1.0:
            return blade
        source = f"{blade.source}, the chord times {factor:g} for more than two blades"
        citation = f"{blade.citation}; static thrust with more blades: {STAND}"
        return replace(blade, chord=factor * blade.chord, source=source, citation=citation)

    def with_blades(self, asked: int | None) -> ExpectedBlade:
        """Take the number of blades that was ``asked`` for beside the designation, if any."""
        return replace(self, wanted=self.wanted.with_blades(asked))

    @property
    def summary(self) -> str:
        """Say in a line how the text was read, what the blade rests on, how far loads may err."""
        count, of = self.shape.propellers, f"{len(self.shape.families)} families"
        if self.geometry == "family":
            of = f"its family, {self.family}"
        reason = "no measured blade of this size"
        if self.own is not None:
            reason = f"the blade of {self.own.tested!r} was not measured"
        elif self.wanted.maker:
            reason = f"no blade of {self.wanted.maker} was measured"
        elif not self.wanted.words:
            reason = "no maker is named"
        elif self.unknown:
            reason += f" ({' '.join(self.unknown)} names no series known here)"
        if self.others:
            reason += f" (known of this size: {', '.join(self.others)})"
        some = f"the mean of {count} propellers" if count > 1 else "that of one propeller"
        geometry = f"{reason}: the geometry is {some} of {of}"
        if self.wanted.size:
            geometry = f"{self.wanted.reading}; {geometry}"
        multirotor = self.geometry == "multirotor"
        if multirotor and (factor := chord_factor(self.wanted.blades or 2)) != 1.0:
            geometry += f", of two blades, with {factor:g} of their chord"
        if self.own is not None:
            return geometry
        # Where none of the family was identified, its constants are as little known as any's.
        own = self.geometry == "family"
        identified = all_identified() if own else identified_without_blade()
        group = "family_blade" if own else "siblings_label"
        if self.family not in {one.family for one in identified}:
            group = "population_blade"
        half, most = ERRORS[group]
        if multirotor:
            geometry += (
                "; four five-inch propellers of multirotors, each left out, err in static thrust "
                f"by less than {LEFT_OUT_ERROR:.0%}"
            )
        return (
            f"{geometry}; with section constants predicted likewise, half of such propellers err "
            f"in thrust and torque by less than {half[0]:.0%} and {half[1]:.0%} (rms) in axial "
            f"flow, nine in ten by less than {most[0]:.0%} and {most[1]:.0%}"
        )


Meant: TypeAlias = catalogue.Entry | ExpectedBlade | None
"""What a name or designation means; None for a file."""


def expected_blade(text: str, wanted: Designation, measured: Sequence[str] = ()) -> ExpectedBlade:
    """Expect the blade of ``wanted``, by the series that its words name or by all; ``measured`` are
    names of propellers of its size in the catalogue, for the summary."""
    families, unknown = series_named(wanted.words)
    size = wanted.diameter, wanted.pitch
    known = [one for one in identified_without_blade() if one.family in families]
    known = [one for one in known if same_size(size, one.size)]
    if len(known) == 1 and not measured and wanted.blades in (None, known[0].blades):
        return blade_of(text, wanted, known[0])
    names = (*measured, *(one.propeller for one in known))
    return ExpectedBlade(
        text, wanted, tuple(families), unknown, _shape_of(families), others=tuple(names)
    )


def blade_of(text: str, wanted: Designation, own: Identified) -> ExpectedBlade:
    """Give the blade with which ``own`` was identified, for what is called ``text``."""
    return ExpectedBlade(text, wanted, (own.family,), (), _shape_of([own.family]), own)


def _shape_of(families: Sequence[str]) -> MeanBlade:
    """Average those of the ``families`` that were measured, all where none was."""
    return bundled_mean(tuple(f for f in families if f in families_measured()))


# -------------------------------------------------------------------------------------------------
# What static thrust of propellers with two, three and four blades says of those not measured.
#
# Nearly all measured blades are of propellers with two. On a stand, five-inch propellers of
# multirotors' makers with three and four have less thrust than these blades would: theirs are
# narrower, and many blades take more from each other than the theory has it. Both are put into the
# chord. There are four propellers, each on 12 or 13 motors; the density of the air was not recorded
# and is taken to be 1.20 kg/m^3, and the rotational speed is that of the motors' current. Beside
# them count propellers of the UIUC Propeller Database whose one blade was tested on hubs for two,
# three and four. ``python -m tools.chord_by_blades`` finds the numbers below.

STAND = "P. Cao, J. Strawson, github StrawsonDesign/motor_propeller_testing @7031418 (MIT)"

CHORD_OF_MORE = 0.711
"""Chord of blades on a propeller with more than two, over that of the mean blade; the logarithm is
known to 0.03.  Three and four are alike."""

LEFT_OUT_ERROR = 0.10  # errors of static thrust of the stand's propellers, each left out, are less

STAND_DEVIATION = 0.099
"""Standard deviation of the logarithm of static thrust about that of blades with this chord: the
root mean square of these errors, widened by Student's t, as there are four."""

AT_REST = np.array([0.39, 0.55, -0.02, 0.41, -1.39, 0.0, 1.34, 0.18])
"""Derivatives of the logarithm of static thrust by the coordinates of ``PopulationPrior``, mean
over the stand's propellers."""


def chord_factor(blades: int) -> float:
    """Give the chord of blades of which a propeller has so many, over that of the mean blade."""
    return 1.0 if blades <= 2 else CHORD_OF_MORE


def left_at_rest(covariance: Floats, deviation: float = STAND_DEVIATION) -> float:
    """Say what share of the variance of static thrust, by a ``covariance`` (P, P) of the
    coordinates, is left where its logarithm is known to the ``deviation``."""
    return float(deviation**2 / (AT_REST @ covariance @ AT_REST))


def known_at_rest(covariance: Floats, left: float) -> Floats:
    """Narrow a ``covariance`` (P, P) of the coordinates until the share ``left`` of the variance of
    static thrust is left; what does not change static thrust stays as little known."""
    along = covariance @ AT_REST
    return covariance - (1.0 - left) * np.outer(along, along) / (AT_REST @ along)


# -------------------------------------------------------------------------------------------------
# Section constants to expect of a propeller that was not identified: its family's, or any's.

MEDIAN_ERRORS = {"family": 0.08, "population": 0.12}
"""Errors of C_T and C_P of propellers that were left out, by ``tools.catalogue.left_out``: half of
them err less, rms over rms; with the blade of a maker's file as with a measured one."""


class ExpectedConstants(NamedTuple):
    """Constants of a propeller that was not identified, and a line on how far loads may be off."""

    airfoil: Airfoil
    summary: str


def expected_constants(
    family: str | None = None, size: Size | None = None, geometry: str = "measured"
) -> ExpectedConstants:
    """Give the most likely constants of a small propeller of a ``family`` such as "apcsf", or any,
    and ``size``, or a middling one; its blade's ``geometry`` is "measured", its "maker"'s, or the
    mean of its "family" or of the "population", perhaps that of a "multirotor"."""
    prior, members = expected_prior(family, size, geometry), _members(family, geometry)
    if members and family is not None:
        own, of = family, f"those of its family, {family}, {len(members)} propellers"
    else:
        own, of = "unknown", f"{len(all_identified())} small propellers, none of its family"
    of += ", for the blade of its maker's file" if geometry == "maker" else ""
    known = members and geometry != "population"
    likely = MEDIAN_ERRORS["family" if known else "population"]
    summary = f"constants predicted from {of}, as it was not identified itself: half of such "
    summary += f"propellers have thrust and torque within {likely:.0%} (rms) in axial flow, one in "
    summary += "ten is off by twice that"
    thrust, power = bundled_population(_population_of(geometry)).errors.tolist()
    measured = None if geometry == "measured" else expected_prior(family, size)
    if measured and geometry == "multirotor":
        # How much of the error of static thrust is the blade's was not measured: as of others.
        left = left_at_rest(expected_prior(family, size, "population").covariance)
        narrowed = known_at_rest(measured.covariance, left)
        measured = PopulationPrior.of(measured.mean, narrowed)
    own_part = _of_constants(measured) if measured else None
    known_to = SectionUncertainty(_of_constants(prior), thrust, power, with_blade=own_part)
    name = f"{family} expected" if members else "small propeller expected"
    law = airfoil_at(prior.mean, name, f"prior over propellers by propmap, family {own}")
    return ExpectedConstants(law.with_parameters(uncertainty=known_to), summary)


def airfoil_at(place: Floats, name: str, source: str) -> Airfoil:
    """Make the section law at a ``place``, coordinates (P,) of ``PopulationPrior``."""
    found = zip(PARAMETERS, constants_of(place).tolist(), strict=True)
    values: Any = dict(found)
    return Airfoil(**values, lift_law=LIFT_LAW, name=name, source=source)


def expected_prior(
    family: str | None = None,
    size: Size | None = None,
    geometry: str = "measured",
    without: str | None = None,
) -> PopulationPrior:
    """Give the distribution for ``expected_constants``; the propeller ``without`` is left out."""
    members = [one for one in _members(family, geometry) if one.tested != without]
    population = bundled_population(_population_of(geometry))
    prior = family_prior(members, population, size or (MIDDLE[0], MIDDLE[0] * MIDDLE[1]))
    return on_makers_blade(prior, family) if geometry == "maker" else prior


def _population_of(geometry: str) -> str:
    """Say which of ``GEOMETRIES`` constants with a blade of this ``geometry`` are drawn from."""
    return "measured" if geometry == "maker" else geometry


def siblings(family: str | None, without: str | None = None) -> int:
    """Count the identified propellers of a ``family``, but for one that is left out."""
    return sum(one.tested != without for one in _members(family, "measured"))


def size_of(meant: Meant, blade: Propeller) -> Size:
    """Read diameter and pitch [m] from the label of what ``lookup.meant_by`` has found; for a file,
    None, from the blade, whose pitch at 0.75 R is 3 % of the diameter above labels in the mean."""
    if isinstance(meant, ExpectedBlade):
        return meant.wanted.diameter, meant.wanted.pitch
    label = designation(meant.title) if meant is not None else None
    if label is not None:
        return label.diameter, label.pitch
    at = 0.75 * blade.radius
    return blade.diameter, 2.0 * np.pi * at * np.tan(np.interp(at, blade.station, blade.twist))


@lru_cache(maxsize=64)
def _members(family: str | None, geometry: str) -> list[Member]:
    """Collect what is known of the family's propellers, on the blade of this ``geometry``."""
    if geometry == "population":
        return [
            member_without_blade(one)
            for one in identified_without_blade()
            if one.family == family and one.geometry == "population"
        ]
    known = one_of_each(all_identified(family)) if family else []
    if geometry != "family" or not known:
        return [on_measured_blade(one) for one in known]
    return [on_mean_blade(one, bundled_mean((one.family,))) for one in known]


def on_measured_blade(one: Identified) -> Member:
    """Take what the data of ``one`` say; of a maker's blade, for what would have been measured."""
    own = member(one)
    if one.geometry != "maker":
        return own
    shift, spread = _by_difference(apc.difference(one.family))
    return own.shifted(-shift, spread)


def on_makers_blade(
    prior: PopulationPrior, family: str | None, without: str = ""
) -> PopulationPrior:
    """Move a distribution from a measured blade to that of its maker's file, without the measured
    blade that the catalogue calls ``without``."""
    shift, spread = _by_difference(apc.difference(family, without))
    return PopulationPrior.of(prior.mean + shift, prior.covariance + spread)


def _by_difference(of: apc.Difference) -> tuple[Floats, Floats]:
    """Give the change of coordinates (P,) from measured to makers' blades, and its covariance."""
    by = np.stack([_FORCES, -_ANGLES], axis=1)
    return by @ of.mean, by @ of.covariance @ by.T


def on_mean_blade(one: Identified, shape: MeanBlade) -> Member:
    """Put a mean blade in the place of its own into what the data of ``one`` say."""
    mean = shape.propeller(one.tested, one.diameter_m, one.pitch_m, one.blades)
    return member(one).shifted(equivalent(catalogue.load(one.propeller), mean))


def member_without_blade(one: Identified) -> Member:
    """Take what the data of ``one`` say, which was identified on the mean blade of all families."""
    return member(one, family_prior([], bundled_population("population"), one.size))


def _of_constants(prior: PopulationPrior) -> SectionCovariance:
    slopes = slopes_of(prior.mean)
    return SectionCovariance(PARAMETERS, slopes @ prior.covariance @ slopes.T)


# -------------------------------------------------------------------------------------------------
# The mean blade of a series of propellers, or of many.
#
# Propellers of one series resemble each other: chord over radius, and the twist less that of a
# screw with the labelled pitch, hardly change with the size.  Their means over the measured blades
# of the series, or over all series with one vote each, make a blade of any size.

SHARES = np.linspace(0.15, 1.0, 18)
"""Radii over the tip radius at which blades are averaged, those of most measured blades."""


class MeasuredShape(NamedTuple):
    """A blade without its size: chord over the tip radius [-], and twist less ``screw_angle``
    [rad], (18,) at ``SHARES``; NaN inward of the first measured station."""

    family: str  # code of its series
    size: tuple[float, float]  # labelled diameter and pitch [m]
    chord: Floats
    offset: Floats


@dataclass(frozen=True, eq=False)
class MeanBlade:
    """Mean chord and twist (n,) of one series or several, with one vote each."""

    families: tuple[str, ...]
    propellers: int  # how many were measured
    share: Floats  # radii over the tip radius, from where most members' blades begin
    chord: Floats  # over the tip radius [-]
    offset: Floats  # twist less that of a screw with the labelled pitch [rad]

    def propeller(self, name: str, diameter: float, pitch: float, blades: int) -> Propeller:
        """Make a propeller of this shape, labelled ``diameter`` and ``pitch`` [m]."""
        radius = 0.5 * diameter
        of = self.families[0] if len(self.families) == 1 else f"{len(self.families)} series"
        source = "not measured: chord over radius, and twist less that of a screw of the labelled "
        source += f"pitch, are the means of {self.propellers} propellers of {of}"
        twist = self.offset + screw_angle(self.share, pitch / diameter)
        blade = self.share * radius, self.chord * radius, twist, None
        citation = "geometry: that of the propellers of the catalogue"
        return Propeller(name, blades, *blade, source, citation)


def screw_angle(share: Floats, pitch_ratio: float) -> Floats:
    """Compute the angle [rad] of a screw at a ``share`` of the radius, atan(P / (2 pi r))."""
    return np.arctan(pitch_ratio / (math.pi * share))


@lru_cache(maxsize=1)
def measured_shapes() -> tuple[MeasuredShape, ...]:
    """List means of blades in the catalogue by series and size, but for the table of a maker's."""
    blades_of: dict[tuple[str, tuple[float, float]], list[tuple[Floats, Floats]]] = {}
    for entry in catalogue.entries():
        if entry.name in apc.apc_blades():
            continue
        label = designation(entry.title)
        assert label is not None  # a test reads all titles
        blade = catalogue.load(entry.name)
        share = blade.station / blade.radius
        # A first station that is rounded lies on the grid too.
        begun = share[0] - 1e-6 <= SHARES
        chord, twist = (
            np.where(begun, np.interp(SHARES, share, values), np.nan)
            for values in (blade.chord / blade.radius, blade.twist)
        )
        offset = twist - screw_angle(SHARES, label.pitch / label.diameter)
        blades_of.setdefault((entry.family, label_size(label)), []).append((chord, offset))
    return tuple(
        MeasuredShape(family, size, *np.mean(blades, axis=0))
        for (family, size), blades in blades_of.items()
    )


def families_measured() -> set[str]:
    """List codes of the series of which a blade was measured."""
    return {one.family for one in measured_shapes()}


@lru_cache(maxsize=32)
def bundled_mean(families: tuple[str, ...] = ()) -> MeanBlade:
    """Average shapes of the catalogue, as ``mean_blade``."""
    return mean_blade(measured_shapes(), families)


def mean_blade(shapes: Sequence[MeasuredShape], families: Collection[str] = ()) -> MeanBlade:
    """Average the ``shapes`` of some ``families``, of all where none is given."""
    by_family: dict[str, list[Floats]] = {}
    for one in shapes:
        by_family.setdefault(one.family, []).append(np.stack([one.chord, one.offset]))
    chosen = tuple(families) or tuple(by_family)
    means = np.stack([_mean(np.stack(by_family[family])) for family in chosen])
    counted = sum(len(by_family[family]) for family in chosen)
    begun = np.mean(np.isfinite(means[:, 0]), axis=0) >= 0.5
    return MeanBlade(chosen, counted, SHARES[begun], *_mean(means[..., begun]))


def label_size(label: Designation) -> tuple[float, float]:
    """Give the labelled diameter and pitch [m], rounded to be compared."""
    return round(label.diameter, 5), round(label.pitch, 5)


def _mean(some: Floats) -> Floats:
    """Average over the first axis what is not NaN; NaN where all are."""
    known = np.isfinite(some)
    count = known.sum(axis=0)
    total = np.where(known, some, 0.0).sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


# -------------------------------------------------------------------------------------------------
# Section constants that have the loads of another blade.
#
# A blade whose chord is larger by one factor everywhere has the forces of section constants larger
# by it, and a blade that is twisted further by one angle everywhere those of angles smaller by it.
# So what is not known of a blade is kept as a change of its constants.

INNERMOST = 0.3  # share of the radius from which blades are compared

_FORCES = np.array([name in ("c_l1", "c_l2", "c_d", "c_d0") for name in PARAMETERS], float)
# The coordinate of the drag angle is from the chord line, as the zero-lift angle is.
_ANGLES = np.array([name in ("zero_lift_angle", "drag_angle") for name in PARAMETERS], float)


def equivalent(blade: Propeller, other: Propeller) -> Floats:
    """Say how coordinates (P,) of constants identified on a ``blade`` change on the ``other`` for
    about the same loads: by the logarithm of the chords' mean ratio, less the twists' mean
    difference [rad], weighed by radius squared and the other's chord; both have one radius."""
    share = other.station / other.radius
    share = share[share >= INNERMOST]
    own, its = (
        [np.interp(share, b.station / b.radius, values) for values in (b.chord, b.twist)]
        for b in (blade, other)
    )
    weight = share**2 * its[0]
    ratio = (weight * own[0] / its[0]).sum() / weight.sum()
    turned = (weight * (own[1] - its[1])).sum() / weight.sum()
    return np.log(ratio) * _FORCES - turned * _ANGLES


# -------------------------------------------------------------------------------------------------
# What is known of a propeller's section constants before its own data are looked at.

LOGARITHMIC = np.array([CONSTANTS[name].population == "log" for name in PARAMETERS])
"""Whose logarithm is the coordinate (P,)."""

_DRAG_ANGLE, _ZERO_LIFT = PARAMETERS.index("drag_angle"), PARAMETERS.index("zero_lift_angle")


@dataclass(frozen=True, eq=False)
class PopulationPrior:
    """A normal distribution of coordinates of the P constants in ``PARAMETERS``: logarithms where
    ``CONSTANTS`` says so, and for ``drag_angle`` the angle of least pressure drag from the chord
    line."""

    mean: Floats
    deviation: Floats
    correlation: Floats = field(default_factory=lambda: np.eye(len(PARAMETERS)))

    @classmethod
    def of(cls, mean: Floats, covariance: Floats) -> PopulationPrior:
        """Make the distribution with this ``mean`` (P,) and ``covariance`` (P, P)."""
        deviation = np.sqrt(np.diag(covariance))
        return cls(mean, deviation, covariance / np.outer(deviation, deviation))

    @property
    def covariance(self) -> Floats:
        """Covariance of the coordinates, (P, P)."""
        return np.outer(self.deviation, self.deviation) * self.correlation


_MEAN = np.array([5.31, 2.4, 2.45, 0.226, -0.045, 0.024, -0.019, 0.025])
_BETWEEN = np.array([0.16, 0.12, 0.38, 0.10, 0.024, 0.43, 0.014, 0.019])
_WITHIN = np.array([0.09, 0.12, 0.17, 0.10, 0.014, 0.16, 0.007, 0.012])
_CENTRE = np.where(LOGARITHMIC, np.log(np.where(LOGARITHMIC, _MEAN, 1.0)), _MEAN)
POPULATION = PopulationPrior(_CENTRE, np.hypot(_BETWEEN, _WITHIN))
"""Small propellers: means of 129 of them, and their spread between and within families, put
together; a first identification of the UIUC database gave them."""


def coordinates(constants: Floats) -> Floats:
    """Convert constants (..., 7) in the order of ``PARAMETERS`` to coordinates."""
    found = np.where(LOGARITHMIC, np.log(np.where(LOGARITHMIC, constants, 1.0)), constants)
    found[..., _DRAG_ANGLE] = constants[..., _DRAG_ANGLE] + constants[..., _ZERO_LIFT]
    return found


def constants_of(place: Floats) -> Floats:
    """Convert coordinates (..., 7) to constants, the inverse of ``coordinates``."""
    found = np.where(LOGARITHMIC, np.exp(np.where(LOGARITHMIC, place, 0.0)), place)
    found[..., _DRAG_ANGLE] = place[..., _DRAG_ANGLE] - place[..., _ZERO_LIFT]
    return found


def slopes_of(place: Floats) -> Floats:
    """Differentiate the constants by the coordinates ``place`` (P,), as (P, P)."""
    slopes = np.diag(np.where(LOGARITHMIC, constants_of(place), 1.0))
    slopes[_DRAG_ANGLE, _ZERO_LIFT] = -1.0
    return slopes


def coordinate_covariance(constants: Floats, covariance: Floats) -> Floats:
    """Convert the covariance (P, P) of the ``constants`` (P,) to that of the coordinates."""
    back = np.linalg.inv(slopes_of(coordinates(constants)))
    return np.asarray(back @ covariance @ back.T)


# -------------------------------------------------------------------------------------------------
# What identified propellers say of one that is not: of its family, or of any.


class Member(NamedTuple):
    """What own data, without a prior, say of coordinates x: exp(pull x - x precision x / 2)."""

    family: str  # code of its series
    tested: str  # what the source calls it
    size: Size  # labelled diameter and pitch [m]
    precision: Floats  # (P, P), singular where its data say nothing of some
    pull: Floats  # (P,), ``precision`` times the coordinates that fit best

    def shifted(self, shift: Floats, spread: Floats | None = None) -> Member:
        """Add ``shift`` (P,) to the coordinates, known up to the covariance ``spread`` (P, P)."""
        pull, precision = self.pull + self.precision @ shift, self.precision
        if spread is None:
            return self._replace(pull=pull)
        known = np.linalg.inv(np.eye(shift.size) + precision @ spread)
        return self._replace(precision=known @ precision, pull=known @ pull)


def member(one: Identified, prior: PopulationPrior = POPULATION) -> Member:
    """Take the ``prior``, with which it was identified, out of the constants of ``one``."""
    place = coordinates(one.constants)
    both = np.linalg.inv(coordinate_covariance(one.constants, one.covariance))
    before = np.linalg.inv(prior.covariance)
    values, vectors = np.linalg.eigh(both - before)
    # Data say nothing where rounding makes them say less.
    precision = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return Member(one.family, one.tested, one.size, precision, both @ place - before @ prior.mean)


def family_prior(members: Sequence[Member], population: Population, size: Size) -> PopulationPrior:
    """Predict the distribution of a further propeller of a family from its ``members``, by which
    siblings of a similar size say the most; without members it is that over all propellers."""
    own = population.mean + population.shift(size)
    related = likeness([*(one.size for one in members), size])
    joint = np.kron(np.ones_like(related), population.between) + np.kron(related, population.within)
    if not members:
        return PopulationPrior.of(own, joint)
    known = own.size * len(members)
    precision = np.zeros((known, known))
    for k, one in enumerate(members):
        place = slice(k * own.size, (k + 1) * own.size)
        precision[place, place] = one.precision
    centre = np.concatenate([population.mean + population.shift(one.size) for one in members])
    pull = np.concatenate([one.pull for one in members]) - precision @ centre
    towards = joint[known:, :known] @ np.linalg.inv(
        np.eye(known) + precision @ joint[:known, :known]
    )
    covariance = joint[known:, known:] - towards @ precision @ joint[:known, known:]
    return PopulationPrior.of(own + towards @ pull, 0.5 * (covariance + covariance.T))


# -------------------------------------------------------------------------------------------------
# How section constants are spread over small propellers: by size, between families, within them.
#
# A propeller's coordinates are the mean of its family, a trend by size common to all families, and
# a part of its own, which is like that of its siblings of a similar size.

MIDDLE = (0.2286, 0.6)  # diameter [m] and pitch over diameter at which a family's mean is stated

LIKENESS_WIDTH = (0.4, 0.3)
"""Standard deviations of the bell by which likeness falls with the distance between siblings in the
logarithm of the diameter and in pitch over diameter; with ``OWN_SHARE``, those of the largest
likelihood on a grid, over all three populations."""

OWN_SHARE = 0.25  # share of the variance within families in which siblings of one size differ

GEOMETRIES = ("measured", "family", "population")  # whose blade, as ``Identified.geometry``
Size = tuple[float, float]  # labelled diameter and pitch [m]


@dataclass(frozen=True, eq=False)
class Population:
    """A normal distribution over propellers of the coordinates of ``PopulationPrior``."""

    mean: Floats  # (P,) over families, of a propeller of the size ``MIDDLE``
    trend: Floats  # (P, 2) by the logarithm of the diameter, and by pitch over diameter
    between: Floats  # (P, P) covariance of families' means
    within: Floats  # (P, P) covariance of propellers about the mean of their family
    low: Floats  # (2,) of the two in the data; the trend ends there
    high: Floats
    errors: Floats  # (2,) of C_T and C_P [-] about the model with the best constants

    def shift(self, size: Size) -> Floats:
        """Add up what the trend adds to the coordinates at a ``size``, (P,)."""
        return self.trend @ np.clip(covariates(size), self.low, self.high)


def covariates(size: Size) -> Floats:
    """Measure a size from ``MIDDLE``: logarithm of the diameter, and pitch over diameter, (2,)."""
    diameter, pitch = size
    return np.array([np.log(diameter / MIDDLE[0]), pitch / diameter - MIDDLE[1]])


def likeness(sizes: Sequence[Size]) -> Floats:
    """Correlate siblings (n, n) about their family's mean; of one size, 1 - ``OWN_SHARE``."""
    place = np.stack([covariates(size) for size in sizes]) / LIKENESS_WIDTH
    distance = ((place[:, None] - place[None]) ** 2).sum(axis=-1)
    return (1.0 - OWN_SHARE) * np.exp(-0.5 * distance) + OWN_SHARE * np.eye(len(place))


@lru_cache(maxsize=4)
def bundled_population(geometry: str = "measured") -> Population:
    """Read the bundled population of one of ``GEOMETRIES``, or that of all for a "multirotor"."""
    if geometry == "multirotor":
        of_all = bundled_population("population")
        whole = of_all.between + of_all.within
        narrowed = known_at_rest(whole, left_at_rest(whole))
        return replace(of_all, between=narrowed, within=np.zeros_like(whole))
    file = Path(__file__).parent / "identified" / "population.toml"
    return parse_populations(file.read_text(encoding="utf-8"))[geometry]


def parse_populations(text: str) -> dict[str, Population]:
    """Read the populations of a file's ``text``, by the blade that their constants belong to."""
    tables = tomllib.loads(text).items()
    return {n: Population(**{key: np.array(v) for key, v in table.items()}) for n, table in tables}
