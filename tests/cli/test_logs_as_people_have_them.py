"""Logs of PX4, ArduPilot, Betaflight and ROS as people have them: a fit, or a line and a remedy."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog
from tests.flight.commands import Commands, commands
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
    "actuator_motors": 10,
    "actuator_outputs": 10,
    "battery_status": 20,
}
"""One of so many samples, as by PX4's default profile: velocities and speeds at 10 Hz."""

SLOTS = (None, 3, 1, None, 4, 2)
OUTPUTS = [(k, motor) for k, motor in enumerate(SLOTS, start=1) if motor]
DRIVEN = commands(LOG, noise=0.01)
UNTOUCHED: dict[str, Any] = dict.fromkeys(("rotor_acceleration", "throttle", "throttle_by_lag"))
FROM_THROTTLE = "rotor speeds are computed from throttle by a fitted curve"
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


def px4(log: FlightLog, *leave_out: str, **more: Any) -> str:
    tables = topics_of(log, PROFILE, **more)
    for name in leave_out:
        del tables[name]
    write_px4_log(tables, Path("log.ulg"), {f"PWM_MAIN_FUNC{k}": 100 + m for k, m in OUTPUTS})
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


def write_table(columns: dict[str, Any]) -> None:
    with Path("log.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))


def betaflight() -> str:
    """A table as of blackbox_decode: microseconds, deg/s, counts, commands, and no velocity."""
    seen = InFrames(LOG, "flu", "enu")
    angles = seen.rotation.as_euler("ZYX")[:, ::-1]
    columns = {"loopIteration": np.arange(LOG.time.size), " time (us)": 1e6 * LOG.time}
    columns |= {f" gyroADC[{k}]": np.degrees(LOG.rates[:, k]) for k in range(3)}
    columns |= {f" accSmooth[{k}]": 2048 / 9.81 * LOG.specific_force[:, k] for k in range(3)}
    columns |= {f" motor[{k}]": 1.2 * LOG.rotor_speed[:, k] for k in range(4)}
    columns |= {f" {n}": angles[:, k] for k, n in enumerate(("roll", "pitch", "heading"))}
    write_table(columns)
    return BETAFLIGHT


def betaflight_in_si(low: float = 48.0, high: float = 2047.0, more: str = "") -> str:
    """Beside motion capture: blackbox_decode --unit-frame-time s --unit-rotation rad/s ... ."""
    seen = InFrames(LOG, "flu", "enu")
    angles = seen.rotation.as_euler("ZYX")[:, ::-1]
    columns = {"loopIteration": np.arange(LOG.time.size), "time (s)": LOG.time}
    columns |= {f"gyroADC[{k}] (rad/s)": LOG.rates[:, k] for k in range(3)}
    columns |= {f"accSmooth[{k}] (m/s/s)": LOG.specific_force[:, k] for k in range(3)}
    columns |= {f"motor[{k}]": low + (high - low) * DRIVEN.share[:, k] for k in range(4)}
    columns["vbatLatest (V)"] = DRIVEN.voltage
    columns |= {n: angles[:, k] for k, n in enumerate(("roll", "pitch", "heading"))}
    columns |= {f"mocap_v{a}": seen.world_velocity[:, k] for k, a in enumerate("xyz")}
    write_table(columns)
    named = {"time": "time (s)", "roll": "roll", "pitch": "pitch", "yaw": "heading"}
    several = {
        "velocity": [f"mocap_v{a}" for a in "xyz"],
        "rates": [f"gyroADC[{k}] (rad/s)" for k in range(3)],
        "specific_force": [f"accSmooth[{k}] (m/s/s)" for k in range(3)],
    }
    lines = [f"{key} = {json.dumps(value)}" for key, value in (named | several).items()]
    how = 'body_frame = "flu"\nworld_frame = "enu"\nvelocity_in = "world"\n'
    above, _, below = more.partition("\n")
    return "\n".join(["[log]", how, above, "[log.columns]", *lines, below, ""])


def driven_bag() -> str:
    """A bag of ROS 2 with commands as a robot's driver has them, and without a battery."""
    table = write_bag(replace(LOG, rotor_speed=100.0 * DRIVEN.share), Path("bag"), VEHICLE)
    table = table.replace("rotor_speed =", "throttle =")
    return table.replace("[log]\n", "[log]\nthrottle_range = [0, 100]\n")


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
    "px4, actuator_motors": (
        "log.ulg",
        lambda: px4(LOG, "esc_status", driven=DRIVEN),
        FROM_THROTTLE,
    ),
    "px4, actuator_outputs": (
        "log.ulg",
        lambda: px4(LOG, "esc_status", "actuator_motors", order=SLOTS, driven=DRIVEN),
        FROM_THROTTLE,
    ),
    "px4, no battery": (
        "log.ulg",
        lambda: px4(LOG, "esc_status", "battery_status", driven=DRIVEN),
        "there is throttle but no battery voltage, so that thrust drifts",
    ),
    "ardupilot, RCOU": (
        "log.bin",
        lambda: write_dataflash(
            LOG,
            Path("log.bin"),
            leave_out=("ESC",),
            outputs=dict(enumerate(SLOTS, start=1)),
            driven=DRIVEN,
        ),
        FROM_THROTTLE,
    ),
    "betaflight, motor and voltage": ("log.csv", betaflight_in_si, FROM_THROTTLE),
    "betaflight, pulses": (
        "log.csv",
        lambda: betaflight_in_si(1000.0, 2000.0, "throttle_range = [1000, 2000]"),
        FROM_THROTTLE,
    ),
    "ros 2, commands": ("bag", driven_bag, "there is throttle but no battery voltage"),
}
REFUSED: dict[str, tuple[str, Callable[[], str], tuple[str, ...]]] = {
    "px4, no telemetry": (
        "log.ulg",
        lambda: px4(LOG, "esc_status"),
        (
            "no topic esc_status or actuator_motors or actuator_outputs; found sensor_combined",
            "motor controllers with telemetry",
        ),
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
        ("throttle (RCOU) never changes (1500)", "a flight in which the motors were armed"),
    ),
    "ardupilot, pulses": (
        "log.bin",
        lambda: write_dataflash(PULSES, Path("log.bin")),
        ("they look like PWM in us", "log measured speeds, as PWM is a command"),
    ),
    "betaflight": ("log.csv", betaflight, ("vehicle.toml: [log.columns]: no velocity; name the",)),
    "betaflight, another range": (
        "log.csv",
        lambda: betaflight_in_si(more="throttle_range = [0, 1]"),
        (
            "goes from",
            "outside its range of 0 to 1; write throttle_range = [at rest, at full throttle]",
        ),
    ),
    "betaflight, no such voltage": (
        "log.csv",
        lambda: betaflight_in_si(more='\nbattery_voltage = "vbat"'),
        ("columns: 'vbat' missing", "correct battery_voltage in [log.columns]"),
    ),
    "betaflight, three motors": (
        "log.csv",
        lambda: betaflight_in_si(
            more='throttle_range = [48, 2047]\nthrottle = ["motor[0]", "motor[1]", "motor[2]"]'
        ),
        ("throttle names 3 columns, the vehicle has 4 rotors", "name one column per rotor"),
    ),
    "betaflight, range not stated": (
        "log.csv",
        lambda: betaflight_in_si(
            more='\nthrottle = ["motor[0]", "motor[1]", "motor[2]", "motor[3]"]'
        ),
        ("no throttle_range; add throttle_range = [1000, 2000], those at rest and at full",),
    ),
    "px4, six motors driven": (
        "log.ulg",
        lambda: px4(
            replace(LOG, rotor_speed=np.tile(LOG.rotor_speed, 2)[:, :6], **UNTOUCHED),
            "esc_status",
            driven=Commands(np.tile(DRIVEN.share, 2)[:, :6], DRIVEN.voltage),
            order=(1, 2, 3, 4, 5, 6),
        ),
        ("the log has 6 commands to motors", "give a [[rotors]] table per rotor"),
    ),
    "rpm taken for rad/s": (
        "log.csv",
        lambda: write_csv(LOG, Path("log.csv"), rotor_unit="rpm").replace('"rpm"', '"rad/s"'),
        ("they look like rpm read as rad/s", 'write rotor_unit = "rpm"'),
    ),
}


