"""Recognition of columns by name: quantities, their spellings and their units."""

from __future__ import annotations

import difflib
import re
import tomllib
import unicodedata
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from propmap.errors import InputError, quoted
from propmap.loads import LOADS
from propmap.units import DEGREE, FOOT, GRAVITY, HORSEPOWER, INCH, KMH, KNOT, MPH, POUND, RPM

# --- Spellings of units, in lower case and without separators ------------------------------------


def _units(factors: Mapping[str, float]) -> dict[str, float]:
    """Return a factor for each spelling; keys contain several spellings."""
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
REYNOLDS = {"": 1.0} | _units({"k 1000 x1000 1e3 x1e3 103 x103": 1e3, "1e6 x1e6 106 x106": 1e6})
OTHERS = {"%", "percent", "s", "v", "a", "us", "c", "gw"}  # units of other quantities


class Quantity(NamedTuple):
    """A quantity that a column may contain."""

    words: str  # name in messages
    names: tuple[str, ...]  # patterns of its spellings, in lower case; better matches first
    units: Mapping[str, float]  # factors to the unit of the column that propmap writes
    bare: str = ""  # pattern of names that need no unit


_TURNS = "(rotor|motor|prop|propeller|shaft|optical|motor optical)"
_UNITS = {"SPIN": SPIN, "SPEED": SPEED, "ANGLE": ANGLE, "LENGTH": LENGTH, "FORCE": FORCE}
_UNITS |= {"MOMENT": MOMENT, "POWER": POWER, "VOLT": VOLT, "AMPERE": AMPERE, "SHARE": SHARE}
_UNITS |= {"REYNOLDS": REYNOLDS}


def _quantities() -> dict[str, Quantity]:
    """Return the quantities by column: those of ``columns.toml``, and the in-plane loads."""
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
"""Quantities by the name of the column that propmap writes, which ends with the unit."""

NOT_TAKEN = {
    r"(electric|electrical|elec|el|input|battery|esc|motor) power|power (electrical|elec|el|in)"
    r"|pel|pin|p (el|elec|in)|electrical": "electrical, not of the shaft",
    r"e ?rpm|electrical rpm|rpm electrical": "electrical: divide it by the motor's pole pairs",
}
"""Patterns of columns that resemble a known quantity but are another one, and the reason."""

SIDE = re.compile(  # qualifiers of other quantities, as in "Speed (level) (km/h)"
    r"\b(el|elec|electric|electrical|input|battery|esc|level|vertical|pitch"
    r"|min|max|std|sd|error|uncertainty|target|setpoint|command)\b"
)

OTHER_SPEED = re.compile(rf"{SIDE.pattern}|tip|sound|exit|jet|wake|gust|climb|inflow|induced")
NO_SPEED = {"ms", "fps"}  # milliseconds and frames per second

AROUND = "([ab]|powertrain|rotor|propeller|prop|mean|average|avg|measured|filtered|raw) ?[1-9]?"


# --- Assignment of the columns of a header to quantities -----------------------------------------


class Taken(NamedTuple):
    """A column of a file that matches one of ``QUANTITIES``."""

    rank: int  # quality of the match; the smallest is used
    place: int
    name: str  # name and unit as spelled in the file
    unit: str
    factor: float  # to the unit of the column in ``QUANTITIES``


GREEK = str.maketrans({"\u03c9": "omega", "\u03b2": "beta", "\u03b1": "alpha", "\u03b8": "theta"})
LONGEST = 80  # number of characters of a name that are compared
MOST = 40  # largest number of names in a message


def _words(text: str) -> str:
    text = text.translate(GREEK)
    return re.sub(r"([a-z])([1-9])\b", r"\1 \2", re.sub(r"[^a-z0-9]+", " ", text).strip())


def _parted(name: str) -> Iterator[tuple[str, str, str, int]]:
    """Yield all splits of a column name: words, unit, unit as spelled in the file, and number of
    omitted qualifiers.  If "Motor 1" is omitted from "Thrust - Motor 1 (N)", this number is 1."""
    text = unicodedata.normalize("NFKC", name[:LONGEST]).strip()
    low = text.lower()
    found = re.fullmatch(r"(.*[\])}>]|.*?)[\s,_]*[\[({<](.*)[\])}>]", low)
    cuts = [] if found else [m.span() for m in re.finditer(r"[\s_,/]+", low)]
    parts = [(found.end(1), *found.span(2))] if found else [(a, b, len(low)) for a, b in cuts]
    yield _words(low), "", "", 0
    for qualified in (0, 1):
        for end, start, stop in [*parts, *[(len(low), 0, 0)] * (qualified and not found)]:
            words = re.split(r"\s-\s|[\[({<:]", low[:end])[0] if qualified else low[:end]
            if not qualified or not SIDE.search(low, len(words), end):
                plain = re.sub("[^a-z0-9%]", "", low[start:stop].replace("°", "deg"))
                yield _words(words), plain, text[start:stop].strip(" -"), qualified


def _shortened(texts: Sequence[str]) -> str:
    """Return a comma-separated list of at most ``MOST`` of the ``texts``, for a message."""
    more = len(texts) - MOST
    return ", ".join(texts[:MOST]) + (f" and {more} more" if more > 0 else "")


