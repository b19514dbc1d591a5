"""Readers of flight logs by file extension: CSV, Parquet, ULog of PX4, DataFlash, ROS bags."""

from __future__ import annotations

import contextlib
import csv
import difflib
import io
import itertools
import os
import struct
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError, quoted, require
from propmap.io.csv import SEPARATORS, has_decimal_commas, separator_of, too_many_fields
from propmap.typing import Floats
from propmap.units import MICROSECOND
from propmap.vehicle.dataflash import read_dataflash
from propmap.vehicle.files import EULER_COLUMNS, QUATERNION_COLUMNS, LogMap, VehicleFile
from propmap.vehicle.log import (
    FlightLog,
    Recording,
    Signal,
    flight_log,
    motor_slots,
    quaternion_of_angles,
)
from propmap.vehicle.throttle import PULSES, share_of_full, worth_of_throttle

# --- Flight logs as CSV or Parquet; the vehicle file contains their column names -----------------

MOST_SHOWN = 30  # largest number of columns listed in a message
MOST_SETTINGS = 1000  # number of lines of a file in which the header is searched
QUANTITIES = ("time", "velocity", "rates")
SUPPLY = ("battery_voltage", "hover_throttle")
OPTIONAL = ("specific_force", "air_speed", *SUPPLY)
BLACKBOX, BLACKBOX_VOLTAGE = "motor[", "vbatLatest (V)"
"""Start of the column names of motor commands, and column of the voltage, by blackbox_decode."""

DSHOT = (48.0, 2047.0)  # Betaflight's commands at rest and at full throttle, except for old ESCs


def read_csv_log(path: Path, log: LogMap) -> Recording:
    """Read a CSV file with a header line, or a Parquet file (``.parquet``, ``.pq``).

    The ``log`` map must state the frames and units, and the columns of:

    - ``time`` [s], ``velocity`` [m/s], ``rates`` [rad/s], optionally ``specific_force`` [m/s^2]
      and ``air_speed`` [m/s];
    - the attitude: ``qw, qx, qy, qz``, or ``roll, pitch, yaw`` [rad] (yaw about z, then pitch about
      y, then roll about x of the stated body frame);
    - ``rotor_speed``, or ``throttle`` with ``throttle_range`` and optionally ``battery_voltage``
      [V] or ``hover_throttle``; columns of blackbox_decode are found automatically.

    All dialects of ``propmap.io.csv`` are read; settings may precede the header.  A row with only
    empty cells in the columns of a quantity contains no sample of it; other empty cells count as
    invalid samples.  Raises ``InputError``, for example for text in a column of numbers.
    """
    where = str(path)
    log = _with_blackbox(path, log)
    turning = "throttle" if "throttle" in log.columns else "rotor_speed"
    angles, quaternion = (
        bool(set(names) & set(log.columns)) for names in (EULER_COLUMNS, QUATERNION_COLUMNS)
    )
    if angles and quaternion:
        found = "the attitude is given twice, as quaternion and as angles"
        raise InputError(found, "keep only one", f"{log.file}: [log.columns]")
    attitude = EULER_COLUMNS if angles else QUATERNION_COLUMNS
    wanted = [*QUANTITIES, turning, *OPTIONAL, *attitude]
    names = {key: log.columns[key] for key in wanted if key in log.columns}
    table = _table(path, where, {name for several in names.values() for name in several})
    unnamed = [key for key in wanted if key not in log.columns and key not in OPTIONAL]
    _check_columns(list(table.columns), names, unnamed, where, log)
    stated: dict[str, Any] = {
        key: log.stated(key) for key in ("body_frame", "world_frame", "velocity_in")
    }
    factor = 1.0 if turning == "throttle" else log.rotor_factor(log.stated("rotor_unit"))
    values = {
        key: np.stack([_numbers(table[name], name, where) for name in columns], axis=1)
        for key, columns in names.items()
    }
    time = values["time"][:, 0]

    def signal(key: str, array: Floats) -> Signal:
        # In one table of several topics, the cells of a topic are empty at the times of others.
        at = ~np.isnan(array).all(axis=1)
        return Signal(f"{key} ({', '.join(names.get(key, attitude))})", time[at], array[at])

    force = values.get("specific_force")
    supply = None
    if turning == "throttle":
        turned = as_share(signal(turning, values[turning]), log.stated("throttle_range"))
        supply = next(
            (as_supply(signal(key, values[key])) for key in SUPPLY if key in values), None
        )
    else:
        turned = signal(turning, values[turning] * factor)
    return Recording(
        source=where,
        attitude=signal("attitude", _quaternions([values[key][:, 0] for key in attitude], where)),
        velocity=signal("velocity", values["velocity"]),
        rates=signal("rates", values["rates"]),
        rotor_speed=turned,
        specific_force=None if force is None else signal("specific_force", force),
        commanded=turning == "throttle",
        supply=supply,
        air_speed=signal("air_speed", values["air_speed"]) if "air_speed" in values else None,
        **stated,
    )


