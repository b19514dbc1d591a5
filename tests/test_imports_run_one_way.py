"""Imports run one way: from the core over the rotor to what is made of its loads."""

from __future__ import annotations

import graphlib

import pytest

from tools.import_graph import module_imports, room

LEFT_TO_RIGHT = (
    "errors",
    "core",
    "typing",
    "units",
    "tasks",
    "loads",
    "results",
    "model",
    "operating_points",
    "backward",
    "bands",
    "rotor",
    "jax",
    "dynamic_inflow",
    "hover",
    "io",
    "sweep",
    "catalogue",
    "vehicle",
    "study",
    "fit",
    "table",
    "aircraft",
    "flight",
    "sim",
    "export",
    "report",
    "cluster",
    "explore",
    "cli",
    "__main__",
)
"""Rooms of the package; none knows of one to its right."""

FACES = (
    "rotor",
    "results",
    "model.airfoil",
    "vehicle.wakes",
    "vehicle.vehicle_forces",
    "table.query",
    "sim.mujoco",
)
"""The modules through which all others use the compiled core: sections ask for their own
coefficients, tables for their loads, vehicles for the flow at hubs and the forces there."""


@pytest.fixture(scope="module")
def imports() -> dict[str, set[str]]:
    """Modules that every module imports; without the package's face, which has all."""
    graph = module_imports()
    assert "propmap.core" in graph["propmap.rotor"]  # it does find imports
    return graph


def _layer(module: str) -> int:
    return LEFT_TO_RIGHT.index(room(module))


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


def test_only_the_faces_know_the_core(imports: dict[str, set[str]]) -> None:
    others = {
        module
        for module, imported in imports.items()
        if any(other.startswith("propmap.core") for other in imported)
    }
    assert others == {f"propmap.{face}" for face in FACES}
