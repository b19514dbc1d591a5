"""A vehicle file, TOML: the vehicle, its powertrain, and how to read its logs."""

from __future__ import annotations

import functools
import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from propmap import catalogue
from propmap.catalogue.lookup import looks_like_path, propeller
from propmap.errors import InputError, quoted
from propmap.io.csv import read_lines
from propmap.io.toml import TomlTable, parse_toml
from propmap.model.corrections import MountDrag
from propmap.model.model import PAPER_DENSITY, PAPER_VISCOSITY, Air, Propeller
from propmap.units import RPM
from propmap.vehicle.powertrain import COLD, Battery, Motor, Powertrain, SpeedController
from propmap.vehicle.vehicle import SPINS, Body, Mount, Vector, Vehicle, Wakes, Wing

# -------------------------------------------------------------------------------------------------
# The tables ``[motor]``, ``[esc]`` and ``[battery]`` of a vehicle file.

MOTOR_KEYS = (
    "kv_rpm_per_volt",
    "resistance",
    "no_load_current",
    "no_load_voltage",
    "maximum_current",
    "maximum_rpm",
    "winding_temperature",
)
ESC_KEYS = ("resistance", "efficiency")
BATTERY_KEYS = (
    "cells",
    "capacity_mAh",
    "resistance",
    "usable_share",
    "maximum_current",
    "auxiliary_power",
)
POWERTRAIN_KEYS = ("motor", "esc", "battery")


def read_powertrain(top: TomlTable, radius: float) -> Powertrain:
    """The powertrain of a vehicle file.

    ``[motor]`` ``kv_rpm_per_volt``, ``resistance`` [ohm], ``no_load_current`` [A] and, optional,
    ``no_load_voltage`` [V] at which that was measured (either may be a list of up to three),
    ``maximum_current`` [A], ``maximum_rpm``, ``winding_temperature`` [degrees C];
    ``[esc]`` ``resistance`` [ohm] or ``efficiency``; ``[battery]`` ``cells``, ``capacity_mAh``,
    and, optional, ``resistance`` [ohm] of the pack, ``usable_share``, ``maximum_current`` [A],
    ``auxiliary_power`` [W].

    Parameters
    ----------
    top : TomlTable
        The whole file.
    radius : float
        Of the rotors [m].

    Raises
    ------
    InputError
        Naming the table and the key.
    """
    made = Powertrain(
        motor=_motor(top) if "motor" in top else None,
        controller=_controller(top) if "esc" in top else None,
        battery=_battery(top) if "battery" in top else None,
    )
    made.check_blade(radius)
    return made


def _made_in(table: TomlTable, kind: Any, *values: Any) -> Any:
    try:
        return kind(*values)
    except InputError as error:
        raise InputError(error.found, error.remedy, table.where) from None


def _motor(top: TomlTable) -> Motor:
    table = top.table("motor", MOTOR_KEYS)
    kv = table.number("kv_rpm_per_volt", "920, revolutions per minute and volt")
    resistance = table.number("resistance", "0.1, the winding's ohms")
    if resistance > 10.0:
        raise InputError(
            f"resistance is {resistance:g} ohm", "give ohms, not milliohms", table.where
        )
    found: Motor = _made_in(
        table,
        Motor,
        kv * RPM,
        resistance,
        _one_or_more(table, "no_load_current", "0.6, amperes"),
        _one_or_more(table, "no_load_voltage", "10, volts") if "no_load_voltage" in table else (),
        _or_infinite(table, "maximum_current", "20, amperes"),
        _or_infinite(table, "maximum_rpm", "12000") * RPM,
        table.number("winding_temperature", "80, degrees C", COLD),
    )
    return found


