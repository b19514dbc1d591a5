"""CSV as spreadsheets write it: commas, semicolons or tabs between columns, commas in numbers."""

from __future__ import annotations

import csv
import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Any

from propmap.errors import InputError, quoted

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}
"""What may stand between columns, and its name."""

SNIFFED = 10_000
"""Characters of a header that ``csv.Sniffer`` sees, whose search is quadratic in quotes."""

_MARKED = re.compile(r"[+-]?[\d.,]*\d[\d.,]*([eE][+-]?\d+)?")
_GROUP = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")


@dataclass(frozen=True)
class CsvTable:
    """A CSV file with a header line, as text.

    Attributes
    ----------
    line : int
        Number of the header's line, from 1.
    header : list of str
        Names of the columns, without those at the end that have none.
    rows : list of (int, list of str)
        Number of the line and cells of each row that is not blank.  Numbers have decimal points in
        the columns that were asked for.  A row may be shorter than the header, but not longer.
    comments : list of str
        Lines that begin with #, where the format has them.
    """

    line: int
    header: list[str]
    rows: list[tuple[int, list[str]]]
    comments: list[str]


def read_csv_table(
    lines: Iterable[str], columns: Collection[str], where: str, *, comments: bool = False
) -> CsvTable | None:
    """The header and the rows of a CSV file in any of the dialects of spreadsheets.

    Parameters
    ----------
    lines : iterable of str
        Of the file, without their ends.
    columns : collection of str
        Names of those that hold numbers; upper and lower case are alike.
    where : str
        The file, for messages.
    comments : bool
        Whether lines that begin with # are comments.

    Returns
    -------
    CsvTable or None
        None where all lines are blank or comments.

    Raises
    ------
    InputError
        Where quotes do not close, a row has more fields than the header, or points and commas in
        numbers cannot be told apart.
    """
    body, told = [], []
    for text in lines:
        comment = comments and is_comment(text)
        told += [text] if comment else []
        body.append("" if comment else text)
    first = next((text for text in body if text.strip(" \t;,")), None)
    if first is None:
        return None
    separator = separator_of(first, columns)
    (line, header), *rows = _rows(body, separator, where)
    while not header[-1]:
        header.pop()
    for number, row in rows:
        if any(row[len(header) :]):
            raise too_many_fields(len(row), len(header), separator, f"{where}: line {number}")
        del row[len(header) :]
    wanted = {name.lower() for name in columns}
    places = [place for place, name in enumerate(header) if name.lower() in wanted]
    cells = [(n, row, place) for n, row in rows for place in places if place < len(row)]
    if has_decimal_commas(((n, row[place]) for n, row, place in cells), separator, where):
        for _, row, place in cells:
            row[place] = row[place].replace(",", ".")
    return CsvTable(line, header, rows, [_uncovered(text, separator) for text in told])


def separator_of(header: str, columns: Collection[str]) -> str:
    """The separator of a CSV file, one of ``SEPARATORS``, from its header line.

    ``csv.Sniffer`` is shown the header alone: in rows it takes decimal commas and what stands next
    to quotes for separators (CPython's issues 97611 and 119123).  It is overruled where another
    separator brings to light more of the ``columns`` that are looked for, as it prefers commas.
    """
    try:
        sniffed = csv.Sniffer().sniff(header[:SNIFFED], "".join(SEPARATORS)).delimiter
    except csv.Error:
        sniffed = ","  # one column
    wanted = {name.lower() for name in columns}
    return max((sniffed, *SEPARATORS), key=lambda mark: len(wanted & set(_names(header, mark))))


def header_names(header: str, columns: Collection[str]) -> list[str]:
    """The names in a header line, in lower case, where ``columns`` are looked for."""
    return _names(header, separator_of(header, columns))


def has_decimal_commas(cells: Iterable[tuple[int, str]], separator: str, where: str) -> bool:
    """Whether the numbers of a file have decimal commas.

    Parameters
    ----------
    cells : iterable of (int, str)
        Number of the line, and what stands there for a number; other texts do not count.
    separator : str
        Of the columns.  Where it is the comma, no number has one.
    where : str
        The file, for messages.

    Raises
    ------
    InputError
        Where one number has two marks or one of each kind, numbers differ in their mark, or all
        that have a mark may be thousands just as well, as 6.000 and 6,000.
    """
    if separator == ",":
        return False
    first: dict[str, tuple[int, str]] = {}
    decimal = False
    for number, cell in cells:
        marks = [c for c in cell if c in ".,"]
        if not marks or not _MARKED.fullmatch(cell):
            continue
        if len(marks) > 1:
            raise InputError(
                f"{quoted(cell)} has {len(marks)} marks, points or commas",
                "write numbers without separators of thousands",
                f"{where}: line {number}",
            )
        first.setdefault(marks[0], (number, cell))
        decimal = decimal or not _GROUP.fullmatch(cell)
    if len(first) > 1:
        told = " and ".join(f"{quoted(cell)} in line {n}" for n, cell in first.values())
        raise InputError(
            f"found {told}: both commas and points in numbers", "keep one of them", where
        )
    if first and not decimal:
        ((mark, (number, cell)),) = first.items()
        whole = cell.replace(mark, "")
        raise InputError(
            f"{quoted(cell)} may be {whole} or {cell.replace(mark, '.')}, no other tells",
            f"write {whole} or {cell}0",
            f"{where}: line {number}",
        )
    return "," in first


def too_many_fields(found: int, expected: int, separator: str, where: str) -> InputError:
    """The error for a row with more fields than the header, which decimal commas may have made."""
    advice = "complete the header or remove what is too much"
    if separator == ",":
        advice = f"use a decimal point or semicolons between columns, or {advice}"
    return InputError(
        f"found {found} figures separated by {SEPARATORS[separator]}, expected {expected}",
        advice,
        where,
    )


def is_comment(line: str) -> bool:
    """Whether a line begins with #; a spreadsheet puts quotes around one that has a separator."""
    return line.lstrip().removeprefix('"').startswith("#")


def _uncovered(comment: str, separator: str) -> str:
    """A comment without the quotes and the empty fields that a spreadsheet adds."""
    if comment.lstrip().startswith('"'):
        return next(_reader([comment.lstrip()], separator), [""])[0]
    return comment.rstrip(f" {separator}")


def _rows(lines: Iterable[str], separator: str, where: str) -> list[tuple[int, list[str]]]:
    """Number of the line and cells of each row that is not blank."""
    reader = _reader((f"{line}\n" for line in lines), separator, strict=True)
    try:
        found = [(reader.line_num, [cell.strip() for cell in row]) for row in reader]
    except csv.Error as error:
        raise InputError(
            f"line {reader.line_num}: not CSV: {error}", "save the file as plain CSV", where
        ) from None
    return [(number, row) for number, row in found if any(row)]


def _names(header: str, separator: str) -> list[str]:
    return [cell.strip().lower() for cell in next(_reader([header], separator), [])]


def _reader(lines: Iterable[str], separator: str, *, strict: bool = False) -> Any:
    return csv.reader(lines, delimiter=separator, skipinitialspace=True, strict=strict)
