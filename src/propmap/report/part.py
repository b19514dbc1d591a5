"""A section of the page and the files that go with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from matplotlib.figure import Figure

from propmap.report.page import Picture, Section
from propmap.report.style import as_svg


@dataclass(frozen=True)
class Part:
    """section : of the page.  files : by name, what lies beside it."""

    section: Section
    files: Mapping[str, str | bytes] = field(default_factory=dict)


def picture(figure: Figure, name: str, caption: str, alt: str) -> Picture:
    """A figure for the page, and the name of its file: the name with ``.svg``."""
    return Picture(as_svg(figure), caption, alt, f"{name}.svg")


def files_of(*pictures: Picture) -> dict[str, str | bytes]:
    """The figures as files."""
    return {one.file: one.svg for one in pictures}
