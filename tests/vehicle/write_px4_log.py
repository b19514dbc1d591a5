"""A ULog file as PX4 1.15 and 1.16 write it: whole topics, each at its own rate.

By the published format, https://docs.px4.io/v1.16/en/dev_log/ulog_file_format.html, and the fields
of PX4's msg/*.msg of those releases, sorted by size as uORB does, with its padding.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np

from propmap.typing import Floats
from propmap.vehicle.log import FlightLog
from propmap.vehicle.vehicle import Vehicle
from tests.flight.commands import Commands

from .write_logs import FLIP, RPM, InFrames

C_TYPES = {
    "u8": "uint64_t",
    "u4": "uint32_t",
    "u2": "uint16_t",
    "u1": "uint8_t",
    "i4": "int32_t",
    "i1": "int8_t",
    "f8": "double",
    "f4": "float",
    "?": "bool",
}
Field = tuple[str, str, int]
"""Name, NumPy's type, and how many."""


def _fields(text: str) -> list[Field]:
    """Fields of "type name", "type[3] name", ..., separated by semicolons."""
    found = []
    for part in text.split(";"):
        kind, name = part.split()
        base, _, count = kind.rstrip("]").partition("[")
        found.append((name, base, int(count or 1)))
    return found


ESC_REPORT = _fields(
    "u8 timestamp;u4 esc_errorcount;i4 esc_rpm;f4 esc_voltage;f4 esc_current;f4 esc_temperature;"
    "u2 failures;u1 esc_address;u1 esc_cmdcount;u1 esc_state;u1 actuator_function;i1 esc_power;"
    "u1[5] _padding0"
)
TOPICS = {
    "vehicle_attitude": _fields(
        "u8 timestamp;u8 timestamp_sample;f4[4] q;f4[4] delta_q_reset;u1 quat_reset_counter"
    ),
    "vehicle_angular_velocity": _fields(
        "u8 timestamp;u8 timestamp_sample;f4[3] xyz;f4[3] xyz_derivative"
    ),
    "vehicle_acceleration": _fields("u8 timestamp;u8 timestamp_sample;f4[3] xyz"),
    "sensor_combined": _fields(
        "u8 timestamp;f4[3] gyro_rad;u4 gyro_integral_dt;i4 accelerometer_timestamp_relative;"
        "f4[3] accelerometer_m_s2;u4 accelerometer_integral_dt;u1 accelerometer_clipping;"
        "u1 gyro_clipping;u1 accel_calibration_count;u1 gyro_calibration_count"
    ),
    "vehicle_local_position": _fields(
        "u8 timestamp;u8 timestamp_sample;u8 ref_timestamp;f8 ref_lat;f8 ref_lon;f4 x;f4 y;f4 z;"
        "f4[2] delta_xy;f4 delta_z;f4 vx;f4 vy;f4 vz;f4 z_deriv;f4[2] delta_vxy;f4 delta_vz;f4 ax;"
        "f4 ay;f4 az;f4 heading;f4 heading_var;f4 unaided_heading;f4 delta_heading;f4 tilt_var;"
        "f4 ref_alt;f4 dist_bottom;f4 dist_bottom_var;f4 delta_dist_bottom;f4 eph;f4 epv;f4 evh;"
        "f4 evv;f4 vxy_max;f4 vz_max;f4 hagl_min;f4 hagl_max_z;f4 hagl_max_xy;? xy_valid;? z_valid;"
        "? v_xy_valid;? v_z_valid;u1 xy_reset_counter;u1 z_reset_counter;u1 vxy_reset_counter;"
        "u1 vz_reset_counter;u1 heading_reset_counter;? heading_good_for_control;? xy_global;"
        "? z_global;? dist_bottom_valid;u1 dist_bottom_reset_counter;"
        "u1 dist_bottom_sensor_bitfield;? dead_reckoning"
    ),
    "actuator_motors": _fields(
        "u8 timestamp;u8 timestamp_sample;f4[12] control;u2 reversible_flags"
    ),
    "actuator_outputs": _fields("u8 timestamp;u4 noutputs;f4[16] output"),
    "battery_status": _fields(
        "u8 timestamp;f4 voltage_v;f4 current_a;f4 current_average_a;f4 discharged_mah;"
        "f4 remaining;f4 scale;f4 time_remaining_s;f4 temperature;u1 cell_count;u1 source;"
        "? connected"
    ),
}
LATE = 700
"""From a measurement to its publication [us]."""

