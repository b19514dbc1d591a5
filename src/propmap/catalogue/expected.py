"""Prediction of the blade and the section constants of a propeller that was not measured."""

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
from propmap.bands import TUNNEL_GAIN
from propmap.catalogue import apc
from propmap.catalogue.designation import (
    MAKERS,
    Designation,
    designation,
    same_size,
    series_named,
)
from propmap.catalogue.identified import (
    LIFT_LAW,
    PARAMETERS,
    Identified,
    all_identified,
    identified_without_blade,
    one_of_each,
)
from propmap.loads import LOADS
from propmap.model.airfoil import CONSTANTS, Airfoil, SectionCovariance, SectionUncertainty
from propmap.model.corrections import model_corrections
from propmap.model.model import Model
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import INCH

_HELD_OUT: dict[str, Any] = tomllib.loads(
    Path(__file__).with_name("held_out.toml").read_text(encoding="utf-8")
)
ERRORS, MEDIAN_ERRORS = _HELD_OUT["errors"], _HELD_OUT["median_errors"]


@dataclass(frozen=True, eq=False)
class ExpectedBlade:
    """Predicted blade of a designation that no measured propeller has."""

    text: str  # the designation as given by the user
    wanted: Designation
    families: tuple[str, ...]  # codes of the named series, or of all series of the manufacturer
    unknown: tuple[str, ...]  # words that name no series
    shape: MeanBlade  # of the measured blades of these series, or of all
    own: Identified | None = None  # constants identified with this blade
    others: tuple[str, ...] = ()  # names of catalogue propellers of this size

    @property
    def family(self) -> str | None:
        """Code of the series; None if it is not known."""
        return self.families[0] if len(self.families) == 1 else None

    @property
    def geometry(self) -> str:
        """Origin of the blade for ``expected_constants``: "family", "population", "multirotor" or
        "carbon"."""
        if not self.families and self.wanted.maker in CARBON and self.wanted.diameter >= LARGE:
            return "carbon"
        tiny = self.wanted.diameter < SMALLEST
        if not self.families and (self.wanted.maker or self.wanted.blades or tiny):
            return "multirotor"
        return "family" if self.shape.families == self.families[:1] else "population"

    @property
    def propeller(self) -> Propeller:
        """The propeller, with two blades if their number is not known."""
        size, count = self.wanted, self.wanted.blades or 2
        name = "".join(c for c in " ".join(self.text.split()) if c.isprintable())
        return self.shape.propeller(name, size.diameter, size.pitch, count)

    def with_blades(self, asked: int | None) -> ExpectedBlade:
        """Return the prediction for the number of blades ``asked``, if given."""
        return replace(self, wanted=self.wanted.with_blades(asked))

    @property
    def summary(self) -> str:
        """One line of text: interpretation of the designation, origin of the blade, errors."""
        count, of = self.shape.propellers, f"{len(self.shape.families)} families"
        if self.geometry == "family":
            of = f"its family, {self.family}"
        reason = "no measured blade of this size"
        if self.own is not None:
            reason = f"the blade of {self.own.tested!r} was not measured"
        elif self.wanted.maker:
            reason = f"no blade of {self.wanted.maker} was measured"
        elif not self.wanted.words:
            reason = "no manufacturer is named"
            if self.geometry == "population":
                reason += " (for the constants of multirotor propellers, add the manufacturer or "
                reason += "--blades 2)"
        elif self.unknown:
            reason += f" ({' '.join(self.unknown)} is not a known series)"
        if self.others:
            reason += f" (catalogue propellers of this size: {', '.join(self.others)})"
        some = f"the mean of {count} propellers" if count > 1 else "that of one propeller"
        geometry = f"{reason}: the geometry is {some} of {of}"
        if self.wanted.size:
            geometry = f"{self.wanted.reading}; {geometry}"
        if self.own is not None:
            return geometry
        size, blades = (self.wanted.diameter, self.wanted.pitch), self.wanted.blades or 2
        geometry += size_note(self.geometry, size, blades)
        if self.geometry in MULTIROTOR:
            kind = stand_kind(self.geometry == "carbon", blades)
            thrust, torque = STAND_ERRORS[kind]
            return (
                f"{geometry}; the constants agree with the static loads of {STANDS} multirotor "
                "propellers on stands: for half of the held-out propellers of this kind, errors "
                f"of static thrust and torque are below {thrust:.0%} and {torque:.0%}"
            )
        # Without identified members, the family's constants have the errors of the population.
        own = self.geometry == "family"
        identified = all_identified() if own else identified_without_blade()
        group = "family_blade" if own else "siblings_label"
        if self.family not in {one.family for one in identified}:
            group = "population_blade"
        half, most = ERRORS[group]
        return (
            f"{geometry}; rms errors of thrust and torque in axial flow, with predicted section "
            f"constants: below {half[0]:.0%} and {half[1]:.0%} for half of the tested propellers, "
            f"below {most[0]:.0%} and {most[1]:.0%} for nine in ten of them"
        )


