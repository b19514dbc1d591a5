"""The page on the architecture tells of every folder, and its picture of every import."""

from __future__ import annotations

import re

from tools import architecture_picture, import_graph

from .pages import ROOT

PAGE = ROOT / "docs" / "architecture.md"
SOURCE = ROOT / "src" / "propmap"
ROOMS = {path.stem for path in SOURCE.iterdir() if path.suffix == ".py" or path.is_dir()}
ROOMS = {name for name in ROOMS if not name.startswith("_")}


def test_every_folder_and_every_header_is_described() -> None:
    text = PAGE.read_text(encoding="utf-8")
    folders = text.partition("## Folders")[2].partition("## ")[0]
    assert set(re.findall(r"\*\*`(\w+)`\*\*", folders)) == ROOMS
    table = text.partition("| header | contents |")[2].partition("\n\n")[0]
    cells = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    headers = {path.name for path in (ROOT / "core" / "include" / "propmap").glob("*.hpp")}
    assert set(re.findall(r"`(\w+\.hpp)`", " ".join(cells))) == headers


def test_the_picture_has_a_box_for_every_folder() -> None:
    drawn = {text.get_text() for axes in architecture_picture.picture().axes for text in axes.texts}
    assert drawn >= ROOMS
    assert f"{import_graph.lines()['rotor']:,} lines" in drawn


def test_arrows_that_follow_from_others_are_left_out_and_no_more() -> None:
    imports = {"a": [], "b": ["a"], "c": ["a", "b"], "d": ["a", "c"], "e": ["a"]}
    needed = architecture_picture.without_detours(imports)
    assert needed == {"a": set(), "b": {"a"}, "c": {"b"}, "d": {"c"}, "e": {"a"}}
