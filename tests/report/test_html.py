"""Reports: escaped text, tables with units, figures inside; folders are whole or as before."""

from __future__ import annotations

import base64
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from jinja2 import DictLoader, Environment, FileSystemLoader

from propmap.errors import InputError
from propmap.report.html import (
    MINUS,
    MISSING,
    PAGE,
    FigureRecord,
    check_folder,
    columns_of,
    csv_of_columns,
    csv_of_rows,
    new_figure,
    number,
    report_files,
    sentence,
    style,
    write_folder,
)

BODY = """
{% extends "report/layout.html.j2" %}
{% set title = name %}
{% set sections = {"one": "<One>", "two": "Two", "three": "Three"} %}
{% from "report/parts.html.j2" import fact, figure, section, table, verdict with context %}
{% block subtitle %}of {{ name }}{% endblock %}
{% block lead %}{% call verdict("caution", "With care") %}up to 10 m/s{% endcall %}{% endblock %}
{% block body %}
{% call section("one") %}
{% call figure("shown", "an alternative") %}a caption{% endcall %}
{% endcall %}
{% call section("two") %}
{{ table("Loads <here>", heads, rows, "a note") }}
{% endcall %}
{% endblock %}
{% block facts %}{{ fact("Data", "UIUC") }}{{ fact("Nothing", "") }}{% endblock %}
"""
ROWS = [("8x6", -1.5, 3, "a"), ("9x6", None, 12, f"{MINUS}2")]


@pytest.fixture(autouse=True)
def _template(monkeypatch: pytest.MonkeyPatch) -> None:
    """A template of the test's own beside those of the package."""

    class Loader(FileSystemLoader):
        def get_source(self, environment: Environment, template: str):  # type: ignore[no-untyped-def]
            if template == "test":
                return DictLoader({"test": BODY}).get_source(environment, template)
            return super().get_source(environment, template)

    monkeypatch.setattr("jinja2.FileSystemLoader", Loader)


def _files(heads: str = "propeller|thrust [N]|points|kind") -> dict[str, str | bytes]:
    with style():
        figure = new_figure(3.0, 2.0)
        figure.subplots().plot([0.0, 1.0], [0.0, 1.0], label="line")
    values = {"name": "A & <B>", "heads": heads, "rows": ROWS}
    return report_files("test", {"shown": figure}, {"numbers": "a\n1\n"}, **values)


def _html() -> str:
    html = _files()[PAGE]
    assert isinstance(html, str)
    return html


def test_the_page_is_whole_and_fetches_nothing() -> None:
    files, html = _files(), _html()
    assert set(files) == {PAGE, "shown.svg", "numbers.csv"} and files["numbers.csv"] == "a\n1\n"
    found = re.search(r'src="data:image/svg\+xml;base64,([^"]+)" alt="an alternative"', html)
    assert found and base64.b64decode(found[1]) == files["shown.svg"]
    addresses = re.findall(r'(?:src|href)="([^"]*)"', html)
    assert addresses and not [a for a in addresses if a.startswith(("http", "//"))]
    assert "<script" not in html and "@import" not in html and "url(" not in html
    assert '<section id="one">' in html and "<strong>With care.</strong> up to 10 m/s" in html
    assert html.index("With care") < html.index('href="#two"') < html.index("<h2>Two</h2>")
    assert "<dt>Data</dt><dd>UIUC</dd>" in html and "Nothing" not in html
    assert "@media print" in html


def test_text_is_not_markup() -> None:
    html = _html()
    assert "A &amp; &lt;B&gt;" in html and "&lt;One&gt;" in html and "Loads &lt;here&gt;" in html
    assert "<B>" not in html


def test_tables_have_units_and_align_numbers() -> None:
    html = _html()
    assert 'class="number">thrust <span class="unit">[N]</span>' in html
    assert 'class="number">points</th>' in html and '<th scope="col">kind</th>' in html
    assert f'<td class="number">{MINUS}1.5</td>' in html
    assert f'<td class="number">{MISSING}</td>' in html and '<td class="number">12</td>' in html
    with pytest.raises(ValueError, match="zip"):
        _files(heads="propeller|thrust [N]")


def test_the_same_figure_gives_the_same_bytes() -> None:
    first = _files()["shown.svg"]
    assert isinstance(first, bytes) and first == _files()["shown.svg"]
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


def test_sentences() -> None:
    assert sentence("no data") == "No data." and sentence("é is 0.") == "É is 0."


def test_rows_as_csv() -> None:
    text = csv_of_rows("set a_N b_N", [("x", 1.0 / 3.0, float("nan")), ("y", 1e-20, None)])
    assert text == "set,a_N,b_N\nx,0.333333,\ny,0,\n"


def test_columns_as_csv() -> None:
    first = {"set": "x", "a": np.array([1.5, 2.0])[:, None], "b": np.arange(2)}
    text = csv_of_columns([first, {"set": "y", "a": 3.0, "b": None}])
    assert text == "set,a,b\nx,1.5,0\nx,1.5,1\nx,2,0\nx,2,1\ny,3,\n"


def test_a_record_gives_the_picture_and_the_numbers() -> None:
    columns = columns_of("load rms_N", [("thrust", 0.5), ("drag", float("nan"))])
    record = FigureRecord("errors", columns, lambda: new_figure(3.0, 2.0))
    assert record.csv() == "load,rms_N\nthrust,0.5\ndrag,\n"
    assert record.figure().get_size_inches().tolist() == [3.0, 2.0]
    assert FigureRecord("none", columns_of("load rms_N", [])).csv() == "load,rms_N\n"


# -------------------------------------------------------------------------------------------------
# The folder of a report is there with all its files, or as it was before.

FILES = {"index.html": "<p>β</p>", "a.csv": b"1\n"}


def _held(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir()}


def test_all_files_and_nothing_beside(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    write_folder(folder, FILES)
    assert _held(folder) == {"index.html": "<p>β</p>".encode(), "a.csv": b"1\n"}
    assert list(tmp_path.iterdir()) == [folder]


def test_an_earlier_run_is_replaced_as_a_whole(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    write_folder(folder, FILES)
    write_folder(folder, {"index.html": "new", "a.csv": "2\n"})
    assert _held(folder) == {"index.html": b"new", "a.csv": b"2\n"}
    assert list(tmp_path.iterdir()) == [folder]


@pytest.mark.parametrize("there", [False, True])
def test_what_fails_half_way_leaves_no_trace(tmp_path: Path, there: bool) -> None:
    folder = tmp_path / "out"
    if there:
        write_folder(folder, FILES)
    broken = {"index.html": "new", "a.csv": None}
    with pytest.raises(TypeError):
        write_folder(folder, broken)  # type: ignore[arg-type]
    assert folder.exists() == there
    if there:
        assert _held(folder)["index.html"] == "<p>β</p>".encode()
    assert list(tmp_path.iterdir()) == ([folder] if there else [])


def test_other_files_are_never_removed(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(InputError, match=r"thesis\.tex.*choose a new or an empty folder"):
        write_folder(tmp_path, FILES)
    assert (tmp_path / "thesis.tex").read_text() == "years of work"
    (tmp_path / "thesis.tex").rename(tmp_path / "a.csv")
    (tmp_path / "index.html").mkdir()
    with pytest.raises(InputError, match=r"index\.html"):
        check_folder(tmp_path, FILES)


def test_places_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="not a folder"):
        check_folder(tmp_path / "file", FILES)
    with pytest.raises(
        InputError, match=r"out: there is no folder [^;]*; make it or choose another$"
    ):
        check_folder(tmp_path / "no" / "out", FILES)