Meant: TypeAlias = catalogue.Entry | ExpectedBlade | None
"""Result of the lookup of a name or designation; None for a file."""


def expected_blade(text: str, wanted: Designation, measured: Sequence[str] = ()) -> ExpectedBlade:
    """Return the predicted blade of ``wanted``, from the named series or from all series.

    ``measured`` are names of catalogue propellers of this size, for the summary.
    """
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
    """Return the blade with which ``own`` was identified, for the designation ``text``."""
    return ExpectedBlade(text, wanted, (own.family,), (), _shape_of([own.family]), own)


def _shape_of(families: Sequence[str]) -> MeanBlade:
    """Return the mean blade of the measured ``families``, or of all if none was measured."""
    return bundled_mean(tuple(f for f in families if f in families_measured()))


# -------------------------------------------------------------------------------------------------
# Static loads of multirotor propellers.
#
# Multirotor propellers were not measured in the UIUC wind tunnel.  On stands, their thrust and
# torque are smaller than predicted with the mean blade and the constants of all series.  The ratio
# of measured to predicted loads depends little on the size and the number of blades.  The prior of
# the constants is shifted and narrowed to give static loads the distribution measured on stands.
# held_out.toml explains the numbers, which ``python -m tools.stands`` computes.

_STANDS = _HELD_OUT["stands"]
STANDS, SIZE_TREND, TINY_TREND = (_STANDS[k] for k in ("propellers", "size_trend", "tiny_trend"))
STAND_SHIFT, STAND_CORRELATION = np.array(_STANDS["shift"]), _STANDS["correlation"]
STAND_DEVIATIONS, STAND_ERRORS, STAND_SIZES = (
    {kind: tuple(row[key]) for kind, row in _STANDS["kinds"].items()}
    for key in ("deviations", "errors", "diameters")
)
STAND_TIP_SPEED = 100.0  # tip speed [m/s] at which the static loads get this distribution

MULTIROTOR = ("multirotor", "carbon")  # values of ``geometry`` with a prior from stands

LARGE = 0.2921  # smallest diameter [m] of a large propeller, 11.5 in
SMALLEST = 0.0569  # smallest diameter [m] in the UIUC database, 2.24 in

CARBON = tuple(maker.name for maker in MAKERS if maker.carbon)
"""Manufacturers whose ``LARGE`` propellers have similar loads."""


def static_loads(place: Floats, size: Size, blades: int) -> tuple[Floats, Floats]:
    """Return the logarithms (2,) of static thrust and torque, and their derivatives (2, P).

    The derivatives are with respect to the coordinates ``place`` (P,) of ``PopulationPrior``.  The
    blade is the mean of all series with this ``size`` and number of ``blades``.
    """
    blade = bundled_mean().propeller("mean", *size, blades)
    law = airfoil_at(place, "all series", "")
    rotor = Rotor(Model(blade, law, corrections=model_corrections("recommended")))
    found = rotor.gradients(PARAMETERS, STAND_TIP_SPEED / blade.radius, 0.0, 0.0)
    which = [list(LOADS).index(name) for name in ("thrust", "torque")]
    slopes = found.slopes[which] @ slopes_of(place) / found.loads[which, None]
    return np.log(found.loads[which]), slopes


