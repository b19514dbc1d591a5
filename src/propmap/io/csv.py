"""Reading of text and CSV files in any dialect, safe writing, operating points and loads."""

from __future__ import annotations

import csv
import io
import itertools
import math
import os
import re
import stat
import uuid
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from propmap.errors import InputError, located, quoted
from propmap.io.columns import Header
from propmap.loads import LOADS
from propmap.typing import Floats
from propmap.units import RPM

if TYPE_CHECKING:
    import xarray

    from propmap.results import Loads
    from propmap.rotor import Rotor


# --- CSV dialects of spreadsheets: commas, semicolons or tabs as separators, commas in numbers ---

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}
"""Separators of columns, with their names in messages."""

SNIFFED = 10_000
"""Number of header characters for ``csv.Sniffer``, whose time is quadratic in quotes."""

_MARKED = re.compile(r"[+-]?[\d.,]*\d[\d.,]*([eE][+-]?\d+)?")
_PROPELLER = re.compile(r"prop(eller)?s?( (size|name|type|model|inch|in))?")
_GROUP = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")


@dataclass(frozen=True)
class CsvTable:
    """A CSV file with a header line, as text."""

    line: int  # line number of the header, from 1
    header: list[str]  # without trailing columns that have no name
    rows: list[tuple[int, list[str]]]  # with line numbers; decimal points, no blank rows
    comments: list[str]  # lines that begin with #, in formats with comments


def read_csv_table(
    lines: Iterable[str], columns: Collection[str], where: str = "", *, comments: bool = False
) -> CsvTable | None:
    """Read header and rows of a CSV file in any dialect of spreadsheets; None for a blank file.

    ``columns`` are the names of columns with numbers, in any case.  With ``comments``, lines that
    begin with # are comments, and units in the row below the names are appended to the names.
    Raise ``InputError`` for open quotes, a row with more fields than the header, and ambiguous
    points and commas in numbers.
    """
    body, remarks = [], []
    for text in lines:
        comment = comments and is_comment(text)
        remarks += [text] if comment else []
        body.append("" if comment else text)
    first = next((text for text in body if text.strip(" \t;,")), None)
    if first is None:
        return None
    separator = separator_of(first, columns)
    filled = _rows(body, separator, where)
    if not filled:  # for example, only quotes
        return None
    (line, header), *rows = filled
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
    if comments and rows and not any(map(_MARKED.fullmatch, rows[0][1])):
        named = itertools.zip_longest(header, rows.pop(0)[1], fillvalue="")
        header = [f"{name} [{unit}]" if unit else name for name, unit in named]
    return CsvTable(line, header, rows, [_uncovered(text, separator) for text in remarks])


def separator_of(header: str, columns: Collection[str]) -> str:
    """Return the separator of a CSV file, one of ``SEPARATORS``, from its header line.

    ``csv.Sniffer`` gets only the header, because in rows it mistakes decimal commas and characters
    next to quotes for separators (CPython's issues 97611 and 119123).  It prefers commas, so a
    separator that yields more of the wanted ``columns`` overrules it.
    """
    try:
        sniffed = csv.Sniffer().sniff(header[:SNIFFED], "".join(SEPARATORS)).delimiter
    except csv.Error:
        sniffed = ","  # one column
    wanted = {name.lower() for name in columns}
    return max((sniffed, *SEPARATORS), key=lambda mark: len(wanted & set(_names(header, mark))))


def columns_in(header: str, known: Collection[str]) -> list[str]:
    """Return the names in a header line that match ``known`` columns of ``propmap.io.columns``.

    The names are in lower case; all separators are tried.
    """
    every = {name for mark in SEPARATORS for name in _names(header, mark)}
    return [name for name in sorted(every) if Header([name], known).taken]


def header_names(header: str, columns: Collection[str]) -> list[str]:
    """Return the names of a header line in lower case; ``columns`` are the wanted names."""
    return _names(header, separator_of(header, columns))


