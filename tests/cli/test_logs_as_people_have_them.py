"""Logs of PX4, ArduPilot, Betaflight and ROS as people have them: a fit, or a line and a remedy."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog
from tests.flight.synthetic import NEUROBEM, flight, vehicle_text
from tests.vehicle.write_dataflash import write_dataflash
from tests.vehicle.write_logs import InFrames, write_bag, write_csv, write_ulog
from tests.vehicle.write_px4_log import topics_of, write_px4_log

from .conftest import Run

pytestmark = pytest.mark.usefixtures("brief")

LOG = flight(rate=100.0)
VEHICLE = read_vehicle(NEUROBEM).vehicle
RPM = np.pi / 30.0
PROFILE = {
    "vehicle_attitude": 5,
    "vehicle_local_position": 10,
    "vehicle_angular_velocity": 5,
    "vehicle_acceleration": 5,
    "esc_status": 10,
}
"""One of so many samples, as by PX4's default profile: velocities and speeds at 10 Hz."""

SLOTS = (None, 3, 1, None, 4, 2)
BETAFLIGHT = """[log]
body_frame = "flu"
world_frame = "enu"
velocity_in = "world"
rotor_unit = "rpm"
[log.columns]
time = "time (us)"
rates = ["gyroADC[0]", "gyroADC[1]", "gyroADC[2]"]
specific_force = ["accSmooth[0]", "accSmooth[1]", "accSmooth[2]"]
rotor_speed = ["motor[0]", "motor[1]", "motor[2]", "motor[3]"]
roll = "roll"
pitch = "pitch"
yaw = "heading"
"""


def turning(log: FlightLog, factor: float, offset: float = 0.0) -> FlightLog:
    return replace(log, rotor_speed=factor * log.rotor_speed + offset)


PULSES = turning(LOG, 0.4 * RPM, 1200.0 * RPM)
"""About 1650 us, where rpm are expected."""


def px4(log: FlightLog, leave_out: str = "", **more: tuple[int | None, ...]) -> str:
    tables = topics_of(log, PROFILE, **more)
    tables.pop(leave_out, None)
    write_px4_log(tables, Path("log.ulg"))
    return ""


def unassigned() -> str:
    tables = topics_of(LOG, PROFILE, SLOTS)
    tables["esc_status"]["esc"]["actuator_function"] = 0
    write_px4_log(tables, Path("log.ulg"))
    return ""


def cut_short() -> str:
    table = write_dataflash(LOG, Path("log.bin"))
    whole = Path("log.bin").read_bytes()
    Path("log.bin").write_bytes(whole[: int(0.95 * len(whole))])
    return table


def betaflight() -> str:
    """A table as of blackbox_decode: microseconds, deg/s, counts, commands, and no velocity."""
    seen = InFrames(LOG, "flu", "enu")
    angles = seen.rotation.as_euler("ZYX")[:, ::-1]
    columns = {"loopIteration": np.arange(LOG.time.size), " time (us)": 1e6 * LOG.time}
    columns |= {f" gyroADC[{k}]": np.degrees(LOG.rates[:, k]) for k in range(3)}
    columns |= {f" accSmooth[{k}]": 2048 / 9.81 * LOG.specific_force[:, k] for k in range(3)}
    columns |= {f" motor[{k}]": 1.2 * LOG.rotor_speed[:, k] for k in range(4)}
    columns |= {f" {n}": angles[:, k] for k, n in enumerate(("roll", "pitch", "heading"))}
    with Path("log.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
    return BETAFLIGHT


FITS: dict[str, tuple[str, Callable[[], str], str]] = {
    "px4, default profile": ("log.ulg", lambda: px4(LOG), ""),
    "px4, six slots": (
        "log.ulg",
        lambda: px4(LOG, order=SLOTS),
        "esc_status has 6 slots, of which those of motors 1 to 4 are read",
    ),
    "px4, an older one": (
        "log.ulg",
        lambda: write_ulog(
            LOG,
            Path("log.ulg"),
            VEHICLE,
            leave_out=("vehicle_angular_velocity", "vehicle_acceleration"),
        ),
        "",
    ),
    "ardupilot": ("log.bin", lambda: write_dataflash(LOG, Path("log.bin")), ""),
    "ardupilot, six outputs": (
        "log.bin",
        lambda: write_dataflash(LOG, Path("log.bin"), outputs=dict(enumerate(SLOTS, start=1))),
        "ESC has 6 instances, of which those of motors 1 to 4 are read",
    ),
    "ardupilot, cut short": ("log.bin", cut_short, ""),
    "ros 2, a gap": (
        "bag",
        lambda: write_bag(LOG.picked(np.abs(LOG.time - 5.0) > 0.405), Path("bag"), VEHICLE),
        "has no sample from 4.59 to 5.41 s, which is left out",
    ),
}
REFUSED: dict[str, tuple[str, Callable[[], str], tuple[str, ...]]] = {
    "px4, no telemetry": (
        "log.ulg",
        lambda: px4(LOG, "esc_status"),
        ("no topic esc_status; found sensor_combined", "motor controllers with telemetry"),
    ),
    "px4, slots without function": (
        "log.ulg",
        unassigned,
        ("6 rotor speeds, of which these ever turn: 2, 3, 5, 6", "save as CSV and name the motors"),
    ),
    "px4, electrical rpm": (
        "log.ulg",
        lambda: px4(turning(LOG, 7.0)),
        ("they look like electrical rpm of motors with about", 'write rotor_unit = "erpm"'),
    ),
    "px4, pulses": (
        "log.ulg",
        lambda: px4(PULSES),
        ("they look like PWM in us", "log measured speeds, as PWM is a command"),
    ),
    "ardupilot, no telemetry": (
        "log.bin",
        lambda: write_dataflash(LOG, Path("log.bin"), leave_out=("ESC",)),
        ("no message ESC or RPM; found ATT, IMU, RCOU, XKF1", "RCOU are commands (PWM)"),
    ),
    "ardupilot, pulses": (
        "log.bin",
        lambda: write_dataflash(PULSES, Path("log.bin")),
        ("they look like PWM in us", "log measured speeds, as PWM is a command"),
    ),
    "betaflight": ("log.csv", betaflight, ("vehicle.toml: [log.columns]: no velocity; name the",)),
    "rpm taken for rad/s": (
        "log.csv",
        lambda: write_csv(LOG, Path("log.csv"), rotor_unit="rpm").replace('"rpm"', '"rad/s"'),
        ("they look like rpm read as rad/s", 'write rotor_unit = "rpm"'),
    ),
}


def fitted(run: Run, log: str, write: Callable[[], str]) -> tuple[int, str]:
    Path("vehicle.toml").write_text(vehicle_text(write()), encoding="utf-8")
    done = run("fit", "flight", log, "--vehicle", "vehicle.toml", "-o", "fit.toml")
    return done.code, done.out + done.err


@pytest.mark.parametrize("name", FITS)
def test_a_log_is_fitted(name: str, run: Run) -> None:
    log, write, note = FITS[name]
    code, told = fitted(run, log, write)
    assert code == 0, told
    assert note in " ".join(told.split()) and Path("fit.toml").exists()


@pytest.mark.parametrize("name", REFUSED)
def test_a_log_is_refused_with_a_remedy(name: str, run: Run) -> None:
    log, write, parts = REFUSED[name]
    code, told = fitted(run, log, write)
    assert code == 2 and not Path("fit.toml").exists()
    (line,) = [line for line in told.splitlines() if line.startswith("propmap: error: ")]
    assert all(part in line for part in parts), line
