"""Imports run one way: from the physics over the rotor to what is made of its loads."""

from __future__ import annotations

import ast
import graphlib
from collections.abc import Iterator
from pathlib import Path

import pytest

import propmap

SOURCE = Path(propmap.__file__).parent

LEFT_TO_RIGHT = (
    "errors",
    "loads",
    "arrays",
    "physics",
    "solve",
    "engine",
    "model",
    "rotor",
    "baselines",
    "io",
    "catalogue",
    "vehicle",
    "fit",
    "flight",
    "table",
    "export",
    "report",
    "papers",
    "cli",
    "__main__",
)
"""Rooms of the package; none knows of one to its right."""


def _modules() -> dict[str, Path]:
    found = {}
    for file in SOURCE.rglob("*.py"):
        parts = ("propmap", *file.relative_to(SOURCE).with_suffix("").parts)
        found[".".join(parts).removesuffix(".__init__")] = file
    return found


MODULES = _modules()


def _imported(node: ast.AST) -> Iterator[str]:
    """The package's modules that a piece of code imports, deferred imports included; not those
    for the type checker alone."""
    if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
        return
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names if alias.name in MODULES)
    elif isinstance(node, ast.ImportFrom) and node.module in MODULES:
        for alias in node.names:
            inner = f"{node.module}.{alias.name}"
            yield inner if inner in MODULES else node.module
    for child in ast.iter_child_nodes(node):
        yield from _imported(child)


@pytest.fixture(scope="module")
def imports() -> dict[str, set[str]]:
    """Of every module, those that it imports; without the package's face, which has all."""
    graph = {
        module: set(_imported(ast.parse(file.read_text(encoding="utf-8")))) - {module, "propmap"}
        for module, file in MODULES.items()
    }
    assert "propmap.solve.root" in graph["propmap.solve.disk"]  # it does find imports
    return graph


def _layer(module: str) -> int:
    return LEFT_TO_RIGHT.index(module.split(".")[1])


def test_no_module_imports_itself_by_way_of_others(imports: dict[str, set[str]]) -> None:
    try:
        graphlib.TopologicalSorter(imports).prepare()
    except graphlib.CycleError as circle:
        pytest.fail(" <- ".join(circle.args[1]))


def test_nothing_knows_of_what_is_to_its_right(imports: dict[str, set[str]]) -> None:
    wrong = [
        f"{module} imports {other}"
        for module, others in imports.items()
        if module != "propmap"
        for other in others
        if _layer(other) > _layer(module)
    ]
    assert not wrong