def stand_kind(carbon: bool, blades: int) -> str:
    """Return the kind of a multirotor propeller in ``STAND_DEVIATIONS``."""
    return "carbon" if carbon else "three blades and more" if blades > 2 else "two blades"


@lru_cache(maxsize=64)
def after_stands(size: Size, kind: str, blades: int, doubt: float = 0.0) -> PopulationPrior:
    """Return the prior of a multirotor propeller, derived from that of all series.

    ``kind`` is a key of ``STAND_DEVIATIONS``.  ``doubt`` is the probability that the propeller has
    three blades instead of two, or two instead of three.

    Static thrust and torque then follow the distribution measured on stands, which includes the
    tunnel term of ``propmap.bands``.  The variance does not change in directions of the coordinates
    that do not affect the static loads.  Outside the diameters on stands, the variance
    grows with the logarithm of the diameter.
    """
    prior = family_prior([], bundled_population("population"), size)
    place, target = prior.mean, static_loads(prior.mean, size, blades)[0] + STAND_SHIFT
    for _ in range(3):  # Gauss-Newton steps; the third changes the loads by less than 1e-3
        loads, slopes = static_loads(place, size, blades)
        before = slopes @ prior.covariance @ slopes.T
        gain = prior.covariance @ slopes.T @ np.linalg.inv(before)
        place = prior.mean + gain @ (target - loads + slopes @ (place - prior.mean))
    low, high = np.array(STAND_SIZES[kind]) * INCH
    trend = SIZE_TREND if size[0] > low or kind == "carbon" else TINY_TREND
    beyond = trend * np.log(max(low / size[0], size[0] / high, 1.0))
    deviation = np.hypot(STAND_DEVIATIONS[kind], beyond)
    wanted = np.outer(deviation, deviation) * [[1.0, STAND_CORRELATION], [STAND_CORRELATION, 1.0]]
    wanted -= TUNNEL_GAIN**2 * np.eye(2)
    if doubt > 0.0:
        change = static_loads(place, size, 3 if blades == 2 else 2)[0] - target
        wanted += doubt * np.outer(change, change)
    covariance = prior.covariance - gain @ (before - wanted) @ gain.T
    return PopulationPrior.of(place, covariance)


# --- Predicted section constants of a propeller, from its family or from all propellers ----------


class ExpectedConstants(NamedTuple):
    """Predicted constants of a propeller, and a line of text on origin and errors."""

    airfoil: Airfoil
    summary: str


def expected_constants(
    family: str | None = None,
    size: Size | None = None,
    geometry: str = "measured",
    blades: int = 2,
    doubt: float = 0.0,
) -> ExpectedConstants:
    """Return the most likely constants of a small propeller of a ``family`` and ``size``.

    By default, the family is unknown and the size is ``MEDIUM``.  ``geometry`` is the origin of the
    blade: "measured"; "maker", the manufacturer's file; "family" or "population", the mean blade of
    the family or of all families.  "multirotor" and "carbon" mean the blade of all families with
    a prior from stands for this number of ``blades`` and this ``doubt``, as in ``Designation``.
    """
    prior = expected_prior(family, size, geometry, blades, doubt)
    members = _members(family, geometry)
    if members and family is not None:
        own, of = family, f"{len(members)} propellers of its family, {family}"
    else:
        own, of = "unknown", f"{len(all_identified())} small propellers, none of its family"
    of += ", with the blade of the manufacturer's file" if geometry == "maker" else ""
    known = members and geometry != "population"
    likely = MEDIAN_ERRORS["family" if known else "population"]
    summary = f"constants predicted from {of}; no measurements of this propeller were fitted; rms "
    summary += f"errors of thrust and torque in axial flow: below {likely:.0%} for half of the "
    summary += "tested propellers, below twice this value for nine in ten of them"
    summary += size_note(geometry, size or MEDIUM, blades)
    thrust, power = bundled_population(_population_of(geometry)).errors.tolist()
    measured = None if geometry == "measured" else expected_prior(family, size)
    if geometry in MULTIROTOR:
        # Stands do not separate the errors of blade, constants and theory.
        measured, thrust, power = None, 0.0, 0.0
    own_part = _of_constants(measured) if measured else None
    known_to = SectionUncertainty(_of_constants(prior), thrust, power, with_blade=own_part)
    name = f"{family} expected" if members else "small propeller expected"
    law = airfoil_at(prior.mean, name, f"prior over propellers by propmap, family {own}")
    return ExpectedConstants(law.with_parameters(uncertainty=known_to), summary)