class Header:
    """The columns of a header, by the quantity that they match."""

    def __init__(
        self, names: Sequence[str], wanted: Collection[str], blank: Collection[int] = ()
    ) -> None:
        self.names, self.blank = names, blank  # ``blank``: indices of columns without a value
        self.taken: dict[str, list[Taken]] = {}  # by column of ``QUANTITIES``, best match first
        self.unclear: dict[str, str] = {}  # names with an unknown unit, by the likely quantity
        for place, name in enumerate(names):
            unclear: dict[str, str] = {}
            if place not in blank and not self._take(place, name, wanted, unclear):
                self.unclear = unclear | self.unclear
        for several in self.taken.values():
            several.sort()

    def _take(
        self, place: int, name: str, wanted: Collection[str], unclear: dict[str, str]
    ) -> bool:
        """Match the column ``name`` with one of the ``wanted`` columns; return whether it matches.

        A match except for the unit is added to ``unclear``.
        """
        if name in wanted:
            self.taken.setdefault(name, []).append(Taken(-1, place, name, "", 1.0))
            return True
        parts = list(_parted(name))
        for column in wanted:
            quantity, own = QUANTITIES[column], column.rpartition("_")[0]
            for words, unit, written, qualified in parts:
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
                        # Names such as thrust_g follow propmap's convention, with another unit.
                        order = -1 if name == f"{own}_{written}" else rank + 10 * qualified
                        factor = quantity.units.get(unit, 1.0)
                        taken = Taken(order, place, name, written, factor)
                        self.taken.setdefault(column, []).append(taken)
                        return True
                    if len(words) > 1 and unit not in OTHERS and not self._why_not(place):
                        unclear.setdefault(column, name)
        return False

    def one_of(self, *columns: str) -> Taken | None:
        """Return the column of a quantity that is called one of ``columns``, or None.

        Raise ``InputError`` for two equal matches, and for a single match with an unknown unit.
        """
        found = sorted(taken for column in columns for taken in self.taken.get(column, ()))
        if len(found) > 1 and found[0].rank == found[1].rank:
            names = " and ".join(quoted(taken.name) for taken in found[:2])
            words = QUANTITIES[columns[0]].words
            raise InputError(f"{names} both contain {words}", "keep one of them")
        for column in columns if not found else ():
            # With a torque column the power is not used, so its unit does not matter.
            if column in self.unclear and not (column == "power_W" and "torque_Nm" in self.taken):
                fault = f"column {quoted(self.unclear[column])} has no known unit"
                remedy = f"name it {' or '.join(columns)}, with its unit, or remove it"
                raise InputError(fault, remedy)
        return found[0] if found else None

    def speed_with_another_name(self) -> int | None:
        """Return the index of the first unrecognized column that has a unit of speed or contains
        the advance ratio, or None.  Other speeds, such as "Tip speed (m/s)", do not count."""
        mine = {one.place for several in self.taken.values() for one in several}
        for place, name in enumerate(self.names):
            if place in mine or place in self.blank or OTHER_SPEED.search(name.lower()):
                continue
            words, *split = _parted(name)
            if words[0] in ("j", "advance ratio"):
                return place
            if any(
                unit in SPEED and written.lower() not in NO_SPEED for _, unit, written, _ in split
            ):
                return place
        return None

    def listed(self) -> str:
        """Return the names of the columns, each with the nearest known quantity, for messages."""
        every = Header(self.names, QUANTITIES)
        means = {name: f"{QUANTITIES[c].words} without unit" for c, name in every.unclear.items()}
        means |= {one.name: QUANTITIES[c].words for c, ones in every.taken.items() for one in ones}
        shown = []
        for place, name in enumerate(self.names):
            near = "".join(f"like {c}" for c in difflib.get_close_matches(name, QUANTITIES, n=1))
            mean = self._why_not(place) or means.get(name) or near
            shown.append(f"{quoted(name)} ({mean})" if mean else quoted(name))
        return f"the columns are {_shortened(shown) or 'not named'}"

    def _why_not(self, place: int) -> str:
        """Return why a column is not the quantity that it resembles; empty for all other names."""
        if place in self.blank:
            return "blank"
        words = [words for words, *_ in _parted(self.names[place])]
        found = (why for names, why in NOT_TAKEN.items() for w in words if re.fullmatch(names, w))
        return next(found, "")

    def remarks(self, used: Mapping[str, Taken]) -> list[str]:
        """Return a sentence on recognized and unused columns; empty for propmap's column names."""
        parts = []
        for column, taken in used.items():
            if taken.rank >= 0:
                unit = f" in {taken.unit}" if taken.unit else ""
                parts.append(f"{quoted(taken.name)} is {QUANTITIES[column].words}{unit}")
                if column == "rpm" and "electrical" in taken.name.lower():
                    parts[-1] += ", divided by pole pairs if their number was set in the stand"
        mine = {taken.place for taken in used.values()}
        left = []
        for place, name in enumerate(self.names):
            if place not in mine:
                why = self._why_not(place)
                left.append(f"{quoted(name)} ({why})" if why else quoted(name))
        parts += [f"not used: {_shortened(left)}"] if left else []
        return [f"columns: {'; '.join(parts)}"] if parts else []
