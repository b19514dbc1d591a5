"""Names of propellers on the pages, and number formats."""

from __future__ import annotations

import re

from propmap import catalogue
from propmap.catalogue.identified import Identified

GOOD = "good"

_SIZE = re.compile(r"\dx\d|^mm$")


def flagged(one: Identified) -> bool:
    """Return whether the verdict reports a problem of the data or of the fit."""
    return not one.verdict.endswith(GOOD)


def page_name(one: Identified) -> str:
    """Return the file name of the card without extension: the propeller, and its number of blades
    if it differs from the catalogue."""
    if one.blades == catalogue.entry(one.propeller).blades:
        return one.propeller
    return f"{one.propeller}-{one.blades}-blades"


def title(one: Identified) -> str:
    """Return the maker's title, with the number of blades if it differs from the catalogue."""
    entry = catalogue.entry(one.propeller)
    return entry.title if one.blades == entry.blades else f"{entry.title}, {one.blades} blades"


def series_title(family: str) -> str:
    """Return the title of a series: the words that all its titles share, without sizes."""
    titles = [entry.title.split() for entry in catalogue.entries() if entry.family == family]
    shared = [word for word in titles[-1] if all(word in other for other in titles)]
    return " ".join(word for word in shared if not _SIZE.search(word))


def fixed(value: float, digits: int) -> str:
    """Return ``value`` with this number of ``digits`` after the point, or a dash for NaN."""
    if value != value:
        return "\N{EN DASH}"
    return f"{value:.{digits}f}".replace("-", "\N{MINUS SIGN}")
