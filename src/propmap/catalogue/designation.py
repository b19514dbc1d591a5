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
    """What a form of designation means with one maker."""

    form: str  # pattern of what is printed, in lower case
    blades: int
    means: str
    size: tuple[float, ...] = ()  # diameter and pitch [in] that the form stands for


class Maker(NamedTuple):
    """A maker of propellers for multirotors; without rules, its designations say all they mean."""

    name: str
    words: str  # pattern of what it and its series are called, in lower case
    rules: tuple[Rule, ...] = ()


def _rule(row: dict[str, Any]) -> Rule:
    return Rule(row["form"], row["blades"], row["means"], tuple(row.get("size", ())))


_KNOWN = tomllib.loads(Path(__file__).with_name("makers.toml").read_text(encoding="utf-8"))
MAKERS = tuple(
    Maker(maker["name"], maker["words"], tuple(map(_rule, maker.get("rules", ()))))
    for maker in _KNOWN["makers"]
)  # makers with the rules that are known of them; shops' and makers' pages agree on these

_NAMES = {maker: rf"(?<![a-z])(?:{maker.words})(?![a-z])" for maker in MAKERS}


def spaced(text: str) -> str:
    """Part a maker's name from the figure behind it, as in "gf51466"; ``text`` in lower case."""
    for name in _NAMES.values():
        text = re.sub(rf"({name})(?=\d)", r"\1 ", text)
    return text


def ruled(text: str) -> tuple[str, Rule] | None:
    """Find the rule that a designation in lower case follows, and whose it is. Where no maker is
    named the rule may be anybody's, but for names that stand for a size."""
    named = [maker for maker, name in _NAMES.items() if re.search(name, text)]
    for maker in named or MAKERS:
        for rule in maker.rules:
            found = re.search(rf"(?<![\w.]){rule.form}(?!\d)", text)
            if found and (named or not rule.size):
                return maker.name, rule
    return None


# -------------------------------------------------------------------------------------------------
# Maker, size and number of blades of a designation, and what it may mean in the catalogue.

LARGEST_INCHES = 40.0  # diameter above which a bare number is taken for millimetres
LEAST_DIAMETER, LARGEST_DIAMETER = 0.02, 3.0  # [m] of any propeller that is meant to be known here
STEEPEST = 2.5  # largest ratio of pitch to diameter
MOST_BLADES = 8
SAME = 0.006  # relative difference of lengths that are the same, as makers round to 1/20 in
NO_MAKER = ("mm", "in", "inch", "uiuc")  # units, and where names in the catalogue are from

WITHOUT_BLADE: dict[str, str] = _KNOWN["without_blade"]
"""Titles of series of which loads were measured and no blade, by their codes."""

_NUMBER = r"(\d{1,3}(?:[.,]\d+)?)"
_TIMES = "[x\u00d7*]"
_SIZE = re.compile(
    rf"(?<![\d.,])(?<!{_TIMES}){_NUMBER}\s*{_TIMES}\s*{_NUMBER}(?:\s*{_TIMES}\s*(\d+))?"
    rf"(?![\d.,]|{_TIMES}\d)"
)
# Figures alone, 51466-3, with a mark before them as in T5045C.
_FIGURES = re.compile(
    rf"(?<![\w.])[tqp]?([1-9]\d)(\d\d\d?)(?:[cs](?![a-z]))?(?:\s*{_TIMES}\s*(\d+)|-(\d))?"
    rf"(?!\.?\d|\s*{_TIMES}\s*\d)"
)
# The UIUC database writes "gwsdd 5.0x4.3 - 2", APC "5x4E-3".
_BLADES = re.compile(r"(\d+)\s*-?\s*blades?\b|(?<=\s)-\s+(\d+)$|(?<=\de)-(\d)\b")
_WORD = re.compile(r"[a-z]+\d*[a-z]*")