def size_note(geometry: str, size: Size, blades: int) -> str:
    """Return a remark if the diameter is outside the range of the measured propellers."""
    if geometry in MULTIROTOR:
        low, high = STAND_SIZES[stand_kind(geometry == "carbon", blades)]
    else:
        population = bundled_population(_population_of(geometry))
        low, high = np.exp([population.low[0], population.high[0]]) * MIDDLE[0] / INCH
    note = f"; bands widened, because diameters of {low:.3g} to {high:.3g} in were measured"
    return "" if low <= size[0] / INCH <= high else note


def airfoil_at(place: Floats, name: str, source: str) -> Airfoil:
    """Return the section law for coordinates ``place`` (P,) of ``PopulationPrior``."""
    found = zip(PARAMETERS, constants_of(place).tolist(), strict=True)
    values: Any = dict(found)
    return Airfoil(**values, lift_law=LIFT_LAW, name=name, source=source)


def expected_prior(
    family: str | None = None,
    size: Size | None = None,
    geometry: str = "measured",
    blades: int = 2,
    doubt: float = 0.0,
    without: str | None = None,
) -> PopulationPrior:
    """Return the distribution for ``expected_constants``, excluding the propeller ``without``."""
    if geometry in MULTIROTOR:
        kind = stand_kind(geometry == "carbon", blades)
        return after_stands(size or MEDIUM, kind, blades, doubt)
    members = [one for one in _members(family, geometry) if one.tested != without]
    population = bundled_population(_population_of(geometry))
    prior = family_prior(members, population, size or MEDIUM)
    return on_makers_blade(prior, family) if geometry == "maker" else prior


def _population_of(geometry: str) -> str:
    """Return which population of ``GEOMETRIES`` applies to a blade of this ``geometry``."""
    others = dict.fromkeys(MULTIROTOR, "population")
    return {"maker": "measured", **others}.get(geometry, geometry)


def siblings(family: str | None, without: str | None = None) -> int:
    """Return the number of identified propellers of a ``family``, excluding ``without``."""
    return sum(one.tested != without for one in _members(family, "measured"))


def size_of(meant: Meant, blade: Propeller) -> Size:
    """Return diameter and pitch [m] from the label of a result of ``lookup.meant_by``.

    For a file, ``meant`` is None and the size is computed from the blade.  The pitch at 0.75 R
    exceeds the labeled pitch by 3 % of the diameter on average.
    """
    if isinstance(meant, ExpectedBlade):
        return meant.wanted.diameter, meant.wanted.pitch
    label = designation(meant.title) if meant is not None else None
    if label is not None:
        return label.diameter, label.pitch
    at = 0.75 * blade.radius
    return blade.diameter, 2.0 * np.pi * at * np.tan(np.interp(at, blade.station, blade.twist))


@lru_cache(maxsize=64)
def _members(family: str | None, geometry: str) -> list[Member]:
    """Return the members of a family, with constants for a blade of this ``geometry``."""
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
    """Return the likelihood of ``one``, with constants for a measured blade.

    Constants identified with the blade of a manufacturer's file are shifted.
    """
    own = member(one)
    if one.geometry != "maker":
        return own
    shift, spread = _by_difference(apc.difference(one.family))
    return own.shifted(-shift, spread)