def _with_blackbox(path: Path, log: LogMap) -> LogMap:
    """Return ``log`` with the columns of commands and voltage of a file of blackbox_decode."""
    if {"rotor_speed", "throttle"} & {*log.columns} or path.suffix.lower() != ".csv":
        return log
    heads = [head.strip().strip('"') for head in _head(path)[1].split(",")]
    found = {"throttle": tuple(head for head in heads if head.startswith(BLACKBOX))}
    found["battery_voltage"] = tuple(head for head in heads if head == BLACKBOX_VOLTAGE)
    if not found["throttle"]:
        return log
    more = {key: names for key, names in found.items() if names}
    return replace(log, columns={**more, **log.columns}, throttle_range=log.throttle_range or DSHOT)


def as_share(signal: Signal, limits: tuple[float, float]) -> Signal:
    """Return motor commands as fractions of full throttle, see ``share_of_full``."""
    return replace(signal, values=share_of_full(signal.values, limits, signal.name))


def as_supply(signal: Signal) -> Signal:
    """Return the scale of the throttle from a voltage, or from the throttle in hover."""
    inverse = signal.name.startswith("hover_throttle")
    return replace(signal, values=worth_of_throttle(signal.values, signal.name, inverse=inverse))


def _quaternions(columns: list[Floats], where: str) -> Floats:
    """Return quaternions (n, 4) from columns of quaternions or angles [rad]."""
    if len(columns) == len(QUATERNION_COLUMNS):
        return np.stack(columns, axis=1)
    largest = max(float(np.nanmax(np.abs(column), initial=0.0)) for column in columns)
    # Only yaw may be unwrapped over many turns.
    if float(np.nanmax(np.abs(columns[:2]), initial=0.0)) > 2.0 * np.pi:
        found = f"roll, pitch and yaw reach {largest:.4g}, probably in degrees"
        raise InputError(found, "convert these columns to radians", where)
    return quaternion_of_angles(*columns)


def _table(path: Path, where: str, wanted: Collection[str]) -> Any:
    """Load the file as a pandas data frame; cells of CSV files are text with decimal points."""
    import pandas as pd  # type: ignore[import-untyped]

    try:
        if path.suffix.lower() != ".csv":
            table = pd.read_parquet(path, engine="pyarrow")
            table.index = pd.RangeIndex(2, len(table) + 2)  # line 1 is the header
        else:
            table = _csv_table(path, where, wanted)
    except InputError:
        raise
    # pandas raises ValueErrors; pyarrow also raises OSErrors for damaged files.
    except (ValueError, OSError) as error:
        raise InputError(f"cannot be read: {error}", "export the log again", where) from None
    table.columns = [str(name).strip() for name in table.columns]
    return table


def _head(path: Path) -> tuple[int, str, str]:
    """Return the index of the header, the header and the next line.

    Blackbox Explorer writes settings above the header, with fewer fields.
    """
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        lines = [*itertools.islice(file, MOST_SETTINGS), "", ""]
    fields = [1 + max(map(line.count, SEPARATORS)) for line in lines]
    start = next(k for k, count in enumerate(fields) if 2 * count > np.median(fields))
    return start, lines[start], lines[start + 1]


