"""Formats of section tables, told by their content: AeroDyn, XFOIL, CACTUS, and CSV."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from propmap.errors import InputError, quoted
from propmap.io.blade_table import parse_number
from propmap.io.csv_dialect import header_names, read_csv_table
from propmap.io.text_file import read_lines

Lines = list[tuple[int, str]]
"""Lines that are not empty, with their numbers from 1."""

Row = tuple[int, float, float, float]
"""Line number, angle of attack [deg], C_L, C_D."""

CSV_COLUMNS = ("alpha_deg", "re", "cl", "cd")


def section_format(lines: Lines) -> str | None:
    """The format of a file's lines, one of ``READERS``, or None."""
    head = [line for _, line in lines[:40]]
    if any("number of airfoil tables in this file" in line.lower() for line in head):
        return "AeroDyn v15" if _value_of(head, "NumTabs") is not None else "AeroDyn"
    if _value_of(head, "NumTabs") is not None:
        return "AeroDyn v15"
    if any(re.match(r"\s*alpha\s+CL\s+CD\b", line) for line in head):
        return "XFOIL"
    if any(line.lower().startswith("reynolds number:") for line in head):
        return "CACTUS"
    if head and set(CSV_COLUMNS) <= set(header_names(head[0], CSV_COLUMNS)):
        return "CSV"
    return None


def _aerodyn(lines: Lines, where: str) -> Iterator[tuple[float, list[Row]]]:
    """v13 and v14: per table its Reynolds number in millions, parameters, and rows up to EOT."""
    start = next(k for k, (_, line) in enumerate(lines) if "airfoil tables" in line.lower())
    count = _whole(lines[start], where)
    rest = iter(lines[start + 1 :])
    for number in range(1, count + 1):
        first = next(rest, None)
        if first is None:
            raise InputError(f"table {number} of {count} is missing", "give the whole file", where)
        reynolds = 1e6 * parse_number(first[1].split()[0], "Re", _at(where, first))
        rows: list[Row] = []
        for line in rest:
            if line[1].strip().upper().startswith("EOT"):
                break
            if _is_row(line[1]):
                rows.append(_row(line, where, most=4 if count > 1 else None))
            elif rows:
                raise InputError(
                    f"found {quoted(line[1].strip())} between rows",
                    "end a table with EOT",
                    f"{where}, line {line[0]}",
                )
        yield reynolds, rows


def _aerodyn_15(lines: Lines, where: str) -> Iterator[tuple[float, list[Row]]]:
    """v15: lines of a value and a keyword; NumAlf says how many rows follow."""
    plain = [(n, line.partition("!")[0]) for n, line in lines]
    rest = iter([(n, line) for n, line in plain if line.strip()])
    reynolds = None
    for line in rest:
        words = line[1].split()
        keyword = words[1] if len(words) > 1 else ""
        if keyword == "Re":
            reynolds = 1e6 * parse_number(line[1].split()[0], "Re", _at(where, line))
        elif keyword == "NumAlf":
            if reynolds is None:
                raise InputError("no Re before NumAlf", "give Re in millions", _at(where, line))
            count = _whole(line, where)
            rows = [_row(row, where) for _, row in zip(range(count), rest, strict=False)]
            if len(rows) < count:
                raise InputError(
                    f"found {len(rows)} rows, NumAlf is {count}", "give the whole file", where
                )
            yield reynolds, rows
            reynolds = None


def _xfoil(lines: Lines, where: str) -> Iterator[tuple[float, list[Row]]]:
    """One polar; rows in any order, as they were computed."""
    head = next(k for k, (_, line) in enumerate(lines) if re.match(r"\s*alpha\s+CL\s+CD\b", line))
    found = re.search(
        r"Re\s*=\s*([\d.]+)\s*e\s*([+-]?\d+)", "\n".join(line for _, line in lines[:head])
    )
    if found is None:
        raise InputError(
            "no Reynolds number above the rows", "keep the line with Re = 0.100 e 6", where
        )
    rows = [line for line in lines[head + 1 :] if set(line[1].strip()) - set("- ")]
    yield float(found[1]) * 10.0 ** int(found[2]), [_row(line, where) for line in rows]


