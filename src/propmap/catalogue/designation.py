"""Designations of propellers, as they are printed on the blade: 8x6E, 5x4.3x3, 1045, 130x70 mm."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

from propmap import catalogue
from propmap.errors import InputError, quoted

INCH = 0.0254
"""[m]."""

LARGEST_INCHES = 40.0
"""Diameter above which a bare number is taken for millimetres."""

LEAST_DIAMETER, LARGEST_DIAMETER = 0.02, 3.0
"""[m] of any propeller that is meant to be known here."""

STEEPEST = 2.5
"""Largest ratio of pitch to diameter."""

MOST_BLADES = 8

SAME = 0.006
"""Relative difference up to which two lengths are the same: makers round to a twentieth of an
inch."""

NO_MAKER = ("mm", "in", "inch", "uiuc")
"""Units, and where names in the catalogue are from."""

WITHOUT_BLADE = {
    "ance": "Aeronaut CAM Carbon Electric",
    "ancf": "Aeronaut CAM Carbon Folding",
    "apccf": "APC Carbon Fiber",
    "kavfk": "Kavon FK",
    "rusp": "Rev Up Special",
    "zin": "Zingali",
}
"""Series of which loads were measured and no blade."""

_NUMBER = r"(\d{1,3}(?:[.,]\d+)?)"
_TIMES = "[x\u00d7*]"
_SIZE = re.compile(
    rf"(?<![\d.,])(?<!{_TIMES}){_NUMBER}\s*{_TIMES}\s*{_NUMBER}(?:\s*{_TIMES}\s*(\d+))?"
    rf"(?![\d.,]|{_TIMES}\d)"
)
_FOUR_DIGITS = re.compile(rf"(?<![\w.])(\d\d)(\d\d)(?:\s*{_TIMES}\s*(\d+))?(?!\d)")
# The UIUC database writes "gwsdd 5.0x4.3 - 2".
_BLADES = re.compile(r"(\d+)\s*-?\s*blades?\b|(?<=\s)-\s+(\d+)$")
_WORD = re.compile(r"[a-z]+\d*[a-z]*")


@dataclass(frozen=True)
class Designation:
    """A propeller by maker, size and number of blades.

    Attributes
    ----------
    words : tuple of str
        Maker and series in lower case, in the order given; empty where none is named.
    diameter, pitch : float
        [m].
    blades : int or None
        None where the text does not say.
    """

    words: tuple[str, ...]
    diameter: float
    pitch: float
    blades: int | None


def designation(text: str) -> Designation | None:
    """Read a designation; None where it has no size.

    Diameter and pitch are in inches; in millimetres where the text says ``mm`` or the diameter is
    above 40.  Four digits are diameter and pitch as makers of multirotors write them: 1045 is
    10x4.5, 6040 is 6x4, 9450 is 9.4x5.

    Parameters
    ----------
    text : str
        Such as "apc 10x4.7sf", "5x4.3x3", "HQ 5x4.3 3-blade", "130x70" or "DJI 9450".

    Raises
    ------
    InputError
        For a size or a number of blades that no propeller has.
    """
    lower = text.strip().lower()
    blades = _BLADES.search(lower)
    rest = lower[: blades.start()] + " " + lower[blades.end() :] if blades else lower
    sized, digits = _SIZE.search(rest), _FOUR_DIGITS.search(rest)
    if sized:
        numbers = [float(part.replace(",", ".")) for part in sized.groups()[:2]]
    elif digits:
        first, second = digits.groups()[:2]
        # Ten inches and more are whole inches, less are tenths.
        numbers = [float(first) / (1.0 if first[0] == "1" else 10.0), float(second) / 10.0]
    else:
        return None
    found = sized or digits
    assert found is not None
    words = _WORD.findall(rest[: found.start()] + " " + rest[found.end() :])
    unit = 1e-3 if "mm" in words or numbers[0] > LARGEST_INCHES else INCH
    said = blades[1] or blades[2] if blades else found[3]
    return _checked(
        text,
        Designation(
            words=tuple(word for word in words if word not in NO_MAKER),
            diameter=numbers[0] * unit,
            pitch=numbers[1] * unit,
            blades=int(said) if said else None,
        ),
    )


def _checked(text: str, found: Designation) -> Designation:
    if not LEAST_DIAMETER <= found.diameter <= LARGEST_DIAMETER:
        raise InputError(
            f"{quoted(text)} has a diameter of {found.diameter:.3g} m",
            f"give {LEAST_DIAMETER:g} to {LARGEST_DIAMETER:g} m, in inches or with mm; "
            + catalogue.close_names(text),
        )
    if not 0.0 < found.pitch <= STEEPEST * found.diameter:
        raise InputError(
            f"{quoted(text)} has a pitch of {found.pitch:.3g} m",
            f"give a pitch above 0, up to {STEEPEST:g} diameters; {catalogue.close_names(text)}",
        )
    if found.blades is not None and not 2 <= found.blades <= MOST_BLADES:
        raise InputError(
            f"{quoted(text)} has {found.blades} blades", f"give 2 to {MOST_BLADES} blades"
        )
    return found


def candidates(wanted: Designation) -> list[catalogue.Entry]:
    """The propellers of the catalogue that a designation may mean, one for each series.

    Of several blades of one series and size the first that was measured is given.  Where the words
    are the whole name of a series or its code, others whose names go on are left out.  The number
    of blades counts only where no maker is named: makers put one blade on hubs for two and more.
    """
    found: dict[str, catalogue.Entry] = {}
    named, whole = _series(wanted.words), set()
    for entry in catalogue.entries():
        own = designation(entry.title)
        if own is None or not same_size((wanted.diameter, wanted.pitch), (own.diameter, own.pitch)):
            continue
        if wanted.words and entry.family not in named:
            continue
        if not wanted.words and wanted.blades not in (None, entry.blades):
            continue
        family = entry.family
        if family not in found or (_measured(entry) and not _measured(found[family])):
            found[family] = entry
        if _whole(wanted.words, family):
            whole.add(family)
    return [entry for family, entry in found.items() if family in whole or not whole]


def series_named(words: tuple[str, ...]) -> tuple[list[str], tuple[str, ...]]:
    """Codes of the series that a designation's ``words`` name, and the words that name none.

    Words are given up from the last on until the others name a series: "gws hd" stands for all
    series of GWS.  The list is empty where the first word is unknown, or there is none.
    """
    for count in range(len(words), 0, -1):
        found = _series(words[:count])
        whole = [family for family in found if _whole(words[:count], family)]
        if found:
            return whole or found, words[count:]
    return [], words


def same_size(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Whether two pairs of diameter and pitch are the same but for what makers round."""
    return all(abs(a - b) <= SAME * b for a, b in zip(one, other, strict=True))


