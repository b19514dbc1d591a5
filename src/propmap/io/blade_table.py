"""A blade as rows of a file, on the way to a ``Propeller``."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from propmap.errors import InputError, quoted
from propmap.model.blade_check import check_blade, check_blades
from propmap.model.propeller import Propeller
from propmap.typing import Floats

INCH = 0.0254
"""Metres in an inch."""

RADIUS_TOLERANCE = 1e-3
"""Share of the radius within which two statements of it agree."""

GIVE_BLADES = "pass --blades 2 (in Python: blades=2)"
GIVE_RADIUS = "pass --radius 0.1 (in Python: radius=0.1), in metres"


def parse_number(text: str, field: str, where: str) -> float:
    """A finite number written as plain decimal text, or ``InputError``."""
    stripped = text.strip()
    try:
        # float() also takes 1_000, which in a data file is a slip.
        value = float(stripped) if "_" not in stripped else math.nan
    except ValueError:
        value = math.nan
    if math.isfinite(value):
        return value
    remedy = "use a decimal point" if "," in stripped else "remove the row or correct it"
    found = quoted(stripped) if stripped else "nothing"
    raise InputError(f"{field} is {found}, expected a finite number", remedy, where)


def parse_blades(text: str, where: str) -> int:
    """A number of blades written as text, or ``InputError``."""
    stripped = text.strip()
    count: object = int(stripped) if stripped.isascii() and stripped.isdigit() else stripped
    return check_blades(count, where)


def parse_rows(
    rows: Iterable[tuple[int, Sequence[str]]],
    header: Sequence[str],
    columns: Sequence[str],
    where: str,
) -> tuple[list[str], Floats]:
    """The numbers of a table, and "line 7" for each of its rows.

    Parameters
    ----------
    rows : iterable
        Number of the line, from 1, and its cells.
    header, columns : sequence of str
        Names of all columns, and of those wanted.
    where : str
        The file, for messages.

    Returns
    -------
    labels : list of str
        n of them.
    table : ndarray, shape (n, columns)
        As written in the file.
    """
    labels: list[str] = []
    table: list[list[float]] = []
    for number, cells in rows:
        place = f"{where}: line {number}"
        if len(cells) != len(header):
            raise InputError(
                f"found {len(cells)} figures, expected {len(header)}",
                "complete the row or remove it",
                place,
            )
        labels.append(f"line {number}")
        table.append([parse_number(cells[header.index(name)], name, place) for name in columns])
    return labels, np.array(table, dtype=np.float64).reshape(-1, len(columns))


def check_radius(own: float, given: float, where: str, tolerance: float | None = None) -> None:
    """Raise ``InputError`` unless ``given`` repeats the radius that the geometry has.

    Parameters
    ----------
    own, given : float
        Tip radius [m].
    where : str
        The file, for the message.
    tolerance : float, optional
        Largest difference [m]; by default 0.1 %.
    """
    limit = RADIUS_TOLERANCE * own if tolerance is None else tolerance
    if not abs(given - own) <= limit:
        raise InputError(
            f"the radius is {own:.6g} m by its last station, but {given:g} m was given",
            "leave the radius out or correct it",
            where,
        )


def usable_radius(radius: float | None, where: str) -> float:
    """The tip radius [m] that scales a file in fractions of it, or ``InputError``."""
    if radius is None:
        raise InputError("the file gives fractions of the radius only", GIVE_RADIUS, where)
    if not (isinstance(radius, int | float) and 0.0 < radius < math.inf):
        raise InputError(
            f"the radius is {quoted(radius)} m, expected a length above 0", GIVE_RADIUS, where
        )
    return float(radius)


def check_fractions(fraction: Floats, where: str, labels: Sequence[str]) -> None:
    """Raise ``InputError`` unless fractions of the radius, shape (n,), end at the tip, 1.0."""
    high = int(np.argmax(fraction))
    if fraction[high] > 1.0:
        raise InputError(
            f"{labels[high]}: r/R is {fraction[high]:g}, expected at most 1"
            + ("; it looks like per cent" if fraction[high] == 100.0 else ""),
            "divide by the tip radius, or name the column after its unit",
            where,
        )
    if fraction[-1] < 1.0 - 1e-6:
        raise InputError(
            f"{labels[-1]}: the last r/R is {fraction[-1]:g}, expected 1 (the tip)",
            "add the tip station with its chord, or sort the rows by station",
            where,
        )


def build_propeller(
    path: str,
    labels: Sequence[str],
    name: str,
    blades: int | None,
    station: Floats,
    chord: Floats,
    twist: Floats,
    source: str = "",
    citation: str = "",
) -> Propeller:
    """A ``Propeller`` whose faults are reported with the file and the line they are in.

    Parameters
    ----------
    path : str
        The file.
    labels : sequence of str
        "line 7" for each row.
    name, source, citation : str
        As in ``Propeller``.
    blades : int or None
        None where the file gives no number, which is refused.
    station, chord : ndarray, shape (n,)
        [m].
    twist : ndarray, shape (n,)
        [rad].
    """
    check_blade(station, chord, twist, path, labels)
    if blades is None:
        raise InputError("the file gives no number of blades", GIVE_BLADES, path)
    count = check_blades(blades, path)
    return Propeller(name, count, station, chord, twist, None, source, citation)
