"""Flight logs as CSV or Parquet, whose columns the vehicle file names."""

from __future__ import annotations

import csv
import difflib
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from propmap.errors import InputError, quoted
from propmap.io.csv_dialect import has_decimal_commas, separator_of, too_many_fields
from propmap.typing import Floats
from propmap.vehicle.log_map import EULER_COLUMNS, QUATERNION_COLUMNS, LogMap
from propmap.vehicle.logs.frames import quaternion_of_angles
from propmap.vehicle.logs.recording import Recording, Signal

MOST_SHOWN = 30
"""Columns of a file that a message lists."""

QUANTITIES = ("time", "velocity", "rates", "rotor_speed", "specific_force")
OPTIONAL = ("specific_force",)


def read_csv_log(path: Path, log: LogMap) -> Recording:
    """A CSV file with a header line, or a Parquet file (``.parquet``, ``.pq``).

    The ``log`` map must state the frames and units and name the columns: ``time`` [s],
    ``velocity`` [m/s], ``rates`` [rad/s] and the optional ``specific_force`` [m/s^2] (3 each),
    ``rotor_speed``, and either ``qw, qx, qy, qz`` or ``roll, pitch, yaw`` [rad] (yaw about z,
    then pitch about y, then roll about x of the stated body frame).
    Any dialect of ``propmap.io.csv_dialect`` is read.  Empty cells are samples that are not
    finite; text is refused.  Raises ``InputError``.
    """
    where = str(path)
    stated = {key: log.stated(key) for key in ("body_frame", "world_frame", "velocity_in")}
    factor = log.rotor_factor(log.stated("rotor_unit"))
    attitude = _attitude_columns(log)
    wanted = [*QUANTITIES, *attitude]
    for key in wanted:
        if key not in log.columns and key not in OPTIONAL:
            raise InputError(
                f"no {key}", f"add {key} = the column's name", f"{log.file}: [log.columns]"
            )
    names = {key: log.columns[key] for key in wanted if key in log.columns}
    table = _table(path, where, {name for several in names.values() for name in several})
    values = {key: _columns(table, columns, key, where, log) for key, columns in names.items()}
    time = values["time"][:, 0]

    def signal(key: str, array: Floats) -> Signal:
        return Signal(f"{key} ({', '.join(names.get(key, attitude))})", time, array)

    force = values.get("specific_force")
    return Recording(
        source=where,
        attitude=signal("attitude", _quaternions([values[key][:, 0] for key in attitude], where)),
        velocity=signal("velocity", values["velocity"]),
        rates=signal("rates", values["rates"]),
        rotor_speed=signal("rotor_speed", values["rotor_speed"] * factor),
        specific_force=None if force is None else signal("specific_force", force),
        **stated,
    )


def _attitude_columns(log: LogMap) -> tuple[str, ...]:
    given = [set(names) & set(log.columns) for names in (QUATERNION_COLUMNS, EULER_COLUMNS)]
    if all(given):
        raise InputError(
            "the attitude is given twice, as quaternion and as angles",
            "keep one of them",
            f"{log.file}: [log.columns]",
        )
    return EULER_COLUMNS if given[1] else QUATERNION_COLUMNS


def _quaternions(columns: list[Floats], where: str) -> Floats:
    if len(columns) == len(QUATERNION_COLUMNS):
        return np.stack(columns, axis=1)
    largest = max(float(np.nanmax(np.abs(column), initial=0.0)) for column in columns)
    # Yaw may be unwrapped over many turns, roll and pitch may not.
    if float(np.nanmax(np.abs(columns[:2]), initial=0.0)) > 2.0 * np.pi:
        raise InputError(
            f"roll, pitch and yaw reach {largest:.4g}, which looks like degrees",
            "convert these columns to radians",
            where,
        )
    return quaternion_of_angles(*columns)


