"""Target ``cpp``: a rotor as a C++ header that includes propmap's core."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

import numpy as np

import propmap
from propmap.export.files import Files, filled
from propmap.model.airfoil import GROWING, GROWTHS
from propmap.model.propeller import blade_intervals
from propmap.rotor import Rotor, core_corrections

FIELDS = {
    "tip-loss": "rotor.tip_loss = true",
    "hub-loss": "rotor.hub_radius = {}",
    "radial-friction": "rotor.radial_friction = true",
    "blade-untwist": "rotor.change.untwist = {}",
    "installed": "rotor.installed = true; rotor.drag_factor = {}",
    "mount-area": "rotor.mount_area = {}",
    "mount-wake": "rotor.mount_wake = {}",
    "stall-delay": "rotor.law.stall_delay = {}",
    "prandtl-glauert": "rotor.law.speed_of_sound = {}",
}
"""C++ statements that switch on the core's corrections, by name in ``core_corrections``."""


def rotor_files(rotor: Rotor) -> Files:
    """Return a ``rotor`` as one header, with a function that creates its solver."""
    blade, air = rotor.model.propeller, rotor.model.air
    name = re.sub(r"[^0-9a-z]+", "_", blade.name.lower()).strip("_") or "rotor"
    name = name if name[0].isalpha() else f"prop_{name}"
    corrections = core_corrections(rotor.model)
    root, tip = rotor.model.span
    rows = blade_intervals(blade, root).tolist()
    parts = (f"{{{start!r}, {_list(cubics[:4])}, {_list(cubics[4:])}}}" for start, *cubics in rows)
    shape = f"{{{{{', '.join(parts)}}}, {root!r}, {tip!r}, {blade.blades}}}"
    law, statements = _law(rotor.model.airfoil.core_law())
    statements += [f"rotor.density = {air.density!r}", f"rotor.viscosity = {air.viscosity!r}"]
    if inflow := corrections.pop("inflow", None):
        statements.append(f"rotor.inflow_shape = propmap::InflowShape::{inflow.replace('-', '_')}")
    statements += [FIELDS[key].format(repr(float(value))) for key, value in corrections.items()]
    title = " ".join(f"{blade.name}, {rotor.model.law_title}".replace("\\", "/").split())
    text = filled(
        "rotor.hpp",
        title=title,
        version=propmap.__version__,
        law=law,
        name=name,
        blade=shape,
        statements=statements,
        accuracy=rotor.accuracy,
    )
    return {f"{name}.hpp": text}


def _law(numbers: dict[str, Any]) -> tuple[str, list[str]]:
    """Return the name of the core's section law and the statements that set its constants."""
    kind = numbers.pop("kind")
    if kind == "tabulated":
        angle = numbers.pop("zero_lift_angle")
        parts = (f".{k} = {_list(v) if np.ndim(v) else repr(v)}" for k, v in numbers.items())
        table = (
            f"std::make_shared<propmap::SectionTable>(propmap::SectionTable{{{', '.join(parts)}}})"
        )
        zero = f"rotor.law.zero_lift_angle = {angle!r}"
        return "TabulatedLaw", [f"rotor.law.table = {table}", zero]
    if kind != GROWING:
        numbers = {key: value for key, value in numbers.items() if key not in GROWTHS}
    given = [f"rotor.law.{key} = {float(value)!r}" for key, value in numbers.items()]
    return f"{kind.capitalize()}Law", [*given, "rotor.law.complete()"]


def _list(values: Iterable[float]) -> str:
    return f"{{{', '.join(map(repr, np.asarray(values).tolist()))}}}"
