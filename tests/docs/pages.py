"""Pages of the documentation as a reader follows them: files to make, commands to run."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[2]
SHELL = ("bash", "sh")


@dataclass(frozen=True)
class Step:
    """A block of a page, at a line from 1.

    kind: "run", a shell block; "file", whose text is to be saved under ``name``; "edit", a
    difference of the file ``name``; "python"; "cell"; or "other", which is not for a machine.
    """

    kind: str
    text: str
    name: str = ""
    line: int = 0


def steps(page: Path) -> list[Step]:
    """The blocks of a page in order."""
    found = []
    for token in MarkdownIt().parse(page.read_text(encoding="utf-8")):
        if token.type != "fence":
            continue
        language, _, argument = token.info.strip().partition(" ")
        options, body = _options(token.content)
        line = (token.map or [0])[0] + 1
        if language in SHELL:
            found.append(Step("run", token.content, line=line))
        elif language == "{literalinclude}" and "caption" in options:
            text = (page.parent / argument).read_text(encoding="utf-8")
            found.append(Step("file", text, options["caption"], line))
        elif language == "{code-block}" and "caption" in options:
            kind = "edit" if argument == "diff" else "file"
            found.append(Step(kind, body, options["caption"], line))
        elif language == "{code-cell}":
            found.append(Step("cell", body, line=line))
        elif language == "python":
            found.append(Step("python", token.content, line=line))
        else:
            found.append(Step("other", token.content, language, line))
    return found


def _options(content: str) -> tuple[dict[str, str], str]:
    """The directive's leading ``:name: value`` lines, and what follows them."""
    options = {}
    lines = content.splitlines(keepends=True)
    while lines and (match := re.fullmatch(r":([\w-]+):\s*(.*?)\s*", lines[0].rstrip("\n"))):
        options[match[1]] = match[2]
        lines.pop(0)
    return options, "".join(lines)


def edited(text: str, step: Step) -> str:
    """Apply an "edit" to the text of a file."""
    lines = step.text.splitlines()
    before = "\n".join(line[1:] for line in lines if not line.startswith("+"))
    after = "\n".join(line[1:] for line in lines if not line.startswith("-"))
    assert text.count(f"{before}\n") == 1, f"{step.name} has not once:\n{before}"
    return text.replace(f"{before}\n", f"{after}\n")
