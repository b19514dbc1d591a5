"""The propellers of the catalogue.

Measured blades and a few others have one TOML file each in ``propellers/``.  Blades from geometry
files of APC are in one table, see ``apc``.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

from propmap.catalogue.apc import apc_blades, name_of, series_of
from propmap.errors import InputError, quoted
from propmap.model.propeller import Propeller


@dataclass(frozen=True)
class Entry:
    """A propeller of the catalogue, without the geometry of its blade.

    Attributes
    ----------
    name, title, family : str
        Name that ``load`` accepts, title from the manufacturer, and code of the series.
    blades : int
        Number of blades.
    diameter_m : float
        Diameter [m].
    source : str
        Source of the geometry.
    """

    name: str
    title: str
    family: str
    blades: int
    diameter_m: float
    source: str

    @property
    def geometry(self) -> str:
        """Origin of the blade: "measured", or the file of its "maker"."""
        return "measured" if self.name.startswith("uiuc-") else "maker"


def names() -> list[str]:
    """Return the names of all propellers, in alphabetical order."""
    return list(_names())


def entries() -> list[Entry]:
    """Return an ``Entry`` for each propeller, in the order of ``names``."""
    return [entry(name) for name in names()]


def search(text: str) -> list[Entry]:
    """Return the entries with all words of ``text`` in name, title or family, ignoring case."""
    return matching(text, entries())


def matching(text: str, among: list[Entry]) -> list[Entry]:
    """Return the entries of ``among`` that ``search`` would return for ``text``."""
    words = text.lower().split()
    said = [f"{one.name} {one.title} {one.family}".lower() for one in among]
    return [one for one, its in zip(among, said, strict=True) if all(w in its for w in words)]


def load(name: str) -> Propeller:
    """Return the propeller ``name``, ignoring case; raise ``InputError`` if it is unknown."""
    key = name.strip().lower()
    if key not in _names():
        raise unknown_name(name)
    if key in apc_blades():
        return apc_blades()[key].propeller()
    # Tests check these files, so the slow validation of user files is not needed here.
    file = tomllib.loads(_files()[key].read_text(encoding="utf-8"))
    blade = file["station_m"], file["chord_m"], file["twist_rad"], file.get("root_cutout_m")
    texts = file.get("source", ""), file.get("citation", "")
    return Propeller(file["name"], file["blades"], *blade, *texts)


@cache
def entry(name: str) -> Entry:
    """Return the entry of the propeller called ``name``, one of ``names``."""
    if name in apc_blades():
        blade = apc_blades()[name]
        return _of_maker(blade.title, blade.blades, 2.0 * blade.radius, blade.source)
    # Skip the arrays, the last and largest part of the file: this makes a listing fast.
    head, _, _ = _files()[name].read_text(encoding="utf-8").partition("\nstation_m")
    file = tomllib.loads(head)
    texts = file["title"], file["family"]
    return Entry(name, *texts, file["blades"], 2.0 * file["radius_m"], file["source"])


def of_makers_file(title: str, blades: int, diameter_m: float) -> Entry | None:
    """Return the entry of the propeller in an APC file with this ``title``.

    A title outside the catalogue has a new entry; None if the title names no known series.
    """
    name = name_of(title)
    if name in _names():
        return entry(name)
    known = series_of(title) is not None
    return _of_maker(title, blades, diameter_m, f"APC PE0 file {title}") if known else None


def _of_maker(title: str, blades: int, diameter_m: float, source: str) -> Entry:
    series = series_of(title)
    assert series is not None  # the callers pass only titles of a known series
    family, words = series
    return Entry(name_of(title), f"APC {title} {words}", family, blades, diameter_m, source)


def unknown_name(name: str) -> InputError:
    """Return the error for a name that is not in the catalogue, with similar names."""
    found = f"{quoted(name)} is neither a propeller of the catalogue nor a file"
    return InputError(found, f"{close_names(name)} see `propmap props`")


def close_names(text: str) -> str:
    """Return a question with the names of the catalogue that are closest to ``text``."""
    import difflib

    close = difflib.get_close_matches(text.strip().lower(), names(), n=3, cutoff=0.0)
    return f"did you mean {', '.join(close)}?"


@lru_cache(maxsize=1)
def _names() -> dict[str, None]:
    return dict.fromkeys(sorted({*_files(), *apc_blades()}))


@lru_cache(maxsize=1)
def _files() -> dict[str, Path]:
    found = (Path(__file__).parent / "propellers").glob("*.toml")
    return {file.stem: file for file in found}
