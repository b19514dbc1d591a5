"""Designations of propellers, as printed on the blade: 8x6E, 5x4.3x3, T5045C, 36190."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

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
    """A manufacturer with sizes in inches; rules only for designations that need one."""

    name: str
    words: str  # pattern of the names of manufacturer and series, in lower case
    sizes: tuple[float, float]  # smallest and largest diameter [in]
    rules: tuple[Rule, ...] = ()
    racing: bool = False  # whether most propellers of about five inches have three blades
    carbon: bool = False  # whether large propellers are of carbon fiber
    multirotor: bool = True  # whether most propellers are for multirotors

    def makes(self, diameter: float) -> bool:
        """Return whether propellers of this ``diameter`` [m] are in the range, within 2 %."""
        return 0.98 * self.sizes[0] <= diameter / INCH <= 1.02 * self.sizes[1]


def _rule(row: dict[str, Any]) -> Rule:
    return Rule(row["form"], row["blades"], row["means"], tuple(row.get("size", ())))


_KNOWN = tomllib.loads(Path(__file__).with_name("makers.toml").read_text(encoding="utf-8"))
MAKERS = tuple(
    Maker(
        **(row | {"sizes": tuple(row["sizes"]), "rules": tuple(map(_rule, row.get("rules", ())))})
    )
    for row in _KNOWN["makers"]
)  # manufacturers and their rules, as stated by pages of shops and manufacturers alike

_NAMES = {maker: rf"(?<![a-z])(?:{maker.words})(?![a-z])" for maker in MAKERS}


def spaced(text: str) -> str:
    """Insert a blank between a manufacturer and a number, as in "gf51466"; ``text`` in lower
    case."""
    for name in _NAMES.values():
        text = re.sub(rf"({name})(?=\d)", r"\1 ", text)
    return text


def ruled(text: str) -> tuple[Maker, Rule] | None:
    """Return manufacturer and rule of a designation in lower case, or None.

    If the text names no manufacturer, rules of all manufacturers apply, except names of sizes.
    """
    named = [maker for maker, name in _NAMES.items() if re.search(name, text)]
    for maker in named or MAKERS:
        for rule in maker.rules:
            found = re.search(rf"(?<![\w.]){rule.form}(?!\d)", text)
            if found and (named or not rule.size):
                return maker, rule
    return None


# -------------------------------------------------------------------------------------------------
# Manufacturer, size and number of blades of a designation, and matching catalogue propellers.

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

_TIMES = "[x\u00d7*]"
_UNIT = r"(?:mm|cm|m|in(?:ch(?:es)?)?)(?![a-z])|[\"\u2033\u201d]|''|\u2019\u2019"
_WITH_UNIT = rf"(?:\s*({_UNIT}))?"
# A diameter of four digits requires a pitch of three, because 5040x3 means three blades.
_NUMBER = rf"(\d{{1,3}}(?:[.,]\d+)?|\d{{4}}(?=(?:\s*(?:{_UNIT}))?\s*{_TIMES}\s*\d{{3}}))"
_SIZE = re.compile(
    rf"(?<![\d.,])(?<!{_TIMES}){_NUMBER}{_WITH_UNIT}\s*{_TIMES}\s*{_NUMBER}{_WITH_UNIT}"
    rf"(?:\s*{_TIMES}\s*(\d+){_WITH_UNIT})?(?![\d.,]|{_TIMES}\d)"
)
# Digits without an x, as in 51466-3, with an optional letter in front, as in T5045C.
_FIGURES = re.compile(
    rf"(?<![\w.])[tqpr]?([1-9]\d)(\d\d\d?)(?:[cs](?![a-z]))?(?:\s*{_TIMES}\s*(\d+)|-(\d))?"
    rf"(?!\.?\d|\s*{_TIMES}\s*\d)"
)
# The UIUC database writes "gwsdd 5.0x4.3 - 2", APC "5x4E-3".
_BLADES = re.compile(r"(\d+)\s*-?\s*blades?\b|(?<=\s)-\s+(\d+)$|(?<=\de)-(\d)\b")
_WORD = re.compile(r"[a-z]+\d*[a-z]*")
_LENGTH = re.compile(rf"\d+(?:[.,]\d+)?\s*(?:{_UNIT})")


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

    Written units count.  Of all readings without a unit, or of digits such as 51466, the result is
    the most probable one for the sizes of the manufacturer, see ``_log_prior``; ``reading`` lists
    the others.  ``MAKERS`` contains further rules.  Raise ``InputError`` for an impossible size or
    number of blades.
    """
    lower = spaced(text.strip().lower())
    blades = _BLADES.search(lower)
    rest = lower[: blades.start()] + " " + lower[blades.end() :] if blades else lower
    own = next((maker for maker, name in _NAMES.items() if re.search(name, rest)), None)
    found = _SIZE.search(rest) or _FIGURES.search(rest)
    by_rule = ruled(rest)
    said = None
    if found is None:
        if by_rule is None or not by_rule[1].size:
            return None
        readings = [_reading(by_rule[1].size[0], by_rule[1].size[1])]
    elif found.re is _SIZE:
        readings, said = _readings(own, *found.groups()), found[5]
    else:
        readings, said = _from_figures(found[1], found[2]), found[3] or found[4]
    if not readings:
        return None
    size = _likeliest(readings, own)
    _, diameter, pitch, _ = size
    words = _WORD.findall(f"{rest[: found.start()]} {rest[found.end() :]}" if found else rest)
    if blades:
        said = blades[1] or blades[2] or blades[3]
    count = int(said) if said else None
    if not LEAST_DIAMETER <= diameter <= LARGEST_DIAMETER:
        remedy = f"give {LEAST_DIAMETER:g} to {LARGEST_DIAMETER:g} m, in inches or with a unit; "
        remedy += catalogue.close_names(text)
        raise InputError(f"{quoted(text)} has a diameter of {diameter:.3g} m", remedy)
    if not 0.0 < pitch <= STEEPEST * diameter:
        remedy = f"give a pitch of up to {STEEPEST:g} diameters; {catalogue.close_names(text)}"
        raise InputError(f"{quoted(text)} has a pitch of {pitch:.3g} m", remedy)
    if count is not None and not 2 <= count <= MOST_BLADES:
        raise InputError(f"{quoted(text)} has {count} blades", f"give 2 to {MOST_BLADES} blades")
    maker, doubt = own.name if own and own.multirotor else "", 0.0
    counted = f"{count} blades"
    if count is None and by_rule is not None and by_rule[0].makes(diameter):
        whose, rule = by_rule[0].name, by_rule[1]
        count = rule.blades
        counted = f"{count} blades" + ("" if maker else f" if it is from {whose}")
        counted += f": {rule.means}"
        maker = whose
    elif count is None and own and own.racing and RACING[0] < diameter < RACING[1]:
        count, doubt = 3, FIVE_INCH_DOUBT
        counted = f"three blades assumed, as for most {maker} propellers of this size "
        counted += "(for two, add --blades 2)"
    elif count is None:
        if own and own.racing and diameter < 11.5 * INCH:
            doubt = OTHER_DOUBT
        counted = "two blades assumed (for three, add --blades 3 or end the name with x3)"
    named = tuple(word for word in words if word not in NO_MAKER)
    return Designation(named, diameter, pitch, count, maker, size.text, counted, doubt)


