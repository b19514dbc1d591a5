"""A flight log as a CSV file, and the table ``[log]`` with which it is read again."""

from __future__ import annotations

import io

import numpy as np

from propmap.flight.leaning import lean
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.log_map import LogMap

VECTORS = {
    "velocity": ("vx_mps", "vy_mps", "vz_mps"),
    "rates": ("p_radps", "q_radps", "r_radps"),
    "specific_force": ("ax_mps2", "ay_mps2", "az_mps2"),
}
ANGLES = ("roll", "pitch", "yaw")


def log_map(rotors: int) -> LogMap:
    """How a file of ``log_csv`` is to be read."""
    columns = {"time": ("time_s",), **VECTORS, **{name: (f"{name}_rad",) for name in ANGLES}}
    columns["rotor_speed"] = tuple(f"rotor_{k}_radps" for k in range(1, rotors + 1))
    return LogMap("flu", "enu", "body", "rad/s", columns=columns)


def log_table(rotors: int) -> str:
    """The same as text for a vehicle file."""
    how = log_map(rotors)
    lines = ["[log]"]
    for key in ("body_frame", "world_frame", "velocity_in", "rotor_unit"):
        lines.append(f'{key} = "{how.stated(key)}"')
    lines += ["", "[log.columns]"]
    for key, names in how.columns.items():
        listed = ", ".join(f'"{name}"' for name in names)
        lines.append(
            f"{key} = [{listed}]" if key in (*VECTORS, "rotor_speed") else f"{key} = {listed}"
        )
    return "\n".join(lines) + "\n"


def log_csv(log: FlightLog) -> str:
    """The log as CSV; the heading, which a log does not have, follows from the yaw rate."""
    pitch, roll = lean(log.up)
    turn = np.sum(log.rates * log.up, axis=1)
    steps = 0.5 * (turn[1:] + turn[:-1]) * np.diff(log.time)
    yaw = np.concatenate([[0.0], np.cumsum(steps)])
    vectors = np.concatenate([getattr(log, name) for name in VECTORS], axis=1)
    angles = np.stack([roll, pitch, yaw], axis=1)
    names = [name for part in log_map(log.rotor_speed.shape[1]).columns.values() for name in part]
    text = io.StringIO()
    table = np.column_stack([log.time, vectors, angles, log.rotor_speed])
    np.savetxt(text, table, "%.9g", delimiter=",", header=",".join(names), comments="")
    return text.getvalue()
