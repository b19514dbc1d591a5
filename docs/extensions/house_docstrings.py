"""The project's short docstrings, told to numpydoc.

Below its first sentence a docstring lists what it takes as ``name : [unit], meaning`` or
``name [unit], other [unit] : meaning``, several on a line where they are short.  numpydoc wants
a section with a heading and an entry each.  This turns the one into the other before numpydoc
sees it; sentences that are no such list stay as they are.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
import textwrap
from collections.abc import Iterator
from typing import Any

NAME = r"[A-Za-z_][A-Za-z0-9_]*(?: (?:\([^()]*\)|\[[^\]]*\])){0,2}"
HEAD = rf"(?P<names>{NAME}(?:, {NAME})*) : "
START = re.compile(rf"(?:^|(?<=[.;] ) ){HEAD}|(?:^|(?<=\.)  ?)Raises (?P<error>``\w+``)", re.M)
"""An entry begins a line, or follows a full stop and two spaces."""

KIND = re.compile(
    r"(?P<kind>(?:shape )?\([^()]*\)(?: ?\[[^\]]*\])?|scalar \[[^\]]*\]|\[[^\]]*\])(?:[,;:]? |$)"
)


@dataclasses.dataclass(frozen=True)
class Entry:
    """One thing that a docstring explains; kind : its shape and [unit], where they come first."""

    names: tuple[str, ...]
    kind: str
    meaning: str


@dataclasses.dataclass(frozen=True)
class Told:
    """What a docstring says, in order of appearance."""

    prose: list[str]
    entries: list[Entry]
    errors: list[tuple[str, str]]


def read(text: str) -> Told:
    """Take a docstring apart."""
    told = Told([], [], [])
    for paragraph in re.split(r"\n\s*\n", inspect.cleandoc(text)):
        before, rest = _split(paragraph)
        if before:
            told.prose.append(before)
        for found, body in rest:
            meaning = " ".join(body.split())
            if found["error"]:
                told.errors.append((found["error"].strip("`"), _sentence(meaning.lstrip("; "))))
            else:
                told.entries.append(_entry(found["names"], meaning))
    return told


def _split(paragraph: str) -> tuple[str, list[tuple[re.Match[str], str]]]:
    starts = list(START.finditer(paragraph))
    ends = [*(s.start() for s in starts[1:]), len(paragraph)]
    before = paragraph[: starts[0].start()] if starts else paragraph
    return before.strip(), [
        (s, paragraph[s.end() : e]) for s, e in zip(starts, ends, strict=True)
    ] if starts else []


def _entry(names: str, meaning: str) -> Entry:
    each = [part.split(" ", 1) for part in re.split(r", (?![^(\[]*[)\]])", names)]
    kinds = [part[1] for part in each if len(part) > 1]
    kind = ", ".join(dict.fromkeys(kinds))
    if not kinds and (found := KIND.match(meaning)):
        kind, meaning = found["kind"], meaning[found.end() :]
    return Entry(tuple(part[0] for part in each), kind, _sentence(meaning))


def _sentence(text: str) -> str:
    # A symbol such as v_i keeps its case.
    return text[:1].upper() + text[1:] if re.match(r"[a-z]{2,}\b", text) else text


def numpydoc_lines(text: str, heading: str) -> list[str]:
    """The docstring as numpydoc wants it; heading : of the section that its entries go to."""
    told = read(text)
    lines: list[str] = []
    for paragraph in told.prose:
        lines += [*_escaped(paragraph).splitlines(), ""]
    if told.entries:
        lines += [heading, "-" * len(heading)]
        for entry in told.entries:
            names = ", ".join(entry.names)
            lines.append(f"{names} : {entry.kind}" if entry.kind else names)
            lines += _indented(entry.meaning)
        lines.append("")
    if told.errors:
        lines += ["Raises", "------"]
        for error, meaning in told.errors:
            lines += [error, *_indented(meaning)]
    return lines


def _indented(text: str) -> Iterator[str]:
    yield from textwrap.indent(_escaped(text) or ".", "    ").splitlines()


def _escaped(text: str) -> str:
    """Bars and stars outside literals, which reStructuredText would take for markup."""
    parts = re.split(r"(``[^`]*``)", text)
    return "".join(
        part if k % 2 else re.sub(r"([|*])", r"\\\1", part) for k, part in enumerate(parts)
    )


def _heading(what: str, thing: Any) -> str:
    if what != "class":
        return "Parameters"
    fields = dataclasses.is_dataclass(thing) or hasattr(thing, "_fields")
    return "Attributes" if fields else "Parameters"


def rewrite(_: Any, what: str, __: str, thing: Any, ___: Any, lines: list[str]) -> None:
    """Replace ``lines`` in place, for autodoc."""
    if not lines or what == "module":
        return
    if any(line.startswith("----") for line in lines):  # numpydoc's own sections
        lines[:] = [_escaped(line) for line in lines]
    else:
        lines[:] = numpydoc_lines("\n".join(lines), _heading(what, thing))


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx, ahead of numpydoc."""
    app.connect("autodoc-process-docstring", rewrite, priority=100)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
