"""The page on the architecture tells of every folder, and its picture of every import."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tools import architecture_picture, import_graph

from .pages import ROOT, steps

PAGE = ROOT / "docs" / "architecture.md"


@pytest.fixture(scope="module")
def rooms() -> set[str]:
    return set(import_graph.room_imports()) - {"__main__"}


def test_every_folder_has_its_paragraph(rooms: set[str]) -> None:
    text = PAGE.read_text(encoding="utf-8")
    folders = text.partition("## Folders")[2].partition("## ")[0]
    assert set(re.findall(r"\*\*`(\w+)`\*\*", folders)) == rooms


def test_every_header_has_its_line() -> None:
    text = PAGE.read_text(encoding="utf-8")
    table = text.partition("| header | contents |")[2].partition("\n\n")[0]
    cells = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    headers = {path.name for path in (ROOT / "core" / "include" / "propmap").glob("*.hpp")}
    assert set(re.findall(r"`(\w+\.hpp)`", " ".join(cells))) == headers


def test_what_is_added_is_short() -> None:
    """A file of ten lines at most, without imports, and a line or two at a time elsewhere."""
    kinds = [step.kind for step in steps(PAGE)]
    assert kinds.count("file") == 3 and kinds.count("edit") == 18
    heads = ("from ", "import ", "#pragma ", "#include ", "namespace ", "}  // namespace ")
    for step in steps(PAGE):
        lines = [line for line in step.text.splitlines() if line]
        if step.kind == "file":
            code = [line for line in lines if not line.startswith(heads)]
            assert len(code) <= 10, step.name
        elif step.kind == "edit":
            assert sum(line.startswith("+") for line in lines) <= 2, step.name


def test_the_picture_has_a_box_for_every_folder(rooms: set[str]) -> None:
    drawn = {text.get_text() for axes in architecture_picture.picture().axes for text in axes.texts}
    assert drawn >= rooms
    assert f"{import_graph.lines()['rotor']:,} lines" in drawn


def test_arrows_that_follow_from_others_are_left_out_and_no_more() -> None:
    imports = {"a": [], "b": ["a"], "c": ["a", "b"], "d": ["a", "c"], "e": ["a"]}
    needed = architecture_picture.without_detours(imports)
    assert needed == {"a": set(), "b": {"a"}, "c": {"b"}, "d": {"c"}, "e": {"a"}}


def test_an_import_is_seen_wherever_it_stands(tmp_path: Path) -> None:
    folder = tmp_path / "pkg"
    folder.mkdir()
    for name in ("__init__", "one", "two"):
        (folder / f"{name}.py").write_text("", encoding="utf-8")
    (folder / "three.py").write_text(
        "from typing import TYPE_CHECKING\n"
        "from propmap.pkg import one\n"
        "if TYPE_CHECKING:\n    from propmap.pkg.two import more\n"
        "def later():\n    import propmap.pkg.two\n",
        encoding="utf-8",
    )
    found = import_graph.module_imports(tmp_path)
    assert found["propmap.pkg.three"] == {"propmap.pkg.one", "propmap.pkg.two"}
