"""The propellers that come with propmap, one TOML file each in ``propellers/``."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

from propmap.errors import InputError, quoted
from propmap.model.model import Propeller


@dataclass(frozen=True)
class Entry:
    """One line of the catalogue: what a propeller is, without its blade.

    Attributes
    ----------
    name, title, family : str
        By which it is loaded, as its maker calls it, and the code of its series.
    blades : int
        Number of blades.
    diameter_m : float
        Diameter [m].
    source : str
        Where the geometry is from.
    """

    name: str
    title: str
    family: str
    blades: int
    diameter_m: float
    source: str


def names() -> list[str]:
    """List the names of all propellers, in alphabetical order."""
    return list(_files())


def entries() -> list[Entry]:
    """List one ``Entry`` for each propeller, in the order of ``names``."""
    return [entry(name) for name in names()]


def search(text: str) -> list[Entry]:
    """Find entries whose name, title or family hold every word of ``text``, in any case."""
    return matching(text, entries())


def matching(text: str, among: list[Entry]) -> list[Entry]:
    """Keep entries whose name, title or family hold every word of ``text``."""
    words = text.lower().split()
    said = [f"{one.name} {one.title} {one.family}".lower() for one in among]
    return [one for one, its in zip(among, said, strict=True) if all(w in its for w in words)]


def load(name: str) -> Propeller:
    """Load the propeller called ``name``, in any case; ``InputError`` if there is none."""
    key = name.strip().lower()
    if key not in _files():
        raise unknown_name(name)
    # These files are propmap's own, and tested; a user's file is checked entry by entry.
    file = tomllib.loads(_files()[key].read_text(encoding="utf-8"))
    blade = file["station_m"], file["chord_m"], file["twist_rad"], file.get("root_cutout_m")
    texts = file.get("source", ""), file.get("citation", "")
    return Propeller(file["name"], file["blades"], *blade, *texts)


@cache
def entry(name: str) -> Entry:
    """Read the line of the propeller called ``name``, one of ``names``."""
    # The arrays come last and are most of the file: leaving them out makes a listing fast.
    head, _, _ = _files()[name].read_text(encoding="utf-8").partition("\nstation_m")
    file = tomllib.loads(head)
    texts = file["title"], file["family"]
    return Entry(name, *texts, file["blades"], 2.0 * file["radius_m"], file["source"])


def unknown_name(name: str) -> InputError:
    """Make the error for a name that the catalogue does not have, with those close to it."""
    found = f"{quoted(name)} is neither a propeller of the catalogue nor a file"
    return InputError(found, f"{close_names(name)} see `propmap props`")


def close_names(text: str) -> str:
    """Ask whether one of the names in the catalogue closest to ``text`` is meant."""
    import difflib

    close = difflib.get_close_matches(text.strip().lower(), names(), n=3, cutoff=0.0)
    return f"did you mean {', '.join(close)}?"


@lru_cache(maxsize=1)
def _files() -> dict[str, Path]:
    found = (Path(__file__).parent / "propellers").glob("*.toml")
    return {file.stem: file for file in sorted(found, key=lambda file: file.stem)}
