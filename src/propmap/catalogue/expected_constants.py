"""Section constants to expect of a propeller that was not identified: its family's, or any's."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from propmap import catalogue
from propmap.catalogue.designation import designation
from propmap.catalogue.equivalent import equivalent
from propmap.catalogue.expected_blade import ExpectedBlade
from propmap.catalogue.family_prior import Member, family_prior, member
from propmap.catalogue.identified import (
    PARAMETERS,
    Identified,
    all_identified,
    identified_without_blade,
    one_of_each,
)
from propmap.catalogue.mean_blade import MeanBlade, bundled_mean
from propmap.catalogue.population import MIDDLE, Size, bundled_population
from propmap.catalogue.prior import HELD, PopulationPrior, constants_of, slopes_of
from propmap.model.airfoil import Airfoil, SectionCovariance, SectionUncertainty
from propmap.model.model import Propeller
from propmap.typing import Floats

MEDIAN_ERRORS = {"family": 0.09, "population": 0.12}
"""Of C_T and C_P of propellers that were left out, by ``python -m tools.left_out``: half of them
err less, rms over rms."""


class ExpectedConstants(NamedTuple):
    """Constants of a propeller that was not identified, and how far its loads may be off.

    Attributes
    ----------
    airfoil : Airfoil
        The constants, with how well they are known.
    told : str
        In one line: how many propellers they are from and how far loads may err.
    """

    airfoil: Airfoil
    told: str


def expected_constants(
    family: str | None = None, size: Size | None = None, geometry: str = "measured"
) -> ExpectedConstants:
    """The most likely constants of a small propeller.

    Parameters
    ----------
    family : str, optional
        Code of its series in the catalogue, such as "apcsf"; None where it is not known.
    size : tuple of float, optional
        Labelled diameter and pitch [m], see ``size_of``; a middling one where it is not known.
    geometry : str
        Its blade: "measured", or expected by the means of its "family" or of the "population".
    """
    prior = expected_prior(family, size, geometry)
    members = _members(family, geometry)
    known = members and geometry != "population"
    name = f"{family} expected" if members else "small propeller expected"
    source = f"prior over propellers by propmap, family {family if members else 'unknown'}"
    likely = MEDIAN_ERRORS["family" if known else "population"]
    of = (
        f"of its family, {family}, {len(members)} propellers"
        if members
        else f"of {len(all_identified())} small propellers, none of its family"
    )
    told = (
        f"constants as to be expected by those {of}; it was not identified itself: half of such "
        f"propellers have thrust and torque within {likely:.0%} (rms) in axial flow, one in ten is "
        "off by twice that"
    )
    errors = bundled_population(geometry).errors
    with_blade = None
    if geometry != "measured":
        with_blade = _of_constants(expected_prior(family, size))
    known_to = SectionUncertainty(
        _of_constants(prior),
        float(errors[0]),
        float(errors[1]),
        with_blade=with_blade,
    )
    law = airfoil_at(prior.mean, name, source).with_parameters(uncertainty=known_to)
    return ExpectedConstants(law, told)


def airfoil_at(place: Floats, name: str, source: str) -> Airfoil:
    """The section law at coordinates of the constants.

    Parameters
    ----------
    place : ndarray, shape (7,)
        As in ``prior.PopulationPrior``.
    name, source : str
        Of the set.
    """
    found = zip(PARAMETERS, constants_of(place).tolist(), strict=True)
    values: Any = {**HELD, **dict(found)}
    return Airfoil(**values, name=name, source=source)


def expected_prior(
    family: str | None = None,
    size: Size | None = None,
    geometry: str = "measured",
    without: str | None = None,
) -> PopulationPrior:
    """The distribution of a propeller's constants without its own data.

    Parameters
    ----------
    family, size, geometry
        As in ``expected_constants``.
    without : str, optional
        What the database calls a propeller that is left out.
    """
    members = [one for one in _members(family, geometry) if one.tested != without]
    population = bundled_population(geometry)
    return family_prior(members, population, size or (MIDDLE[0], MIDDLE[0] * MIDDLE[1]))


def siblings(family: str | None, without: str | None = None) -> int:
    """How many propellers of a ``family`` were identified, one that is left out apart.

    Parameters
    ----------
    family : str or None
        Code of its series in the catalogue; None where it is not known.
    without : str, optional
        What the database calls a propeller that is left out.
    """
    return sum(one.tested != without for one in _members(family, "measured"))


def size_of(meant: catalogue.Entry | ExpectedBlade | None, blade: Propeller) -> Size:
    """Labelled diameter and pitch [m] of what a name means, as ``lookup.meant_by`` gives it.

    Of a file, None, they are the blade's diameter and the pitch of its twist at three quarters of
    the radius, which is 3 % of the diameter above labels in the mean over those measured.
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
    """What is known of the family's propellers, on the blade of this ``geometry``."""
    if geometry == "population":
        return [
            member_without_blade(one)
            for one in identified_without_blade()
            if one.family == family and one.geometry == "population"
        ]
    measured = one_of_each([one for one in all_identified() if one.family == family])
    if geometry == "measured" or not measured:
        return [member(one) for one in measured]
    return [on_mean_blade(one, bundled_mean((one.family,))) for one in measured]


def on_mean_blade(one: Identified, shape: MeanBlade) -> Member:
    """What the data of ``one`` say of the constants with a mean blade in place of its own."""
    mean = shape.propeller(one.tested, one.diameter_m, one.pitch_m, one.blades)
    return member(one).moved(equivalent(catalogue.load(one.propeller), mean))


def member_without_blade(one: Identified) -> Member:
    """What the data of ``one`` say, which was identified on the mean blade of all families."""
    return member(one, family_prior([], bundled_population("population"), one.size))


def _of_constants(prior: PopulationPrior) -> SectionCovariance:
    slopes = slopes_of(prior.mean)
    return SectionCovariance(PARAMETERS, slopes @ prior.covariance @ slopes.T)
