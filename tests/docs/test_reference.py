"""The reference names what exists, and says what every parameter and field of it means."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import re
from typing import Any

from propmap.io.toml import TomlTable
from propmap.sim.mjx import JaxForces, MjxRotors
from propmap.table import JaxTable
from propmap.vehicle import files

from .pages import ROOT

DIRECTIVE = re.compile(r"^\.\. (?:auto(\w+)|py:(currentmodule)):: ([\w.]+)", re.MULTILINE)


def documented() -> list[str]:
    """Full names of the functions and classes on the reference's pages."""
    found = []
    for page in sorted((ROOT / "docs" / "reference").glob("*.md")):
        module = ""
        for kind, current, name in DIRECTIVE.findall(page.read_text(encoding="utf-8")):
            if current:
                module = name
            elif kind in ("function", "class", "exception"):
                found.append(name if name.startswith("propmap.") else f"{module}.{name}")
    return found


def thing(name: str) -> Any:
    module, _, attribute = name.rpartition(".")
    return getattr(importlib.import_module(module), attribute)


def callables(name: str) -> list[tuple[str, Any]]:
    """The thing itself and, of a class, its public methods."""
    found = thing(name)
    if not inspect.isclass(found):
        return [(name, found)]
    own = {k: getattr(v, "__func__", v) for k, v in vars(found).items() if not k.startswith("_")}
    return [(name, found), *((f"{name}.{k}", v) for k, v in own.items() if inspect.isfunction(v))]


def parameters(found: Any) -> list[str]:
    if found in (JaxTable, JaxForces, MjxRotors):
        return []  # made with ``of``
    if inspect.isclass(found) and issubclass(found, Exception):
        return []
    if dataclasses.is_dataclass(found):
        return [field.name for field in dataclasses.fields(found)]
    if hasattr(found, "_fields"):
        return list(found._fields)
    if getattr(found, "_is_protocol", False):
        return []
    return [n for n in inspect.signature(found).parameters if n not in ("self", "cls")]


def test_all_public_names_are_in_it() -> None:
    for package in ("propmap", "propmap.table"):
        module = importlib.import_module(package)
        public = {f"{package}.{n}" for n in module.__all__ if callable(getattr(module, n))}
        assert public <= set(documented())


def test_members_that_a_page_lists_exist() -> None:
    for page in sorted((ROOT / "docs" / "reference").glob("*.md")):
        text, module = page.read_text(encoding="utf-8"), ""
        for block in re.split(r"^\.\. ", text, flags=re.MULTILINE):
            kind, _, name = block.partition("\n")[0].partition(":: ")
            if kind == "py:currentmodule":
                module = name
            elif members := re.search(r"^ +:members: (.+)$", block, re.MULTILINE):
                found = thing(name if name.startswith("propmap.") else f"{module}.{name}")
                missing = [m for m in members[1].split(", ") if not hasattr(found, m)]
                assert not missing, f"{page.name}: {name} has no {', '.join(missing)}"


def explained(text: str) -> set[str]:
    """Names that have an entry in a section on parameters or attributes."""
    sections = re.split(r"^(\w[\w ]*)\n-{3,}\n", inspect.cleandoc(text), flags=re.MULTILINE)
    names: set[str] = set()
    for heading, body in zip(sections[1::2], sections[2::2], strict=True):
        if heading in ("Parameters", "Attributes"):
            for entry in re.findall(r"^(\*{0,2}\w[^:\n]*?)(?: :.*)?$", body, re.MULTILINE):
                names |= set(entry.replace("*", "").split(", "))
    return names


def test_every_parameter_is_explained() -> None:
    """It has an entry of its own, or a sentence names it."""
    names = documented()
    assert len(names) > 60 and len(names) == len(set(names))
    for name, found in (pair for one in names for pair in callables(one)):
        text = found.__doc__
        assert text, name
        missing = {p for p in set(parameters(found)) - explained(text) if f"``{p}``" not in text}
        assert not missing, f"{name} has no entry for {', '.join(sorted(missing))}"


def test_all_entries_of_a_vehicle_file_are_in_it() -> None:
    """Except those of ``[log]``, which ``LogMap`` explains."""
    page = (ROOT / "docs" / "reference" / "vehicle.md").read_text(encoding="utf-8")
    tables = [
        found
        for name, found in vars(files).items()
        if isinstance(found, type) and issubclass(found, TomlTable) and found is not TomlTable
        if name not in ("_Log", "_Columns", "_Topics")
    ]
    entries = {entry for table in tables for entry in table.__struct_fields__}
    assert len(entries) > 40
    assert not [entry for entry in entries if not re.search(rf"`\[*{entry}\]*`", page)]