def without_size(text: str) -> InputError:
    """Return the error for a ``text`` that is neither a name nor contains a size."""
    length, ducted = _LENGTH.search(text.lower()), re.search(r"\bedf\b|duct", text.lower())
    if ducted:
        remedy = "propmap models propellers without a duct; give an open propeller"
        return InputError(f"{quoted(text)} is a ducted fan", remedy)
    if length is None:
        return catalogue.unknown_name(text)
    found = f"{quoted(text)} is neither a propeller of the catalogue nor a file: {length[0]} is a "
    found += "diameter without a pitch"
    return InputError(found, "add the pitch, with the unit at the end, as in 31x20mm or 12x6in")


# -------------------------------------------------------------------------------------------------
# Readings of a size, and their probability.

UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}  # [m]; other units are inches

NO_UNIT, NO_POINT, WHOLE_DIAMETER, WHOLE_PITCH = -4.0, -5.0, -1.0, -0.5
"""Logarithms of the probabilities of a style: millimeters without a unit; sizes without their
decimal points; in four or five digits, a diameter and a pitch in whole inches."""

SIZES = 9.0, 0.9  # median diameter [in], and standard deviation of its logarithm

RATIOS = np.array(
    [
        [1.5, 3.0, 5.0, 9.0, 16.0, 30.0],  # diameter [in]
        [1.1, 0.85, 0.78, 0.56, 0.5, 0.37],  # median of pitch over diameter
        [0.55, 0.35, 0.3, 0.3, 0.33, 0.25],  # standard deviation of its logarithm
    ]
)
"""Pitch over diameter by size, of the 370 different sizes in the catalogue and on stands."""