def _cactus(lines: Lines, where: str) -> Iterator[tuple[float, list[Row]]]:
    """Per table a line with its Reynolds number, parameters, and rows."""
    starts = [k for k, (_, line) in enumerate(lines) if line.lower().startswith("reynolds number:")]
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        n, line = lines[start]
        reynolds = parse_number(line.partition(":")[2], "Reynolds number", f"{where}, line {n}")
        body = [one for one in lines[start + 1 : end] if ":" not in one[1]]
        yield reynolds, [_row(one, where) for one in body if one[1][:1] not in "Aa"]


def _csv(lines: Lines, where: str) -> Iterator[tuple[float, list[Row]]]:
    """Columns by name; rows of one Reynolds number are a table."""
    numbered = dict(lines)
    every = [numbered.get(n, "") for n in range(1, lines[-1][0] + 1)]
    file = read_csv_table(every, CSV_COLUMNS, where)
    assert file is not None  # its header has told the format
    header = [name.lower() for name in file.header]
    places = [header.index(name) for name in CSV_COLUMNS]
    tables: dict[float, list[Row]] = {}
    for number, cells in file.rows:
        place = f"{where}, line {number}"
        if len(cells) < len(header):
            raise InputError(
                f"found {len(cells)} fields, expected {len(header)}", "complete the row", place
            )
        angle, reynolds, lift, drag = (
            parse_number(cells[k], name, place) for k, name in zip(places, CSV_COLUMNS, strict=True)
        )
        tables.setdefault(reynolds, []).append((number, angle, lift, drag))
    yield from tables.items()


READERS: dict[str, Callable[[Lines, str], Iterator[tuple[float, list[Row]]]]] = {
    "AeroDyn": _aerodyn,
    "AeroDyn v15": _aerodyn_15,
    "XFOIL": _xfoil,
    "CACTUS": _cactus,
    "CSV": _csv,
}
"""Of each format, what gives the Reynolds number and the rows of every table."""


def lines_of(path: Path) -> Lines:
    """The lines of a file that are not empty."""
    return [(n, t) for n, t in enumerate(read_lines(path, "section table"), start=1) if t.strip()]


def _at(where: str, line: tuple[int, str]) -> str:
    return f"{where}, line {line[0]}"


def _row(line: tuple[int, str], where: str, most: int | None = None) -> Row:
    words, place = line[1].split(), _at(where, line)
    if len(words) < 3 or (most and len(words) > most):
        raise InputError(
            f"found {len(words)} numbers, expected angle, C_L, C_D and possibly C_m",
            "give one row a line and one table after the other",
            place,
        )
    names = ("the angle", "C_L", "C_D")
    angle, lift, drag = (parse_number(w, n, place) for w, n in zip(words, names, strict=False))
    return line[0], angle, lift, drag


def _is_row(line: str) -> bool:
    """Whether a line of AeroDyn is a row: three numbers or more and nothing else."""
    words = line.split()
    return len(words) >= 3 and all(re.fullmatch(r"[-+.\deEdD]+", word) for word in words)


def _whole(line: tuple[int, str], where: str) -> int:
    word = line[1].split()[0]
    if not word.isdigit() or int(word) < 1:
        raise InputError(
            f"found {quoted(word)}, expected a count", "give 1 or more", _at(where, line)
        )
    return int(word)


def _value_of(lines: Sequence[str], keyword: str) -> str | None:
    """The value in front of an AeroDyn v15 keyword."""
    pairs = (line.partition("!")[0].split() for line in lines)
    return next((words[0] for words in pairs if words[1:2] == [keyword]), None)
