"""Commas, semicolons, tabs and decimal commas give the same values, or one clear refusal."""

from __future__ import annotations

import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from propmap.errors import InputError
from propmap.io.csv import SEPARATORS, read_csv_table, separator_of

from .samples_csv import DIALECTS, rewritten

PLAIN = "rpm,note,speed_mps,beta_deg\n6000,first,1.5,90\n4000.25,,0,-1e-3\n"
COLUMNS = ("rpm", "speed_mps", "beta_deg")


def cells(text: str) -> list[list[str]]:
    table = read_csv_table(text.split("\n"), COLUMNS, "points.csv")
    assert table is not None
    return [table.header, *(row for _, row in table.rows)]


@pytest.mark.parametrize("dialect", DIALECTS)
def test_dialects_read_the_same(dialect: str) -> None:
    found = cells(rewritten(PLAIN, dialect).removeprefix("\ufeff").replace("\r\n", "\n"))
    assert found == cells(PLAIN)


NAMES = st.text("abcXYZ0189_ ./()[],;'\"", min_size=1, max_size=12).map(str.strip).filter(bool)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False, width=32)


@given(
    st.lists(NAMES, min_size=2, max_size=6, unique_by=str.lower),
    st.data(),
    st.sampled_from(sorted(SEPARATORS)),
    st.booleans(),
)
def test_whatever_a_writer_quotes_is_read(
    names: list[str], data: st.DataObject, separator: str, quote_all: bool
) -> None:
    """Names with separators and quotes in them, numbers of any size, half a row of remarks."""
    rows = data.draw(st.lists(st.tuples(*[NUMBERS] * len(names)), min_size=1, max_size=4))
    comma = separator != ","
    text = io.StringIO()
    quoting = csv.QUOTE_ALL if quote_all else csv.QUOTE_MINIMAL
    writer = csv.writer(text, delimiter=separator, lineterminator="\n", quoting=quoting)
    writer.writerow(names)
    for row in rows:
        written = [f"{value:.17f}" for value in row]
        writer.writerow([cell.replace(".", ",") if comma else cell for cell in written])
    table = read_csv_table(text.getvalue().split("\n"), names, "any.csv")
    assert table is not None
    assert table.header == names
    expected = [[float(f"{value:.17f}") for value in row] for row in rows]
    assert [[float(cell) for cell in row] for _, row in table.rows] == expected


@pytest.mark.parametrize(
    ("header", "expected"),
    [
        ("rpm;speed_mps;beta_deg;note, free", ";"),
        ("rpm\tspeed_mps\tbeta_deg\tnote; free", "\t"),
        ("rpm,speed_mps,beta_deg,note; a; b; c; d", ","),
        ('"rpm";"speed_mps";"a,""b"",c"', ";"),
        ("rpm", ","),
    ],
)
def test_separator(header: str, expected: str) -> None:
    assert separator_of(header, COLUMNS) == expected


def test_comments_and_numbers_of_lines() -> None:
    text = '# blades: 2;;\n"# name: wide; short";;\n\nrpm;note\n\n1,5;"two\nlines"\n2;x\n'
    table = read_csv_table(text.split("\n"), COLUMNS, "points.csv", comments=True)
    assert table is not None and table.line == 4
    assert [number for number, _ in table.rows] == [7, 8]
    assert table.comments == ["# blades: 2", "# name: wide; short"]


def test_blank_file() -> None:
    for lines in (["", ";;;", ""], ['"",""'], ["\x0c,"]):
        assert read_csv_table(lines, COLUMNS, "points.csv") is None, lines


REFUSED = {
    "decimal commas between commas": (
        "rpm,speed_mps\n6000,1,5\n",
        "line 2: found 3 ",
        "decimal point",
    ),
    "more fields than names": ("rpm;speed_mps\n6000;1;5\n", "line 2: found 3 ", "semicolons"),
    "points and commas": (
        "rpm;speed_mps\n6000;1,5\n6000;2.5\n",
        "'1,5' in line 2 and '2.5' in line 3",
        "keep one of them",
    ),
    "thousands and decimals": ("rpm;speed_mps\n6.000,5;1\n", "line 2: '6.000,5' has 2 marks"),
    "thousands by commas": ("rpm\tspeed_mps\n6,000\t5\n", "6000 or 6.000", "write 6000 or"),
    "open quote": ('rpm;speed_mps\n6000;"5\n', "not CSV"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_ambiguous(case: str) -> None:
    text, *parts = REFUSED[case]
    with pytest.raises(InputError) as caught:
        read_csv_table(text.split("\n"), COLUMNS, "points.csv")
    message = str(caught.value)
    assert message.startswith("points.csv: ")
    for part in parts:
        assert part in message


def test_three_decimals_are_decimals_once_another_number_tells() -> None:
    assert cells("rpm;speed_mps\n4000,125;5,000\n")[1] == ["4000.125", "5.000"]
    assert cells("rpm;speed_mps\n4,125;0,000\n")[1] == ["4.125", "0.000"]
    # Commas in other columns are left.
    assert cells("rpm;note\n1,5;a, 2,500\n")[1] == ["1.5", "a, 2,500"]
