"""Designations of propellers, as printed on the blade: 8x6E, 5x4.3x3, T5045C, 130x70 mm."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from propmap import catalogue
from propmap.errors import InputError, quoted
from propmap.units import INCH


class Rule(NamedTuple):
    """Meaning of a form of designation for one manufacturer."""

    form: str  # pattern of the printed text, in lower case
    blades: int
    means: str  # explanation for messages
    size: tuple[float, ...] = ()  # diameter and pitch [in], if the text does not contain them


class Maker(NamedTuple):
    """A manufacturer of multirotor propellers; rules only for designations that need one."""

    name: str
    words: str  # pattern of the names of manufacturer and series, in lower case
    rules: tuple[Rule, ...] = ()
    racing: bool = False  # whether most propellers of about five inches have three blades
    carbon: bool = False  # whether large propellers are of carbon fiber


def _rule(row: dict[str, Any]) -> Rule:
    return Rule(row["form"], row["blades"], row["means"], tuple(row.get("size", ())))


_KNOWN = tomllib.loads(Path(__file__).with_name("makers.toml").read_text(encoding="utf-8"))
MAKERS = tuple(
    Maker(**{**maker, "rules": tuple(map(_rule, maker.get("rules", ())))})
    for maker in _KNOWN["makers"]
)  # manufacturers and their rules, as stated by pages of shops and manufacturers alike

_NAMES = {maker: rf"(?<![a-z])(?:{maker.words})(?![a-z])" for maker in MAKERS}


def spaced(text: str) -> str:
    """Insert a blank between a manufacturer and a number, as in "gf51466"; ``text`` in lower
    case."""
    for name in _NAMES.values():
        text = re.sub(rf"({name})(?=\d)", r"\1 ", text)
    return text


def ruled(text: str) -> tuple[str, Rule] | None:
    """Return manufacturer and rule of a designation in lower case, or None.

    If the text names no manufacturer, rules of all manufacturers apply, except names of sizes.
    """
    named = [maker for maker, name in _NAMES.items() if re.search(name, text)]
    for maker in named or MAKERS:
        for rule in maker.rules:
            found = re.search(rf"(?<![\w.]){rule.form}(?!\d)", text)
            if found and (named or not rule.size):
                return maker.name, rule
    return None


# -------------------------------------------------------------------------------------------------
# Manufacturer, size and number of blades of a designation, and matching catalogue propellers.

LARGEST_INCHES = 40.0  # a larger diameter without a unit is in millimeters
LEAST_DIAMETER, LARGEST_DIAMETER = 0.02, 3.0  # limits of supported propellers [m]
STEEPEST = 2.5  # largest ratio of pitch to diameter
MOST_BLADES = 8

RACING = (4.5 * INCH, 6.2 * INCH)
"""Diameters [m] at which racing propellers are assumed to have three blades, if the designation
contains no number of blades."""

FIVE_INCH_DOUBT, OTHER_DOUBT = 0.1, 0.5
"""Probabilities that the number of blades assumed for these manufacturers is wrong.

