"""Docstrings are numpydoc's: what a function takes stands in a section, not between sentences."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator

import pytest

from .pages import ROOT

HEADING = re.compile(r"^(\w[\w ]*)\n-{3,}$", re.MULTILINE)
ENTRY = re.compile(r"(?:^|(?<=[.;] ) ?)[A-Za-z_]\w*(?:(?:, | \(| \[)[^.:`]*)? : ", re.MULTILINE)
"""``name : meaning`` or ``name [unit], other [unit] : meaning``, which no heading announces."""


def docstrings() -> Iterator[tuple[str, str]]:
    """Where each docstring of the package, papers, tools and benchmarks stands, and its text."""
    for folder in ("src/propmap", "papers", "tools", "benchmarks"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            where = file.relative_to(ROOT).as_posix()
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Module):
                    line = getattr(node, "lineno", 1)
                    yield f"{where}:{line}", ast.get_docstring(node) or ""


def entries_outside_sections(text: str) -> list[str]:
    """What looks like an explained parameter above the first heading."""
    heading = HEADING.search(text)
    before = text[: heading.start()] if heading else text
    return [found.group().strip() for found in ENTRY.finditer(before)]


def test_no_docstring_explains_parameters_between_its_sentences() -> None:
    wrong = [
        f"{where}: {', '.join(found)}"
        for where, text in docstrings()
        if (found := entries_outside_sections(text))
    ]
    assert not wrong, "\n".join(wrong)


def test_every_docstring_stands_alone() -> None:
    """One that begins with "Of" goes on from a name, one with "The same" from its neighbour."""
    folders = ("src/propmap", "papers", "tools", "benchmarks", "tests", "examples")
    files = (file for folder in folders for file in (ROOT / folder).rglob("*.py"))
    begun = re.compile(r'^\s*"""(?:Of|The same)\b', re.MULTILINE)
    assert not [file for file in files if begun.search(file.read_text(encoding="utf-8"))]


@pytest.mark.parametrize(
    "text",
    [
        "Loads.\n\nomega : [rad/s] >= 0.",
        "Loads.\n\nspeed [m/s], beta [rad] : of the hub.",
        "Loads.\n\nSome words.  panels, azimuth : see there.",
        "Loads.\n\nstation, chord : shape (n,) [m]; twist : shape (n,) [rad].",
    ],
)
def test_the_old_form_is_found(text: str) -> None:
    assert entries_outside_sections(text)


def test_sections_and_prose_are_not_taken_for_it() -> None:
    text = """Loads at a point.

    Ratios such as 1 : 2 and ``name : type`` are prose.

    Parameters
    ----------
    omega : ndarray
        Rotational speed [rad/s].
    """
    assert not entries_outside_sections(inspect.cleandoc(text))
