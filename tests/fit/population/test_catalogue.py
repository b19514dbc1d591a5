"""All propellers of a table: which blades they get, runs that are misfiled, and a run continued."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from propmap.catalogue.identified import Identified, all_identified
from propmap.catalogue.prior import coordinates
from propmap.catalogue.spread import spread
from propmap.fit.population import catalogue, identification
from propmap.fit.population.misfiled import MISFILED, refiled
from propmap.fit.population.summary import summary
from propmap.fit.population.verdict import conflict
from propmap.io.uiuc_database import MeasuredPropeller, read_uiuc_database

LOADS = Path(__file__).parents[4] / "shared" / "data" / "uiuc" / "loads.csv"
with_data = pytest.mark.skipif(not LOADS.exists(), reason="the database is not there")


def made(name: str, blade: str, blades: int, rpm: list[float]) -> MeasuredPropeller:
    n = len(rpm)
    advance, run = np.linspace(0.1, 0.3, n), np.cumsum(np.diff(rpm, prepend=rpm[0]) != 0.0)
    return MeasuredPropeller(
        name, blade, "nr640", blades, np.array(rpm), advance, 0.1 - 0.1 * advance, advance, run
    )


def test_runs_go_to_the_number_of_blades_that_they_have() -> None:
    four = made("nr640 9x5.68 - 4", "nr640 9x5.68", 4, [4035.0, 4035.0, 6024.0])
    two = made("nr640 9x5.68 - 2", "nr640 9x5.68", 2, [5032.0, 5032.0])
    gone = made("nr640 9x7.72 - 4", "nr640 9x7.72", 4, [4051.0, 4058.0])
    found = {one.name: one for one in refiled([four, two, gone])}
    assert set(found) == {"nr640 9x5.68 - 4", "nr640 9x5.68 - 2", "nr640 9x7.72 - 2"}
    np.testing.assert_array_equal(found["nr640 9x5.68 - 4"].rpm, [6024.0])
    np.testing.assert_array_equal(found["nr640 9x5.68 - 2"].rpm, [5032.0, 5032.0, 4035.0, 4035.0])
    assert len(set(found["nr640 9x5.68 - 2"].run)) == 2
    assert [found[name].blades for name in sorted(found)] == [2, 4, 2]


@with_data
def test_refiled_runs_agree_with_those_beside_them() -> None:
    every = read_uiuc_database(LOADS)
    before = {one.name: one for one in every}
    after = {one.name: one for one in refiled(every)}
    rows = [sum(one.rpm.size for one in part.values()) for part in (before, after)]
    assert rows[0] == rows[1]
    for name in ("nr640 9x5.68 - 3", "nr640 9x5.68 - 4", "nr640 5x3.16 - 4"):
        assert min(conflict(before[name])) > 0.15
        assert max(conflict(after[name])) < 0.05
    assert {name for name, _ in MISFILED} <= set(before)


@with_data
def test_blades_are_those_of_the_catalogue() -> None:
    names = {one.name: catalogue.blade_names(one) for one in read_uiuc_database(LOADS)}
    assert names["apce 10.0x5.0 - 2"] == ["uiuc-apce-10x5"]
    assert names["apce 9.0x6.0 - 2"] == ["uiuc-apce-9x6", "apc-9x6e"]
    assert names["apce 8.0x6.0 - 2"] == ["apc-8x6e"]
    assert len(names["gwsdd 5.0x4.3 - 2"]) == 3
    measured = [found for found in names.values() if any(name[:4] == "uiuc" for name in found)]
    assert len(measured) == 134


@with_data
def test_the_bundled_constants_are_what_the_command_finds() -> None:
    """Of one propeller, of another number of blades too; and known results are not fitted again."""
    every = [one for one in refiled(read_uiuc_database(LOADS)) if one.blade == "da4022 5.0x3.75"]
    bundled = {one.key: one for one in all_identified()}
    found = catalogue.identify_all(every[:2], {}, lambda _: None)
    assert [one.blades for one in found] == [2, 3]
    for one in found:
        same = bundled[one.key]
        apart = np.abs(one.constants - same.constants) / np.sqrt(np.diag(one.covariance))
        # The digits of the file, and compilers that round differently.
        assert apart.max() < 1e-3
    called: list[list[Identified]] = []
    again = catalogue.identify_all(every[:2], bundled, called.append)
    assert not called and again[0] is bundled[again[0].key]


def test_the_spread_over_propellers_is_that_of_the_draws() -> None:
    """Within families and between them, from made-up constants of small errors."""
    rng, entries = np.random.default_rng(27), []
    from dataclasses import replace

    from propmap.catalogue.prior import POPULATION, constants_of, slopes_of
    from propmap.fit.population.coefficients import airfoil_of

    template = all_identified()[0]
    for family in range(60):
        centre = POPULATION.mean + 0.4 * POPULATION.deviation * rng.normal(size=7)
        for member in range(4):
            place = centre + 0.2 * POPULATION.deviation * rng.normal(size=7)
            slopes = slopes_of(place)
            error = np.diag((0.1 * POPULATION.deviation) ** 2)
            place = place + 0.1 * POPULATION.deviation * rng.normal(size=7)
            entries.append(
                replace(
                    template,
                    family=str(family),
                    tested=f"{family}-{member}",
                    airfoil=airfoil_of(constants_of(place)),
                    covariance=slopes @ error @ slopes.T,
                )
            )
    found = spread(entries)
    np.testing.assert_allclose(found.between / POPULATION.deviation, 0.4, atol=0.12)
    np.testing.assert_allclose(found.within / POPULATION.deviation, 0.2, atol=0.05)
    np.testing.assert_allclose((found.mean - POPULATION.mean) / POPULATION.deviation, 0.0, atol=0.2)


def test_the_summary_names_the_worst() -> None:
    told = summary(all_identified())
    assert told.propellers > 125 and len(told.worst) == 10
    assert "gwsdd 5.0x4.3 - 2" in [one.tested for one in told.worst]
    assert np.isfinite(coordinates(told.worst[0].constants)).all()
    assert identification.INDEPENDENT == 10.0