def _csv_table(path: Path, where: str, wanted: Collection[str]) -> Any:
    import pandas as pd

    start, *head = _head(path)
    separator = separator_of(head[0].rstrip("\r\n"), wanted)
    # Spreadsheets may append empty fields to a row.  The number of columns is therefore the larger
    # one of the header and the next line.
    width = max(len(row) for row in csv.reader(head, delimiter=separator, skipinitialspace=True))
    # Blank lines are kept so that row numbers are line numbers.  The header is read as a row, since
    # pandas would rename duplicate columns.
    cells = pd.read_csv(
        path,
        sep=separator,
        skiprows=start,
        header=None,
        names=range(width),
        dtype=str,
        skipinitialspace=True,
        skip_blank_lines=False,
        encoding="utf-8-sig",
    )
    if cells.empty:
        raise InputError("no line is readable: a quote may be open", "export the log again", where)
    cells.index += start + 1  # line numbers
    named = int(np.flatnonzero(cells.iloc[0].notna()).max(initial=-1)) + 1
    beyond = np.flatnonzero(cells.iloc[:, named:].notna().any(axis=1))
    if beyond.size:
        raise too_many_fields(width, named, separator, f"{where}, line {cells.index[beyond[0]]}")
    table = cells.iloc[1:, :named].set_axis(cells.iloc[0, :named], axis=1)
    _use_points(table, separator, where, wanted)
    return table


def _use_points(table: Any, separator: str, where: str, wanted: Collection[str]) -> None:
    """Convert decimal commas in the columns ``wanted``, unless commas separate the columns."""
    if separator == ",":
        return
    places = [k for k, name in enumerate(table.columns) if str(name).strip() in wanted]
    marked = []
    for k in places:
        column = table.iloc[:, k]
        some = column[column.str.contains("[.,]", na=False)]
        marked += [(int(line), cell.strip()) for line, cell in some.items()]
    if has_decimal_commas(marked, separator, where):
        for k in places:
            table.isetitem(k, table.iloc[:, k].str.replace(",", ".", regex=False))


def _check_columns(
    present: list[str],
    names: dict[str, tuple[str, ...]],
    unnamed: list[str],
    where: str,
    log: LogMap,
) -> None:
    """Raise ``InputError`` for keys that are ``unnamed`` in [log.columns], and for columns in
    ``names`` that are missing from the file or not unique."""
    wanted = {name: key for key, columns in names.items() for name in columns}
    missing = [name for name in wanted if name not in present]
    twice = [name for name in wanted if present.count(name) > 1]
    kinds = (unnamed, "keys without a column"), (missing, "missing columns")
    found = [
        f"{what}: {', '.join(map(quoted, some))}"
        for some, what in (*kinds, (twice, "repeated columns"))
        if some
    ]
    if not found:
        return
    close = [difflib.get_close_matches(name, present, n=1) for name in missing]
    meant = ", ".join(map(repr, itertools.chain(*close)))
    keys = ", ".join(dict.fromkeys([*unnamed, *(wanted[name] for name in (*missing, *twice))]))
    raise InputError(
        f"{'; '.join(found)}; the file has {', '.join(present[:MOST_SHOWN])}"
        f"{', ...' if len(present) > MOST_SHOWN else ''}",
        (f"did you mean {meant}? " if meant else "")
        + f"correct {keys} in [log.columns] of {log.file}",
        where,
    )


def _numbers(column: Any, name: str, where: str) -> Floats:
    """Return a column of a data frame as float64, NaN for empty cells; refuse text."""
    import pandas as pd

    numbers = pd.to_numeric(column, errors="coerce")
    values: Floats = numbers.to_numpy(dtype=np.float64, na_value=np.nan)
    text = np.flatnonzero(np.isnan(values) & column.notna().to_numpy())
    if text.size:
        row = int(text[0])
        found = f"{quoted(column.iloc[row])} is not a number"  # pandas reads "nan" as an empty cell
        remedy = "give a number with a decimal point, or leave the cell empty"
        raise InputError(found, remedy, f"{where}, line {column.index[row]}, column {name}")
    return values


# --- Flight logs of PX4: ULog files, in FRD and NED ----------------------------------------------


# Topics and fields by quantity; the reader uses the first topic that the log contains.
ATTITUDE = {"vehicle_attitude": [f"q[{k}]" for k in range(4)]}
VELOCITY = {"vehicle_local_position": ["vx", "vy", "vz"]}
VALID = ("v_xy_valid", "v_z_valid")
"""Flags of vehicle_local_position for a valid velocity."""

RATES = {
    "vehicle_angular_velocity": [f"xyz[{k}]" for k in range(3)],
    "sensor_combined": [f"gyro_rad[{k}]" for k in range(3)],
}
SPECIFIC_FORCE = {
    "vehicle_acceleration": [f"xyz[{k}]" for k in range(3)],
    "sensor_combined": [f"accelerometer_m_s2[{k}]" for k in range(3)],
}
ROTORS = "esc_status"
COMMANDS, OUTPUTS, BATTERY = "actuator_motors", "actuator_outputs", "battery_status"
"""Topics used without esc_status: motor commands from 0 to 1, outputs as pulses, battery."""

