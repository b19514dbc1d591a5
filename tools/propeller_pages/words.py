"""What propellers are called on the pages, and how numbers are set."""

from __future__ import annotations

import re

from propmap import catalogue
from propmap.catalogue.identified import Identified

GOOD = "good"

_SIZE = re.compile(r"\dx\d|^mm$")


def flagged(one: Identified) -> bool:
    """Whether the verdict says that something is wrong, with the data or with the fit."""
    return not one.verdict.endswith(GOOD)


def page_name(one: Identified) -> str:
    """The page's file without its ending: the propeller's name, and how many blades if others
    than the catalogue's propeller has."""
    if one.blades == catalogue.entry(one.propeller).blades:
        return one.propeller
    return f"{one.propeller}-{one.blades}-blades"


def title(one: Identified) -> str:
    """What its maker calls it, and how many blades if others than the catalogue's propeller has."""
    entry = catalogue.entry(one.propeller)
    return entry.title if one.blades == entry.blades else f"{entry.title}, {one.blades} blades"


def series_title(family: str) -> str:
    """What a maker calls a series: the words that its propellers' titles share, without sizes."""
    titles = [entry.title.split() for entry in catalogue.entries() if entry.family == family]
    shared = [word for word in titles[-1] if all(word in other for other in titles)]
    return " ".join(word for word in shared if not _SIZE.search(word))


def fixed(value: float, digits: int) -> str:
    """With so many digits after the point; a dash for what is not a number."""
    if value != value:
        return "\N{EN DASH}"
    return f"{value:.{digits}f}".replace("-", "\N{MINUS SIGN}")
