"""Section constants identified from published loads, and how propellers are designated."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from propmap import catalogue
from propmap.catalogue.makers import maker_of, ruled, spaced
from propmap.errors import InputError, quoted
from propmap.model.airfoil import CONSTANTS, Airfoil, SectionCovariance, SectionUncertainty
from propmap.typing import Floats
from propmap.units import INCH

# -------------------------------------------------------------------------------------------------
# Section constants identified from published loads, propeller by propeller, in one CSV file.

PARAMETERS = tuple(name for name, constant in CONSTANTS.items() if constant.population)
"""The constants that were identified."""

LIFT_LAW = "plate"
"""The lift law of all identified constants.  On blades that stall at rest it is as good as the
paper's with a larger c_l2 (``python -m tools.catalogue.past_stall``), which has twice the lift of a
plate at 45 degrees."""

MEAN_BLADES = ("family", "population")  # geometries of propellers whose own is not known

POOR = (0.0048, 0.0036)  # errors of C_T and C_P [-] that nine propellers in ten stay below

_PAIRS = [(i, j) for i in range(len(PARAMETERS)) for j in range(i, len(PARAMETERS))]
_TEXTS = ("propeller", "family", "tested", "geometry", "key", "verdict")
_COUNTS = ("blades", "rows", "static_rows")
_RANGES = ("diameter_m", "pitch_m", "rpm_low", "rpm_high", "advance_high")
_ERRORS = ("thrust_rms", "power_rms", "static_thrust_rms", "static_power_rms")


@dataclass(frozen=True, eq=False)
class Identified:
    """Constants of one propeller from its loads in axial flow, and how far they can be trusted."""

    propeller: str  # name of its blade in the catalogue, or one made up in that form
    blades: int
    family: str  # code of its series
    tested: str  # what the source calls it
    geometry: str  # "measured", of its "maker", or the mean of its "family" or "population"
    diameter_m: float  # as labelled, as the pitch
    pitch_m: float
    airfoil: Airfoil  # with how well they are known
    covariance: Floats  # (P, P) of ``PARAMETERS``
    thrust_rms: float  # errors of C_T and C_P over all rows, and at rest; NaN without such
    power_rms: float
    static_thrust_rms: float
    static_power_rms: float
    rows: int  # operating points in all
    static_rows: int
    rpm_low: float  # range of the data, with J = V/(n D) up to ``advance_high``
    rpm_high: float
    advance_high: float
    verdict: str  # "good", or what is wrong with the data or the fit
    key: str  # identifies the data and the settings of the fit

    @property
    def section_covariance(self) -> SectionCovariance:
        """The covariance with its names, as tables take it."""
        return SectionCovariance(PARAMETERS, self.covariance)

    @property
    def size(self) -> tuple[float, float]:
        """Labelled diameter and pitch [m]."""
        return self.diameter_m, self.pitch_m

    @property
    def discrepancy(self) -> tuple[float, float]:
        """Standard deviations of C_T and C_P [-] that these constants leave, beside their own."""
        return self.thrust_rms, self.power_rms

    @property
    def summary(self) -> str:
        """Say in one line whose constants these are, what they rest on, and how well they fit."""
        size = "and at rest " if self.static_rows else ""
        return (
            f"constants identified from {self.rows} loads of {self.tested!r} in axial flow {size}"
            f"(UIUC), {self.rpm_low:.0f} to {self.rpm_high:.0f} rpm, J up to "
            f"{self.advance_high:.2f}: rms error of C_T {self.thrust_rms:.4f}, of C_P "
            f"{self.power_rms:.4f}; {self.verdict}"
        )

    @property
    def constants(self) -> Floats:
        """Values of ``PARAMETERS``, (P,)."""
        return np.array([getattr(self.airfoil, name) for name in PARAMETERS])


def identified(propeller: str, blades: int) -> Identified | None:
    """Find the bundled constants of a blade of the catalogue on a rotor with so many ``blades``."""
    key = propeller.strip().lower(), blades
    return _bundled(key) if key in _rows() else None


def all_identified(family: str | None = None) -> list[Identified]:
    """List the bundled constants of blades that were measured, in the order of the file, and of
    makers' blades where none was; those of one ``family``, or all."""
    rows = [item for item in _rows().items() if family in (None, item[1]["family"])]
    measured = {row["tested"] for _, row in rows if row["geometry"] == "measured"}
    return [
        _bundled(key)
        for key, row in rows
        if row["geometry"] == "measured"
        or (row["geometry"] == "maker" and row["tested"] not in measured)
    ]


def identified_without_blade() -> list[Identified]:
    """List all bundled constants of propellers whose blades are not known."""
    return [_bundled(key) for key, row in _rows().items() if row["geometry"] in MEAN_BLADES]


def named_without_blade(name: str) -> Identified | None:
    """Find the one of ``identified_without_blade`` with this ``name``, in lower case."""
    found = [
        key for key, row in _rows().items() if key[0] == name and row["geometry"] in MEAN_BLADES
    ]
    return _bundled(found[0]) if found else None


def one_of_each(entries: Sequence[Identified]) -> list[Identified]:
    """Keep, of ``entries`` for several blades of one tested propeller, a measured one, and of these
    the one that fits best."""
    best: dict[str, Identified] = {}
    for one in sorted(entries, key=lambda one: (one.geometry != "measured", badness(one))):
        best.setdefault(one.tested, one)
    return [one for one in entries if best[one.tested] is one]


