"""A vehicle and how to read its logs, from one TOML file."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from propmap import catalogue
from propmap.catalogue.lookup import looks_like_path, propeller
from propmap.errors import InputError, quoted
from propmap.io.text_file import read_lines
from propmap.io.toml_table import TomlTable, parse_toml
from propmap.model.air import PAPER_DENSITY, PAPER_VISCOSITY, Air
from propmap.model.corrections import MountDrag
from propmap.model.propeller import Propeller
from propmap.vehicle import log_map, powertrain_toml
from propmap.vehicle.log_map import CHOICES, LogMap, read_log_map
from propmap.vehicle.powertrain_toml import read_powertrain
from propmap.vehicle.vehicle import SPINS, Body, Mount, Vector, Vehicle, Wakes, Wing

SCHEMA = 1
KEYS = (
    "schema",
    "name",
    "frame",
    "mass",
    "inertia",
    "rotor_inertia",
    "propeller",
    "air",
    "rotors",
    "mount",
    "body",
    "wing",
    *powertrain_toml.KEYS,
    "wakes",
    "sensor",
    "log",
)
PROPELLER_KEYS = ("geometry", "blades", "radius", "root_cutout")
WAKE_RANGES = {"ahead": 20.0, "beside": 20.0, "downwash": 20.0, "share": 2.0}
"""Largest values of the table ``[wakes]``."""
FARTHEST_SENSOR, FARTHEST_ROTOR = 5.0, 20.0
"""From the centre of mass, along each axis [m]."""
WING_KEYS = ("area", "incidence", "c_l1", "c_l2", "alpha_0", "span")
GEOMETRY = '"apc-8x6e", a name of `propmap props` or a geometry file beside this file'

Made = TypeVar("Made")


@dataclass(frozen=True)
class VehicleFile:
    """The vehicle, in FLU whatever the file's frame, and how its logs are to be read."""

    vehicle: Vehicle
    log: LogMap


def read_vehicle(path: str | os.PathLike[str]) -> VehicleFile:
    """Read a vehicle file in TOML; SI units and radians throughout.

    ``schema = 1``, ``name``, ``frame`` ("flu" or "frd", of ``position`` and ``axis``), ``mass``
    [kg] and ``propeller``: a name of the catalogue, the path of a geometry file relative to the
    vehicle file, or a table with ``geometry`` (either of these) and, where the geometry lacks
    them, ``blades``, ``radius`` [m], ``root_cutout`` [m].
    ``[[rotors]]``, one per rotor: ``position`` [m], ``spin`` ("ccw" or "cw", seen from above),
    ``axis`` (unit vector along the thrust, by default up).
    Optional: ``inertia`` about the three axes [kg m^2] and ``rotor_inertia`` [kg m^2], see
    ``Vehicle``; ``[air]`` ``density``, ``viscosity`` (by default the paper's);
    ``[mount]``, what is in the rotors' slipstreams, see ``MountDrag``: ``area`` [m^2], one for all
    rotors or a list with one for each, ``wake`` (by default 1); ``[body]``
    ``drag_area`` (3 numbers [m^2]), ``lift_area`` [m^2], ``download_area`` (2 numbers [m^2]);
    ``[wing]`` ``area`` [m^2], ``incidence`` [rad], ``c_l1``, ``c_l2``, ``alpha_0`` [rad], ``span``
    [m], with which it has induced drag;
    ``[motor]``, ``[esc]`` and ``[battery]``, see ``read_powertrain``;
    ``[wakes]``, the rotors' wakes on each other, see
    ``Wakes``: ``ahead``, ``beside``, ``downwash``, ``share`` (each by default 1); ``[sensor]``
    ``position`` [m] of the accelerometer, from the centre of mass; ``[log]``, see ``LogMap``.

    Parameters
    ----------
    path : path
        Of the file.

    Raises
    ------
    InputError
        Naming the file, the table and the key.
    """
    where = os.fspath(path)
    fields = parse_toml("\n".join(read_lines(path, "vehicle description")), where, SCHEMA)
    top = TomlTable(fields, where, KEYS)
    flip = top.choice("frame", CHOICES["body_frame"]) == "frd"
    rotors = top.tables("rotors", ("position", "axis", "spin"))
    drags = _mount_drags(top, len(rotors))
    mounts = tuple(_mount(rotor, flip, drag) for rotor, drag in zip(rotors, drags, strict=True))
    mass = top.number("mass", "the take-off mass in kg, battery included")
    propeller = _propeller(top, Path(where).parent)
    vehicle = _located(
        where,
        lambda: Vehicle(
            name=top.text("name", '"what the vehicle is called"'),
            mass=mass,
            propeller=propeller,
            mounts=mounts,
            air=_air(top),
            body=_body(top),
            wing=_wing(top),
            powertrain=read_powertrain(top, propeller.radius),
            wakes=_wakes(top),
            sensor=_sensor(top, flip),
            inertia=_inertia(top),
            rotor_inertia=top.number("rotor_inertia", "that of one rotor in kg m^2", 0.0),
        ),
    )
    return VehicleFile(vehicle, read_log_map(top.table("log", log_map.KEYS), len(mounts)))


def _located(where: str, make: Callable[[], Made]) -> Made:
    """What ``make`` gives; an error that does not say where it is gets ``where``."""
    try:
        return make()
    except InputError as error:
        raise InputError(error.found, error.remedy, error.where or where) from None


