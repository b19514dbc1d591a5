"""The pages on propellers: a card for each with the bundled numbers, the list, the population."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from propmap.catalogue.expected import POPULATION, bundled_population, coordinates
from propmap.catalogue.identified import PARAMETERS, Identified, all_identified, identified
from tools import measured_rows
from tools.catalogue.database import read_uiuc_database, refiled
from tools.catalogue.verdict import summary
from tools.propeller_pages import listing, population, words
from tools.propeller_pages.card import card
from tools.propeller_pages.comparison import compare

from .pages import ROOT

ROWS = measured_rows.read()
LOADS = ROOT.parent / "shared" / "data" / "uiuc" / "loads.csv"

SOME = (("uiuc-da4022-5x3.75", 3), ("uiuc-apcsf-11x3.8", 2))
"""One with three blades, and one that is flagged."""


def entry(name: str, blades: int) -> Identified:
    found = identified(name, blades)
    assert found is not None
    return found


@pytest.mark.parametrize(("name", "blades"), SOME)
def test_a_card_tells_the_bundled_numbers_and_the_verdict(name: str, blades: int) -> None:
    one = entry(name, blades)
    text = card(one, ROWS[one.tested])
    plain = text.replace("\N{MINUS SIGN}", "-").replace("&#x27;", "'")
    assert all(part in plain for part in one.verdict.split("; "))
    assert ("Limits of this fit" in text) == (not one.verdict.endswith("good"))
    deviations = np.sqrt(np.diag(one.covariance))
    for parameter, value, deviation in zip(PARAMETERS, one.constants, deviations, strict=True):
        (row,) = [line for line in plain.splitlines() if line.startswith(f"| `{parameter}` |")]
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        assert float(cells[2].split()[0]) == pytest.approx(value, abs=6e-5)
        assert float(cells[3]) == pytest.approx(deviation, abs=6e-5)
    for number in (f"{one.thrust_rms:.4f}", f"{one.power_rms:.4f}", f"{one.rpm_low:.0f}"):
        assert number in plain
    assert f"| {one.rows}, " in plain.replace("| rows ", "") and one.tested in plain
    assert "UIUC Propeller Database" in text
    assert "nan" not in re.findall(r"[a-z]+", text) and len(text) < 40_000


def test_every_propeller_has_the_rows_of_its_fit() -> None:
    """Otherwise run `python -m tools.measured_rows LOADS`."""
    for one in all_identified():
        rows = ROWS[one.tested]
        assert (rows.rpm.size, int((rows.advance == 0.0).sum())) == (one.rows, one.static_rows)
        assert rows.blades == one.blades
    for name, blades in SOME:
        one = entry(name, blades)
        rms = np.sqrt(np.mean(compare(one, ROWS[one.tested]).error ** 2, axis=1))
        np.testing.assert_allclose(rms, [one.thrust_rms, one.power_rms], atol=2e-5)


@pytest.mark.skipif(not LOADS.exists(), reason="needs the database's table of loads")
def test_rows_kept_are_those_of_the_database() -> None:
    every = {one.name: one for one in refiled(read_uiuc_database(LOADS))}
    kept = measured_rows.FILE.read_text(encoding="utf-8")
    assert measured_rows.as_text([every[name] for name in ROWS]) == kept


LISTED = listing.listing(all_identified())
ITEMS = re.findall("<li [^>]*>", LISTED)


def test_the_list_has_every_propeller_and_hides_none() -> None:
    """The box is hidden until the script is there; without it all propellers are shown."""
    cards = {f"propellers/{words.page_name(one)}.html" for one in all_identified()}
    assert len(cards) == len(all_identified()) == len(ITEMS)
    assert {*re.findall('(?:href|src)="([^"]*)"', LISTED)} == {*cards, "_static/propellers.js"}
    assert len(re.findall("<div [^>]*hidden", LISTED)) == 1
    assert not any("hidden" in item for item in ITEMS)
    flagged = sum('class="flagged"' in item for item in ITEMS)
    assert flagged == sum(not one.verdict.endswith("good") for one in all_identified()) > 20


def test_the_worst_have_reasons_and_cards() -> None:
    text = listing.worst(all_identified(), ROWS)
    assert "not examined" not in text
    for one in summary(all_identified()).worst:
        assert f"propellers/{words.page_name(one)}.md" in text and f"{one.thrust_rms:.4f}" in text


def test_the_population_shows_every_propeller_where_it_is() -> None:
    entries = all_identified()
    groups = ElementTree.fromstring(population.picture(entries)).findall("g")
    # Marks are at round values; along each column a place is linear in the coordinate.
    by_title = {group.findtext("title", ""): group for group in groups}
    assert set(by_title) == set(map(words.title, entries)) and len(groups) == len(entries)
    marks = [by_title[words.title(one)][2].attrib["d"] for one in entries]
    places = np.array([re.findall(r"M([\d.]+) [\d.]+h0", one) for one in marks], float)
    own = coordinates(np.stack([one.constants for one in entries]))
    assert places.shape == own.shape == (len(entries), len(PARAMETERS))
    for drawn_at, value in zip(places.T, own.T, strict=True):
        assert np.corrcoef(drawn_at, value)[0, 1] > 0.99999
    table = population.table()
    assert f"{np.exp(bundled_population('measured').mean[0]):.3f}" in table
    assert f"{np.exp(POPULATION.mean[1]):.3f}" in table