def on_makers_blade(
    prior: PopulationPrior, family: str | None, without: str = ""
) -> PopulationPrior:
    """Return the distribution for manufacturers' blades from the distribution for measured blades.

    The mean difference of the two blades excludes the propeller with the name ``without``.
    """
    shift, spread = _by_difference(apc.difference(family, without))
    return PopulationPrior.of(prior.mean + shift, prior.covariance + spread)


def _by_difference(of: apc.Difference) -> tuple[Floats, Floats]:
    """Return mean (P,) and covariance of the change of coordinates from measured to file blades."""
    by = np.stack([_FORCES, -_ANGLES], axis=1)
    return by @ of.mean, by @ of.covariance @ by.T


def on_mean_blade(one: Identified, shape: MeanBlade) -> Member:
    """Return the likelihood of ``one``, shifted from its own blade to a mean blade."""
    mean = shape.propeller(one.tested, one.diameter_m, one.pitch_m, one.blades)
    return member(one).shifted(equivalent(catalogue.load(one.propeller), mean))


def member_without_blade(one: Identified) -> Member:
    """Return the likelihood of ``one``, which was identified on the mean blade of all families."""
    return member(one, family_prior([], bundled_population("population"), one.size))


def _of_constants(prior: PopulationPrior) -> SectionCovariance:
    slopes = slopes_of(prior.mean)
    return SectionCovariance(PARAMETERS, slopes @ prior.covariance @ slopes.T)


# -------------------------------------------------------------------------------------------------
# Mean blade of one series of propellers, or of several.
#
# Within a series, chord / radius, and twist minus the screw angle of the labeled pitch, depend
# little on the size.  Their means over the measured blades of a series, or over all series with
# equal weight, define a blade of any size.

SHARES = np.linspace(0.15, 1.0, 18)
"""Radii in tip radii at which blades are averaged: the stations of most measured blades."""


class MeasuredShape(NamedTuple):
    """A blade without its size: chord divided by tip radius [-], and twist minus ``screw_angle``
    [rad], (18,) at ``SHARES``; NaN inside the first measured station."""

    family: str  # code of its series
    size: tuple[float, float]  # labeled diameter and pitch [m]
    chord: Floats
    offset: Floats


@dataclass(frozen=True, eq=False)
class MeanBlade:
    """Mean chord and twist (n,) of one series, or of several series with equal weight."""

    families: tuple[str, ...]
    propellers: int  # number of measured propellers
    share: Floats  # radii divided by the tip radius, from the radius where most blades begin
    chord: Floats  # divided by the tip radius [-]
    offset: Floats  # twist minus the screw angle of the labeled pitch [rad]

    def propeller(self, name: str, diameter: float, pitch: float, blades: int) -> Propeller:
        """Return a propeller of this shape with labeled ``diameter`` and ``pitch`` [m]."""
        radius = 0.5 * diameter
        of = self.families[0] if len(self.families) == 1 else f"{len(self.families)} families"
        source = "not measured: chord over radius, and twist minus the screw angle of the labeled "
        source += f"pitch, are means over {self.propellers} propellers of {of}"
        twist = self.offset + screw_angle(self.share, pitch / diameter)
        blade = self.share * radius, self.chord * radius, twist, None
        citation = "geometry: propellers of the catalogue"
        return Propeller(name, blades, *blade, source, citation)


def screw_angle(share: Floats, pitch_ratio: float) -> Floats:
    """Return the angle [rad] of a screw at a ``share`` of the radius, atan(P / (2 pi r))."""
    return np.arctan(pitch_ratio / (math.pi * share))


@lru_cache(maxsize=1)
def measured_shapes() -> tuple[MeasuredShape, ...]:
    """Return the mean of measured specimens by series and size, without blades of APC's files."""
    blades_of: dict[tuple[str, tuple[float, float]], list[tuple[Floats, Floats]]] = {}
    for entry in catalogue.entries():
        if entry.name in apc.apc_blades():
            continue
        label = designation(entry.title)
        assert label is not None  # a test reads all titles
        blade = catalogue.load(entry.name)
        share = blade.station / blade.radius
        # The tolerance keeps grid points at a rounded first station.
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
    """Return the codes of the series with a measured blade."""
    return {one.family for one in measured_shapes()}