def has_decimal_commas(cells: Iterable[tuple[int, str]], separator: str, where: str) -> bool:
    """Return whether the numbers in a file have decimal commas.

    ``cells`` contains pairs of line number and text.  Raise ``InputError`` for a number with two
    marks, different marks in different numbers, and marks that are all ambiguous, as in 6.000 and
    6,000.  If commas separate columns, numbers cannot contain commas.
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
            found = f"{quoted(cell)} has {len(marks)} marks, points or commas"
            remedy = "write numbers without thousands separators"
            raise InputError(found, remedy, f"{where}: line {number}")
        first.setdefault(marks[0], (number, cell))
        decimal = decimal or not _GROUP.fullmatch(cell)
    if len(first) > 1:
        both = " and ".join(f"{quoted(cell)} in line {n}" for n, cell in first.values())
        found = f"found {both}: both commas and points in numbers"
        raise InputError(found, "keep one of them", where)
    if first and not decimal:
        ((mark, (number, cell)),) = first.items()
        whole = cell.replace(mark, "")
        found = f"{quoted(cell)} is ambiguous: {whole} or {cell.replace(mark, '.')}"
        raise InputError(found, f"write {whole} or {cell}0", f"{where}: line {number}")
    return "," in first


def too_many_fields(found: int, expected: int, separator: str, where: str) -> InputError:
    """Return the error for a row with more fields than the header, a possible decimal comma."""
    advice = "complete the header or remove the extra fields"
    if separator == ",":
        advice = f"use a decimal point or semicolons between columns, or {advice}"
    marks = SEPARATORS[separator]
    fault = f"found {found} fields separated by {marks}, expected {expected}"
    return InputError(fault, advice, where)


def is_comment(line: str) -> bool:
    """Return whether a line begins with #, also inside quotes that a spreadsheet has added."""
    return line.lstrip().removeprefix('"').startswith("#")


def _uncovered(comment: str, separator: str) -> str:
    """Return a comment without the quotes and the empty fields that a spreadsheet adds."""
    if comment.lstrip().startswith('"'):
        return (_cells(comment.lstrip(), separator) or [""])[0]
    return comment.rstrip(f" {separator}")


def _rows(lines: Iterable[str], separator: str, where: str) -> list[tuple[int, list[str]]]:
    """Return line number and cells of each row that is not blank."""
    reader = _reader((f"{line}\n" for line in lines), separator, strict=True)
    try:
        rows = [(reader.line_num, [cell.strip() for cell in row]) for row in reader]
    except csv.Error as error:
        found = f"line {reader.line_num}: not CSV: {error}"
        raise InputError(found, "save the file as plain CSV", where) from None
    return [(number, row) for number, row in rows if any(row)]


def _names(header: str, separator: str) -> list[str]:
    return [cell.lower() for cell in _cells(header, separator)]


def _cells(line: str, separator: str) -> list[str]:
    """Return the cells of a line, or an empty list if ``csv.reader`` refuses a long cell."""
    try:
        return [cell.strip() for cell in next(_reader([line], separator), [])]
    except csv.Error:
        return []


def _reader(lines: Iterable[str], separator: str, *, strict: bool = False) -> Any:
    return csv.reader(lines, delimiter=separator, skipinitialspace=True, strict=strict)


# --- Text of CSV files ---------------------------------------------------------------------------