WHOLE = "px4, actuator_motors"
"""What is fitted with all that is free by default; layouts need not be, in a fifth of the time."""


def fitted(run: Run, log: str, write: Callable[[], str], *, whole: bool = False) -> tuple[int, str]:
    Path("vehicle.toml").write_text(vehicle_text(write()), encoding="utf-8")
    few = () if whole else ("--free", "c_l1,zero_lift_angle,drag_factor")
    done = run("fit", "flight", log, "--vehicle", "vehicle.toml", "-o", "fit.toml", *few)
    return done.code, done.out + done.err


@pytest.mark.parametrize("name", FITS)
def test_a_log_is_fitted(name: str, run: Run) -> None:
    log, write, note = FITS[name]
    code, told = fitted(run, log, write, whole=name == WHOLE)
    assert code == 0, told
    assert note in " ".join(told.split()) and Path("fit.toml").exists()


@pytest.mark.parametrize("name", REFUSED)
def test_a_log_is_refused_with_a_remedy(name: str, run: Run) -> None:
    log, write, parts = REFUSED[name]
    code, told = fitted(run, log, write)
    assert code == 2 and not Path("fit.toml").exists()
    (line,) = [line for line in told.splitlines() if line.startswith("propmap: error: ")]
    assert all(part in line for part in parts), line