@lru_cache(maxsize=32)
def bundled_mean(families: tuple[str, ...] = ()) -> MeanBlade:
    """Return the mean blade of ``families`` of the catalogue, or of all."""
    return mean_blade(measured_shapes(), families)


def mean_blade(shapes: Sequence[MeasuredShape], families: Collection[str] = ()) -> MeanBlade:
    """Return the mean blade of the ``shapes`` of ``families``, or of all families."""
    by_family: dict[str, list[Floats]] = {}
    for one in shapes:
        by_family.setdefault(one.family, []).append(np.stack([one.chord, one.offset]))
    chosen = tuple(families) or tuple(by_family)
    means = np.stack([_mean(np.stack(by_family[family])) for family in chosen])
    counted = sum(len(by_family[family]) for family in chosen)
    begun = np.mean(np.isfinite(means[:, 0]), axis=0) >= 0.5
    return MeanBlade(chosen, counted, SHARES[begun], *_mean(means[..., begun]))


def label_size(label: Designation) -> tuple[float, float]:
    """Return the labeled diameter and pitch [m], rounded for comparisons."""
    return round(label.diameter, 5), round(label.pitch, 5)


def _mean(some: Floats) -> Floats:
    """Return the mean over the first axis without NaN; NaN if all values are NaN."""
    return np.asarray(np.ma.masked_invalid(some).mean(axis=0).filled(np.nan))


# -------------------------------------------------------------------------------------------------
# Equivalent section constants for another blade.
#
# A factor on the chord at all stations acts like this factor on the force coefficients.  An angle
# added to the twist at all stations acts like a decrease of the zero-lift angle by this angle; the
# other angles of the section law are measured from the zero-lift angle.  So a change of the
# constants represents the uncertainty of the blade.

INNERMOST = 0.3  # share of the radius outside which blades are compared

_FORCES = np.array([name in ("c_l1", "c_l2", "c_d", "c_d0") for name in PARAMETERS], float)
# The coordinate of the drag angle is measured from the chord line, like the zero-lift angle.
_ANGLES = np.array([name in ("zero_lift_angle", "drag_angle") for name in PARAMETERS], float)


def equivalent(blade: Propeller, other: Propeller) -> Floats:
    """Return the change of coordinates (P,) from a ``blade`` to the ``other``, for equal loads.

    It consists of the logarithm of the mean chord ratio, and of minus the mean difference of the
    twist [rad].  Both means are weighted by the squared radius times the chord of ``other``.  Both
    blades have the same radius.
    """
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


# --- Prior of the section constants of a propeller -----------------------------------------------

LOGARITHMIC = np.array([CONSTANTS[name].population == "log" for name in PARAMETERS])
"""Whether the coordinate is the logarithm of the constant (P,)."""

_DRAG_ANGLE, _ZERO_LIFT = PARAMETERS.index("drag_angle"), PARAMETERS.index("zero_lift_angle")


@dataclass(frozen=True, eq=False)
class PopulationPrior:
    """A normal distribution of coordinates of the P constants in ``PARAMETERS``.

    A coordinate is the constant, or its logarithm, see ``CONSTANTS``; for ``drag_angle`` it is the
    angle of least pressure drag from the chord line.
    """

    mean: Floats
    deviation: Floats
    correlation: Floats = field(default_factory=lambda: np.eye(len(PARAMETERS)))

    @classmethod
    def of(cls, mean: Floats, covariance: Floats) -> PopulationPrior:
        """Return the distribution with this ``mean`` (P,) and ``covariance`` (P, P)."""
        deviation = np.sqrt(np.diag(covariance))
        return cls(mean, deviation, covariance / np.outer(deviation, deviation))

    @property
    def covariance(self) -> Floats:
        """Covariance of the coordinates, (P, P)."""
        return np.outer(self.deviation, self.deviation) * self.correlation


