"""What a family says of a further propeller."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from propmap.catalogue.family_prior import family_prior
from propmap.catalogue.identified import all_identified
from propmap.catalogue.prior import POPULATION, constants_of, coordinates
from propmap.catalogue.spread import Spread, variance_of
from propmap.fit.population.coefficients import airfoil_of
from propmap.fit.population.left_out import by_designation, left_out
from propmap.fit.population.misfiled import refiled
from propmap.io.uiuc_database import read_uiuc_database
from tests.fit.population.test_catalogue import LOADS, with_data

MEAN, TOTAL = POPULATION.mean, POPULATION.deviation
SPREAD = Spread(MEAN, 0.8 * TOTAL, 0.6 * TOTAL)


def test_of_an_unknown_family_all_propellers_are_the_prior() -> None:
    found = family_prior([], SPREAD)
    np.testing.assert_allclose(found.mean, MEAN)
    np.testing.assert_allclose(found.deviation, TOTAL, rtol=1e-12)


def test_many_members_leave_the_spread_within_the_family() -> None:
    place = MEAN + 0.5 * TOTAL
    one = replace(all_identified()[0], airfoil=airfoil_of(constants_of(place)))
    found = family_prior([one] * 3000, SPREAD)
    np.testing.assert_allclose(found.mean, place, rtol=1e-2)
    np.testing.assert_allclose(found.deviation, SPREAD.within, rtol=1e-2)


def test_one_member_is_weighed_by_its_own_error() -> None:
    one = all_identified()[0]
    found = family_prior([one], SPREAD)
    doubt = SPREAD.within**2 + variance_of(one)
    share = SPREAD.between**2 / (SPREAD.between**2 + doubt)
    np.testing.assert_allclose(
        found.mean, MEAN + share * (coordinates(one.constants) - MEAN), rtol=1e-10
    )


@with_data
def test_a_family_predicts_better_than_all_propellers() -> None:
    """Of one family, whose blades are alike, with all others as the population."""
    chosen = [one for one in all_identified() if one.family in ("apcsf", "gwssf", "kyosho", "mae")]
    found = left_out(chosen, refiled(read_uiuc_database(LOADS)))
    own, family, population = (
        np.median([getattr(one, name) for one in found], axis=0)
        for name in ("own", "family", "population")
    )
    assert (own < 0.05).all()
    assert (own < family).all() and (family < population).all()
    blades = np.median([[one.family_blade, one.population_blade] for one in found], axis=0)
    # One propeller in its family's blade may do better by chance, half of them do not.
    assert (blades[0] > own).all() and (blades[0] < blades[1]).all()


@with_data
def test_propellers_whose_blades_were_never_measured() -> None:
    """Of three series; their loads are in none of the constants."""
    every = [
        one
        for one in read_uiuc_database(LOADS)
        if one.family in ("apcsf", "grsn", "kyosho") or one.name.startswith("ancf 1")
    ]
    found = {one.tested: one for one in by_designation(every)}
    assert {one.family for one in found.values()} == {"apcsf", "grsn", None}
    assert not any("125" in name or "x65" in name for name in found)
    known = [one.errors for one in found.values() if one.family]
    other = [one.errors for one in found.values() if not one.family]
    assert len(known) == 7 and len(other) > 20
    assert (np.median(known, axis=0) < 0.15).all()
    assert (np.median(known, axis=0) < np.median(other, axis=0)).all()
