"""`docs/equations.md` has every equation, shows the whole reference, and names what exists."""

from __future__ import annotations

import ast
import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "equations.md").read_text(encoding="utf-8")

SOURCE = (ROOT / "papers" / "gill_dandrea_2017" / "reference.py").read_text(encoding="utf-8")
REFERENCE = ast.parse(SOURCE)

REQUIRED = {f"({n})" for n in range(1, 19)}
REQUIRED |= {"footnote 1", "footnote 3", "footnote 4", "section III.A"}


def rows() -> list[tuple[str, str, str]]:
    """Equation or subject, functions, tests: the first and the last two columns."""
    found = []
    for line in PAGE.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("| ") and cells[-1] != "test":
            found.append((cells[0], cells[-2], cells[-1]))
    return found


HEADERS = ROOT / "core" / "include" / "propmap"


def named(cell: str) -> list[tuple[str, str]]:
    """File and name of every function in a cell; a file is followed by its names."""
    found: list[tuple[str, str]] = []
    file = ""
    for word in re.findall(r"`([^`]+)`", cell):
        if word.endswith((".py", ".hpp")):
            file = word
        elif re.fullmatch(r"[A-Za-z_][\w.]*", word):  # not ``attached = 0``, an argument
            assert file, f"{word} follows no file in {cell!r}"
            found.append((file, word))
    return found


def functions(cell: str) -> list[tuple[str, str]]:
    """Module and name of every function in Python in a cell, of the package or of ``papers``."""
    python = [(file.removesuffix(".py"), name) for file, name in named(cell) if ".py" in file]
    modules = [file if file.startswith("papers/") else f"propmap/{file}" for file, _ in python]
    return [(m.replace("/", "."), name) for m, (_, name) in zip(modules, python, strict=True)]


def numbered(text: str) -> set[int]:
    """Numbers of the equations named in ``text``, as in "Eq. (10)", "Eqs. (13)-(15)"."""
    found: set[int] = set()
    for first, last in re.findall(r"Eqs?\. \((\d+)\)(?:-\((\d+)\))?", text):
        found |= set(range(int(first), int(last or first) + 1))
    return found


def test_the_page_shows_the_whole_reference() -> None:
    """Every function once; of the classes only the one that needs words."""
    defined = [n for n in REFERENCE.body if isinstance(n, ast.FunctionDef)]
    block = r"papers/gill_dandrea_2017/reference\.py\n:language: python\n:pyobject: (\w+)"
    assert sorted(re.findall(block, PAGE)) == sorted(["Case", *(node.name for node in defined)])


@pytest.mark.parametrize("number", range(1, 16))
def test_an_equation_stands_in_the_function_that_its_row_names(number: int) -> None:
    """By its number, in a comment or in what the function says of itself."""
    (cell,) = [cell for first, cell, _ in rows() if first == f"({number})"]
    names = [
        name for module, name in functions(cell) if module == "papers.gill_dandrea_2017.reference"
    ]
    (body,) = [n for n in REFERENCE.body if isinstance(n, ast.FunctionDef) and n.name == names[0]]
    lines = SOURCE.splitlines()[body.lineno - 1 : body.end_lineno]
    assert number in numbered("\n".join(lines))


def test_every_equation_has_its_row() -> None:
    named = {number for first, _, _ in rows() for number in re.findall(r"\(\d+\)", first)}
    named |= {first for first, _, _ in rows()}
    assert named >= REQUIRED, f"missing: {sorted(REQUIRED - named)}"


@pytest.mark.parametrize(("subject", "cell"), [(s, f) for s, f, _ in rows()])
def test_the_functions_exist(subject: str, cell: str) -> None:
    assert named(cell), f"{subject}: no function is named"
    for module, name in functions(cell):
        found: object = importlib.import_module(module)
        for part in name.split("."):
            found = getattr(found, part)
        assert getattr(found, "__doc__", None), f"{module}.{name} says nothing of itself"
    for file, name in named(cell):
        if file.endswith(".py"):
            continue
        text = (HEADERS / file).read_text(encoding="utf-8")
        defined = rf"^(?! *return)[\w <>,:*&[\]]*\b(?:{name}\(|(?:struct|class) {name}\b)"
        assert re.search(defined, text, re.MULTILINE), f"{subject}: {file} has no {name}"


@pytest.mark.parametrize("number", range(1, 13))
def test_an_equation_stands_in_the_header_that_its_row_names(number: int) -> None:
    """By its number, in a comment."""
    (cell,) = [cell for first, cell, _ in rows() if first == f"({number})"]
    files = {file for file, _ in named(cell) if file.endswith(".hpp")}
    text = "".join((HEADERS / file).read_text(encoding="utf-8") for file in files)
    told = re.sub(r"\((\d+)\)\((\d+)\)", r"(\1)-(\2)", text)  # Eqs. (3)(4)
    assert number in numbered(re.sub(r"\beq(s?\.)", r"Eq\1", told).replace(") to (", ")-("))


@pytest.mark.parametrize(("subject", "cell"), [(s, t) for s, _, t in rows()])
def test_the_tests_exist(subject: str, cell: str) -> None:
    """By its name behind its file; `::name` is in the file named last."""
    words, file = re.findall(r"`([^`]+)`", cell), ""
    assert words, f"{subject}: no test is named"
    for word in words:
        before, _, name = word.partition("::")
        file = before or file
        text = (ROOT / "tests" / file).read_text(encoding="utf-8")
        assert name.startswith("test_") and f"\ndef {name}(" in text, f"{subject}: {word}"


def test_names_on_the_page_about_the_root_search_are_in_the_headers() -> None:
    page = (ROOT / "docs" / "root-search.md").read_text(encoding="utf-8")
    headers = " ".join(path.read_text(encoding="utf-8") for path in HEADERS.glob("*.hpp"))
    names = set(re.findall(r"`(?:\w+::)?([a-zA-Z_]+)`", page))
    assert len(names) > 20
    assert {name for name in names if not re.search(rf"\b{name}\b", headers)} == set()