ACCELEROMETER_LATE = -1250
"""Delay of sensor_combined, from the stamp to the accelerometer's own time [us]."""


def topics_of(
    log: FlightLog,
    every: dict[str, int],
    order: tuple[int | None, ...] = (1, 2, 3, 4),
    driven: Commands | None = None,
) -> dict[str, Any]:
    """Tables by topic of a ``log``, of whose samples each topic has one of ``every`` so many.

    order : number of the motor that each controller turns; None for a slot of something else.
    driven : what commands and battery are; by default none of them are there.
    """
    seen = InFrames(log, "frd", "ned")
    stamp = np.round(log.time * 1e6).astype(np.int64) + 1_000_000
    tables = {name: _table(fields, stamp + LATE, stamp) for name, fields in TOPICS.items()}
    tables["vehicle_attitude"]["q"] = seen.quaternion
    tables["vehicle_angular_velocity"]["xyz"] = seen.rates
    tables["vehicle_acceleration"]["xyz"] = seen.specific_force
    both = tables["sensor_combined"]
    both["timestamp"] = stamp
    both["gyro_rad"] = seen.rates
    both["accelerometer_timestamp_relative"] = ACCELEROMETER_LATE
    earlier = log.time + 1e-6 * ACCELEROMETER_LATE
    both["accelerometer_m_s2"] = _at(seen.specific_force, log.time, earlier)
    place = tables["vehicle_local_position"]
    for name, column in zip(("vx", "vy", "vz"), seen.world_velocity.T, strict=True):
        place[name] = column
    place["v_xy_valid"] = place["v_z_valid"] = True
    if driven is None:
        for name in ("actuator_motors", "actuator_outputs", "battery_status"):
            tables.pop(name)
    else:
        tables["actuator_motors"]["control"] = np.nan
        tables["actuator_outputs"]["output"] = 900.0
        for place, motor in enumerate(order):
            if motor is not None:
                share = driven.share[:, motor - 1]
                tables["actuator_motors"]["control"][:, motor - 1] = share
                tables["actuator_outputs"]["output"][:, place] = 1000.0 + 1000.0 * share
        tables["actuator_motors"]["control"][:20] = np.nan  # not armed yet
        tables["battery_status"]["voltage_v"] = driven.voltage
    tables["esc_status"] = _esc_status(log, stamp, order)
    return {name: table[:: every.get(name, 1)] for name, table in tables.items()}


def _at(values: Floats, time: Floats, when: Floats) -> Floats:
    return np.stack([np.interp(when, time, column) for column in values.T], axis=1)


def _table(fields: list[Field], published: Any, measured: Any) -> Any:
    table = np.zeros(published.size, dtype=_dtype(fields))
    table["timestamp"] = published
    if "timestamp_sample" in table.dtype.names:
        table["timestamp_sample"] = measured
    return table


def _dtype(fields: list[Field]) -> np.dtype[Any]:
    return np.dtype([(n, f"<{kind}", (count,) if count > 1 else ()) for n, kind, count in fields])


def _esc_status(log: FlightLog, stamp: Any, order: tuple[int | None, ...]) -> Any:
    report = _dtype(ESC_REPORT)
    head = [("timestamp", "<u8"), ("counter", "<u2"), ("esc_count", "u1")]
    flags = [("esc_connectiontype", "u1"), ("esc_online_flags", "u1"), ("esc_armed_flags", "u1")]
    whole = np.dtype([*head, *flags, ("_padding0", "u1", (2,)), ("esc", report, (8,))])
    table = np.zeros(stamp.size, dtype=whole)
    # Without a stamp of the measurement, publication is at once.
    table["timestamp"], table["esc_count"] = stamp, len(order)
    for place, motor in enumerate(order):
        if motor is None:
            table["esc"]["actuator_function"][:, place] = 40 + place
            continue
        reversed_ = -1 if motor % 2 else 1
        esc = table["esc"][:, place]
        esc["timestamp"] = stamp
        esc["esc_rpm"] = reversed_ * np.round(log.rotor_speed[:, motor - 1] / RPM)
        esc["actuator_function"] = 100 + motor
        table["esc"][:, place] = esc
    return table