def csv_text(columns: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> str:
    """Return CSV text with a header line, empty fields for None, and all digits of floats."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([row[name] for name in columns] for row in rows)
    return text.getvalue()


def loads_csv(points: OperatingPoints, loads: Loads, spread: Mapping[str, Floats]) -> str:
    """Return the CSV of `propmap sweep`; ``spread`` are standard deviations (n,) by column."""
    further = {name: getattr(loads, name) for name in ("mean_inflow", "reverse_flow", "roots")}
    further |= spread
    return csv_text([*points.columns, *further], points.rows(loads, further))


# --- Lines of a text file, or an ``InputError`` with the reason why the file cannot be read ------

MAX_BYTES = 5_000_000


def read_lines(
    path: str | os.PathLike[str], content: str = "geometry", *, latin: bool = False
) -> list[str]:
    """Return the lines of the UTF-8 text file at ``path``, without line ends.

    Raise ``InputError`` for a missing file, a directory, a file above 5 MB, and a file that is
    empty, binary or in another encoding.  With ``latin``, Latin-1 is allowed too, for instruments
    which write "\u00b5s".  ``content`` is the name of the expected content in messages.
    """
    where = os.fspath(path)
    try:
        status = Path(where).stat()
        if status.st_size <= MAX_BYTES and stat.S_ISREG(status.st_mode):
            data = Path(where).read_bytes()
    except FileNotFoundError:
        raise InputError("no such file", "check the path", where) from None
    except OSError as error:
        found = f"cannot read it: {error.strerror or type(error).__name__}"
        raise InputError(found, "check the path and your permission to read it", where) from None
    except ValueError as error:  # a path with a null character
        raise InputError(f"not a path: {error}", "check the path", where) from None
    with located(where):
        if stat.S_ISDIR(status.st_mode):
            raise InputError("this is a directory, expected a file", "name a file inside it")
        if not stat.S_ISREG(status.st_mode):
            found = "this is a device or pipe, expected a file"
            raise InputError(found, "save the data to a file")
        if status.st_size > MAX_BYTES:
            sizes = f"{status.st_size / 1e6:.1f} MB", f"{MAX_BYTES / 1e6:g} MB"
            found = f"{sizes[0]} is not a {content} file, expected at most {sizes[1]}"
            raise InputError(found, f"name the file with the {content}")
        if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
            raise InputError("the text is in UTF-16, expected UTF-8", "save it as UTF-8")
        if b"\0" in data:
            found = "found binary data, expected text"
            raise InputError(found, f"give a text file with the {content}")
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            if latin:
                return data.decode("latin-1").splitlines()
            line = data.count(b"\n", 0, error.start) + 1
            found = f"line {line}: byte 0x{data[error.start]:02x} is not UTF-8 text"
            raise InputError(found, "save the file as UTF-8") from None
        if not text.strip():
            found = f"the file is empty, expected the {content}"
            raise InputError(found, f"give a {content} file")
    # str.splitlines also splits at form feeds, which would shift the line numbers.
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


# --- Safe writing: an interrupted command leaves no partial files --------------------------------


def check_place(path: Path, where: str) -> bool:
    """Return whether ``path`` exists; raise ``InputError`` if a file cannot be created there."""
    if not path.parent.is_dir():
        found = f"there is no folder {str(path.parent)!r}"
        raise InputError(found, "create it or choose another", where)
    if not os.access(path.parent, os.W_OK):
        raise InputError("the folder is not writable", "choose another", where)
    return path.exists()


@contextmanager
def replacing(path: Path, *, new: bool = False) -> Iterator[Path]:
    """Yield a temporary path in the same folder, which replaces ``path`` if the block succeeds.

    Otherwise the temporary file is removed.  An ``OSError``, for example of a full disk, names
    ``path``.  If ``path`` must be ``new``, raise ``InputError`` if another process created it.
    """
    part = path.with_name(f".{path.name[:30]}.{uuid.uuid4().hex}.part")
    try:
        yield part
        if new:
            os.link(part, path)
        else:
            part.replace(path)
    except FileExistsError:
        found = "another run has written this file in the meantime"
        raise InputError(found, "choose another name, or pass --force", str(path)) from None
    except OSError as error:
        if error.filename is not None and str(error.filename) != str(part):
            raise
        reason = error.strerror or str(error)
        raise OSError(error.errno or 0, reason, str(path)) from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def write_dataset(dataset: xarray.Dataset, path: Path, *, new: bool = False) -> None:
    """Write a dataset as a complete NetCDF file; if ``new``, only to a path without a file."""
    with replacing(path, new=new) as part:
        # Encoded in memory first, because the HDF5 library ends the process if the disk is full.
        part.write_bytes(dataset.to_netcdf(engine="h5netcdf"))


# --- Operating points and loads in units of files: rpm, m/s, degrees, columns with units ---------

GIVEN = ("rpm", "speed_mps", "beta_deg")  # columns of an operating point
PREDICT_COLUMNS = (*GIVEN, *(load.column for load in LOADS.values()), "power_W", "status")

REMEDIES = {
    "rpm": "give revolutions per minute, 0 or more for both spin directions; only the option --rpm "
    "accepts negative values, for propellers that turn backward",
    "speed": "give 0 or more m/s; beta is the direction, 180 in descent",
    "beta": "give degrees: 0 axial climb, 90 edgewise flight, 180 descent",
    "climb": "give m/s, negative in descent",
    "height": "give the height of the disk above level ground in m, or omit it",
    "ceiling": "give the distance of a level ceiling above the disk in m, or omit it",
}

FURTHER = {"height": "height_m", "ceiling": "ceiling_m"}
"""Columns of the optional quantities of an operating point, see ``operating_points.Further``."""

SIGNED = ("rpm", "beta", "climb")  # quantities that may be negative
MOST_BETA = 360.0  # largest absolute value [deg]


@dataclass(frozen=True)
class OperatingPoints:
    """Operating points: rpm [1/min], speed [m/s], beta [degrees], ``further``, arrays (n,)."""

    rpm: Floats
    speed_mps: Floats
    beta_deg: Floats
    further: Mapping[str, Floats] = field(default_factory=dict)

    @classmethod
    def grid(cls, rpm: Floats, speed: Floats, beta: Floats) -> OperatingPoints:
        """Return all combinations of the values; beta varies fastest."""
        w, v, b = (axis.ravel() for axis in np.meshgrid(rpm, speed, beta, indexing="ij"))
        return cls(w, v, b)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns of ``rows``."""
        return *GIVEN, *(FURTHER[name] for name in self.further), *PREDICT_COLUMNS[3:]

    @property
    def si(self) -> tuple[Floats, Floats, Floats]:
        """Rotational speed [rad/s], airspeed [m/s] and beta [rad], (n,) each."""
        return self.rpm * RPM, self.speed_mps, np.radians(self.beta_deg)

    def loads(self, rotor: Rotor) -> Loads:
        """Return the loads of a rotor at these points, with fields (n,)."""
        return rotor.loads(*self.si, **self.further)

    def rows(
        self, loads: Loads, further: Mapping[str, Floats] | None = None
    ) -> list[dict[str, Any]]:
        """Return one mapping per point, with ``columns`` and ``further`` (n,), and None for NaN."""
        given = (self.rpm, self.speed_mps, self.beta_deg, *self.further.values())
        numbers = (*given, *(getattr(loads, name) for name in LOADS), loads.power)
        columns: dict[str, list[Any]] = dict(
            zip(self.columns, map(numbers_of, numbers), strict=False)
        )
        columns["status"] = loads.status.tolist()
        columns |= {name: numbers_of(values) for name, values in (further or {}).items()}
        return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def check_value(quantity: str, value: float) -> float:
    """Return ``value``; raise ``InputError`` if it is invalid for a ``quantity``."""
    if not np.isfinite(value):
        raise InputError(f"{quantity} is {value}, not a finite number", REMEDIES[quantity])
    if value < 0.0 and quantity not in SIGNED:
        raise InputError(f"{quantity} is negative ({value:g})", REMEDIES[quantity])
    if quantity == "beta" and abs(value) > MOST_BETA:
        raise InputError(f"beta is {value:g}, more than a turn", REMEDIES[quantity])
    return value


def std_columns(loads: Loads, *, by_source: bool) -> dict[str, Floats]:
    """Return standard deviations by column, as "thrust_std_N"; with ``by_source`` also columns
    such as "thrust_std_tunnel_N"."""
    kinds = {"std": loads.std} if loads.std_by_source else {}
    if by_source:
        kinds |= {f"std_{source}": values for source, values in loads.std_by_source.items()}
    found: dict[str, Floats] = {}
    for kind, values in kinds.items():
        found |= {load.column_of(kind): getattr(values, name) for name, load in LOADS.items()}
        found[f"power_{kind}_W"] = values.power
    return found


def number_or_none(value: float) -> float | None:
    """Return a value for a file: 0.0 for -0.0, None for values that are not finite."""
    return float(value) + 0.0 if math.isfinite(value) else None


def numbers_of(values: Floats) -> list[float | None]:
    """Return ``number_or_none`` of all values, of any shape, as a list."""
    return [number_or_none(value) for value in values.ravel().tolist()]


# --- CSV files with a column per quantity: operating points and measured loads -------------------

POINT_COLUMNS = {"rpm": "rpm", "speed_mps": "speed", "beta_deg": "beta"}
OF_POINTS = POINT_COLUMNS | {column: name for name, column in FURTHER.items()}
LOAD_COLUMNS = {load.column: name for name, load in LOADS.items()}  # names of loads by their column
TITLED = 10  # number of lines of a file in which the header is searched
AT_REST = "columns of speed and beta are missing: all rows are assumed to be at V = 0"


def read_points(
    path: Path, further: Iterable[str] = (), *, at_rest: bool = False
) -> tuple[OperatingPoints, dict[str, Floats], list[str]]:
    """Return the operating points of a CSV file, its ``further`` columns (n,), and remarks.

    The columns are those of ``propmap.io.columns``, in any dialect of spreadsheets; the remarks
    list recognized columns.  Without speed and beta, all rows are at V = 0.  With ``at_rest``, beta
    is not required.  An empty field of a further column is NaN.
    """
    wanted = (*OF_POINTS, *further)
    pair = ("speed_mps", "beta_deg")
    implied = dict([pair] if at_rest else [pair, pair[::-1]])
    columns, remarks = read_columns(path, ("rpm",), wanted[1:], "list of operating points", implied)
    absent = [name for name in pair if name not in columns]
    columns |= dict.fromkeys(absent, np.zeros_like(columns["rpm"]))
    remarks += [AT_REST] if len(absent) == 2 and not at_rest else []
    rpm, speed, beta = (columns.pop(name) for name in POINT_COLUMNS)
    more = {name: columns.pop(column) for name, column in FURTHER.items() if column in columns}
    return OperatingPoints(rpm, speed, beta, more), columns, remarks


def read_columns(
    path: Path,
    needed: Collection[str],
    further: Iterable[str],
    what: str,
    implied: Mapping[str, str] | None = None,
) -> tuple[dict[str, Floats], list[str]]:
    """Return columns (n,) of a CSV file in the units of their names, and remarks on the columns.

    The result contains the ``needed`` columns, and the ``further`` columns of the file.  If the
    file contains a value of ``implied``, its key is also needed.  An empty field is NaN, or an
    error in columns of the operating point.  Messages call the expected content ``what``.
    """
    wanted, lines = (*needed, *further), read_lines(path, what, latin=True)
    with located(str(path)):
        # Some programs write a title above the header.
        head = ["" if is_comment(line) else line for line in lines[:TITLED]]
        start = next((k for k, line in enumerate(head) if len(columns_in(line, wanted)) > 1), 0)
        lines = [line if is_comment(line) else "" for line in lines[:start]] + lines[start:]
        first = next((text for text in lines if text.strip(" \t;,") and not is_comment(text)), "")
        file = read_csv_table(lines, columns_in(first, wanted), comments=True)
        names = file.header if file else []
        rows = file.rows if file else []
        # Test stands write zero for rotational speeds without a sensor.
        filled = itertools.zip_longest(*(row for _, row in rows), fillvalue="")
        blank = {
            place
            for place, (name, cells) in enumerate(zip(names, filled, strict=False))
            if name not in OF_POINTS
            and not "".join(cells).strip("0." if "rpm" in name.lower() else "")
        }
        header = Header(names, wanted, blank)
        with located(f"line {file.line if file else 1}"):
            found = {name: one for name in wanted if (one := header.one_of(name)) is not None}
        if "torque_Nm" in found:
            found.pop("power_W", None)
        needed = *needed, *(name for name, other in (implied or {}).items() if other in found)
        absent = [name for name in needed if name not in found]
        if absent:
            fault = f"line {file.line if file else 1}: column {absent[0]} is missing"
            remedy = f"the header must name {', '.join(needed)}, with values below"
            raise InputError(f"{fault}; {header.listed()}", remedy)
        if not rows:
            raise InputError("there is no row below the header", "add a row per point")
        if "speed_mps" in wanted and "speed_mps" not in found:
            _check_no_speed(header, rows)
        remarks = header.remarks(found)
        if "thrust_N" in further:
            _check_propellers(names, rows)
        if "thrust_N" in further and "rpm" in found:
            rows = _turning(rows, found["rpm"].place, remarks)
        columns: dict[str, Floats] = {}
        for name, one in found.items():
            values = [
                _value(row[one.place] if one.place < len(row) else "", name, line, one.name)
                for line, row in rows
            ]
            columns[name] = np.array(values) * one.factor
    return columns, remarks


def _check_no_speed(header: Header, rows: Sequence[tuple[int, list[str]]]) -> None:
    """Raise ``InputError`` if an unrecognized column may be the airspeed of these ``rows``."""
    place = header.speed_with_another_name()
    if place is None or not any("".join(row[place:][:1]).strip("-0., ") for _, row in rows):
        return
    like = quoted(header.names[place])
    fault = f"there is no column speed_mps, but {like} may be the airspeed or the advance ratio"
    remedy = (
        "give the airspeed as speed_mps (V = J n D for an advance ratio J), or remove this column"
    )
    raise InputError(fault, remedy)


def _check_propellers(names: Sequence[str], rows: Sequence[tuple[int, list[str]]]) -> None:
    """Raise ``InputError`` for measurements of several propellers, as in manufacturers' tables."""
    for place, name in enumerate(names):
        if _PROPELLER.fullmatch(re.sub(r"[\W_]+", " ", name.lower()).strip()):
            cells = dict.fromkeys(row[place] for _, row in rows if len(row) > place and row[place])
            if len(cells) > 1:
                few = ", ".join(map(quoted, [*cells][:3])) + ", ..." * (len(cells) > 3)
                found = f"column {quoted(name)} names {len(cells)} propellers: {few}"
                raise InputError(found, "keep the rows of one propeller")


def _turning(
    rows: list[tuple[int, list[str]]], place: int, remarks: list[str]
) -> list[tuple[int, list[str]]]:
    """Return the rows of measurements with a turning rotor; add a remark on the omitted rows."""
    kept = [row for row in rows if len(row[1]) > place and row[1][place].strip("0.")]
    if kept and len(kept) < len(rows):
        remarks.append(f"{len(rows) - len(kept)} of {len(rows)} rows have no rpm and are omitted")
    return kept or rows


def _value(cell: str, column: str, line: int, name: str) -> float:
    quantity, where = OF_POINTS.get(column), f"line {line}, column {name}"
    if quantity is None and not cell:
        return math.nan
    remedy = REMEDIES[quantity] if quantity else "give a finite number or leave the field empty"
    try:
        value = float(cell)
    except ValueError:
        found = f"{quoted(cell)} is not a number" if cell else "the field is empty"
        plain = "write a number without a unit and without thousands separators"
        raise InputError(found, plain if cell else remedy, where) from None
    if not math.isfinite(value):
        raise InputError(f"{cell} is not a finite number", remedy, where)
    if value < 0.0 and quantity in ("rpm", "speed", *FURTHER):
        raise InputError(f"{cell} is negative", remedy, where)
    with located(where):
        return check_value("beta", value) if quantity == "beta" else value


def disk_csv(rotor: Rotor, omega: float, speed: float, beta: float) -> str:
    """Return CSV of angle of attack, inflow and force, one row per element and azimuth."""
    field = rotor.inflow(omega, speed, beta)
    radius, psi = np.meshgrid(field.radius, np.degrees(field.azimuth), indexing="ij")
    columns = {
        "radius_m": radius,
        "psi_deg": psi,
        "alpha_deg": np.degrees(field.alpha),
        "inflow_mps": field.local_inflow,
        "force_N_per_m": field.normal_force,
        "past_stall_deg": np.degrees(field.past_stall),
        "reverse": field.reverse.astype(int),
    }
    flat = zip(*(values.ravel().tolist() for values in columns.values()), strict=True)
    return csv_text([*columns], [dict(zip(columns, row, strict=True)) for row in flat])
