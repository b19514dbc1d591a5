"""A report as one HTML file: text, tables with units, figures; nothing is fetched for it."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from propmap.errors import InputError

MINUS, MISSING = "\N{MINUS SIGN}", "\N{EN DASH}"
"""In front of a negative number, and where there is none."""

LEVELS = ("good", "caution", "bad", "plain")
"""How a ``Verdict`` is marked: by a word and a border, never by colour alone."""


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    kind: ClassVar[str] = "text"
    text: str


@dataclass(frozen=True)
class Points:
    """A list of sentences."""

    kind: ClassVar[str] = "points"
    items: tuple[str, ...]


@dataclass(frozen=True)
class Verdict:
    """What a section comes to, in one or two plain sentences.

    level : one of ``LEVELS``.  word : printed in front, such as "Yes" or "With care".
    """

    kind: ClassVar[str] = "verdict"
    level: str
    word: str
    text: str

    def __post_init__(self) -> None:
        if self.level not in LEVELS:
            raise InputError(f"{self.level!r} is not a level", f"choose from {', '.join(LEVELS)}")


@dataclass(frozen=True)
class Table:
    """Rows under headings; a column is a heading and its unit, "" for text.

    caption : what is shown, and of what data.  rows : cells as text, one per column; an entry
    that looks like a number is set right-aligned.  note : below the table.
    """

    kind: ClassVar[str] = "table"
    caption: str
    columns: tuple[tuple[str, str], ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise InputError(
                    f"a row of {self.caption!r} has {len(row)} cells", f"give {len(self.columns)}"
                )

    @property
    def numeric(self) -> list[bool]:
        """Which columns hold numbers: all that have a unit or no words in them."""
        return [
            bool(unit) or all(_is_number(row[k]) for row in self.rows)
            for k, (_, unit) in enumerate(self.columns)
        ]


@dataclass(frozen=True)
class Picture:
    """A figure: its SVG, what it shows, and the same for those who cannot see it.

    file : name of the file beside the page that holds the same figure, "" if there is none.
    """

    kind: ClassVar[str] = "picture"
    svg: bytes
    caption: str
    alt: str
    file: str = ""

    @property
    def address(self) -> str:
        """The figure itself, as an address."""
        return "data:image/svg+xml;base64," + base64.b64encode(self.svg).decode("ascii")


Block = Text | Points | Verdict | Table | Picture


@dataclass(frozen=True)
class Section:
    """A heading and what stands under it.  name : for links, such as "figure-6"."""

    name: str
    title: str
    blocks: Sequence[Block]


@dataclass(frozen=True)
class Page:
    """The whole report.

    lead : the answer, before anything else.  facts : what it was made from, name and value.
    """

    title: str
    subtitle: str
    lead: Sequence[Block]
    sections: Sequence[Section]
    facts: Sequence[tuple[str, str]] = field(default=())


def page_html(page: Page) -> str:
    """The page as one HTML file, figures and style within; it prints as it reads."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    names = [section.name for section in page.sections]
    if len(set(names)) != len(names):
        raise InputError("two sections have one name", "give each its own")
    environment = Environment(
        loader=PackageLoader("propmap.report", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("page.html.j2").render(page=page)


def number(value: float | None, digits: int = 3) -> str:
    """A number to so many significant digits, without an exponent where that can be read."""
    if value is None or value != value:
        return MISSING
    text = f"{value:.{digits}g}"
    if "e" in text and 1e-5 < abs(value) < 1e7:
        rounded = float(text)
        text = f"{rounded:.0f}" if abs(value) >= 1.0 else f"{rounded:.{digits + 4}f}".rstrip("0")
    return text.replace("-", MINUS)


def percent(share: float) -> str:
    """A share as per cent, to two figures, in one piece."""
    return f"{number(100.0 * share, 2)}\N{NO-BREAK SPACE}%"


def _is_number(text: str) -> bool:
    bare = text.replace(MINUS, "").replace(MISSING, "").replace("%", "").replace(" ", "")
    return bare == "" or bare.replace(".", "", 1).isdigit()