LIMITS = tuple((f"{kind}_MIN", f"{kind}_MAX") for kind in ("PWM_MAIN", "PWM_AUX", "PWM"))
"""Parameters with the pulses at rest and at full throttle.  The first two pairs are followed by the
output number; the last pair is from before PX4 1.13."""

ACCELEROMETER_LATE, NOT_SAMPLED = "accelerometer_timestamp_relative", 2**31 - 1
"""Field of sensor_combined with the accelerometer's time relative to the time stamp [us], and value
of this field without an accelerometer sample: PX4's SensorCombined.msg."""

MOTORS = {100 + number: number for number in range(1, 13)}
"""Motor number by ``actuator_function`` in PX4's EscReport.msg."""

FUNCTIONS = ("UAVCAN_EC_FUNC", "PWM_MAIN_FUNC", "PWM_AUX_FUNC")
"""Parameters with the function of an output, followed by the output number."""

TURNING = (ROTORS, COMMANDS, OUTPUTS)
TOPICS = sorted({*ATTITUDE, *VELOCITY, *RATES, *SPECIFIC_FORCE, *TURNING, BATTERY})


MAGIC, HEADER = b"ULog\x01\x12\x35", 16  # first bytes and size of the header of a ULog file
DEFINING, FIRST_DATA = b"BFIMPQ", b"ALC"  # types of the definitions and of the next message
AS_LOGGED = "give the original .ulg file of the flight controller"


def read_ulog(path: Path, log: LogMap) -> Recording:
    """Read a ULog file of PX4.

    - Attitude: vehicle_attitude.
    - Velocity: vehicle_local_position; samples that are marked as invalid are left out.
    - Rates: vehicle_angular_velocity, or sensor_combined.
    - Specific force, optional: vehicle_acceleration, or sensor_combined.
    - Rotor speeds: esc_status, whose ``esc_rpm`` is in rpm unless the ``log`` map specifies "erpm".
      If the log assigns controllers to motors, only assigned controllers are read, by motor number.
    - Without esc_status: the commands of actuator_motors, or actuator_outputs, with the voltage of
      battery_status.

    Times are the times of measurement if the log contains them.  The frames are always FRD and NED.
    """
    file = parsed_ulog(path)
    unit = "erpm" if log.rotor_unit == "erpm" else "rpm"
    source = f"{path} (damaged parts skipped)" if file.file_corruption else str(path)
    missing = [
        " or ".join(topics)
        for topics in ([*ATTITUDE], [*VELOCITY], [*RATES], [*TURNING])
        if not any(_dataset(file, topic) for topic in topics)
    ]
    if missing:
        present = sorted({data.name for data in file.data_list}) or ["no required topic"]
        raise InputError(
            f"no topic {', no '.join(missing)}; found {', '.join(present)}",
            "log the missing topics (see SDLOG_PROFILE of PX4); esc_status requires motor "
            "controllers with telemetry",
        )
    commanded = _dataset(file, ROTORS) is None
    notes: tuple[str, ...] = ()
    if commanded:
        rotor_speed = _ulog_commands(file, log.throttle_range)
    else:
        rotor_speed, notes = _ulog_rotor_speed(file, log.rotor_factor(unit))
    voltage = commanded and _dataset(file, BATTERY) is not None
    return Recording(
        source=source,
        body_frame="frd",
        world_frame="ned",
        velocity_in="world",
        attitude=_signal(file, "attitude", ATTITUDE),
        velocity=_signal(file, "velocity", VELOCITY),
        rates=_signal(file, "rates", RATES),
        rotor_speed=rotor_speed,
        specific_force=(
            _signal(file, "specific force", SPECIFIC_FORCE)
            if any(_dataset(file, topic) for topic in SPECIFIC_FORCE)
            else None
        ),
        commanded=commanded,
        supply=(as_supply(_signal(file, "voltage", {BATTERY: ["voltage_v"]})) if voltage else None),
        notes=notes,
    )


