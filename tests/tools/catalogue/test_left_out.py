"""Propellers predicted from the others of their families."""

from __future__ import annotations

import numpy as np
import pytest

from propmap import catalogue
from propmap.catalogue.expected import GEOMETRIES, bundled_population
from propmap.catalogue.identified import all_identified, identified_without_blade
from tests.tools.catalogue.test_entries import LOADS, with_data
from tools.catalogue.database import read_uiuc_database, refiled
from tools.catalogue.left_out import GROUPS, LeftOut, left_out, never_measured

FAMILIES = ("apcsf", "gwssf", "kyosho", "mae")


@pytest.fixture(scope="module")
def found() -> list[LeftOut]:
    """Four families whose blades are alike, and of two whose blades were not measured."""
    every = refiled(read_uiuc_database(LOADS))
    chosen = all_identified()
    names = ("magf 7.0x4.0 - 2", "magf 8.0x4.0 - 2", "ance 8.5x6.0 - 2", "ance 8.5x7.0 - 2")
    others = [one for one in identified_without_blade() if one.tested in names]
    populations = {name: bundled_population(name) for name in GEOMETRIES}
    some = [one for one in every if one.family in FAMILIES]
    files = {entry.name: catalogue.load(entry.name) for entry in catalogue.search("apcsf")}
    return [
        *left_out(chosen, some, files),
        *never_measured(chosen, others, every, populations, files),
    ]


@with_data
@pytest.mark.slow
def test_what_is_known_makes_errors_smaller_and_bands_hold_most_rows(found: list[LeftOut]) -> None:
    count = {group: sum(one.group == group for one in found) for group in GROUPS}
    assert count["own"] == count["population"] == count["population_blade"] == 24
    assert count["family"] == count["family_blade"] == count["other_blade_of_family"] == 24
    assert count["family_label"] == count["siblings_label"] == count["population_label"] == 2
    assert count["maker"] == 10
    half = {
        group: np.median([one.found.errors for one in found if one.group == group], axis=0)
        for group in GROUPS
    }
    assert (half["own"] < 0.05).all()
    for less, more in (
        ("own", "family"),
        ("family", "population"),
        ("family_blade", "population_blade"),
        ("family_static", "population_static"),
    ):
        assert (half[less] < half[more]).all(), (less, more)
    # Rows that move have less thrust: the same error is a larger share of it.
    assert half["population_static"][0] < 1.2 * half["population"][0]
    inside = [one.found.moving for one in found if one.group.endswith("_static")]
    assert (np.mean(inside, axis=0) > 0.85).all()
    for group in ("family", "population", "family_blade", "population_blade"):
        own = [one.found for one in found if one.group == group]
        held = [np.concatenate([one.at_rest, one.moving]) for one in own]
        assert (np.nanmean(held, axis=0) > 0.85).all(), group