FLATTEST = 0.18  # a smaller pitch over diameter is unusual
UNUSUAL, STRANGE = -12.0, -4.0
"""Logarithm of the probability of ratios or diameters outside the usual range, and the least one of
ratios inside."""

CLOSE = 4.0  # difference of the logarithms below which the note lists another reading


class Reading(NamedTuple):
    """A possible reading of a size."""

    text: str  # for messages
    diameter: float  # [m]
    pitch: float  # [m]
    style: float  # logarithm of the probability that this size is written in this way

    @property
    def possible(self) -> bool:
        """Whether propmap supports this size."""
        within = LEAST_DIAMETER <= self.diameter <= LARGEST_DIAMETER
        return within and 0.0 < self.pitch <= STEEPEST * self.diameter


def _reading(
    diameter: float, pitch: float, unit: str = "in", of_pitch: str = "", style: float = 0.0
) -> Reading:
    """Return the reading of two lengths in these units, by default in inches."""
    one, other = (UNITS.get(name, INCH) for name in (unit, of_pitch or unit))
    name = unit if unit in UNITS else "in"
    text = f"{diameter:g} x {pitch * other / one:.4g} {name}"
    return Reading(text, diameter * one, pitch * other, style)


def _readings(maker: Maker | None, *written: str | None) -> list[Reading]:
    """Return the readings of the groups of ``_SIZE``, in order of preference.

    The list is empty if a unit is only after the first number, and the second may be the number of
    blades, as in "31mm x 4".
    """
    first, unit, second, *others = ((part or "").replace(",", ".") for part in written)
    after = others[0] or others[2]
    if unit and not after and second.isdigit() and not others[1]:
        return []
    numbers = float(first), float(second)
    if (unit or after) and (after != "m" or numbers[0] <= LARGEST_DIAMETER):
        return [_reading(*numbers, unit or after, after)]
    found = []
    for k, diameter in enumerate(_with_points(first)):
        for j, pitch in enumerate(_with_points(second)):
            # Nobody writes 130 for 13.0, but 51x50 may be 5.1x5.0.
            if not (first if k else second if j else "").endswith("0"):
                style = NO_POINT if j or k else 0.0
                found.append(_reading(diameter, pitch, style=style))
    metric = NO_UNIT + (UNUSUAL if maker else 0.0)
    return [*found, _reading(*numbers, "mm", style=metric)]


def _with_points(number: str) -> list[float]:
    """Return the values of a ``number``, first as written, then with added decimal points."""
    points = range(len(number)) if number.isdigit() else [0]
    return [float(number) / 10.0**k for k in points]


def _from_figures(first: str, second: str) -> list[Reading]:
    """Return the readings of two groups of digits: tenths of an inch first, then whole inches."""
    diameter, pitch = float(first), float(second)
    found = [
        _reading(diameter / 10.0, pitch / 10.0 ** (len(second) - 1)),
        _reading(diameter, pitch / 10.0, style=WHOLE_DIAMETER),
    ]
    whole = _reading(diameter, pitch, style=WHOLE_DIAMETER + WHOLE_PITCH)
    return [*found, whole] if len(second) == 2 else found


def _likeliest(readings: list[Reading], maker: Maker | None) -> Reading:
    """Return the most probable reading; its text lists the other probable ones, and the first.

    Without a possible reading, return the first one.
    """
    possible = [one for one in readings if one.possible]
    if not possible:
        return readings[0]
    scores = [_log_prior(one, maker) for one in possible]
    score, best = max(zip(scores, possible, strict=True), key=lambda pair: pair[0])
    others = [
        one.text
        for other, one in zip(scores, possible, strict=True)
        if one is not best and (other > score - CLOSE or one is readings[0])
    ]
    text = best.text + (f" (not {' or '.join(others)})" if others else "")
    if score <= UNUSUAL:
        text += f", an unusual size{f' for {maker.name}' if maker else ''}"
    return best._replace(text=text)


def _log_prior(one: Reading, maker: Maker | None) -> float:
    """Return the logarithm of the probability density of a reading, except for a constant."""
    size, ratio = one.diameter / INCH, one.pitch / one.diameter
    if ratio < FLATTEST or (maker and not maker.makes(one.diameter)):
        return one.style + UNUSUAL
    usual, deviation = (np.interp(np.log(size), np.log(RATIOS[0]), row) for row in RATIOS[1:])
    of_ratio = -0.5 * (np.log(ratio / usual) / deviation) ** 2
    return (
        one.style - 0.5 * (np.log(size / SIZES[0]) / SIZES[1]) ** 2 + max(float(of_ratio), STRANGE)
    )


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
