"""What a view is: a question, what can be set, and an answer to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from propmap.explore.controls import Control, Values
from propmap.explore.figures import Figure
from propmap.explore.session import Session


@dataclass(frozen=True)
class Table:
    """A small table: heads, rows of texts, and a caption."""

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str


@dataclass(frozen=True)
class Answer:
    """What a view shows.

    Attributes
    ----------
    figures : mapping of str to Figure
        By the names of the view's graphs.
    tables : sequence of Table
        Of numbers.
    remarks : sequence of str
        A line each.
    legend : sequence of (str, str)
        What colours mean: a name and its colour, which begins with "-" where the line is dashed.
    """

    figures: Mapping[str, Figure]
    tables: Sequence[Table] = ()
    remarks: Sequence[str] = ()
    legend: Sequence[tuple[str, str]] = ()


@dataclass(frozen=True)
class Graph:
    """A place for a figure.

    Attributes
    ----------
    name, label : str
        Within the view; what it shows, in words.
    wide : bool
        Whether it takes the whole width.
    tall : bool
        Whether it is as high as it is wide.
    """

    name: str
    label: str
    wide: bool = False
    tall: bool = False


@dataclass(frozen=True)
class Download:
    """A text that can be saved: the name of its file, and what it is for the button."""

    file: str
    label: str


class View(Protocol):
    """A view; see the modules of ``propmap.explore.views``.

    Attributes
    ----------
    name, title, question : str
        In the address, in the menu, and what it answers.
    downloads : tuple of Download
        What can be saved.
    """

    @property
    def name(self) -> str: ...  # noqa: D102 - above
    @property
    def title(self) -> str: ...  # noqa: D102
    @property
    def question(self) -> str: ...  # noqa: D102
    @property
    def downloads(self) -> tuple[Download, ...]: ...  # noqa: D102

    def controls(self, session: Session) -> Sequence[Control]:
        """What can be set."""

    def graphs(self, session: Session) -> Sequence[Graph]:
        """Where figures are."""

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """What is shown; ``settled`` when nothing has been moved for a moment."""

    def shell(self, session: Session, values: Values) -> str:
        """Lines for a shell that make the same numbers."""

    def python(self, session: Session, values: Values) -> str:
        """The same in Python."""

    def text(self, session: Session, values: Values, file: str) -> str:
        """What is saved in the ``file`` of one of the downloads."""
