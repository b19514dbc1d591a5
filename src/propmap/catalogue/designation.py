"""Designations of propellers, as printed on the blade: 8x6E, 5x4.3x3, T5045C, 36190."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from propmap import catalogue
from propmap.errors import InputError, quoted
from propmap.io.geometry import COUNTED, COUNTS
from propmap.units import INCH


class Maker(NamedTuple):
    """A manufacturer of propellers whose designations contain sizes in inches."""

    name: str
    words: str  # pattern of the names of manufacturer and series, in lower case
    sizes: Sequence[float]  # smallest and largest diameter [in]
    rules: Sequence[dict[str, Any]] = ()  # interpretation of special designations, see makers.toml
    racing: bool = False  # whether most propellers of about five inches have three blades
    carbon: bool = False  # whether large propellers are of carbon fiber
    multirotor: bool = True  # whether most propellers are for multirotors

    def makes(self, diameter: float) -> bool:
        """Return whether the range of sizes, widened by 2 %, contains this ``diameter`` [m]."""
        return 0.98 * self.sizes[0] <= diameter / INCH <= 1.02 * self.sizes[1]


_KNOWN = tomllib.loads(Path(__file__).with_name("makers.toml").read_text(encoding="utf-8"))
MAKERS = tuple(Maker(**row) for row in _KNOWN["makers"])
"""Manufacturers and their designation rules, on which shops and manufacturers agree."""

ANY_MAKER = Maker("", "", (1.0, 80.0), multirotor=False)
_NAMES = [rf"(?<![a-z])(?:{maker.words})(?![a-z])" for maker in MAKERS]
_NAME_AND_NUMBER = re.compile(rf"({'|'.join(_NAMES)})(?=\d)")  # as in gf51466


# -------------------------------------------------------------------------------------------------
# Manufacturer, size and number of blades of a designation, and matching catalogue propellers.

LEAST_DIAMETER, LARGEST_DIAMETER = 0.02, 3.0  # limits of supported propellers [m]
STEEPEST = 2.5  # largest ratio of pitch to diameter
MOST_BLADES = 8

# Range of diameters [m] and probabilities of a wrong number of blades; makers.toml explains them.
RACING = _KNOWN["racing"]["from"] * INCH, _KNOWN["racing"]["to"] * INCH
FIVE_INCH_DOUBT, OTHER_DOUBT = _KNOWN["racing"]["doubt"], _KNOWN["racing"]["other_doubt"]

SAME = 0.006  # smaller relative differences of lengths are roundings to 1/20 in
NO_MAKER = ("mm", "cm", "in", "uiuc")  # words that name neither a manufacturer nor a series

WITHOUT_BLADE: dict[str, str] = _KNOWN["without_blade"]
"""Titles of series with measured loads but without a measured blade, by code of the series."""

_UNIT = r"(?:\s*(mm|cm|m|in)(?![a-wyz]))?"
# A diameter of four digits requires a pitch of three digits, because 5040x3 means three blades.
_SIZE = re.compile(
    rf"(?<![\d.x])(\d{{1,3}}(?:\.\d+)?|\d{{4}}(?=[ mx]+\d{{3}})){_UNIT}\s*x\s*"
    rf"(\d{{1,4}}(?:\.\d+)?){_UNIT}(?:\s*x\s*(\d+){_UNIT})?(?![\d.]|x\d)"
)
# Four or five digits without an x, as in 51466-3.  A letter may precede the digits, as in T5045C.
_FIGURES = re.compile(
    r"(?<![\w.])[tqprf]?([1-9]\d)(\d\d\d?)(?:[cs](?![a-z]))?(?:\s*x\s*(\d+)|-(\d))?"
    r"(?!\.?\d|\s*x\s*\d)"
)
# Examples: "gwsdd 5.0x4.3 - 2" in the UIUC database, "5x4E-3" and "10x7-3" at APC.
_BLADES = re.compile(
    r"(\d+)\s*-?\s*(?:blade[ds]?|blatt)\b|(?<=\s)-\s+(\d+)$|(?<=[\de])-(\d)(?![\w.])"
)
_PACK = re.compile(r"(?<![\d.x])(\d)\s*x\s+(?=(\d{4}|\d+(?=[\d.]*x\d)))")  # in 4x 5x4.3x3
_MOTOR = re.compile(r"(?<![\w.])(?:\d{4}[\d.]*[\s-]+)?(?:\d+\s*kv|kv\s*\d+)\b")  # 2212 920kv
_WORD = re.compile(r"[a-z]+\d*[a-z]*")
_LENGTH = re.compile(r"\d\s*(?:(?:mm|cm|m|in|inch)(?![a-wyz])|''|[\"\u2033\u201d])")


@dataclass(frozen=True)
class Designation:
    """A propeller by manufacturer, size and number of blades."""

    words: tuple[str, ...]  # manufacturer and series in lower case, in the order of the text
    diameter: float  # [m]
    pitch: float  # [m]
    blades: int | None  # None if neither the text nor a rule states the number
    maker: str = ""  # name of one of ``MAKERS``; empty for a maker without multirotor propellers
    size: str = ""  # diameter and pitch, and other probable sizes, for messages
    counted: str = ""  # number of blades and its origin, for messages
    doubt: float = 0.0  # probability that the number is wrong: three instead of two, or vice versa

    @property
    def reading(self) -> str:
        """Interpretation of the text, with assumptions, for messages."""
        return f"read as {self.size}, {self.counted}"

    def with_blades(self, asked: int | None) -> Designation:
        """Return the designation with ``asked`` blades; unchanged if ``asked`` is None."""
        if asked is None or (asked == self.blades and not self.doubt):
            return self
        other = f", not {self.blades}" if self.blades not in (None, asked) else ""
        return replace(self, blades=asked, counted=f"{asked} blades as requested{other}", doubt=0.0)


@lru_cache(maxsize=1024)
def designation(text: str) -> Designation | None:
    """Return the designation in a text such as "apc 10x4.7sf" or "T5045C"; None without a size.

    A written unit determines the size.  Numbers without a unit have the most probable meaning
    within the manufacturer's range of sizes; ``reading`` lists other probable meanings.  ``MAKERS``
    contains further rules.  Raises ``InputError`` for an impossible size or number of blades.
    """
    lower = re.sub("[\u00d7*]", "x", text.strip().lower().replace(",", "."))
    lower = re.sub(r"(?<![a-z])inch(?:es)?|''|[\"\u2033\u201d]", " in ", lower)
    lower = re.sub(COUNTED, lambda word: str(COUNTS[word[1]]), _MOTOR.sub(" ", lower))
    lower = _PACK.sub(lambda one: one[0] if int(one[1]) >= int(one[2]) else "", lower)
    lower = _NAME_AND_NUMBER.sub(r"\1 ", lower)
    blades = _BLADES.search(lower)
    rest = lower[: blades.start()] + " " + lower[blades.end() :] if blades else lower
    named = zip(MAKERS, _NAMES, strict=True)
    own = next((maker for maker, name in named if re.search(name, rest)), ANY_MAKER)
    # Without a manufacturer, all rules apply, except rules that supply the size of a name.
    rules = ((maker, rule) for maker in ([own] if own.name else MAKERS) for rule in maker.rules)
    valid = (pair for pair in rules if own.name or "size" not in pair[1])
    by_rule = next(
        (it for it in valid if re.search(rf"(?<![\w.]){it[1]['form']}(?!\d)", rest)), None
    )
    found = _SIZE.search(rest) or _FIGURES.search(rest)
    readings, said = _readings(own, found) if found else ([], None)
    if found is None and by_rule is not None and "size" in by_rule[1]:
        readings = [Reading(*by_rule[1]["size"])]
    if not readings:
        return None
    size, score, meaning = _likeliest(readings, own)
    diameter, pitch = size.lengths
    units = " ".join(part for part in found.groups() if part and part.isalpha()) if found else ""
    around = f"{rest[: found.start()]} {units} {rest[found.end() :]}" if found else rest
    if blades:
        said = next(filter(None, blades.groups()))
    count = int(said) if said else None
    if score == -np.inf:
        remedy = f"give {LEAST_DIAMETER:g} to {LARGEST_DIAMETER:g} m, a pitch up to {STEEPEST:g} "
        remedy += f"diameters, and a unit if not inches; {catalogue.close_names(text)}"
        wrong = f"a diameter of {diameter:.3g} m and a pitch of {pitch:.3g} m"
        raise InputError(f"{quoted(text)} has {wrong}", remedy)
    if count is not None and not 2 <= count <= MOST_BLADES:
        raise InputError(f"{quoted(text)} has {count} blades", f"give 2 to {MOST_BLADES} blades")
    maker, doubt = own.name if own.multirotor else "", 0.0
    counted = f"{count} blades"
    if count is None and by_rule is not None and by_rule[0].makes(diameter):
        whose, rule = by_rule
        count, origin = rule["blades"], "" if maker else f" if it is from {whose.name}"
        counted, maker = f"{count} blades{origin}: {rule['means']}", whose.name
    elif count is None and own.racing and RACING[0] < diameter < RACING[1]:
        count, doubt = 3, FIVE_INCH_DOUBT
        counted = f"three blades assumed, as for most {maker} propellers of this size "
        counted += "(for two, add --blades 2)"
    elif count is None:
        if own.racing and diameter < 11.5 * INCH:
            doubt = OTHER_DOUBT
        counted = "two blades assumed (for three, add --blades 3 or end the name with x3)"
    own_words = tuple(word for word in _WORD.findall(around) if word not in (*NO_MAKER, size.unit))
    return Designation(own_words, diameter, pitch, count, maker, meaning, counted, doubt)


def without_size(text: str) -> InputError:
    """Return the error for a ``text`` without a known name and without a complete size."""
    lower = text.lower()
    if re.search(r"\bedf\b|duct", lower):
        remedy = "propmap models propellers without a duct; give an open propeller"
        return InputError(f"{quoted(text)} is a ducted fan", remedy)
    if _MOTOR.search(lower):
        return InputError(f"{quoted(text)} is a motor", "give the propeller, as in 10x4.5")
    if not _LENGTH.search(lower):
        return catalogue.unknown_name(text)
    found = f"{quoted(text)} is neither a propeller of the catalogue nor a file nor a complete "
    found += "size: the pitch, or the unit after the pitch, is missing"
    return InputError(found, "give diameter x pitch and the unit, as in 31x20mm 4-blade or 12x6in")


# --- Readings of a size.  The table ``[prior]`` of makers.toml contains their probabilities ------

UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": INCH}  # [m]
PRIOR: dict[str, Any] = _KNOWN["prior"]


class Reading(NamedTuple):
    """A possible size, and the probability of the style in which the text writes this size."""

    diameter: float  # in ``unit``
    pitch: float  # in ``unit``
    unit: str = "in"  # one of ``UNITS``
    style: float = 0.0  # logarithm of the probability

    def __str__(self) -> str:
        return f"{self.diameter:g} x {self.pitch:.4g} {self.unit}"

    @property
    def lengths(self) -> tuple[float, float]:
        """Diameter and pitch [m]."""
        return self.diameter * UNITS[self.unit], self.pitch * UNITS[self.unit]

    def score(self, maker: Maker) -> float:
        """Return the logarithm of the probability density, up to an additive constant."""
        diameter, pitch = self.lengths
        if (
            not LEAST_DIAMETER <= diameter <= LARGEST_DIAMETER
            or not 0.0 < pitch <= STEEPEST * diameter
        ):
            return -np.inf
        if pitch < PRIOR["flattest"] * diameter or not maker.makes(diameter):
            return self.style + PRIOR["unusual"]
        at, known = np.log(diameter / INCH), np.log(PRIOR["diameters"])
        usual, spread = (np.interp(at, known, PRIOR[row]) for row in ("ratios", "spread"))
        of_ratio = (np.log(pitch / diameter / usual) / spread) ** 2
        of_size = ((at - known[3]) / PRIOR["size_spread"]) ** 2
        return self.style - 0.5 * float(of_size + min(of_ratio, PRIOR["largest"]))


def _readings(maker: Maker, found: re.Match[str]) -> tuple[list[Reading], str | None]:
    """Return the readings of a size, the usual reading first, and the number of blades.

    The list is empty for a text such as "31mm x 4", because the 4 may be a number of blades.
    """
    if found.re is _FIGURES:
        diameter, pitch, rows = float(found[1]), float(found[2]), PRIOR["digits"][len(found[2]) - 2]
        sizes = [Reading(diameter / k, pitch / j, "in", style) for k, j, style in rows]
        return sizes, found[3] or found[4]
    first, unit, second, after, blades, last = found.groups()
    diameter, pitch, after = float(first), float(second), after or last
    if unit and not after and not blades and pitch <= MOST_BLADES and second.isdigit():
        return [], None
    # The M of 10x10M denotes a series, not meters.
    if (unit or after) and (after != "m" or diameter <= LARGEST_DIAMETER):
        one, other = unit or after, after or unit
        return [Reading(diameter, pitch * UNITS[other] / UNITS[one], one)], blades
    usual = diameter <= PRIOR["inches"] and pitch <= STEEPEST * diameter
    # No manufacturer abbreviates 13.0 as 130, but 51x50 may denote 5.1x5.0.
    sizes = [
        Reading(diameter / k, pitch / j, "in", style)
        for k, j, style in PRIOR["numbers"][: 1 if usual else None]
        if (k == 1.0 or diameter % 10.0)
        and (j == 1.0 or pitch % 10.0 or (k > 1.0 and pitch < 100.0))
    ]
    metric = PRIOR["no_unit"]
    if maker.name:
        metric += PRIOR["unusual"]
    return [*sizes, Reading(diameter, pitch, "mm", metric)], blades


def _likeliest(readings: list[Reading], maker: Maker) -> tuple[Reading, float, str]:
    """Return the most probable reading, its score, and a text that lists other probable sizes."""
    scores = {one: one.score(maker) for one in readings}
    best, highest = max(scores.items(), key=lambda pair: pair[1])
    close = highest - PRIOR["close"]
    others = [str(one) for one, score in scores.items() if one != best and score > close]
    text = f"{best} (not {' or '.join(others)})" if others else str(best)
    if highest <= PRIOR["unusual"]:
        text += f", an unusual size{f' for {maker.name}' if maker.name else ''}"
    return best, highest, text


def candidates(wanted: Designation) -> list[catalogue.Entry]:
    """Return the propellers of the catalogue that a designation may mean, one for each series.

    Within a series, propellers with the wanted number of blades come first, then measured blades.
    If the words are the whole name or code of a series, series with longer names are excluded.
    With a manufacturer, the number of blades need not agree, because a blade may fit several hubs.
    """
    found: dict[str, catalogue.Entry] = {}
    named, whole = _series(wanted.words), set()

    def place(entry: catalogue.Entry) -> tuple[bool, bool]:
        return entry.blades == (wanted.blades or 2), entry.geometry == "measured"

    for entry in catalogue.entries():
        own = designation(entry.title)
        fits = entry.family in named if wanted.words else wanted.blades in (None, entry.blades)
        size = wanted.diameter, wanted.pitch
        if own is None or not fits or not same_size(size, (own.diameter, own.pitch)):
            continue
        family = entry.family
        if family not in found or place(entry) > place(found[family]):
            found[family] = entry
        if _whole(wanted.words, family):
            whole.add(family)
    return [entry for family, entry in found.items() if family in whole or not whole]


def series_named(words: tuple[str, ...]) -> tuple[list[str], tuple[str, ...]]:
    """Return the codes of the series that the ``words`` of a designation name, and unknown words.

    The function drops words at the end until the other words name a series.  Therefore "gws hd"
    means all series of GWS.
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
    """Return whether ``words`` are a whole title of the series, or the code of the series."""
    return words in _title_words()[family] or "".join(words) == family


def _names_series(words: tuple[str, ...], family: str, title: tuple[str, ...]) -> bool:
    """Return whether the title contains all ``words``, or the words form the code of the series."""
    first, *rest = words
    if not rest and len(first) == 1:
        # A single letter, as in 12x6E, denotes a series, not a manufacturer.
        return first in title[1:]
    if all(word in title or word == family for word in words):
        return True
    # "apc" and "sf" form the code apcsf.  A manufacturer without a series means all its series.
    return family == "".join(words) or (not rest and family.startswith(first))