def parsed_ulog(path: Path) -> Any:
    """Return the object of pyulog for a ULog file, with the required topics.

    Raises ``InputError`` if the file cannot be read.
    """
    from pyulog import ULog

    with path.open("rb") as file:
        _check_definitions(file, path.stat().st_size)
        file.seek(0)
        try:
            # pyulog prints messages about damaged parts, but ``file_corruption`` suffices.
            with contextlib.redirect_stdout(io.StringIO()):
                return ULog(file, TOPICS)
        # Damaged bytes make the parser of pyulog raise undocumented exceptions.
        except Exception as error:
            found = f"not a ULog file: {str(error) or type(error).__name__}"
            raise InputError(found, AS_LOGGED) from None


def _check_definitions(file: Any, size: int) -> None:
    """Raise ``InputError`` for damaged definitions at the beginning of a ULog file of ``size``
    bytes.  pyulog 1.3 never returns if a definition extends beyond the end of the file."""
    if not file.read(HEADER).startswith(MAGIC):
        raise InputError("not a ULog file: the first bytes are wrong", AS_LOGGED)
    kind, at = 0, HEADER
    while kind not in FIRST_DATA and at < size:
        file.seek(at)
        length, kind = struct.unpack("<HB", file.read(3).ljust(3, b"\0"))
        if at + 3 + length > size or kind not in DEFINING + FIRST_DATA:
            found = f"a damaged ULog file: no complete definition begins at byte {at} of {size}"
            raise InputError(found, AS_LOGGED)
        at += 3 + length


def _dataset(file: Any, topic: str) -> Any:
    """Return the first instance of a topic with samples, or None."""
    found = [data for data in file.data_list if data.name == topic and len(data.data["timestamp"])]
    return min(found, key=lambda data: data.multi_id) if found else None


def _signal(file: Any, name: str, sources: dict[str, list[str]]) -> Signal:
    """Return the samples of the first topic in ``sources`` that the log contains."""
    topic = next(topic for topic in sources if _dataset(file, topic))
    data, fields = _dataset(file, topic), sources[topic]
    values = np.stack([_field(data, topic, field) for field in fields], axis=1)
    valid = _valid(data, name, topic)
    return Signal(f"{name} ({topic})", _time(data, fields[0])[valid], values[valid])


def _valid(data: Any, name: str, topic: str) -> NDArray[np.bool_]:
    """Return a mask (n,) of the samples of a topic that the log does not mark as invalid."""
    stamps = data.data["timestamp"]
    flags = [data.data[flag] for flag in VALID if flag in data.data]
    late = data.data.get(ACCELEROMETER_LATE)
    if late is not None and name == "specific force":
        flags.append(late != NOT_SAMPLED)
    valid = np.all([np.ones(stamps.size, dtype=np.bool_), *flags], axis=0)
    if not valid.any():
        raise InputError(
            f"{topic} marks all {stamps.size} samples of its {name} as not valid",
            "fly with a velocity estimate, from GPS, optical flow or motion capture",
        )
    return np.asarray(valid)


def _ulog_rotor_speed(file: Any, factor: float) -> tuple[Signal, tuple[str, ...]]:
    """Return the motor speeds, and a note on slots that are left out."""
    data = _dataset(file, ROTORS)
    count = int(np.max(_field(data, ROTORS, "esc_count")))
    columns = [_field(data, ROTORS, f"esc[{k}].esc_rpm") for k in range(count)]
    if not columns:
        found = "esc_count of topic esc_status is 0: no motor controller reports its speed"
        remedy = "fly with controllers that report rpm, by DShot telemetry or UAVCAN"
        raise InputError(found, remedy)
    logged = [data.data.get(f"esc[{k}].actuator_function", np.zeros(1)) for k in range(count)]
    own = motor_slots([int(np.median(values)) for values in logged], MOTORS)
    slots = own or next(filter(None, _slots_stated(file, count)), None)
    notes: tuple[str, ...] = ()
    if slots and len(slots) < count:
        left = ", ".join(str(k + 1) for k in range(count) if k not in slots)
        notes = (
            f"{ROTORS} has {count} slots; those of motors 1 to {len(slots)} are read; slots "
            f"of no motor are left out: {left}",
        )
    speeds = np.stack(columns, axis=1)[:, slots or [*range(count)]]
    return Signal(f"rotor speed ({ROTORS})", _time(data), speeds * factor), notes


