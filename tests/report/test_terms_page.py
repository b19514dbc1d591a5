"""The page on what each term of a flight fit is worth."""

from __future__ import annotations

import base64
import csv
import io
import re

import numpy as np
import pytest

from propmap.fit.comparison import AxisErrors, FittedStep, RecordedFlight
from propmap.report.html import PAGE, TERMS_FILES
from propmap.report.terms_page import HOVER_MODEL, terms_pages, worth
from tests.fit.test_flight_terms import COUNT, VEHICLE, flight, held

STEPS = ("vertical balance alone", "wakes", "noise")


def known(predicted: bool, names: tuple[str, ...] = ("first", "second")) -> list[RecordedFlight]:
    made = [flight(name) for name in names]
    if not predicted:
        return made
    weight = VEHICLE.mass * made[0].passed.specific_force
    return [RecordedFlight(f.name, f.passed, f.raw, weight + 0.4, weight + 0.5) for f in made]


def found(flights: list[RecordedFlight]) -> list[FittedStep]:
    """Wakes take half of the error away, noise adds a different one of the same size."""
    made, many = [], len(flights) > 1
    for number, (step, size) in enumerate(zip(STEPS, (0.6, 0.3, 0.3), strict=True)):
        for left_out in range(len(flights)) if many else (None,):
            offs = []
            for k in range(len(flights)):
                grown = 1.0 if k == left_out else 0.8
                # Noise leaves a part of what was there and adds as much.
                off = grown * size * np.sqrt(np.abs(held(1.0, 1.0, k if number < 2 else 90 + k)))
                offs.append(AxisErrors(off, 1.5 * off))
            hover = tuple(
                AxisErrors(np.full((COUNT, 3), 4.0), np.full((COUNT, 3), 5.0)) for _ in flights
            )
            made.append(FittedStep(step, left_out, {"c_l1": 5.0 + number}, tuple(offs), hover))
    return made


def test_worth_is_judged_on_what_was_not_seen() -> None:
    flights = known(predicted=False)
    first, second = worth(flights, found(flights))
    assert first[:2] == ("wakes", "pays") and first[2] > 2.0 * first[3]
    assert second[:2] == ("noise", "no sure gain")


@pytest.mark.parametrize(("names", "predicted"), [(("first", "second"), True), (("alone",), False)])
def test_the_page_tells_it_in_words_and_files(
    names: tuple[str, ...], predicted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("propmap.report.html.as_svg", lambda _: b"<svg/>")
    flights = known(predicted, names)
    fits = found(flights)
    pages = terms_pages(VEHICLE, flights, fits, low_pass=6.0, samples=300, remarks=["a remark <b>"])
    assert set(pages) == TERMS_FILES
    page, sheet, values = (
        str(pages[name]) for name in (PAGE, "fit-terms.csv", "fit-terms-values.csv")
    )
    assert "1 of 2 terms reduce the error" in page and "No significant change with: noise." in page
    # Text is no markup; units stand apart; pictures are inside, and nothing is fetched.
    assert "A remark &lt;b&gt;." in page and '<span class="unit">[N]</span>' in page
    pictures = re.findall(r'src="data:image/svg\+xml;base64,([^"]+)"', page)
    assert {base64.b64decode(one) for one in pictures} == {b"<svg/>"}
    assert not re.findall(r'(?:src|href)="(?:http|//)', page)
    assert not [word for word in ("<script", "@import", "url(") if word in page]
    assert ("prediction in the file" in page) == predicted
    assert ("give a second flight" in page) == (len(names) == 1)
    table = list(csv.DictReader(io.StringIO(sheet)))
    # Low-passed and as recorded; fitted to it and not, where there are two.
    per_flight = (2 if len(names) == 1 else 4) * len(STEPS) + 2 + 2 * predicted
    assert len(table) == per_flight * len(names)
    hover = {row["signals"]: row for row in table if row["model"] == HOVER_MODEL}
    assert float(hover["as recorded"]["z_rms_N"]) == 5.0
    assert len(values.splitlines()) == 1 + len(fits)