_MEAN = np.array([5.31, 2.4, 2.45, 0.226, -0.045, 0.024, -0.023, 0.13, -0.4, 0.025])
_BETWEEN = np.array([0.16, 0.12, 0.38, 0.10, 0.024, 0.43, 0.014, 0.04, 0.1, 0.019])
_WITHIN = np.array([0.09, 0.12, 0.17, 0.10, 0.014, 0.16, 0.007, 0.03, 0.07, 0.012])
_CENTER = np.where(LOGARITHMIC, np.log(np.where(LOGARITHMIC, _MEAN, 1.0)), _MEAN)
POPULATION = PopulationPrior(_CENTER, np.hypot(_BETWEEN, _WITHIN))
"""Small propellers: means over 129 propellers, and their spread between and within families, from a
first identification of the UIUC database."""


def coordinates(constants: Floats) -> Floats:
    """Return the coordinates of constants (..., P) in the order of ``PARAMETERS``."""
    found = np.where(LOGARITHMIC, np.log(np.where(LOGARITHMIC, constants, 1.0)), constants)
    found[..., _DRAG_ANGLE] = constants[..., _DRAG_ANGLE] + constants[..., _ZERO_LIFT]
    return found


def constants_of(place: Floats) -> Floats:
    """Return the constants of coordinates (..., P), the inverse of ``coordinates``."""
    found = np.where(LOGARITHMIC, np.exp(np.where(LOGARITHMIC, place, 0.0)), place)
    found[..., _DRAG_ANGLE] = place[..., _DRAG_ANGLE] - place[..., _ZERO_LIFT]
    return found


def slopes_of(place: Floats) -> Floats:
    """Return the derivatives (P, P) of the constants with respect to coordinates ``place`` (P,)."""
    slopes = np.diag(np.where(LOGARITHMIC, constants_of(place), 1.0))
    slopes[_DRAG_ANGLE, _ZERO_LIFT] = -1.0
    return slopes


def coordinate_covariance(constants: Floats, covariance: Floats) -> Floats:
    """Return the covariance (P, P) of the coordinates from that of the ``constants`` (P,)."""
    back = np.linalg.inv(slopes_of(coordinates(constants)))
    return np.asarray(back @ covariance @ back.T)


# -------------------------------------------------------------------------------------------------
# Prediction for a propeller without identified constants, from its family or from all propellers.


class Member(NamedTuple):
    """Likelihood of the coordinates x of one propeller: exp(pull x - x precision x / 2)."""

    family: str  # code of its series
    tested: str  # name in the source
    size: Size  # labeled diameter and pitch [m]
    precision: Floats  # (P, P), singular if the data do not determine all coordinates
    pull: Floats  # (P,), ``precision`` times the coordinates that fit best

    def shifted(self, shift: Floats, spread: Floats | None = None) -> Member:
        """Return the member with ``shift`` (P,), of covariance ``spread`` (P, P), added to x."""
        pull, precision = self.pull + self.precision @ shift, self.precision
        if spread is None:
            return self._replace(pull=pull)
        known = np.linalg.inv(np.eye(shift.size) + precision @ spread)
        return self._replace(precision=known @ precision, pull=known @ pull)


def member(one: Identified, prior: PopulationPrior = POPULATION) -> Member:
    """Return the likelihood of ``one``: its constants without the ``prior`` of the fit."""
    place = coordinates(one.constants)
    both = np.linalg.inv(coordinate_covariance(one.constants, one.covariance))
    before = np.linalg.inv(prior.covariance)
    values, vectors = np.linalg.eigh(both - before)
    # Rounding may cause small negative eigenvalues in directions that the data do not determine.
    precision = (vectors * np.maximum(values, 0.0)) @ vectors.T
    # Center the likelihood at the constants of the fit, which the prior affected.  Constants fitted
    # to the data alone can be far outside the range in which the loads are linear.
    return Member(one.family, one.tested, one.size, precision, precision @ place)


