"""The reference names what exists, and says what every parameter and field of it means."""

from __future__ import annotations

import dataclasses
import importlib
import importlib.util
import inspect
import re
from types import ModuleType
from typing import Any

import pytest

from propmap.table import JaxTable

from .pages import ROOT

DIRECTIVE = re.compile(r"^\.\. (?:auto(\w+)|py:(currentmodule)):: ([\w.]+)", re.MULTILINE)


def _extension() -> ModuleType:
    path = ROOT / "docs" / "extensions" / "house_docstrings.py"
    spec = importlib.util.spec_from_file_location("house_docstrings", path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    # Dataclasses look their module up.
    importlib.sys.modules["house_docstrings"] = module  # type: ignore[attr-defined]
    spec.loader.exec_module(module)
    return module


house = _extension()


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
    own = {k: v for k, v in vars(found).items() if not k.startswith("_")}
    methods = [
        (f"{name}.{k}", getattr(v, "__func__", v))
        for k, v in own.items()
        if inspect.isfunction(getattr(v, "__func__", v))
    ]
    return [(name, found), *methods]


EVERY = [pair for name in documented() for pair in callables(name)]


def parameters(found: Any) -> list[str]:
    if found is JaxTable:
        return []  # Made with ``of``; what it is made of is its own affair.
    if inspect.isclass(found) and issubclass(found, Exception):
        return []
    if dataclasses.is_dataclass(found):
        return [field.name for field in dataclasses.fields(found)]
    if hasattr(found, "_fields"):
        return list(found._fields)
    if getattr(found, "_is_protocol", False):
        return []
    return [n for n in inspect.signature(found).parameters if n not in ("self", "cls")]


def test_there_is_a_reference() -> None:
    names = documented()
    assert len(names) > 60
    assert len(names) == len(set(names))


def test_all_public_names_are_in_it() -> None:
    for package in ("propmap", "propmap.table"):
        module = importlib.import_module(package)
        public = {f"{package}.{n}" for n in module.__all__ if callable(getattr(module, n))}
        assert public <= set(documented())


@pytest.mark.parametrize(("name", "found"), EVERY, ids=[name for name, _ in EVERY])
def test_every_parameter_is_explained(name: str, found: Any) -> None:
    text = found.__doc__
    assert text, name
    words = {word.lower() for word in re.findall(r"\w+", text)}
    missing = [p for p in parameters(found) if p.lower() not in words]
    assert not missing, f"{name} says nothing of {', '.join(missing)}"


def test_the_house_style_becomes_sections() -> None:
    text = """Loads at operating points.

    omega : [rad/s] >= 0.  speed [m/s], beta [rad] : of the hub, any shape.
    clamp : whether to hold on to
        the border.
    Raises ``InputError`` for |V| < 0.
    """
    told = house.read(text)
    assert told.prose == ["Loads at operating points."]
    assert [entry.names for entry in told.entries] == [("omega",), ("speed", "beta"), ("clamp",)]
    assert [entry.kind for entry in told.entries] == ["[rad/s]", "[m/s], [rad]", ""]
    assert told.entries[2].meaning == "Whether to hold on to the border."
    assert told.errors == [("InputError", "For |V| < 0.")]
    lines = house.numpydoc_lines(text, "Parameters")
    assert lines[2:6] == ["Parameters", "----------", "omega : [rad/s]", "    >= 0."]
    assert "    For \\|V\\| < 0." in lines
