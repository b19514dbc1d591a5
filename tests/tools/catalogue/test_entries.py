"""All propellers of a table: which blades they get, runs that are misfiled, and a run continued."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from propmap.catalogue.expected import GEOMETRIES, bundled_population
from propmap.catalogue.identified import Identified, all_identified, identified_without_blade
from tests.workers_elsewhere import Elsewhere
from tools.catalogue import entries
from tools.catalogue.database import (
    MISFILED,
    MeasuredPropeller,
    blade_names,
    label_of,
    read_uiuc_database,
    refiled,
)
from tools.catalogue.population import populations_of
from tools.catalogue.verdict import conflict, summary

LOADS = Path(__file__).parents[4] / "shared" / "data" / "uiuc" / "loads.csv"
with_data = pytest.mark.skipif(not LOADS.exists(), reason="the database is not there")


@pytest.fixture(scope="module")
def every() -> list[MeasuredPropeller]:
    return read_uiuc_database(LOADS)


@with_data
def test_refiled_runs_agree_with_those_beside_them(every: list[MeasuredPropeller]) -> None:
    before = {one.name: one for one in every}
    after = {one.name: one for one in refiled(every)}
    rows = [sum(one.rpm.size for one in part.values()) for part in (before, after)]
    assert rows[0] == rows[1]
    for name in ("nr640 9x5.68 - 3", "nr640 9x5.68 - 4", "nr640 5x3.16 - 4"):
        assert min(conflict(before[name])) > 0.15
        assert max(conflict(after[name])) < 0.05
    assert {name for name, _ in MISFILED} <= set(before)
    # Labels that lost a decimal point are put right.
    assert not any("125" in name or "x65" in name for name in after)
    assert {"ancf 12.5x7.5 - 2", "ancf 12.0x6.5 - 2", "ancf 13.0x6.5 - 2"} <= set(after)
    label = label_of(after["ancf 12.5x7.5 - 2"])
    assert (label.diameter, label.pitch) == pytest.approx((12.5 * 0.0254, 7.5 * 0.0254))
    # A pitch of 65 inches would stop to give thrust at J above 5.
    assert after["ancf 12.0x6.5 - 2"].advance.max() < 1.0


@with_data
def test_blades_are_those_of_the_catalogue(every: list[MeasuredPropeller]) -> None:
    names = {one.name: blade_names(one) for one in every}
    assert len(names["gwsdd 5.0x4.3 - 2"]) == 3
    assert names["apcsp 10.0x6.0 - 2"] == ["uiuc-apcsp-10x6"]
    assert names["apce 9.0x6.0 - 2"] == ["uiuc-apce-9x6", "apc-9x6e"]
    measured = [found for found in names.values() if any(name[:4] == "uiuc" for name in found)]
    assert len(measured) == 134


@pytest.mark.slow
@with_data
def test_the_bundled_constants_are_what_the_command_finds(
    every: list[MeasuredPropeller], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One propeller, with another number of blades too; and known results are not fitted again."""
    some = [one for one in refiled(every) if one.blade == "da4022 5.0x3.75"][:2]
    bundled = {one.key: one for one in all_identified()}
    workers, kept = Elsewhere(), list[tuple[list[int], list[int]]]()

    def keep(*told: list[Identified]) -> None:
        before, new = ([one.blades for one in some] for some in told)
        kept.append((before, new))

    monkeypatch.setattr(entries, "TOGETHER", 1)
    found = entries.identify_all(some, {}, keep, workers)
    assert workers.tasks == 2
    assert kept == [([], [3]), ([3], [2])]
    assert [one.blades for one in found] == [2, 3]
    for one in found:
        same = bundled[one.key]
        apart = np.abs(one.constants - same.constants) / np.sqrt(np.diag(one.covariance))
        # The digits of the file, processors that round differently, and nodes of panels, which were
        # shared in another way when the constants were identified: loads moved within 1e-4.
        assert apart.max() < 5e-3
    again = entries.identify_all(some, bundled, keep)
    assert len(kept) == 2 and again[0] is bundled[again[0].key]
    told = summary(all_identified())
    assert told.propellers > 125 and len(told.worst) == 10
    assert "gwsdd 5.0x4.3 - 2" in [one.tested for one in told.worst]


@with_data
def test_propellers_without_blade_are_what_the_command_finds(
    every: list[MeasuredPropeller],
) -> None:
    """A family with measured blades and one without, from the bundled constants."""
    names = ("apcsp 9.0x9.0 - 2", "ancf 12.5x7.5 - 2")
    some = [one for one in refiled(every) if one.name in names]
    measured = all_identified()
    populations = {name: bundled_population(name) for name in GEOMETRIES}
    found = entries.identify_without_blade(
        some, measured, populations, {}, lambda *_: None, Elsewhere()
    )
    assert [one.geometry for one in found] == ["family", "population"]
    bundled = {one.key: one for one in identified_without_blade()}
    for one in found:
        same = bundled[one.key]
        apart = np.abs(one.constants - same.constants) / np.sqrt(np.diag(one.covariance))
        assert apart.max() < 5e-3 and same.propeller == one.propeller  # as above
    again = entries.identify_without_blade(some, measured, populations, bundled, print)
    assert [one.key for one in again] == [one.key for one in found]


@pytest.mark.slow
def test_the_bundled_populations_are_what_the_command_finds() -> None:
    found = populations_of(all_identified())
    for name, one in found.items():
        same = bundled_population(name)
        scale = np.sqrt(np.diag(one.between + one.within))
        assert np.abs((one.mean - same.mean) / scale).max() < 1e-4
        assert np.abs((one.trend - same.trend) / scale[:, None]).max() < 1e-4
        for part in ("between", "within"):
            apart = getattr(one, part) - getattr(same, part)
            assert np.abs(apart / np.outer(scale, scale)).max() < 1e-4
        np.testing.assert_allclose(one.errors, same.errors, rtol=1e-6)