def _mount_drags(top: TomlTable, rotors: int) -> Sequence[MountDrag | None]:
    if "mount" not in top:
        return [None] * rotors
    table = top.table("mount", ("area", "wake"))
    example = "an area in m^2, or a list with one for each rotor"
    given = table.need("area", example)
    areas = given if isinstance(given, list) else [given] * rotors
    if len(areas) != rotors:
        raise InputError(
            f"area has {len(areas)} numbers for {rotors} rotors", f"give {example}", table.where
        )
    each = [TomlTable({"area": area}, table.where, ("area",)) for area in areas]
    wake = table.number("wake", "a share of the inflow, 1 at the disk", MountDrag.wake)
    return [
        _located(table.where, functools.partial(MountDrag, one.number("area", example), wake))
        for one in each
    ]


def _mount(table: TomlTable, flip: bool, drag: MountDrag | None) -> Mount:
    position = table.vector("position", "[x, y, z], in m from the centre of mass")
    if max(abs(x) for x in position) > FARTHEST_ROTOR:
        raise InputError(f"position is {list(position)} m", "give it in m, not mm", table.where)
    spin = table.choice("spin", SPINS)
    if "axis" not in table:
        return Mount(_flu(position, flip), spin=spin, drag=drag)
    axis = _flu(table.vector("axis", "a unit vector along the thrust"), flip)
    return Mount(_flu(position, flip), axis, spin, drag)


def _flu(vector: Vector, flip: bool) -> Vector:
    x, y, z = vector
    # Adding zero keeps -0.0 out of what is shown.
    return (x, 0.0 - y, 0.0 - z) if flip else vector


def _propeller(top: TomlTable, folder: Path) -> Propeller:
    value = top.need("propeller", GEOMETRY)
    entries = value if isinstance(value, dict) else {"geometry": value}
    table = TomlTable(entries, f"{top.where}: propeller", PROPELLER_KEYS)
    name = table.text("geometry", GEOMETRY)
    options: dict[str, Any] = {
        key: table.number(key, "a length in m") for key in ("radius", "root_cutout") if key in table
    }
    known = name.strip().lower() in catalogue.names()
    # Relative to the vehicle file alone: what lies in the current folder plays no part.
    file = not known and ((folder / name).exists() or looks_like_path(name))
    source = folder / name if file else name
    return _located(table.where, lambda: propeller(source, entries.get("blades"), **options))


def _air(top: TomlTable) -> Air:
    table = top.table("air", ("density", "viscosity"))
    density = table.number("density", "the density in kg/m^3", PAPER_DENSITY)
    viscosity = table.number("viscosity", "the viscosity in Pa s", PAPER_VISCOSITY)
    return _located(table.where, lambda: Air(density, viscosity))


def _body(top: TomlTable) -> Body:
    table = top.table("body", ("drag_area", "lift_area", "download_area"))
    example = "[front, side, top], areas in m^2"
    drag_area = table.vector("drag_area", example) if "drag_area" in table else Body.drag_area
    lift_area = table.number("lift_area", "an area in m^2", Body.lift_area)
    for area in (*drag_area, lift_area):
        if area < 0.0:
            raise InputError(f"found {quoted(area)} m^2", "give areas of 0 or more", table.where)
    return Body(drag_area, lift_area, _download_area(table))


def _download_area(table: TomlTable) -> tuple[float, float]:
    """Areas [m^2] of flow along x and y, of either sign."""
    if "download_area" not in table:
        return Body.download_area
    given = table.numbers("download_area")
    if given.shape != (2,) or not np.isfinite(given).all():
        raise InputError(
            f"download_area is {quoted(table.entries['download_area'])}",
            "write [along x, along y], two areas in m^2",
            table.where,
        )
    return float(given[0]), float(given[1])


def _wing(top: TomlTable) -> Wing | None:
    if "wing" not in top:
        return None
    table = top.table("wing", WING_KEYS)
    given = {key: table.number(key, "a number") for key in WING_KEYS if key in table}
    if not table.number("area", "the wing's area in m^2") > 0.0:
        raise InputError(
            f"area is {given['area']} m^2", "give the area, or remove [wing]", table.where
        )
    if "span" in given and not given["span"] ** 2 > given["area"]:
        raise InputError(
            f"span is {given['span']:g} m for an area of {given['area']:g} m^2",
            "give that from tip to tip, in m, longer than the chord",
            table.where,
        )
    return Wing(**given)


def _wakes(top: TomlTable) -> Wakes | None:
    if "wakes" not in top:
        return None
    table = top.table("wakes", tuple(WAKE_RANGES))
    given = {key: table.number(key, "a factor", 1.0) for key in WAKE_RANGES}
    for key, most in WAKE_RANGES.items():
        if not 0.0 <= given[key] <= most:
            raise InputError(
                f"{key} is {given[key]:g}", f"give a number from 0 to {most:g}", table.where
            )
    return Wakes(**given)


def _inertia(top: TomlTable) -> Vector | None:
    if "inertia" not in top:
        return None
    return top.vector("inertia", "[about x, about y, about z], in kg m^2")


def _sensor(top: TomlTable, flip: bool) -> Vector:
    if "sensor" not in top:
        return (0.0, 0.0, 0.0)
    table = top.table("sensor", ("position",))
    place = table.vector("position", "[x, y, z], in m from the centre of mass")
    if max(abs(x) for x in place) > FARTHEST_SENSOR:
        raise InputError(f"position is {list(place)} m", "give it in m", table.where)
    return _flu(place, flip)
