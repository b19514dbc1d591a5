"""The vehicle file in TOML: vehicle, powertrain, and conventions of its logs."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal, get_type_hints

import msgspec
from msgspec import Meta
from msgspec.structs import asdict

from propmap import catalogue
from propmap.catalogue.lookup import looks_like_path, propeller
from propmap.errors import InputError, located, quoted
from propmap.io.toml import Number, Text, TomlTable, Vector, example, read_toml
from propmap.model.air import PAPER_DENSITY, PAPER_VISCOSITY, Air
from propmap.model.corrections import Installed
from propmap.model.propeller import Propeller
from propmap.units import RPM
from propmap.vehicle.powertrain import COLD, Battery, Motor, Powertrain, SpeedController
from propmap.vehicle.vehicle import SLIPSTREAMS, Body, Mount, Vehicle, Wakes, Wing
from propmap.vehicle.wakes import above_each_other

# --- Tables and keys of a vehicle file; error messages suggest the text of an annotation ---------

VEHICLE_SCHEMA = 1
OneOrMore = Number | tuple[Number, ...]
Area = Annotated[float, Meta(ge=0.0, le=1e6)]
"""[m^2]."""
Gain = Annotated[float, Meta(ge=0.0, le=20.0), "a factor from 0 to 20"]
AtRotor = Annotated[float, Meta(ge=-20.0, le=20.0)]
AtSensor = Annotated[float, Meta(ge=-5.0, le=5.0)]
"""Coordinates relative to the center of mass [m]."""
PolePairs = Annotated[int, Meta(ge=1, le=100), "half the number of the motor's magnets"]
Names = Annotated[tuple[Text, Text, Text], '["x", "y", "z"], the names of 3 columns']
Column = Annotated[Text, '"the name of a column"']
Topic = Annotated[Text, '"/the/name/of/a/topic"']
Geometry = Annotated[Text, '"apc-8x6e", a name of `propmap props` or a geometry file']


class _Rotor(TomlTable):
    position: Annotated[
        tuple[AtRotor, AtRotor, AtRotor], "[x, y, z], in m, not mm, from the center of mass"
    ]
    spin: Literal["ccw", "cw"]
    axis: Annotated[Vector, "a unit vector along the thrust"] | None = None


class _VehiclePropeller(TomlTable):
    geometry: Geometry
    blades: Annotated[int, "2"] | None = None
    radius: Annotated[Number, "a length in m"] | None = None
    root_cutout: Annotated[Number, "a length in m"] | None = None


class _Air(TomlTable):
    density: Annotated[Number, "the density in kg/m^3"] = PAPER_DENSITY
    viscosity: Annotated[Number, "the viscosity in Pa s"] = PAPER_VISCOSITY


class _Mount(TomlTable):
    area: Annotated[
        Number | tuple[Number, ...], "an area in m^2, or a list with one for each rotor"
    ]
    wake: Annotated[Number, "a multiple of the inflow, 1 at the disk"] = Installed.wake


class _Body(TomlTable):
    drag_area: Annotated[
        tuple[Area, Area, Area], "[front, side, top], areas of 0 or more in m^2"
    ] = Body.drag_area
    lift_area: Annotated[Area, "an area of 0 or more in m^2"] = Body.lift_area
    # Negative areas are allowed: they give lift.
    download_area: Annotated[tuple[Number, Number], "[along x, along y], two areas in m^2"] = (
        Body.download_area
    )
    plate_area: Annotated[Area, "an area of 0 or more in m^2"] = Body.plate_area


class _Wing(TomlTable):
    area: Annotated[float, Meta(gt=0.0, le=1e6), "the wing's area in m^2, or remove [wing]"]
    incidence: Annotated[Number, "an angle in rad"] = Wing.incidence
    c_l1: Annotated[Number, "a slope in 1/rad"] = Wing.c_l1
    c_l2: Annotated[Number, "a number"] = Wing.c_l2
    alpha_0: Annotated[Number, "an angle in rad"] = Wing.alpha_0
    span: Annotated[Number, "a length in m"] | None = None

    def __post_init__(self) -> None:
        if self.span is not None and not self.span**2 > self.area:
            found = f"span is {self.span:g} m for an area of {self.area:g} m^2"
            raise InputError(found, "give the span from tip to tip in m, larger than the chord")


class _Motor(TomlTable):
    kv_rpm_per_volt: Annotated[Number, "920, in rpm per volt"]
    resistance: Annotated[float, Meta(le=10.0), "0.1, ohms of the winding, not milliohms"]
    no_load_current: Annotated[OneOrMore, "0.6, amperes"]
    no_load_voltage: Annotated[OneOrMore, "10, volts"] = ()
    maximum_current: Annotated[Number, "20, amperes"] = math.inf
    maximum_rpm: Annotated[Number, "12000"] = math.inf
    winding_temperature: Annotated[Number, "80, degrees C"] = COLD


class _Esc(TomlTable):
    resistance: Annotated[float, Meta(le=1.0), "0.01, ohms, not milliohms"] | None = None
    efficiency: Annotated[Number, "0.95, a fraction"] | None = None

    def __post_init__(self) -> None:
        given = [value for value in (self.resistance, self.efficiency) if value is not None]
        if len(given) != 1:
            fault = f"[esc] has {len(given)} keys, expected 1"
            raise InputError(fault, "give resistance or efficiency")


class _Battery(TomlTable):
    cells: Annotated[int, "4, the number of cells in series"]
    capacity_mAh: Annotated[Number, "5000"]  # noqa: N815
    resistance: Annotated[float, Meta(le=2.0), "0.02, ohms of the pack, not milliohms"] = 0.0
    usable_share: Annotated[Number, "0.8"] = Battery.usable_share
    maximum_current: Annotated[Number, "60, amperes"] = math.inf
    auxiliary_power: Annotated[Number, "5, watts"] = Battery.auxiliary_power

    def __post_init__(self) -> None:
        if 0.0 < self.capacity_mAh < 50.0:
            remedy = f"give milliampere hours: {1000.0 * self.capacity_mAh:g} for a value in A h"
            raise InputError(f"capacity_mAh is {self.capacity_mAh:g}", remedy)


class _Wakes(TomlTable):
    ahead: Gain = Wakes.ahead
    beside: Gain = Wakes.beside
    downwash: Gain = Wakes.downwash
    share: Annotated[float, Meta(ge=0.0, le=2.0), "a number from 0 to 2"] = Wakes.share


class _Sensor(TomlTable):
    position: Annotated[
        tuple[AtSensor, AtSensor, AtSensor], "[x, y, z], in m from the center of mass"
    ] = (0.0, 0.0, 0.0)


class _Columns(TomlTable):
    time: Column = ""
    velocity: Names | None = None
    rates: Names | None = None
    specific_force: Names | None = None
    qw: Column = ""
    qx: Column = ""
    qy: Column = ""
    qz: Column = ""
    roll: Column = ""
    pitch: Column = ""
    yaw: Column = ""
    rotor_speed: Annotated[tuple[Text, ...], '["rotor_1", ...], the names of the columns'] = ()
    throttle: Annotated[tuple[Text, ...], '["motor_1", ...], the names of the columns'] = ()
    battery_voltage: Column = ""
    hover_throttle: Column = ""
    air_speed: Column = ""


class _Topics(TomlTable):
    odometry: Topic = ""
    pose: Topic = ""
    velocity: Topic = ""
    imu: Topic = ""
    rotor_speed: Topic = ""
    throttle: Topic = ""
    battery: Topic = ""


class _Log(TomlTable):
    body_frame: Literal["flu", "frd"] | None = None
    world_frame: Literal["enu", "ned"] | None = None
    velocity_in: Literal["body", "world"] | None = None
    rotor_unit: Literal["rad/s", "rpm", "erpm"] | None = None
    pole_pairs: PolePairs | None = None
    rotor_order: Annotated[tuple[int, ...], "[2, 1, ...]"] | None = None
    throttle_range: (
        Annotated[tuple[Number, Number], "[1000, 2000], at rest and at full throttle"] | None
    ) = None
    wind: Annotated[Vector, "[east, north, up]"] = (0.0, 0.0, 0.0)
    columns: _Columns = msgspec.field(default_factory=_Columns)
    topics: _Topics = msgspec.field(default_factory=_Topics)


class _VehicleFile(TomlTable):
    name: Annotated[Text, '"the name of the vehicle"']
    frame: Literal["flu", "frd"]
    mass: Annotated[Number, "the take-off mass in kg, including the battery"]
    propeller: Geometry | _VehiclePropeller
    rotors: tuple[_Rotor, ...] = ()
    inertia: Annotated[Vector, "[about x, about y, about z], in kg m^2"] | None = None
    rotor_inertia: Annotated[Number, "the inertia of one rotor in kg m^2"] = 0.0
    air: _Air = msgspec.field(default_factory=_Air)
    mount: _Mount | None = None
    body: _Body = msgspec.field(default_factory=_Body)
    wing: _Wing | None = None
    motor: _Motor | None = None
    esc: _Esc | None = None
    battery: _Battery | None = None
    wakes: _Wakes | None = None
    sensor: _Sensor = msgspec.field(default_factory=_Sensor)
    log: _Log = msgspec.field(default_factory=_Log)


# --- Reader of vehicle files ---------------------------------------------------------------------


@dataclass(frozen=True)
class VehicleFile:
    """A vehicle, converted to FLU, and the conventions of its logs.

    Attributes
    ----------
    vehicle : Vehicle
        Vehicle with the geometry of its propellers.
    log : LogMap
        Conventions of the logs.
    propeller : str
        Name, designation or file of the propeller, for ``propmap.catalogue_model``.
    blades : int or None
        Number of blades stated in the file, or None.
    """

    vehicle: Vehicle
    log: LogMap
    propeller: str
    blades: int | None


def read_vehicle(path: str | os.PathLike[str]) -> VehicleFile:
    """Read a vehicle file in TOML; the reference "Vehicles and flight logs" lists its entries.

    Parameters
    ----------
    path : path
        Path of the file.

    Raises
    ------
    InputError
        For an invalid entry, with its file, table and key.
    """
    where = os.fspath(path)
    file = read_toml(path, _VehicleFile, VEHICLE_SCHEMA, "vehicle")
    flip = file.frame == "frd"
    stated = file.propeller
    stated = _VehiclePropeller(stated) if isinstance(stated, str) else stated
    source, blade = _propeller(stated, where)
    with located(f"{where}: [air]"):
        air = Air(file.air.density, file.air.viscosity)
    powertrain = _powertrain(file, where)
    drags = _mount_drags(file.mount, len(file.rotors), f"{where}: [mount]")
    with located(where):
        powertrain.check_blade(blade.radius)
        vehicle = Vehicle(
            name=file.name,
            mass=file.mass,
            propeller=blade,
            mounts=tuple(
                Mount(
                    _flu(rotor.position, flip),
                    (0.0, 0.0, 1.0) if rotor.axis is None else _flu(rotor.axis, flip),
                    rotor.spin,
                    drag,
                )
                for rotor, drag in zip(file.rotors, drags, strict=True)
            ),
            air=air,
            body=Body(**asdict(file.body)),
            wing=None if file.wing is None else Wing(**asdict(file.wing)),
            powertrain=powertrain,
            wakes=SLIPSTREAMS if file.wakes is None else Wakes(**asdict(file.wakes)),
            sensor=_flu(file.sensor.position, flip),
            inertia=file.inertia,
            rotor_inertia=file.rotor_inertia,
        )
        if file.wakes is None and not above_each_other(vehicle).any():
            vehicle = replace(vehicle, wakes=None)
    return VehicleFile(vehicle, _log_map(file.log, len(file.rotors), where), source, stated.blades)


def _flu(vector: Vector, flip: bool) -> Vector:
    x, y, z = vector
    # Subtracting from zero avoids -0.0 in printed vectors.
    return (x, 0.0 - y, 0.0 - z) if flip else vector


def _several(given: float | tuple[float, ...]) -> tuple[float, ...]:
    return given if isinstance(given, tuple) else (given,)


def _propeller(given: _VehiclePropeller, where: str) -> tuple[str, Propeller]:
    known = given.geometry.strip().lower() in catalogue.names()
    # Paths are relative to the vehicle file, not to the current folder.
    beside = Path(where).parent / given.geometry
    file = not known and (beside.exists() or looks_like_path(given.geometry))
    with located(f"{where}: propeller"):
        source = str(beside) if file else given.geometry
        return source, propeller(source, given.blades, given.radius, given.root_cutout)


def _mount_drags(mount: _Mount | None, rotors: int, where: str) -> Sequence[Installed | None]:
    if mount is None:
        return [None] * rotors
    areas = mount.area if isinstance(mount.area, tuple) else (mount.area,) * rotors
    if len(areas) != rotors:
        found = f"area has {len(areas)} values for {rotors} rotors"
        raise InputError(found, "give one area in m^2, or a list with one for each rotor", where)
    with located(where):
        return [Installed(1.0, area, mount.wake) for area in areas]


def _powertrain(file: _VehicleFile, where: str) -> Powertrain:
    motor = controller = battery = None
    if (given := file.motor) is not None:
        with located(f"{where}: [motor]"):
            motor = Motor(
                given.kv_rpm_per_volt * RPM,
                given.resistance,
                _several(given.no_load_current),
                _several(given.no_load_voltage),
                given.maximum_current,
                given.maximum_rpm * RPM,
                given.winding_temperature,
            )
    if file.esc is not None:
        with located(f"{where}: [esc]"):
            stated = {key: value for key, value in asdict(file.esc).items() if value is not None}
            controller = SpeedController(**stated)
    if (pack := file.battery) is not None:
        with located(f"{where}: [battery]"):
            battery = Battery(
                pack.cells,
                pack.capacity_mAh * 3.6,
                pack.resistance,
                pack.usable_share,
                pack.maximum_current,
                pack.auxiliary_power,
            )
    with located(where):
        return Powertrain(motor=motor, controller=controller, battery=battery)


# --- Conventions of flight logs in a vehicle file: frames, units, names of columns and topics ----

STATED = ("body_frame", "world_frame", "velocity_in", "rotor_unit")
"""Keys of ``[log]`` with frames and units, except ``throttle_range``."""
QUATERNION_COLUMNS = ("qw", "qx", "qy", "qz")
EULER_COLUMNS = ("roll", "pitch", "yaw")


@dataclass(frozen=True)
class LogMap:
    """Conventions of a vehicle's logs, from the table ``[log]`` of its file.

    None means that the file does not state the convention.  Logs of PX4 and ArduPilot are always in
    FRD and NED; their rotor speeds are in rpm unless "erpm" is stated.  The defaults for bags are
    FLU and ENU (REP 103), and the body frame for the velocity of an Odometry message.  All other
    conventions that a log needs must be stated.

    Attributes
    ----------
    body_frame : str or None
        Body frame of attitude, velocity, rates and specific force: "flu" or "frd".
    world_frame : str or None
        World frame of attitude and velocity: "enu" or "ned".
    velocity_in : str or None
        Frame of the velocity: "body" or "world".
    rotor_unit : str or None
        "rad/s", "rpm" or "erpm" (electrical).
    pole_pairs : int or None
        Number of pole pairs of the motors; required for "erpm".
    rotor_order : tuple of int or None
        Entry k is the number (from 1) of the vehicle's rotor in position k of the log.
    throttle_range : tuple of 2 float or None
        Motor commands at rest and at full throttle, for logs without rotor speeds.
    wind : tuple of 3 float
        Velocity of the air over the ground [m/s], in ``world_frame`` or, if that is not stated, in
        the world frame of the log.
    columns : mapping of str to tuple of str
        Column names by quantity, for CSV and Parquet files.
    topics : mapping of str to str
        Topic names by role, for bags.
    file : str
        Vehicle file, for messages.
    """

    body_frame: str | None = None
    world_frame: str | None = None
    velocity_in: str | None = None
    rotor_unit: str | None = None
    pole_pairs: int | None = None
    rotor_order: tuple[int, ...] | None = None
    throttle_range: tuple[float, float] | None = None
    wind: Vector = (0.0, 0.0, 0.0)
    columns: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    topics: Mapping[str, str] = field(default_factory=dict)
    file: str = "the vehicle file"

    @property
    def where(self) -> str:
        """File and table, for messages."""
        return f"{self.file}: [log]"

    def stated(self, key: str) -> Any:
        """Return the value of a ``key`` of ``STATED``; raise ``InputError`` if it is None."""
        value = getattr(self, key)
        if value is None:
            listed = example(get_type_hints(_Log, include_extras=True)[key])
            raise InputError(f"no {key}", f"add {key} = {listed}, as in the log", self.where)
        return value

    def rotor_factor(self, unit: str) -> float:
        """Return the factor from ``unit``, "rad/s", "rpm" or "erpm", to rad/s."""
        if unit == "rad/s":
            return 1.0
        if unit == "rpm":
            return RPM
        if self.pole_pairs is None:
            remedy = "add pole_pairs = half the number of the motor's magnets"
            raise InputError("rotor_unit is 'erpm', but pole_pairs is missing", remedy, self.where)
        return RPM / self.pole_pairs


def _log_map(log: _Log, rotors: int, where: str) -> LogMap:
    order, columns = log.rotor_order, asdict(log.columns)
    if order is not None and sorted(order) != list(range(1, rotors + 1)):
        raise InputError(
            f"rotor_order is {quoted(list(order))}, expected each number from 1 to {rotors} once",
            "for each rotor speed of the log, give the number of its [[rotors]] table",
            f"{where}: [log]",
        )
    for key in ("rotor_speed", "throttle"):
        named = len(columns[key])
        if named not in (0, rotors):
            found = f"{key} lists {named} columns, the vehicle has {rotors} rotors"
            remedy = "name one column per rotor, or add the missing [[rotors]] tables"
            raise InputError(found, remedy, f"{where}: [log.columns]")
    limits = log.throttle_range
    if limits is not None and not limits[0] < limits[1]:
        remedy = "give the commands at rest and at full throttle, such as [1000, 2000]"
        raise InputError(f"throttle_range is {quoted(list(limits))}", remedy, f"{where}: [log]")
    by_key = {
        key: (names,) if isinstance(names, str) else tuple(names)
        for key, names in columns.items()
        if names
    }
    topics = {role: topic for role, topic in asdict(log.topics).items() if topic}
    own = {"rotor_order": order or None, "columns": by_key, "topics": topics, "file": where}
    return LogMap(**asdict(log) | own)