def _ulog_commands(file: Any, limits: tuple[float, float] | None) -> Signal:
    """Return the motor commands as fractions of full throttle."""
    data = _dataset(file, COMMANDS)
    if data:
        columns = _numbered(data, "control")
        # PX4 logs NaN for motors that are not armed, and for motors that do not exist.
        slots = [k for k, column in enumerate(columns) if np.isfinite(column).any()]
        limits = limits or (0.0, 1.0)
    else:
        outputs = [one for one in file.data_list if one.name == OUTPUTS]
        for data in sorted(outputs, key=lambda one: int(one.multi_id)):
            columns = _numbered(data, "output")
            moving = [k for k, column in enumerate(columns) if np.ptp(column)]
            slots = next(filter(None, _slots_stated(file, len(columns))), moving)
            if moving and {*slots} <= {*moving}:
                break
        limits = limits or _pulses(file.initial_parameters, slots[0] + 1 if slots else 1)
    topic = data.name
    values = np.stack([columns[k] for k in slots or range(len(columns))], axis=1)
    return as_share(Signal(f"throttle ({topic})", _time(data), values), limits)


def _numbered(data: Any, field: str) -> list[Floats]:
    """Return the columns of an array in a topic."""
    names = [name for name in data.data if name.startswith(f"{field}[")]
    return [np.asarray(data.data[name], dtype=np.float64) for name in names]


def _slots_stated(file: Any, count: int) -> Iterator[list[int] | None]:
    """Yield, for each kind of parameters, which of the ``count`` outputs drive motors."""
    stated = file.initial_parameters
    for name in FUNCTIONS:
        functions = [int(stated.get(f"{name}{k + 1}", 0)) for k in range(count)]
        yield motor_slots(functions, MOTORS)


def _pulses(stated: Mapping[str, float], output: int) -> tuple[float, float]:
    """Return the pulses at rest and at full throttle [us] from the parameters of an ``output``."""
    ends = [
        [float(stated.get(f"{name}{output}", stated.get(name, 0.0))) for name in pair]
        for pair in LIMITS
    ]
    return next(((low, high) for low, high in ends if high > low), PULSES)


def _time(data: Any, field: str = "") -> Floats:
    """Return the times at which a ``field`` was measured, (n,) [s].

    If the log does not contain them, return the times at which it was published.
    """
    stamps = data.data["timestamp"]
    measured = data.data.get("timestamp_sample", stamps)
    time = np.where(measured > 0, measured, stamps).astype(np.float64)
    if field.startswith("accelerometer") and ACCELEROMETER_LATE in data.data:
        time += data.data[ACCELEROMETER_LATE]
    return np.asarray(time * MICROSECOND)


def _field(data: Any, topic: str, field: str) -> Floats:
    if field not in data.data:
        found = f"topic {topic} has no field {field}, it has {', '.join(data.data)}"
        raise InputError(found, "give a log of PX4 1.11 or later")
    with np.errstate(invalid="ignore"):  # damaged bytes may be signaling NaN
        return np.asarray(data.data[field], dtype=np.float64)


# --- Flight logs of ROS: bags of ROS 1 (.bag) and ROS 2 (folder, .db3, .mcap) --------------------

TYPES = {
    "odometry": "nav_msgs/msg/Odometry",
    "pose": "geometry_msgs/msg/PoseStamped",
    "velocity": "geometry_msgs/msg/TwistStamped",
    "imu": "sensor_msgs/msg/Imu",
    "battery": "sensor_msgs/msg/BatteryState",
}
"""Message type by role of a topic."""

ROTOR_FIELDS = {
    "std_msgs/msg/Float64MultiArray": "data",
    "std_msgs/msg/Float32MultiArray": "data",
    "sensor_msgs/msg/JointState": "velocity",
    "mav_msgs/msg/Actuators": "angular_velocities",
    "actuator_msgs/msg/Actuators": "velocity",
}
"""Field with the rotor speeds by message type; in other types, the only array of numbers."""

Extract = Callable[[Any], list[float]]