def _controller(top: TomlTable) -> SpeedController:
    table = top.table("esc", ESC_KEYS)
    if len(table.entries) != 1:
        raise InputError(
            f"{len(table.entries)} keys in [esc]", "give resistance or efficiency", table.where
        )
    found: SpeedController = _made_in(
        table,
        SpeedController,
        table.number("resistance", "0.01, ohms", 0.0),
        table.number("efficiency", "0.95, a share", 1.0),
    )
    if found.resistance > 1.0:
        raise InputError(
            f"resistance is {found.resistance:g} ohm", "give ohms, not milliohms", table.where
        )
    return found


def _battery(top: TomlTable) -> Battery:
    table = top.table("battery", BATTERY_KEYS)
    cells = table.need("cells", "4, those in series")
    capacity = table.number("capacity_mAh", "5000")
    if 0.0 < capacity < 50.0:
        raise InputError(
            f"capacity_mAh is {capacity:g}",
            f"give milliampere hours: {1000.0 * capacity:g}, if this is A h",
            table.where,
        )
    resistance = table.number("resistance", "0.02, ohms of the pack", 0.0)
    if resistance > 2.0:
        raise InputError(
            f"resistance is {resistance:g} ohm", "give ohms, not milliohms", table.where
        )
    found: Battery = _made_in(
        table,
        Battery,
        cells,
        capacity * 3.6,
        resistance,
        table.number("usable_share", "0.8", Battery.usable_share),
        _or_infinite(table, "maximum_current", "60, amperes"),
        table.number("auxiliary_power", "5, watts", Battery.auxiliary_power),
    )
    return found


def _one_or_more(table: TomlTable, key: str, example: str) -> tuple[float, ...]:
    if isinstance(table.need(key, example), list):
        found = tuple(table.numbers(key).tolist())
        if not all(map(math.isfinite, found)):
            raise InputError(f"{key} is {quoted(list(found))}", f"give {example}", table.where)
        return found
    return (table.number(key, example),)


def _or_infinite(table: TomlTable, key: str, example: str) -> float:
    return table.number(key, example) if key in table else math.inf


# -------------------------------------------------------------------------------------------------
# A vehicle and how to read its logs, from one TOML file.