def _measured(entry: catalogue.Entry) -> bool:
    return entry.name.startswith("uiuc-")


@lru_cache(maxsize=1)
def _title_words() -> dict[str, set[tuple[str, ...]]]:
    """Of each series, what its propellers' titles call it."""
    found: dict[str, set[tuple[str, ...]]] = {
        family: {tuple(_WORD.findall(title.lower()))} for family, title in WITHOUT_BLADE.items()
    }
    for entry in catalogue.entries():
        own = designation(entry.title)
        if own is not None:
            found.setdefault(entry.family, set()).add(own.words)
    return found


def _series(words: tuple[str, ...]) -> list[str]:
    return [
        family
        for family, titles in _title_words().items()
        if words and any(_names_series(words, family, title) for title in titles)
    ]


def _whole(words: tuple[str, ...], family: str) -> bool:
    """Whether ``words`` are all of a title, or the series' code."""
    return words in _title_words()[family] or "".join(words) == family


def _names_series(words: tuple[str, ...], family: str, title: tuple[str, ...]) -> bool:
    """Whether each of the ``words`` is one of the title, or the series' code is made of them."""
    first, *rest = words
    if not rest and len(first) == 1:
        # A letter alone is a series' mark, as in 12x6E, and no maker's.
        return first in title[1:]
    if all(word in title or word == family for word in words):
        return True
    # "apc" and "sf" make apcsf; a maker alone stands for all its series.
    return family == "".join(words) or (not rest and family.startswith(first))