def _format(name: str, dtype: np.dtype[Any]) -> str:
    parts = []
    for field in dtype.names or ():
        kind = dtype[field]
        count = f"[{kind.shape[0]}]" if kind.shape else ""
        base = kind.base
        text = "esc_report" if base.names else C_TYPES[base.str.lstrip("<|").replace("b1", "?")]
        parts.append(f"{text}{count} {field};")
    return f"{name}:{''.join(parts)}"


def write_px4_log(
    tables: dict[str, Any], path: Path, parameters: dict[str, float | int] | None = None
) -> None:
    """Write tables by topic as the data of one file, in order of their stamps."""
    start = min(int(table["timestamp"][0]) for table in tables.values())
    with path.open("wb") as file:

        def message(kind: str, body: bytes) -> None:
            file.write(struct.pack("<HB", len(body), ord(kind)) + body)

        file.write(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", start))
        message("B", bytes(40))
        message("F", _format("esc_report", _dtype(ESC_REPORT)).encode())
        for name, table in tables.items():
            message("F", _format(name, table.dtype).encode())
        for key, text in (("sys_name", "PX4"), ("ver_hw", "PX4_FMU_V6X")):
            named = f"char[{len(text)}] {key}".encode()
            message("I", struct.pack("<B", len(named)) + named + text.encode())
        for key, value in {"IMU_ACCEL_CUTOFF": 30.0, **(parameters or {})}.items():
            kind, code = ("float", "<f") if isinstance(value, float) else ("int32_t", "<i")
            named = f"{kind} {key}".encode()
            message("P", struct.pack("<B", len(named)) + named + struct.pack(code, value))
        rows = []
        for number, (name, table) in enumerate(tables.items()):
            message("A", struct.pack("<BH", 0, number) + name.encode())
            # Padding at the end of a topic is not written.
            rows += [(int(row["timestamp"]), number, row.tobytes()) for row in table]
        for k, (stamp, number, body) in enumerate(sorted(rows)):
            if k % 1000 == 0:
                message("S", bytes([0x2F, 0x73, 0x13, 0x20, 0x25, 0x0C, 0xBB, 0x12]))
                message("L", struct.pack("<BQ", ord("6"), stamp) + b"[commander] in air")
            message("D", struct.pack("<H", number) + body)


def write_ulog(
    log: FlightLog, path: Path, vehicle: Vehicle, *, leave_out: tuple[str, ...] = ()
) -> str:
    """Write all topics at one rate except ``leave_out``, with the vehicle's geometry as parameters.

    Return the ``[log]`` table.
    """
    tables = topics_of(log, {}, order=tuple(range(1, len(vehicle.mounts) + 1)))
    tables["esc_status"]["esc"]["actuator_function"] = 0
    logged = {name: table for name, table in tables.items() if name not in leave_out}
    write_px4_log(logged, path, _geometry(vehicle))
    return "[log]\n"


def _geometry(vehicle: Vehicle) -> dict[str, float | int]:
    """Parameters by which PX4 knows the vehicle's rotors, all of which thrust upwards."""
    found: dict[str, float | int] = {"CA_ROTOR_COUNT": len(vehicle.mounts)}
    for k, mount in enumerate(vehicle.mounts):
        for axis, place in zip("XYZ", FLIP @ np.array(mount.position), strict=True):
            found[f"CA_ROTOR{k}_P{axis}"] = float(place)
        found[f"CA_ROTOR{k}_KM"] = 0.05 if mount.spin == "ccw" else -0.05
    return found