@dataclass(frozen=True)
class Designation:
    """A propeller by maker, size and number of blades."""

    words: tuple[str, ...]  # maker and series in lower case, in the order given
    diameter: float  # [m]
    pitch: float  # [m]
    blades: int | None  # None where neither the text nor its maker's rule says
    maker: str = ""  # one of ``MAKERS``
    size: str = ""  # how diameter and pitch were read
    counted: str = ""  # how the number of blades is known

    @property
    def reading(self) -> str:
        """Say how the text was read, and what is assumed."""
        return f"read as {self.size}, {self.counted}"

    def with_blades(self, asked: int | None) -> Designation:
        """Take the number of blades that was ``asked`` for beside the text, if any."""
        if asked in (None, self.blades):
            return self
        other = f", not {self.blades}" if self.blades else ""
        return replace(self, blades=asked, counted=f"{asked} blades as asked{other}")


@lru_cache(maxsize=1024)
def designation(text: str) -> Designation | None:
    """Read a designation such as "apc 10x4.7sf", "HQ 5x4.3x3" or "T5045C"; None without a size.

    Diameter and pitch are in inches; in millimetres where the text says ``mm`` or the diameter is
    above 40. Figures alone are tenths of an inch of diameter, and tenths or hundredths of pitch:
    6040 is 6x4, 9450 is 9.4x5, 51466 is 5.1x4.66. Where no propeller of four figures is as steep,
    the diameter is in inches: 1045 is 10x4.5. What else a maker's form says is in ``MAKERS``.
    ``InputError`` for a size or a number of blades that no propeller has.
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
        remedy = f"give one above 0, up to {STEEPEST:g} diameters; {catalogue.close_names(text)}"
        raise InputError(f"{quoted(text)} has a pitch of {pitch:.3g} m", remedy)
    if count is not None and not 2 <= count <= MOST_BLADES:
        raise InputError(f"{quoted(text)} has {count} blades", f"give 2 to {MOST_BLADES} blades")
    maker = next((maker.name for maker, name in _NAMES.items() if re.search(name, rest)), "")
    counted = f"{count} blades"
    if count is None and by_rule is not None:
        whose, rule = by_rule
        count = rule.blades
        counted = f"{count} blades" + ("" if maker else f" if it is from {whose}")
        counted += f": {rule.means}"
        maker = whose
    elif count is None:
        counted = "two blades assumed (--blades 3, or x3 at the end, for three)"
    own = tuple(word for word in words if word not in NO_MAKER)
    size = f"{numbers[0]:g} x {numbers[1]:g} {name}{other}"
    return Designation(own, diameter, pitch, count, maker, size, counted)


def _from_figures(first: str, second: str) -> tuple[list[float], str]:
    """Read diameter and pitch [in] from figures alone, and say what else they may mean."""
    diameter, pitch = float(first) / 10.0, float(second) / 10.0 ** (len(second) - 1)
    if len(second) == 2 and pitch > STEEPEST * diameter:
        return [float(first), pitch], ""
    # Hardly any propeller is flatter.
    large = len(second) == 2 and pitch >= 0.2 * float(first)
    return [diameter, pitch], f" (not {first} x {pitch:g} in)" if large else ""


def candidates(wanted: Designation) -> list[catalogue.Entry]:
    """List the propellers of the catalogue that a designation may mean, one for each series: with
    as many blades if there is such a one, and measured before others. Where the words are a series'
    whole name or code, longer names are left out; blades count only where no maker is named, as one
    blade is put on many hubs."""
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
    """Split a designation's ``words`` into codes of the series that they name, and words that name
    none; the last words are given up until the others name a series, so that "gws hd" is any of
    GWS."""
    for count in range(len(words), 0, -1):
        found = _series(words[:count])
        whole = [family for family in found if _whole(words[:count], family)]
        if found:
            return whole or found, words[count:]
    return [], words


def same_size(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Whether two pairs of diameter and pitch differ by no more than makers round."""
    return all(abs(a - b) <= SAME * b for a, b in zip(one, other, strict=True))


@lru_cache(maxsize=1)
def _title_words() -> dict[str, set[tuple[str, ...]]]:
    """Collect by series what its propellers' titles call it."""
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