The first is for diameters within ``RACING``, where 2 of 21 propellers on stands had two blades.
The second is for the other diameters up to 11.5 in.  There, 9 of 12 propellers had three blades,
but names without a number of blades often denote two-blade propellers."""

SAME = 0.006  # relative difference of equal lengths, because manufacturers round to 1/20 in
NO_MAKER = ("mm", "in", "inch", "uiuc")  # words of designations that name no manufacturer

WITHOUT_BLADE: dict[str, str] = _KNOWN["without_blade"]
"""Titles of series with measured loads but without a measured blade, by their codes."""

_NUMBER = r"(\d{1,3}(?:[.,]\d+)?)"
_TIMES = "[x\u00d7*]"
_SIZE = re.compile(
    rf"(?<![\d.,])(?<!{_TIMES}){_NUMBER}\s*{_TIMES}\s*{_NUMBER}(?:\s*{_TIMES}\s*(\d+))?"
    rf"(?![\d.,]|{_TIMES}\d)"
)
# Digits without an x, as in 51466-3, with an optional letter in front, as in T5045C.
_FIGURES = re.compile(
    rf"(?<![\w.])[tqp]?([1-9]\d)(\d\d\d?)(?:[cs](?![a-z]))?(?:\s*{_TIMES}\s*(\d+)|-(\d))?"
    rf"(?!\.?\d|\s*{_TIMES}\s*\d)"
)
# The UIUC database writes "gwsdd 5.0x4.3 - 2", APC "5x4E-3".
_BLADES = re.compile(r"(\d+)\s*-?\s*blades?\b|(?<=\s)-\s+(\d+)$|(?<=\de)-(\d)\b")
_WORD = re.compile(r"[a-z]+\d*[a-z]*")


@dataclass(frozen=True)
class Designation:
    """A propeller by manufacturer, size and number of blades."""

    words: tuple[str, ...]  # manufacturer and series in lower case, in the order of the text
    diameter: float  # [m]
    pitch: float  # [m]
    blades: int | None  # None if neither the text nor a rule contains it
    maker: str = ""  # name of one of ``MAKERS``
    size: str = ""  # diameter and pitch as read, for messages
    counted: str = ""  # number of blades and its origin, for messages
    doubt: float = (
        0.0  # probability that it has three blades instead of two, or two instead of three
    )

    @property
    def reading(self) -> str:
        """Interpretation of the text and assumptions, for messages."""
        return f"read as {self.size}, {self.counted}"

    def with_blades(self, asked: int | None) -> Designation:
        """Return the designation with the number of blades ``asked``, if given."""
        if asked is None or (asked == self.blades and not self.doubt):
            return self
        other = f", not {self.blades}" if self.blades not in (None, asked) else ""
        return replace(self, blades=asked, counted=f"{asked} blades as requested{other}", doubt=0.0)


@lru_cache(maxsize=1024)
def designation(text: str) -> Designation | None:
    """Return the designation in a text such as "apc 10x4.7sf" or "T5045C"; None without a size.

    Diameter and pitch are in inches, or in millimeters if the text contains ``mm`` or the diameter
    is above 40.  Of four or five digits, the first two are tenths of an inch of diameter, the
    others tenths or hundredths of an inch of pitch: 6040 is 6x4, 9450 is 9.4x5, 51466 is 5.1x4.66.
    If such a propeller would be too steep, the diameter is in inches: 1045 is 10x4.5.  ``MAKERS``
    contains further rules.  Raise ``InputError`` for an impossible size or number of blades.
    """
    lower = spaced(text.strip().lower())
    blades = _BLADES.search(lower)
    rest = lower[: blades.start()] + " " + lower[blades.end() :] if blades else lower
    found = _SIZE.search(rest) or _FIGURES.search(rest)
    by_rule = ruled(rest)
    said: str | None
    if found is None:
        if by_rule is None or not by_rule[1].size:
            return None
        numbers, said, other = list(by_rule[1].size), None, ""
    elif found.re is _SIZE:
        numbers = [float(part.replace(",", ".")) for part in found.groups()[:2]]
        said, other = found[3], ""
    else:
        numbers, other = _from_figures(*found.groups()[:2])
        said = found[3] or found[4]
    words = _WORD.findall(f"{rest[: found.start()]} {rest[found.end() :]}" if found else rest)
    metric = "mm" in words or numbers[0] > LARGEST_INCHES
    unit, name = (1e-3, "mm") if metric else (INCH, "in")
    diameter, pitch = numbers[0] * unit, numbers[1] * unit
    if blades:
        said = blades[1] or blades[2] or blades[3]
    count = int(said) if said else None
    if not LEAST_DIAMETER <= diameter <= LARGEST_DIAMETER:
        remedy = f"give {LEAST_DIAMETER:g} to {LARGEST_DIAMETER:g} m, in inches or with mm; "
        remedy += catalogue.close_names(text)
        raise InputError(f"{quoted(text)} has a diameter of {diameter:.3g} m", remedy)
    if not 0.0 < pitch <= STEEPEST * diameter:
        remedy = f"give a pitch of up to {STEEPEST:g} diameters; {catalogue.close_names(text)}"
        raise InputError(f"{quoted(text)} has a pitch of {pitch:.3g} m", remedy)
    if count is not None and not 2 <= count <= MOST_BLADES:
        raise InputError(f"{quoted(text)} has {count} blades", f"give 2 to {MOST_BLADES} blades")
    whose_own = next((maker for maker, name in _NAMES.items() if re.search(name, rest)), None)
    maker, doubt = whose_own.name if whose_own else "", 0.0
    counted = f"{count} blades"
    if count is None and by_rule is not None:
        whose, rule = by_rule
        count = rule.blades
        counted = f"{count} blades" + ("" if maker else f" if it is from {whose}")
        counted += f": {rule.means}"
        maker = whose
    elif count is None and whose_own and whose_own.racing and RACING[0] < diameter < RACING[1]:
        count, doubt = 3, FIVE_INCH_DOUBT
        counted = f"three blades assumed, as for most {maker} propellers of this size "
        counted += "(for two, add --blades 2)"
    elif count is None:
        if whose_own and whose_own.racing and diameter < 11.5 * INCH:
            doubt = OTHER_DOUBT
        counted = "two blades assumed (for three, add --blades 3 or end the name with x3)"
    own = tuple(word for word in words if word not in NO_MAKER)
    size = f"{numbers[0]:g} x {numbers[1]:g} {name}{other}"
    return Designation(own, diameter, pitch, count, maker, size, counted, doubt)


def _from_figures(first: str, second: str) -> tuple[list[float], str]:
    """Return diameter and pitch [in] from two groups of digits, and a remark on the alternative."""
    diameter, pitch = float(first) / 10.0, float(second) / 10.0 ** (len(second) - 1)
    if len(second) == 2 and pitch > STEEPEST * diameter:
        return [float(first), pitch], ""
    # With a smaller pitch the alternative is not worth a remark: few propellers are flatter.
    large = len(second) == 2 and pitch >= 0.2 * float(first)
    return [diameter, pitch], f" (not {first} x {pitch:g} in)" if large else ""


def candidates(wanted: Designation) -> list[catalogue.Entry]:
    """Return the propellers of the catalogue that a designation may mean, one for each series.

    In a series, the wanted number of blades takes precedence, then a measured blade.  If the words
    are the whole name or code of a series, longer names are excluded.  The number of blades must
    agree only without a manufacturer, because one blade may be used on several hubs.
    """
    found: dict[str, catalogue.Entry] = {}
    named, whole = _series(wanted.words), set()

    def place(entry: catalogue.Entry) -> tuple[bool, bool]:
        return entry.blades == (wanted.blades or 2), entry.geometry == "measured"

    for entry in catalogue.entries():
        own = designation(entry.title)
        if own is None or not same_size((wanted.diameter, wanted.pitch), (own.diameter, own.pitch)):
            continue
        if wanted.words and entry.family not in named:
            continue
        if not wanted.words and wanted.blades not in (None, entry.blades):
            continue
        family = entry.family
        if family not in found or place(entry) > place(found[family]):
            found[family] = entry
        if _whole(wanted.words, family):
            whole.add(family)
    return [entry for family, entry in found.items() if family in whole or not whole]


def series_named(words: tuple[str, ...]) -> tuple[list[str], tuple[str, ...]]:
    """Split ``words`` of a designation into codes of the named series, and unknown words.

    Words at the end are dropped until the rest names a series, so "gws hd" means all series of GWS.
    """
    for count in range(len(words), 0, -1):
        found = _series(words[:count])
        whole = [family for family in found if _whole(words[:count], family)]
        if found:
            return whole or found, words[count:]
    return [], words


def same_size(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Return whether two pairs of diameter and pitch agree within the rounding of designations."""
    return all(abs(a - b) <= SAME * b for a, b in zip(one, other, strict=True))


@lru_cache(maxsize=1)
def _title_words() -> dict[str, set[tuple[str, ...]]]:
    """Return the names of each series, as words, from the titles of its propellers."""
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
    """Return whether ``words`` are a whole title of the series, or its code."""
    return words in _title_words()[family] or "".join(words) == family


def _names_series(words: tuple[str, ...], family: str, title: tuple[str, ...]) -> bool:
    """Return whether each of the ``words`` is in the title, or the words form the series code."""
    first, *rest = words
    if not rest and len(first) == 1:
        # A single letter, as in 12x6E, is the mark of a series, not of a manufacturer.
        return first in title[1:]
    if all(word in title or word == family for word in words):
        return True
    # "apc" and "sf" form apcsf; a manufacturer alone means all its series.
    return family == "".join(words) or (not rest and family.startswith(first))