SCHEMA = 1
VEHICLE_KEYS = (
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
    *POWERTRAIN_KEYS,
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
    top = TomlTable(fields, where, VEHICLE_KEYS)
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
    return VehicleFile(vehicle, read_log_map(top.table("log", LOG_KEYS), len(mounts)))


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


# -------------------------------------------------------------------------------------------------
# What a vehicle file says about flight logs: frames, units, names of columns and topics.

CHOICES = {
    "body_frame": ("flu", "frd"),
    "world_frame": ("enu", "ned"),
    "velocity_in": ("body", "world"),
    "rotor_unit": ("rad/s", "rpm", "erpm"),
}

VECTOR_COLUMNS = ("velocity", "rates", "specific_force")
QUATERNION_COLUMNS = ("qw", "qx", "qy", "qz")
EULER_COLUMNS = ("roll", "pitch", "yaw")
COLUMNS = ("time", *VECTOR_COLUMNS, *QUATERNION_COLUMNS, *EULER_COLUMNS, "rotor_speed")
TOPICS = ("odometry", "pose", "velocity", "imu", "rotor_speed")


@dataclass(frozen=True)
class LogMap:
    """What the table ``[log]`` of a vehicle file states about its logs; None is "not stated".

    PX4 logs are in FRD and NED whatever is stated, and their rotor speeds in rpm unless "erpm" is
    stated.  Bags are in FLU and ENU (REP 103), and an Odometry's velocity in the body frame, unless
    stated.  Whatever else a log needs must be stated.

    Attributes
    ----------
    body_frame : str or None
        "flu" or "frd"; with ``world_frame`` of attitude, velocity, rates and specific force.
    world_frame : str or None
        "enu" or "ned".
    velocity_in : str or None
        "body" or "world", the frame of the velocity.
    rotor_unit : str or None
        "rad/s", "rpm" or "erpm" (electrical).
    pole_pairs : int or None
        Of the motors; needed for "erpm".
    rotor_order : tuple of int or None
        Entry k is the number (from 1) of the vehicle's rotor that the log shows k-th.
    wind : tuple of 3 float
        Velocity of the air over the ground [m/s], in ``world_frame``, else in the log's own.
    columns : mapping of str to tuple of str
        For CSV and Parquet files: quantity to names of columns.
    topics : mapping of str to str
        For bags: role to the name of the topic.
    file : str
        The vehicle file, for messages.
    """

    body_frame: str | None = None
    world_frame: str | None = None
    velocity_in: str | None = None
    rotor_unit: str | None = None
    pole_pairs: int | None = None
    rotor_order: tuple[int, ...] | None = None
    wind: Vector = (0.0, 0.0, 0.0)
    columns: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    topics: Mapping[str, str] = field(default_factory=dict)
    file: str = "the vehicle file"

    @property
    def where(self) -> str:
        """The file and the table, for messages."""
        return f"{self.file}: [log]"

    def stated(self, key: str) -> str:
        """What is stated of a ``key`` of ``CHOICES``; ``InputError`` if nothing is."""
        value: str | None = getattr(self, key)
        if value is None:
            listed = " or ".join(f'"{choice}"' for choice in CHOICES[key])
            raise InputError(f"no {key}", f"add {key} = {listed}, as it is in the log", self.where)
        return value

    def rotor_factor(self, unit: str) -> float:
        """Rotational speed [rad/s] per ``unit`` "rad/s", "rpm" or "erpm"."""
        if unit == "rad/s":
            return 1.0
        if unit == "rpm":
            return RPM
        if self.pole_pairs is None:
            raise InputError(
                "rotor_unit is 'erpm' and there is no pole_pairs",
                "add pole_pairs = half the number of the motor's magnets",
                self.where,
            )
        return RPM / self.pole_pairs


LOG_KEYS = tuple(f.name for f in fields(LogMap) if f.name != "file")
"""Of the table ``[log]``."""


def read_log_map(table: TomlTable, rotors: int) -> LogMap:
    """The ``LogMap`` of the table ``[log]`` of a vehicle with so many ``rotors``."""
    stated = {key: table.choice(key, named) for key, named in CHOICES.items() if key in table}
    topics = table.table("log.topics", TOPICS)
    order = table.optional(
        "rotor_order",
        lambda value: (
            isinstance(value, list)
            and all(type(number) is int for number in value)
            and sorted(value) == list(range(1, rotors + 1))
        ),
        f"each number from 1 to {rotors} once",
        "for each speed in the log, give the number of its [[rotors]] table",
    )
    return LogMap(
        **stated,
        pole_pairs=table.optional(
            "pole_pairs",
            lambda value: type(value) is int and 1 <= value <= 100,
            "a whole number from 1 to 100",
            "give half the number of the motor's magnets",
        ),
        rotor_order=tuple(order) if order else None,
        wind=table.vector("wind", "[east, north, up]") if "wind" in table else (0.0, 0.0, 0.0),
        columns=_columns(table.table("log.columns", COLUMNS), rotors),
        topics={key: topics.text(key, '"/the/name/of/a/topic"') for key in topics.entries},
        file=table.where.partition(": [")[0],
    )


def _columns(table: TomlTable, rotors: int) -> dict[str, tuple[str, ...]]:
    columns: dict[str, tuple[str, ...]] = {}
    for key in table.entries:
        if key in VECTOR_COLUMNS:
            columns[key] = table.texts(key, 3, '["x", "y", "z"], the names of 3 columns')
        elif key == "rotor_speed":
            names = table.texts(key, None, '["rotor_1", ...], the names of the columns')
            if len(names) != rotors:
                raise InputError(
                    f"rotor_speed names {len(names)} columns, the vehicle has {rotors} rotors",
                    "name one column per rotor, or add the missing [[rotors]] tables",
                    table.where,
                )
            columns[key] = names
        else:
            columns[key] = (table.text(key, '"the name of a column"'),)
    return columns
