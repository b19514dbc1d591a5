"""Columns by name: one table of quantities, how people and instruments spell them, and units."""

from __future__ import annotations

import re
import tomllib
import unicodedata
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from propmap.errors import InputError, quoted
from propmap.loads import LOADS
from propmap.units import DEGREE, FOOT, GRAVITY, HORSEPOWER, INCH, KMH, KNOT, MPH, POUND, RPM

# -------------------------------------------------------------------------------------------------
# Units as they are written, in small letters and without what stands between them.


def _units(factors: Mapping[str, float]) -> dict[str, float]:
    """Give each of several spellings its factor."""
    return {spelling: factor for several, factor in factors.items() for spelling in several.split()}


SPIN = _units({"rpm 1min min1 rmin revmin upm": 1.0, "rads radsec rads1 radps": 1.0 / RPM})
SPIN |= _units({"rps hz revs 1s s1": 60.0, "krpm": 1e3})
SPEED = _units({"mps ms ms1 msec": 1.0, "cms": 0.01, "kmh kph kmph": KMH, "mph": MPH})
SPEED |= _units({"kt kts knots": KNOT, "fts fps": FOOT})
ANGLE = _units({"deg degree degrees": 1.0, "rad radian radians": 1.0 / DEGREE})
LENGTH = _units({"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in inch inches": INCH, "ft": FOOT})
FORCE = _units({"n newton newtons": 1.0, "mn": 1e-3, "kg kgf": GRAVITY, "lb lbf lbs": POUND})
FORCE |= _units({"g gf gr gram grams gramf": 1e-3 * GRAVITY, "oz ozf": POUND / 16.0})
MOMENT = _units({"nm": 1.0, "ncm": 1e-2, "nmm mnm": 1e-3, "kgm kgfm": GRAVITY})
MOMENT |= _units({"gm": 1e-3 * GRAVITY, "kgcm kgfcm": 1e-2 * GRAVITY, "gcm gfcm": 1e-5 * GRAVITY})
MOMENT |= _units({"ozin ozfin inoz inozf": POUND * INCH / 16.0, "lbin lbfin inlb": POUND * INCH})
MOMENT |= _units({"lbft lbfft ftlb ftlbf": POUND * FOOT, "inlbf": POUND * INCH})
POWER = _units({"w watt watts": 1.0, "kw": 1e3, "mw": 1e-3, "hp": HORSEPOWER})
VOLT, AMPERE = _units({"v volt volts": 1.0, "mv": 1e-3}), _units({"a amp amps": 1.0, "ma": 1e-3})
SHARE = {"": 1.0, "percent": 0.01, "%": 0.01}
OTHERS = {"%", "percent", "s", "v", "a", "us", "c", "gw"}  # units of what is none of these


class Quantity(NamedTuple):
    """What a column may hold."""

    words: str  # what it is, for messages
    names: tuple[str, ...]  # patterns of its spellings, in small letters; the better ones first
    units: Mapping[str, float]  # factors to the unit of the column that propmap writes
    bare: str = ""  # a pattern of the names that say the unit themselves


_TURNS = "(rotor|motor|prop|propeller|shaft|optical|motor optical)"
_UNITS = {"SPIN": SPIN, "SPEED": SPEED, "ANGLE": ANGLE, "LENGTH": LENGTH, "FORCE": FORCE}
_UNITS |= {"MOMENT": MOMENT, "POWER": POWER, "VOLT": VOLT, "AMPERE": AMPERE, "SHARE": SHARE}


def _quantities() -> dict[str, Quantity]:
    """Read the table of columns; loads in the disk plane go by their own names."""
    text = Path(__file__).with_name("columns.toml").read_text(encoding="utf-8")
    found = {}
    for column, row in tomllib.loads(text.replace("TURNS", _TURNS)).items():
        units = _UNITS[row["units"]]
        found[column] = Quantity(row["words"], tuple(row["names"]), units, row.get("bare", ""))
    for load in LOADS.values():
        if load.inplane:
            names = (f"{load.name}|{load.label}".replace("_", " "),)
            found[load.column] = Quantity(load.label, names, MOMENT if load.moment else FORCE)
    return found


QUANTITIES = _quantities()
"""By the column that propmap writes, whose name ends with its unit."""

NOT_TAKEN = {
    r"(electric|electrical|elec|el|input|battery|esc|motor) power|power (electrical|elec|el|in)"
    r"|pel|pin|p (el|elec|in)": "electrical, not of the shaft",
    r"e ?rpm|electrical rpm|rpm electrical": "electrical: divide it by the motor's pole pairs",
}
"""What looks like a quantity and is another, and why."""

AROUND = "([ab]|powertrain|rotor|propeller|prop|mean|average|avg|measured|filtered|raw) ?[1-9]?"


# -------------------------------------------------------------------------------------------------
# What the columns of a header are taken for.


class Taken(NamedTuple):
    """A column of a file that may be taken for one of ``QUANTITIES``."""

    rank: int  # the least first, where several may be taken
    place: int
    name: str  # as the file has it, and so is its unit
    unit: str
    factor: float  # to the unit of the quantity's column


GREEK = str.maketrans({"\u03c9": "omega", "\u03b2": "beta", "\u03b1": "alpha", "\u03b8": "theta"})
LONGEST = 80  # characters of a name that are looked at


