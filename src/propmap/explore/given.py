"""Files that are explored: what they are, by the package's readers, and where they are kept."""

from __future__ import annotations

import re
import secrets
import tempfile
import threading
import tomllib
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from propmap.catalogue.lookup import looks_like_path
from propmap.errors import InputError, quoted
from propmap.fit.files import is_fit, read_fit
from propmap.fit.tunnel import TunnelData, measured_loads
from propmap.io.geometry_file import read_geometry_file
from propmap.io.points_file import LOAD_COLUMNS
from propmap.io.text_file import read_lines
from propmap.io.uiuc_loads import looks_like_uiuc_loads
from propmap.model.air import Air
from propmap.model.airfoil import read_airfoil
from propmap.model.propeller import Propeller

Kind = Literal["geometry", "constants", "fit", "table", "vehicle", "data"]

MOST_BYTES = 5_000_000
"""Of a file that comes through the browser."""

MOST_FILES = 200
"""Kept at a time, of all tabs; the one not used for longest goes first."""

ENDINGS = (".toml", ".npz", ".csv", ".txt", ".dat")


@dataclass(frozen=True, eq=False)
class Given:
    """A file, read.

    Attributes
    ----------
    kind : str
        What it is.
    name : str
        Without its folder.
    data : bytes
        Its content.
    path : str
        As it was given on the command line, "" for what came through the browser.
    found : Any
        What the reader made of it: a ``Propeller``, an ``Airfoil``, a ``FitFile``, a ``LoadTable``,
        a ``Vehicle``, or a function that gives ``TunnelData`` of a propeller and air.
    """

    kind: Kind
    name: str
    data: bytes
    path: str
    found: Any


def read_path(path: Path) -> Given:
    """The file that the command line names; ``InputError`` in one line where it is none of ours."""
    kind, found = _read(path, trusted=True)
    return Given(kind, path.name, path.read_bytes(), str(path), found)


def read_upload(name: str, data: bytes) -> Given:
    """A file that came through the browser, written to a temporary folder for its reader.

    Parameters
    ----------
    name : str
        As the browser says; only its last part counts, and its ending.
    data : bytes
        Its content.

    Raises
    ------
    InputError
        The reader's, with the name alone; and for a file that is too large or of another kind.
    """
    plain = (
        re.sub(r"[^\w.+ -]", "_", Path(name.replace("\\", "/")).name)[-80:].lstrip(".") or "file"
    )
    if len(data) > MOST_BYTES:
        raise InputError(
            f"the file has {len(data) / 1e6:.1f} MB, expected at most {MOST_BYTES / 1e6:g}",
            "give a smaller one",
            plain,
        )
    with tempfile.TemporaryDirectory(prefix="propmap-") as folder:
        path = Path(folder) / plain
        path.write_bytes(data)
        try:
            kind, found = _read(path, trusted=False)
        except InputError as error:
            # Its own text alone may say where the file lay.
            text = str(error).replace(f"{path}", plain).replace(folder, "")
            raise InputError(text) from None
    return Given(kind, plain, data, "", found)


def _read(path: Path, *, trusted: bool) -> tuple[Kind, Any]:
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise InputError(
            f"the file's ending is {quoted(path.suffix)}",
            "give a propeller, constants, a fit, a table, a vehicle or measured loads: "
            f"{', '.join(ENDINGS)}",
            str(path),
        )
    if ending == ".npz":
        from propmap.table.query import LoadTable

        return "table", LoadTable.load(path)
    if ending == ".toml":
        return _read_toml(path, trusted=trusted)
    if looks_like_uiuc_loads(path) or (ending == ".csv" and _has_loads(path)):
        # Read once now, so that what is wrong is told at once.
        make = _loads_of(path)
        return "data", make
    return "geometry", read_geometry_file(str(path))


def _read_toml(path: Path, *, trusted: bool) -> tuple[Kind, Any]:
    text = "\n".join(read_lines(path, "TOML file"))
    try:
        fields = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"not valid TOML ({error})", "correct the file", str(path)) from None
    if "rotors" in fields or "mass" in fields:
        from propmap.vehicle.vehicle_toml import read_vehicle

        named = fields.get("propeller", "")
        named = named.get("geometry", "") if isinstance(named, dict) else named
        if not trusted and isinstance(named, str) and looks_like_path(named):
            raise InputError(
                f"propeller is {quoted(named)}, another file",
                "name one of the catalogue, or give the vehicle to `propmap explore`",
                str(path),
            )
        return "vehicle", read_vehicle(path).vehicle
    if "station_m" in fields:
        return "geometry", read_geometry_file(str(path))
    if is_fit(path):
        return "fit", read_fit(path)
    return "constants", read_airfoil(path)


def _has_loads(path: Path) -> bool:
    first = next((line for line in read_lines(path, "CSV file") if line.strip()), "")
    return any(name in first for name in LOAD_COLUMNS)


def _loads_of(path: Path) -> Callable[[Propeller, Air], TunnelData]:
    """What turns the file's rows into loads, coefficients by a propeller and air."""
    return measured_loads(path)


class Shelf:
    """The files of all tabs, each under a name that only its own tab knows."""

    def __init__(self) -> None:
        self._kept: OrderedDict[str, Given] = OrderedDict()
        self._first: dict[str, Given] = {}
        self._lock = threading.Lock()

    def put(self, given: Given, *, always: bool = False) -> str:
        """Keep a file, and give the name under which it is; ``always`` for the command line's."""
        token = secrets.token_urlsafe(12)
        with self._lock:
            if always:
                self._first[token] = given
                return token
            self._kept[token] = given
            while len(self._kept) > MOST_FILES:
                self._kept.popitem(last=False)
        return token

    def get(self, token: str) -> Given:
        """The file under a name; ``InputError`` where it is not here any more."""
        with self._lock:
            if token in self._first:
                return self._first[token]
            if token in self._kept:
                self._kept.move_to_end(token)
                return self._kept[token]
        raise InputError("a file that was dropped here is not kept any more", "drop it again")