def _table(path: Path, where: str, wanted: Collection[str]) -> Any:
    """The file as a pandas data frame; of a CSV file, all cells as text with decimal points."""
    import pandas as pd  # type: ignore[import-untyped]

    try:
        if path.suffix.lower() != ".csv":
            table = pd.read_parquet(path, engine="pyarrow")
        else:
            table = _csv_table(path, where, wanted)
    except InputError:
        raise
    except ImportError:
        raise InputError(
            "Parquet files need pyarrow, which is not installed",
            "pip install '.[parquet]' in propmap's checkout, or save the log as CSV",
            where,
        ) from None
    # Errors of pandas are ValueErrors; those of pyarrow for a damaged file OSErrors, too.
    except (ValueError, OSError) as error:
        raise InputError(f"cannot be read: {error}", "export the log again", where) from None
    table.columns = [str(name).strip() for name in table.columns]
    return table


def _csv_table(path: Path, where: str, wanted: Collection[str]) -> Any:
    import pandas as pd

    with path.open(encoding="utf-8-sig", newline="") as file:
        head = [file.readline(), file.readline()]
    separator = separator_of(head[0].rstrip("\r\n"), wanted)
    # Room for what spreadsheets add at the end of a row.
    width = max(len(row) for row in csv.reader(head, delimiter=separator, skipinitialspace=True))
    # Blank lines are kept, so that a row's place tells its line, and the header is read as a row,
    # as pandas would rename a column that occurs twice.
    cells = pd.read_csv(
        path,
        sep=separator,
        header=None,
        names=range(width),
        dtype=str,
        skipinitialspace=True,
        skip_blank_lines=False,
        encoding="utf-8-sig",
    )
    named = int(np.flatnonzero(cells.iloc[0].notna()).max(initial=-1)) + 1
    beyond = np.flatnonzero(cells.iloc[:, named:].notna().any(axis=1))
    if beyond.size:
        raise too_many_fields(width, named, separator, f"{where}, line {beyond[0] + 1}")
    table = cells.iloc[1:, :named].set_axis(cells.iloc[0, :named], axis=1)
    _use_points(table, separator, where, wanted)
    return table


def _use_points(table: Any, separator: str, where: str, wanted: Collection[str]) -> None:
    """Put decimal points into the columns ``wanted`` of a table that is separated otherwise."""
    if separator == ",":
        return
    places = [k for k, name in enumerate(table.columns) if str(name).strip() in wanted]
    marked = []
    for k in places:
        column = table.iloc[:, k]
        some = column[column.str.contains("[.,]", na=False)]
        marked += [(int(row) + 1, cell.strip()) for row, cell in some.items()]
    if has_decimal_commas(marked, separator, where):
        for k in places:
            table.isetitem(k, table.iloc[:, k].str.replace(",", ".", regex=False))


def _columns(table: Any, names: tuple[str, ...], key: str, where: str, log: LogMap) -> Floats:
    """Columns as numbers; (n, len(names))."""
    columns = []
    for name in names:
        count = list(table.columns).count(name)
        if count != 1:
            raise _missing(name, key, list(table.columns), where, log)
        columns.append(_numbers(table[name], name, where))
    return np.stack(columns, axis=1)


def _missing(name: str, key: str, present: list[str], where: str, log: LogMap) -> InputError:
    close = difflib.get_close_matches(name, present, n=1)
    hint = f"did you mean {close[0]!r}? " if close else ""
    listed = ", ".join(present[:MOST_SHOWN]) + (", ..." if len(present) > MOST_SHOWN else "")
    times = "occurs more than once" if name in present else "is missing"
    return InputError(
        f"column {quoted(name)} {times}; the file has {listed}",
        f"{hint}correct {key} in [log.columns] of {log.file}",
        where,
    )


def _numbers(column: Any, name: str, where: str) -> Floats:
    """A column of a data frame as float64; empty cells are NaN, other text is refused."""
    import pandas as pd

    numbers = pd.to_numeric(column, errors="coerce")
    values: Floats = numbers.to_numpy(dtype=np.float64, na_value=np.nan)
    text = np.flatnonzero(np.isnan(values) & column.notna().to_numpy())
    if text.size:
        row = int(text[0])
        # pandas reads "nan" as an empty cell; line 1 is the header.
        raise InputError(
            f"{quoted(column.iloc[row])} is not a number",
            "give a number with a decimal point, or leave the cell empty",
            f"{where}, line {row + 2}, column {name}",
        )
    return values