def read_rosbag(path: Path, log: LogMap) -> Recording:
    """Read the topics in ``[log.topics]`` from a bag.

    - ``odometry`` (nav_msgs/Odometry), or ``pose`` (geometry_msgs/PoseStamped) and ``velocity``
      (geometry_msgs/TwistStamped).
    - ``rotor_speed`` (an array of numbers, see ``ROTOR_FIELDS``), or ``throttle`` (an array of
      motor commands) and optionally ``battery`` (sensor_msgs/BatteryState).
    - Optionally ``imu`` (sensor_msgs/Imu) for rates and specific force.  Without it, the rates are
      from the odometry or twist, and the specific force is unknown.

    Times are those of the headers, or times of recording for messages without a header.
    """
    topics = log.topics
    turning = "throttle" if "throttle" in topics else "rotor_speed"
    if turning not in topics or not ("odometry" in topics or {"pose", "velocity"} <= {*topics}):
        found = "a bag needs the topics odometry (or pose and velocity) and rotor_speed (or "
        found += "throttle)"
        remedy = 'add [log.topics] with odometry = "/...", imu = "/...", rotor_speed = "/..."'
        raise InputError(found, remedy, log.where)
    read = _messages(path, log)
    odometry = "odometry" in topics
    velocity_in = (log.velocity_in or "body") if odometry else log.stated("velocity_in")
    twist_role = "odometry" if odometry else "velocity"
    if "imu" not in topics and velocity_in == "world":
        found = "the twist is in the world frame, and no topic has rates about body axes"
        raise InputError(found, 'add imu = "/..." to [log.topics]', log.where)

    def signal(name: str, role: str, extract: Extract) -> Signal:
        time, messages = read[role]
        rows = [extract(message) for message in messages]
        return Signal(f"{name} (topic {topics[role]})", time, np.array(rows, dtype=np.float64))

    def twist(message: Any) -> Any:
        return message.twist.twist if odometry else message.twist

    def orientation(message: Any) -> list[float]:
        pose = message.pose.pose if odometry else message.pose
        q = pose.orientation
        return [q.w, q.x, q.y, q.z]

    imu = "imu" in topics
    commanded = turning == "throttle"
    factor = 1.0 if commanded else log.rotor_factor(log.stated("rotor_unit"))
    turned = _bag_rotor_speed(
        *read[turning], factor, f"{turning.replace('_', ' ')} (topic {topics[turning]})"
    )
    return Recording(
        source=str(path),
        body_frame=log.body_frame or "flu",
        world_frame=log.world_frame or "enu",
        velocity_in=velocity_in,
        attitude=signal("attitude", "odometry" if odometry else "pose", orientation),
        velocity=signal("velocity", twist_role, lambda m: _xyz(twist(m).linear)),
        rates=(
            signal("rates", "imu", lambda m: _xyz(m.angular_velocity))
            if imu
            else signal("rates", twist_role, lambda m: _xyz(twist(m).angular))
        ),
        rotor_speed=as_share(turned, log.stated("throttle_range")) if commanded else turned,
        specific_force=(
            signal("specific force", "imu", lambda m: _xyz(m.linear_acceleration)) if imu else None
        ),
        commanded=commanded,
        supply=(
            as_supply(signal("voltage", "battery", lambda m: [m.voltage]))
            if commanded and "battery" in topics
            else None
        ),
    )


