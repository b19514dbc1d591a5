"""Flight logs of PX4: ULog files, in FRD and NED."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.typing import Floats
from propmap.vehicle.log_map import LogMap
from propmap.vehicle.logs.recording import Recording, Signal

MICROSECOND = 1e-6

ATTITUDE = {"vehicle_attitude": [f"q[{k}]" for k in range(4)]}
VELOCITY = {"vehicle_local_position": ["vx", "vy", "vz"]}
VALID = ("v_xy_valid", "v_z_valid")
"""Flags of vehicle_local_position that say whether its velocity is known."""

RATES = {
    "vehicle_angular_velocity": [f"xyz[{k}]" for k in range(3)],
    "sensor_combined": [f"gyro_rad[{k}]" for k in range(3)],
}
SPECIFIC_FORCE = {
    "vehicle_acceleration": [f"xyz[{k}]" for k in range(3)],
    "sensor_combined": [f"accelerometer_m_s2[{k}]" for k in range(3)],
}
ROTORS = "esc_status"
"""Topics and fields per quantity; the first topic that the log has is used."""

ACCELEROMETER_LATE, NOT_SAMPLED = "accelerometer_timestamp_relative", 2**31 - 1
"""Field of sensor_combined with the time from its stamp to that of the accelerometer [us], and what
it holds where there is none: PX4's SensorCombined.msg."""

FIRST_MOTOR = 101
"""``actuator_function`` of motor 1 in PX4's EscReport.msg; that of motor k is k - 1 more."""

TOPICS = sorted({*ATTITUDE, *VELOCITY, *RATES, *SPECIFIC_FORCE, ROTORS})


def read_ulog(path: Path, log: LogMap) -> Recording:
    """A ULog file with the topics of PX4.

    vehicle_attitude, vehicle_local_position, vehicle_angular_velocity (else sensor_combined),
    vehicle_acceleration (else sensor_combined, else none) and esc_status, whose ``esc_rpm`` is
    in rpm unless the ``log`` map says "erpm", and which are in the order of PX4's motors where the
    log says which controller turns which.  Times are those of the measurement where logged.
    Velocities that the log marks as not valid are left out.
    Frames are PX4's, FRD and NED, whatever the map says.  Raises ``InputError``.
    """
    where = str(path)
    file = _parsed(path, where)
    unit = "erpm" if log.rotor_unit == "erpm" else "rpm"
    rates = _signal(file, "rates", RATES, where)
    source = f"{where} (damaged parts skipped)" if file.file_corruption else where
    return Recording(
        source=source,
        body_frame="frd",
        world_frame="ned",
        velocity_in="world",
        attitude=_signal(file, "attitude", ATTITUDE, where),
        velocity=_signal(file, "velocity", VELOCITY, where),
        rates=rates,
        rotor_speed=_rotor_speed(file, log.rotor_factor(unit), where),
        specific_force=(
            _signal(file, "specific force", SPECIFIC_FORCE, where)
            if any(_dataset(file, topic) for topic in SPECIFIC_FORCE)
            else None
        ),
    )


def _parsed(path: Path, where: str) -> Any:
    from pyulog import ULog

    try:
        # pyulog prints what it finds damaged; ``file_corruption`` says it too.
        with path.open("rb") as file, contextlib.redirect_stdout(io.StringIO()):
            return ULog(file, TOPICS)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", "check the path", where) from None
    # Damaged bytes make its parser fail in ways that it does not list.
    except Exception as error:
        raise InputError(
            f"not a ULog file: {error or type(error).__name__}",
            "give the .ulg file as the flight controller wrote it",
            where,
        ) from None


def _dataset(file: Any, topic: str) -> Any:
    """The first instance of a topic with samples, or None."""
    found = [data for data in file.data_list if data.name == topic and len(data.data["timestamp"])]
    return min(found, key=lambda data: data.multi_id) if found else None


def _signal(file: Any, name: str, sources: dict[str, list[str]], where: str) -> Signal:
    for topic, fields in sources.items():
        data = _dataset(file, topic)
        if data is not None:
            columns = [_field(data, topic, field, where) for field in fields]
            values = np.stack(columns, axis=1)
            valid = _valid(data, name, topic, where)
            return Signal(f"{name} ({topic})", _time(data, fields[0])[valid], values[valid])
    raise _missing(file, " or ".join(sources), where)


def _valid(data: Any, name: str, topic: str, where: str) -> NDArray[np.bool_]:
    """Which samples (n,) of a topic the log does not mark as unknown."""
    stamps = data.data["timestamp"]
    flags = [data.data[flag] for flag in VALID if flag in data.data]
    late = data.data.get(ACCELEROMETER_LATE)
    if late is not None and name == "specific force":
        flags.append(late != NOT_SAMPLED)
    valid = np.all([np.ones(stamps.size, dtype=np.bool_), *flags], axis=0)
    if not valid.any():
        raise InputError(
            f"{topic} marks all {stamps.size} samples of its {name} as not valid",
            "fly where the autopilot knows its velocity: with GPS, optical flow or motion capture",
            where,
        )
    return np.asarray(valid)


def _rotor_speed(file: Any, factor: float, where: str) -> Signal:
    data = _dataset(file, ROTORS)
    if data is None:
        raise _missing(file, ROTORS, where)
    count = int(np.max(_field(data, ROTORS, "esc_count", where)))
    columns = [_field(data, ROTORS, f"esc[{k}].esc_rpm", where) for k in range(count)]
    if not columns:
        raise InputError(
            "esc_count of topic esc_status is 0: no motor controller reports its speed",
            "fly with controllers that report rpm, by DShot telemetry or UAVCAN",
            where,
        )
    speeds = np.stack(columns, axis=1)[:, _by_motor(data, count)]
    return Signal(f"rotor speed ({ROTORS})", _time(data), speeds * factor)


def _by_motor(data: Any, count: int) -> list[int]:
    """Places of motors 1 to ``count`` among the controllers, where the log tells them all."""
    fields = [f"esc[{k}].actuator_function" for k in range(count)]
    told = [int(np.median(data.data[field])) for field in fields if field in data.data]
    motors = [FIRST_MOTOR + k for k in range(count)]
    return [told.index(motor) for motor in motors] if sorted(told) == motors else [*range(count)]


def _time(data: Any, field: str = "") -> Floats:
    """[s]; (n,): of the measurement of a ``field`` where the topic says it, else of publication."""
    stamps = data.data["timestamp"]
    measured = data.data.get("timestamp_sample", stamps)
    time = np.where(measured > 0, measured, stamps).astype(np.float64)
    if field.startswith("accelerometer") and ACCELEROMETER_LATE in data.data:
        time += data.data[ACCELEROMETER_LATE]
    return np.asarray(time * MICROSECOND)


def _field(data: Any, topic: str, field: str, where: str) -> Floats:
    if field not in data.data:
        raise InputError(
            f"topic {topic} has no field {field}, it has {', '.join(data.data)}",
            "give a log of PX4 1.11 or later",
            where,
        )
    return np.asarray(data.data[field], dtype=np.float64)


def _missing(file: Any, topic: str, where: str) -> InputError:
    # Topics that are not of use here are not parsed, but the log names their formats.
    present = sorted({data.name for data in file.data_list}) or ["no topic of use"]
    return InputError(
        f"no topic {topic}; found {', '.join(present)}",
        "log it: see SDLOG_PROFILE of PX4, and for esc_status motor controllers with telemetry "
        "(actuator_motors and actuator_outputs are commands, no speeds)",
        where,
    )
