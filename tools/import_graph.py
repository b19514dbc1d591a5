"""The imports between the modules and folders of the package, read from the source."""

from __future__ import annotations

import ast
import graphlib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

SOURCE = Path(__file__).resolve().parent.parent / "src" / "propmap"


def modules(source: Path = SOURCE) -> dict[str, Path]:
    """Return the file of each module of the package by the module's full name."""
    found = {}
    for file in sorted(source.rglob("*.py")):
        parts = ("propmap", *file.relative_to(source).with_suffix("").parts)
        found[".".join(parts).removesuffix(".__init__")] = file
    return found


def module_imports(source: Path = SOURCE) -> dict[str, set[str]]:
    """Return the modules that each module imports, deferred and type-checking imports included.

    The package's own ``__init__`` is excluded, because it imports every public name.
    """
    files = modules(source)
    return {
        module: set(_imported(ast.parse(file.read_text(encoding="utf-8")), files))
        - {module, "propmap"}
        for module, file in files.items()
    }


def room(module: str) -> str:
    """Return the folder of a module, or the name of a module at the root of the package."""
    return module.split(".")[1]


def room_imports() -> dict[str, Counter[str]]:
    """Return the number of imports from each folder to each other one, lowest layer first."""
    graph: dict[str, Counter[str]] = {}
    for module, others in module_imports().items():
        if module != "propmap":
            counts = graph.setdefault(room(module), Counter())
            counts.update(room(other) for other in others if room(other) != room(module))
    order = graphlib.TopologicalSorter(graph).static_order()
    return {name: graph[name] for name in order}


def lines() -> Counter[str]:
    """Return the number of source lines of each folder."""
    count: Counter[str] = Counter()
    for module, file in modules().items():
        count[room(module) if module != "propmap" else "propmap"] += len(
            file.read_text(encoding="utf-8").splitlines()
        )
    return count


def _imported(node: ast.AST, files: dict[str, Path]) -> Iterator[str]:
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names if alias.name in files)
    elif isinstance(node, ast.ImportFrom) and node.module in files:
        for alias in node.names:
            inner = f"{node.module}.{alias.name}"
            yield inner if inner in files else node.module
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.expr):  # an expression contains no import
            yield from _imported(child, files)