def badness(one: Identified) -> float:
    """Take the larger of the errors of C_T and C_P, each over ``POOR``."""
    return max(one.thrust_rms / POOR[0], one.power_rms / POOR[1])


def as_csv(entries: Sequence[Identified]) -> str:
    """Write the text of a file that ``parse_identified`` reads."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_header())
    for one in entries:
        numbers = [
            *(getattr(one, name) for name in _RANGES),
            *one.constants,
            *(one.covariance[pair] for pair in _PAIRS),
        ]
        plain = [getattr(one, name) for name in (*_TEXTS, *_COUNTS)]
        errors = [f"{getattr(one, name):.5f}" for name in _ERRORS]
        writer.writerow([*plain, *(f"{value:.8g}" for value in numbers), *errors])
    return text.getvalue()


def parse_identified(text: str, where: str) -> list[Identified]:
    """Read the entries of a file's ``text``; ``InputError`` for what ``as_csv`` has not written."""
    reader = csv.DictReader(io.StringIO(text))
    if reader.fieldnames != _header():
        found = "the columns are not those of identified constants"
        raise InputError(found, "write the file anew with `python -m tools.catalogue`", where)
    entries = []
    for line, row in enumerate(reader, start=2):
        try:
            entries.append(_entry(row))
        except (TypeError, ValueError) as error:
            raise InputError(f"line {line}: {error}", "correct the row", where) from None
    return entries


def _entry(row: dict[str, str]) -> Identified:
    covariance = np.zeros((len(PARAMETERS), len(PARAMETERS)))
    for i, j in _PAIRS:
        covariance[i, j] = covariance[j, i] = float(row[_pair(i, j)])
    values: Any = {name: float(row[name]) for name in PARAMETERS}
    texts: Any = {name: row[name] for name in _TEXTS}
    counts: Any = {name: int(row[name]) for name in _COUNTS}
    numbers: Any = {name: float(row[name]) for name in (*_RANGES, *_ERRORS)}
    source = f"identified by propmap from the UIUC Propeller Database, {row['tested']}"
    known = SectionUncertainty(
        SectionCovariance(PARAMETERS, covariance), numbers["thrust_rms"], numbers["power_rms"]
    )
    name = f"{row['propeller']} identified"
    airfoil = Airfoil(**values, lift_law=LIFT_LAW, name=name, source=source, uncertainty=known)
    return Identified(airfoil=airfoil, covariance=covariance, **texts, **counts, **numbers)


def _header() -> list[str]:
    pairs = [_pair(i, j) for i, j in _PAIRS]
    return [*_TEXTS, *_COUNTS, *_RANGES, *PARAMETERS, *pairs, *_ERRORS]


def _pair(i: int, j: int) -> str:
    return f"cov_{PARAMETERS[i]}_{PARAMETERS[j]}"


@cache
def _rows() -> dict[tuple[str, int], dict[str, str]]:
    """Read the bundled file's rows, by propeller and number of blades."""
    with (Path(__file__).parent / "identified" / "uiuc.csv").open(encoding="utf-8") as file:
        return {(row["propeller"], int(row["blades"])): row for row in csv.DictReader(file)}


@cache
def _bundled(key: tuple[str, int]) -> Identified:
    # Made when it is asked for: a process wants one of them, and all take longer than a rotor.
    return _entry(_rows()[key])


# -------------------------------------------------------------------------------------------------
# Designations of propellers, as they are printed on the blade: 8x6E, 5x4.3x3, 1045, 130x70 mm.

LARGEST_INCHES = 40.0  # diameter above which a bare number is taken for millimetres
LEAST_DIAMETER, LARGEST_DIAMETER = 0.02, 3.0  # [m] of any propeller that is meant to be known here
STEEPEST = 2.5  # largest ratio of pitch to diameter
MOST_BLADES = 8
SAME = 0.006
"""Relative difference up to which two lengths are the same: makers round to a twentieth of an
inch."""

NO_MAKER = ("mm", "in", "inch", "uiuc")  # units, and where names in the catalogue are from

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
    maker: str = ""  # one of ``makers.MAKERS``
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
    the diameter is in inches: 1045 is 10x4.5. What else a maker's form says, ``makers`` knows.
    ``InputError`` for a size or a number of blades that no propeller has.
    """
    lower = spaced(text.strip().lower())
    blades = _BLADES.search(lower)
    rest = lower[: blades.start()] + " " + lower[blades.end() :] if blades else lower
    found = _SIZE.search(rest) or _FIGURES.search(rest)
    by_rule = ruled(rest)
    said: str | None
    if found is None:
        if by_rule is None or by_rule[1].size is None:
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
    maker, counted = maker_of(rest), f"{count} blades"
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
    """List the propellers of the catalogue that a designation may mean, one for each series.

    Of several blades of one series and size one with as many blades is given, and of these the
    first that was measured. Where the words are the whole name of a series or its code, others
    whose names go on are left out. The number of blades counts only where no maker is named: makers
    put one blade on hubs for two and more.
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
    """Split a designation's ``words`` into codes of the series that they name, and words that name
    none.

    Words are given up from the last on until the others name a series: "gws hd" stands for all
    series of GWS. The list is empty where the first word is unknown, or there is none.
    """
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