def family_prior(members: Sequence[Member], population: Population, size: Size) -> PopulationPrior:
    """Return the distribution of another propeller of a family, given its ``members``; without
    members, the distribution over all propellers."""
    own = population.mean + population.shift(size)
    related = likeness([*(one.size for one in members), size])
    joint = np.kron(np.ones_like(related), population.between) + np.kron(related, population.within)
    # Beyond the data the trend may end or continue: the difference is one standard deviation.
    beyond = population.trend @ covariates(size) - population.shift(size)
    joint[-own.size :, -own.size :] += np.outer(beyond, beyond)
    if not members:
        return PopulationPrior.of(own, joint)
    known = own.size * len(members)
    precision = np.zeros((known, known))
    for k, one in enumerate(members):
        place = slice(k * own.size, (k + 1) * own.size)
        precision[place, place] = one.precision
    center = np.concatenate([population.mean + population.shift(one.size) for one in members])
    pull = np.concatenate([one.pull for one in members]) - precision @ center
    towards = joint[known:, :known] @ np.linalg.inv(
        np.eye(known) + precision @ joint[:known, :known]
    )
    covariance = joint[known:, known:] - towards @ precision @ joint[:known, known:]
    return PopulationPrior.of(own + towards @ pull, 0.5 * (covariance + covariance.T))


# -------------------------------------------------------------------------------------------------
# Distribution of section constants over small propellers: by size, between and within families.
#
# The coordinates of a propeller are the sum of the mean of its family, a trend with size common to
# all families, and a deviation.  Within a family, deviations correlate for similar sizes.

MIDDLE = (0.2286, 0.6)  # reference size of a family's mean: diameter [m], pitch / diameter

LIKENESS_WIDTH = (0.4, 0.3)
"""Widths of the Gaussian correlation of deviations within a family, in the logarithm of diameter
and in pitch / diameter.  They and ``OWN_SHARE`` maximize the likelihood of all populations."""

OWN_SHARE = 0.25  # fraction of the variance within families not common to members of equal size

GEOMETRIES = ("measured", "family", "population")  # origins of blades, see ``Identified.geometry``
Size = tuple[float, float]  # labeled diameter and pitch [m]
MEDIUM = (MIDDLE[0], MIDDLE[0] * MIDDLE[1])


@dataclass(frozen=True, eq=False)
class Population:
    """A normal distribution of the coordinates of ``PopulationPrior`` over propellers."""

    mean: Floats  # (P,) over families, for a propeller of the size ``MIDDLE``
    trend: Floats  # (P, 2) derivatives with respect to the two ``covariates``
    between: Floats  # (P, P) covariance of the means of families
    within: Floats  # (P, P) covariance of propellers about the mean of their family
    low: Floats  # (2,) range of the covariates in the data; the trend is constant outside
    high: Floats
    errors: Floats  # (2,) residual standard deviations of C_T and C_P [-], with the best constants

    def shift(self, size: Size) -> Floats:
        """Return the contribution (P,) of the trend at a ``size``."""
        return self.trend @ np.clip(covariates(size), self.low, self.high)


def covariates(size: Size) -> Floats:
    """Return log diameter and pitch / diameter of a size relative to ``MIDDLE``, (2,)."""
    diameter, pitch = size
    return np.array([np.log(diameter / MIDDLE[0]), pitch / diameter - MIDDLE[1]])


def likeness(sizes: Sequence[Size]) -> Floats:
    """Return correlations (n, n) of members of a family; 1 - ``OWN_SHARE`` for equal sizes."""
    place = np.stack([covariates(size) for size in sizes]) / LIKENESS_WIDTH
    distance = ((place[:, None] - place[None]) ** 2).sum(axis=-1)
    return (1.0 - OWN_SHARE) * np.exp(-0.5 * distance) + OWN_SHARE * np.eye(len(place))


@lru_cache(maxsize=4)
def bundled_population(geometry: str = "measured") -> Population:
    """Return the bundled population of one of ``GEOMETRIES``."""
    file = Path(__file__).parent / "identified" / "population.toml"
    return parse_populations(file.read_text(encoding="utf-8"))[geometry]


def parse_populations(text: str) -> dict[str, Population]:
    """Return the populations in the ``text`` of a file, by the origin of their blades."""
    tables = tomllib.loads(text).items()
    return {n: Population(**{key: np.array(v) for key, v in table.items()}) for n, table in tables}