def _xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def _messages(path: Path, log: LogMap) -> dict[str, tuple[Floats, list[Any]]]:
    """Return times [s] and messages of the topics in ``log``, by role."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    try:
        # Old bags of ROS 2 do not contain the definitions of their messages.
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as bag:
            present = {c.topic: _short(c.msgtype) for c in bag.connections}
            missing = {r: topic for r, topic in log.topics.items() if topic not in present}
            if missing:
                listed = ", ".join(f"{topic} ({present[topic]})" for topic in sorted(present))
                found = f"no topic {', no '.join(missing.values())}; the bag has {listed or 'none'}"
                remedy = f"correct {', '.join(missing)} in [log.topics] of {log.file}"
                raise InputError(found, remedy)
            return {role: _topic(bag, role, topic) for role, topic in log.topics.items()}
    except InputError:
        raise
    # Damaged bytes make the SQLite, MCAP and YAML parsers raise undocumented exceptions.
    except Exception as error:
        found = f"not a readable bag: {str(error) or type(error).__name__}"
        remedy = "give a ROS 1 .bag, a ROS 2 folder with metadata.yaml, or an .mcap file"
        raise InputError(found, remedy) from None


def _topic(bag: Any, role: str, topic: str) -> tuple[Floats, list[Any]]:
    connections = [c for c in bag.connections if c.topic == topic]
    wanted, found = TYPES.get(role), connections[0].msgtype
    if wanted not in (None, found):
        fault = f"topic {topic} is of type {_short(found)}, expected {_short(str(wanted))}"
        raise InputError(fault, f"give a topic of this type as {role} in [log.topics]")
    times, messages = [], []
    for connection, recorded, data in bag.messages(connections):
        message = bag.deserialize(data, connection.msgtype)
        header = getattr(message, "header", None)
        stamp = 0.0 if header is None else header.stamp.sec + header.stamp.nanosec * 1e-9
        times.append(stamp or recorded * 1e-9)
        messages.append(message)
    return np.array(times, dtype=np.float64), messages


def _bag_rotor_speed(time: Floats, messages: list[Any], factor: float, name: str) -> Signal:
    """Return rotor speeds [rad/s]; ``factor`` converts from the unit of the log."""
    if not messages:
        return Signal(name, time, np.empty((0, 0)))
    kind: str = messages[0].__msgtype__
    field = ROTOR_FIELDS.get(kind)
    if field is None:
        fields = messages[0].__dataclass_fields__
        arrays = [one for one in fields if isinstance(getattr(messages[0], one), np.ndarray)]
        if len(arrays) != 1:
            found = f"{len(arrays)} arrays of numbers, expected 1"
            remedy = f"record the speeds as one of {', '.join(map(_short, ROTOR_FIELDS))}"
            raise InputError(f"{name} is of type {_short(kind)} with {found}", remedy)
        field = arrays[0]
    rows = [np.asarray(getattr(message, field), dtype=np.float64).ravel() for message in messages]
    lengths = sorted({row.size for row in rows})
    if len(lengths) > 1:
        fault = f"messages of {name} have {lengths[0]} to {lengths[-1]} values"
        raise InputError(fault, "record one value per rotor in every message")
    return Signal(name, time, np.stack(rows) * factor)


def _short(kind: str) -> str:
    """Return a message type in the notation of ROS 1."""
    return kind.replace("/msg/", "/")


# --- Choice of the reader by file extension ------------------------------------------------------

READERS: dict[str, Callable[[Path, LogMap], Recording]] = {
    ".csv": read_csv_log,
    ".parquet": read_csv_log,
    ".pq": read_csv_log,
    ".ulg": read_ulog,
    ".bin": read_dataflash,
    ".bag": read_rosbag,
    ".db3": read_rosbag,
    ".mcap": read_rosbag,
}
"""Readers by file extension; a folder is a bag of ROS 2."""


def read_flight_log(
    path: str | os.PathLike[str], vehicle_file: VehicleFile, *, rate: float | None = None
) -> FlightLog:
    """Read a flight log: CSV, Parquet, ULog of PX4, DataFlash of ArduPilot, or ROS bag.

    Signals are interpolated linearly to common times; faster signals are low-passed first.  Gaps
    above 0.25 s are cut out.  Invalid samples are dropped and counted in ``source``; a log with
    many invalid samples is refused.

    Parameters
    ----------
    path : path
        Path of the file, or the folder of a ROS 2 bag.
    vehicle_file : VehicleFile
        Vehicle and conventions of the log.
    rate : float, optional
        Samples per second [1/s].  By default the log has the sample times of the slowest of
        attitude, velocity and rotor speed.

    Raises
    ------
    InputError
        For a log that cannot be read, or that does not fit the vehicle.
    """
    return flight_log(read_recording(path, vehicle_file), vehicle_file, rate)


def read_recording(path: str | os.PathLike[str], vehicle_file: VehicleFile) -> Recording:
    """Read the signals of a flight log with their own times and frames.

    Raises ``InputError`` if the log cannot be read.
    """
    file = Path(path)
    where = str(file)
    try:
        folder, there = file.is_dir(), file.exists()
        empty = file.is_file() and file.stat().st_size == 0
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read: {error}", "check the path", where) from None
    if not there:
        raise InputError("no such file", "check the path", where)
    if empty:
        raise InputError("the file is empty", "give the log of a flight", where)
    kind = file.suffix.lower()
    if not folder and kind not in READERS:
        found = f"the file extension is {kind!r}, expected one of {', '.join(READERS)}"
        remedy = "give a log of one of these types, or the folder of a ROS 2 bag"
        raise InputError(found, remedy, where)
    if folder and not (file / "metadata.yaml").exists():
        fault = "this folder has no metadata.yaml, expected a ROS 2 bag"
        raise InputError(fault, "give a file of this folder, or the folder of a bag", where)
    require("parquet" if kind in (".parquet", ".pq") else "logs")
    try:
        return (read_rosbag if folder else READERS[kind])(file, vehicle_file.log)
    except InputError as error:
        raise InputError(error.found, error.remedy, error.where or where) from None
