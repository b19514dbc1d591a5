"""A report is one file: escaped text, tables with units, figures inside."""

from __future__ import annotations

import base64
import re
import xml.etree.ElementTree as ElementTree

import pytest

from propmap.errors import InputError
from propmap.report.page import (
    MINUS,
    MISSING,
    Page,
    Picture,
    Points,
    Section,
    Table,
    Text,
    Verdict,
    number,
    page_html,
)
from propmap.report.style import as_svg, new_figure, style

TABLE = Table(
    "Loads <here>",
    (("propeller", ""), ("thrust", "N"), ("points", "-")),
    (("8x6", f"{MINUS}1.5", "3"), ("9x6", MISSING, "12")),
    "a note",
)


def _page(*sections: Section) -> Page:
    return Page("A & B", "of <today>", (Text("first"),), sections, (("Data", "UIUC"),))


def _svg() -> bytes:
    with style():
        figure = new_figure(3.0, 2.0)
        figure.subplots().plot([0.0, 1.0], [0.0, 1.0], label="line")
    return as_svg(figure)


def test_the_page_is_whole_and_fetches_nothing() -> None:
    shown = Picture(_svg(), "a caption", "an alternative", "shown.svg")
    verdict = Verdict("caution", "With care", "up to 10 m/s")
    html = page_html(
        _page(Section("one", "One", (shown, verdict)), Section("two", "Two", (Points(("a", "b")),)))
    )
    found = re.search(r'src="data:image/svg\+xml;base64,([^"]+)" alt="an alternative"', html)
    assert found and base64.b64decode(found[1]) == shown.svg
    addresses = re.findall(r'(?:src|href)="([^"]*)"', html)
    assert addresses and not [a for a in addresses if a.startswith(("http", "//"))]
    assert "<script" not in html and "@import" not in html and "url(" not in html
    assert '<section id="one">' in html and "<strong>With care.</strong> up to 10 m/s" in html
    assert html.index("first") < html.index("<h2>One</h2>") < html.index("<h2>Two</h2>")
    assert "@media print" in html


def test_text_is_not_markup() -> None:
    html = page_html(_page(Section("one", "<One>", (TABLE, Text("1 < 2 <b>")))))
    assert "A &amp; B" in html and "&lt;One&gt;" in html and "Loads &lt;here&gt;" in html
    assert "<b>" not in html


def test_tables_have_units_and_align_numbers() -> None:
    assert TABLE.numeric == [False, True, True]
    html = page_html(_page(Section("one", "One", (TABLE,))))
    assert 'class="number">thrust <span class="unit">[N]</span>' in html
    assert f'<td class="number">{MINUS}1.5</td>' in html
    with pytest.raises(InputError, match="2 cells"):
        Table("t", (("a", ""),), (("1", "2"),))


def test_names_and_levels_are_checked() -> None:
    with pytest.raises(InputError, match="one name"):
        page_html(_page(Section("one", "One", ()), Section("one", "Two", ())))
    with pytest.raises(InputError, match="not a level"):
        Verdict("fine", "Yes", "")


def test_the_same_figure_gives_the_same_bytes() -> None:
    first = _svg()
    assert first == _svg()
    assert ElementTree.fromstring(first).tag.endswith("svg")
    assert b"<text" not in first


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.23456, "1.23"),
        (-0.5, f"{MINUS}0.5"),
        (2585.0, "2580"),
        (0.0000314159, "0.0000314"),
        (None, MISSING),
        (float("nan"), MISSING),
        (0.0, "0"),
    ],
)
def test_numbers(value: float | None, text: str) -> None:
    assert number(value) == text
