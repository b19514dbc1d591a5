"""What a vehicle file says about flight logs: frames, units, names of columns and topics."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from propmap.errors import InputError, quoted
from propmap.io.toml_table import TomlTable
from propmap.vehicle.vehicle import Vector

BODY_FRAMES = ("flu", "frd")
WORLD_FRAMES = ("enu", "ned")
VELOCITIES = ("body", "world")
ROTOR_UNITS = ("rad/s", "rpm", "erpm")

VECTOR_COLUMNS = ("velocity", "rates", "specific_force")
QUATERNION_COLUMNS = ("qw", "qx", "qy", "qz")
EULER_COLUMNS = ("roll", "pitch", "yaw")
COLUMNS = ("time", *VECTOR_COLUMNS, *QUATERNION_COLUMNS, *EULER_COLUMNS, "rotor_speed")
TOPICS = ("odometry", "pose", "velocity", "imu", "rotor_speed")
KEYS = (
    "body_frame",
    "world_frame",
    "velocity_in",
    "rotor_unit",
    "pole_pairs",
    "rotor_order",
    "wind",
    "columns",
    "topics",
)

RPM = math.pi / 30.0
"""[rad/s] per revolution per minute."""


@dataclass(frozen=True)
class LogMap:
    """The table ``[log]`` of a vehicle file.  None is "not stated".

    body_frame : "flu" or "frd"; world_frame : "enu" or "ned"; of attitude, velocity, rates and
        specific force in the log.  PX4 logs are in FRD and NED whatever is stated here, and
        bags in FLU and ENU (REP 103) unless stated; CSV and Parquet files must have them stated.
    velocity_in : "body" or "world", the frame of the velocity.  Bags: "body" for an Odometry
        message unless stated; to be stated for a TwistStamped and for CSV and Parquet files.
    rotor_unit : "rad/s", "rpm" or "erpm" (electrical); to be stated.  PX4 logs are in rpm, for
        which "erpm" may be stated where the motor controllers report that.
    pole_pairs : of the motors; needed for "erpm".
    rotor_order : entry k is the number (from 1) of the vehicle's rotor that the log shows k-th.
    wind : velocity of the air over the ground [m/s], in ``world_frame``, else in the log's own.
    columns : for CSV and Parquet files, quantity to names of columns.
    topics : for bags, role to the name of the topic.
    file : the vehicle file, for messages.
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
        """What is stated; ``InputError`` if nothing is.

        key : body_frame, world_frame, velocity_in or rotor_unit.
        """
        choices = {
            "body_frame": BODY_FRAMES,
            "world_frame": WORLD_FRAMES,
            "velocity_in": VELOCITIES,
            "rotor_unit": ROTOR_UNITS,
        }[key]
        value: str | None = getattr(self, key)
        if value is None:
            listed = " or ".join(f'"{choice}"' for choice in choices)
            raise InputError(f"no {key}", f"add {key} = {listed}, as it is in the log", self.where)
        return value

    def rotor_factor(self, unit: str) -> float:
        """[rad/s] per unit of rotor speed; unit : "rad/s", "rpm" or "erpm"."""
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


def read_log_map(table: TomlTable, rotors: int) -> LogMap:
    """The ``LogMap`` of the table ``[log]`` of a vehicle with so many ``rotors``."""
    return LogMap(
        body_frame=table.choice("body_frame", BODY_FRAMES) if "body_frame" in table else None,
        world_frame=table.choice("world_frame", WORLD_FRAMES) if "world_frame" in table else None,
        velocity_in=table.choice("velocity_in", VELOCITIES) if "velocity_in" in table else None,
        rotor_unit=table.choice("rotor_unit", ROTOR_UNITS) if "rotor_unit" in table else None,
        pole_pairs=_pole_pairs(table),
        rotor_order=_rotor_order(table, rotors),
        wind=table.vector("wind", "[east, north, up]") if "wind" in table else (0.0, 0.0, 0.0),
        columns=_columns(table.table("log.columns", COLUMNS), rotors),
        topics=_topics(table.table("log.topics", TOPICS)),
        file=table.where.partition(": [")[0],
    )


def _pole_pairs(table: TomlTable) -> int | None:
    if "pole_pairs" not in table:
        return None
    value = table.entries["pole_pairs"]
    if not isinstance(value, int) or isinstance(value, bool) or not 1 <= value <= 100:
        raise InputError(
            f"pole_pairs is {quoted(value)}, expected a whole number from 1 to 100",
            "give half the number of the motor's magnets",
            table.where,
        )
    return value


def _rotor_order(table: TomlTable, rotors: int) -> tuple[int, ...] | None:
    if "rotor_order" not in table:
        return None
    order = table.entries["rotor_order"]
    whole = isinstance(order, list) and all(type(number) is int for number in order)
    if not whole or sorted(order) != list(range(1, rotors + 1)):
        raise InputError(
            f"rotor_order is {quoted(order)}, expected each number from 1 to {rotors} once",
            "for each speed in the log, give the number of its [[rotors]] table",
            table.where,
        )
    return tuple(order)


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


def _topics(table: TomlTable) -> dict[str, str]:
    return {key: table.text(key, '"/the/name/of/a/topic"') for key in table.entries}