def _words(text: str) -> str:
    text = text.translate(GREEK)
    return re.sub(r"([a-z])([1-9])\b", r"\1 \2", re.sub(r"[^a-z0-9]+", " ", text).strip())


def _parted(name: str) -> Iterator[tuple[str, str, str]]:
    """Yield the ways to part a column's name into words and a unit, also as it was written."""
    text = unicodedata.normalize("NFKC", name[:LONGEST]).strip()
    low = text.lower()
    found = re.fullmatch(r"(.*?)[\s,_]*[\[({<](.*)[\])}>]", low)
    cuts = [] if found else [m.span() for m in re.finditer(r"[\s_,/]+", low)]
    parts = [(found.end(1), *found.span(2))] if found else [(a, b, len(low)) for a, b in cuts]
    yield _words(low), "", ""
    for end, start, stop in parts:
        plain = re.sub("[^a-z0-9%]", "", low[start:stop].replace("°", "deg"))
        yield _words(low[:end]), plain, text[start:stop].strip(" -")


class Header:
    """The columns of a header by what they are taken for."""

    def __init__(
        self, names: Sequence[str], wanted: Collection[str], blank: Collection[int] = ()
    ) -> None:
        self.names, self.blank = names, blank  # places of columns without a value
        self.taken: dict[str, list[Taken]] = {}  # by column of ``QUANTITIES``, the likeliest first
        self.unclear: dict[str, str] = {}  # names without a unit that is known, by what they may be
        for place, name in enumerate(names):
            unclear: dict[str, str] = {}
            if place not in blank and not self._take(place, name, wanted, unclear):
                self.unclear = unclear | self.unclear
        for several in self.taken.values():
            several.sort()

    def _take(
        self, place: int, name: str, wanted: Collection[str], unclear: dict[str, str]
    ) -> bool:
        """Take the column called ``name`` for one of those ``wanted``, and say whether; what it
        may be but for its unit goes to ``unclear``."""
        for column in wanted:
            quantity, own = QUANTITIES[column], column.rpartition("_")[0]
            if name == column:
                self.taken.setdefault(column, []).append(Taken(-1, place, name, "", 1.0))
                return True
            for words, unit, written in _parted(name):
                for rank, names in enumerate(quantity.names):
                    core = f"({AROUND} )?(?P<core>{names})( ({AROUND}|[1-9]))?"
                    found = re.fullmatch(core, words)
                    if found is None:
                        continue
                    if (
                        unit in quantity.units
                        if unit
                        else re.fullmatch(quantity.bare, found["core"])
                    ):
                        # Names such as thrust_g are propmap's own in all but the unit.
                        place_in_order = -1 if name == f"{own}_{written}" else rank
                        factor = quantity.units.get(unit, 1.0)
                        taken = Taken(place_in_order, place, name, written, factor)
                        self.taken.setdefault(column, []).append(taken)
                        return True
                    if len(words) > 3 and unit not in OTHERS:  # T and Q may be anything
                        unclear.setdefault(column, name)
        return False

    def one_of(self, *columns: str) -> Taken | None:
        """The one column that gives a quantity, by one of these ``columns``; ``InputError`` where
        two do just as well, and where the only one is in no unit that is known."""
        found = sorted(taken for column in columns for taken in self.taken.get(column, ()))
        if len(found) > 1 and found[0].rank == found[1].rank:
            names = " and ".join(quoted(taken.name) for taken in found[:2])
            words = QUANTITIES[columns[0]].words
            raise InputError(f"{names} both give {words}", "keep one of them")
        for column in columns if not found else ():
            # A power needs no unit where there is a torque.
            if column in self.unclear and not (column == "power_W" and "torque_Nm" in self.taken):
                fault = f"column {quoted(self.unclear[column])} is in no unit that is known"
                remedy = f"name it {' or '.join(columns)}, after its unit, or leave it out"
                raise InputError(fault, remedy)
        for name in self.names if "rpm" in columns and not found else ():
            if "pole pairs" in (why := self.not_taken(name)):
                raise InputError(f"column {quoted(name)} is {why}", "and name it rpm")
        return found[0] if found else None

    @staticmethod
    def not_taken(name: str) -> str:
        """Say why a column is not taken for what it looks like; empty for any other."""
        words = [words for words, *_ in _parted(name)]
        found = (why for names, why in NOT_TAKEN.items() for w in words if re.fullmatch(names, w))
        return next(found, "")

    def remarks(self, used: Mapping[str, Taken]) -> list[str]:
        """Say in one sentence what was taken for what, and what was not; none where names are
        propmap's own."""
        parts = []
        for column, taken in used.items():
            if taken.rank >= 0:
                unit = f" in {taken.unit}" if taken.unit else ""
                parts.append(f"{quoted(taken.name)} is {QUANTITIES[column].words}{unit}")
                if re.fullmatch(
                    QUANTITIES["rpm"].names[1], _words(taken.name.lower().partition("(")[0])
                ):
                    parts[-1] += ", divided by pole pairs if the stand was told how many"
        mine = {taken.place for taken in used.values()}
        left = []
        for place, name in enumerate(self.names):
            why = "blank" if place in self.blank else self.not_taken(name)
            if place not in mine:
                left.append(f"{quoted(name)} ({why})" if why else quoted(name))
        parts += [f"not used: {', '.join(left)}"] if left else []
        return [f"columns: {'; '.join(parts)}"] if parts else []
