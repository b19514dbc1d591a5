"""What a vehicle file says about flight logs: frames, units, names of columns and topics."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields

from propmap.errors import InputError
from propmap.io.toml_table import TomlTable
from propmap.vehicle.vehicle import Vector

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
RPM = math.pi / 30.0
"""One revolution per minute [rad/s]."""


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


KEYS = tuple(f.name for f in fields(LogMap) if f.name != "file")
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
