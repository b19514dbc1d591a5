"""Logs of PX4, ArduPilot, Betaflight and ROS as people have them: a fit, or a line and a remedy."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log_readers import read_flight_log
from propmap.vehicle.throttle import lagged
from tests.flight import agile
from tests.flight.commands import commands
from tests.flight.synthetic import NEUROBEM, flight, vehicle_text, vehicle_with
from tests.vehicle.write_dataflash import write_dataflash
from tests.vehicle.write_logs import csv_columns, write_bag
from tests.vehicle.write_px4_log import topics_of, write_px4_log

from .conftest import Run
from .fit_inputs import fit_record

pytestmark = pytest.mark.usefixtures("brief", "filters_once")

LOG = flight(rate=100.0)
VEHICLE = read_vehicle(NEUROBEM).vehicle
FILES = {"px4": "log.ulg", "ardupilot": "log.bin", "betaflight": "log.csv", "ros 2": "bag"}
SLOW = ("vehicle_local_position", "esc_status", "actuator_motors", "actuator_outputs")
PROFILE = dict.fromkeys(SLOW, 10) | {"battery_status": 20}
PROFILE |= dict.fromkeys(
    [f"vehicle_{n}" for n in ("attitude", "angular_velocity", "acceleration")], 5
)
"""Decimation of each topic in PX4's default profile: velocities and rotor speeds at 10 Hz."""

DRIVEN = commands(LOG, noise=0.01)
FROM_THROTTLE = "a fitted curve converts throttle to rotor speed"


def px4() -> str:
    """A log with commands, without rotor speeds."""
    tables = topics_of(LOG, PROFILE, driven=DRIVEN)
    del tables["esc_status"]
    write_px4_log(tables, Path("log.ulg"))
    return ""


def betaflight(low: float = 48.0, high: float = 2047.0, more: str = "") -> str:
    """As of blackbox_decode, with motion capture: motors and voltage without a column map."""
    columns, table = csv_columns(LOG, velocity_in="world", angles=True)
    columns = {name: values for name, values in columns.items() if "rotor" not in name}
    columns |= {f"motor[{k}]": low + (high - low) * DRIVEN.share[:, k] for k in range(4)}
    columns["vbatLatest (V)"] = DRIVEN.voltage
    agile.write(columns, Path("log.csv"))
    above, _, below = more.partition("\n")
    table = re.sub("rotor_.*\n", "", table)
    return table.replace("[log]\n", f"[log]\n{above}\n") + f"{below}\n"


def driven_bag(gap: float = 0.0) -> str:
    """A bag of ROS 2 with commands in percent as a robot's driver has them, without a battery."""
    log = replace(LOG, rotor_speed=100.0 * DRIVEN.share)
    table = write_bag(log.picked(np.abs(log.time - 5.0) >= gap), Path("bag"), VEHICLE)
    table = table.replace("rotor_speed =", "throttle =")
    return table.replace("[log]\n", "[log]\nthrottle_range = [0, 100]\n")


def file_of(name: str) -> str:
    return FILES[name.partition(",")[0]]


READ: dict[str, Callable[[], str]] = {
    "betaflight, motor and voltage": betaflight,
    "betaflight, pulses": lambda: betaflight(1000.0, 2000.0, "throttle_range = [1000, 2000]"),
    "ros 2, percent and no voltage": driven_bag,
}


@pytest.mark.parametrize("name", READ)
def test_commands_are_read(name: str, tmp_path: Path) -> None:
    """As shares of full throttle, times the voltage where it is known, behind the motors' lag."""
    read = read_flight_log(tmp_path / file_of(name), vehicle_with(READ[name](), tmp_path))
    worth = DRIVEN.share * (1.0 if "no voltage" in name else DRIVEN.voltage[:, None])
    expected, _ = lagged(worth, 0.01)
    assert read.commanded
    np.testing.assert_allclose(read.throttle, expected, rtol=1e-6)


FITS: dict[str, tuple[Callable[[], str], str, list[str]]] = {
    "ardupilot": (lambda: write_dataflash(LOG, Path("log.bin")), "level flight", []),
    "px4, commands and all that is free by default": (px4, "flight", [FROM_THROTTLE]),
    "ros 2, commands and a gap": (
        lambda: driven_bag(gap=0.406),
        "flight",
        [FROM_THROTTLE, "no sample from 4.59 to 5.41 s", "throttle but no battery voltage"],
    ),
}


def fitted(run: Run, name: str, table: str, *more: str) -> tuple[int, str]:
    Path("vehicle.toml").write_text(vehicle_text(table), encoding="utf-8")
    few = ("--samples", "40", "--starts", "1", "--folds", "0", "-o", "fit.toml")
    done = run("fit", "flight", file_of(name), "--vehicle", "vehicle.toml", *few, *more)
    return done.code, done.out + done.err


@pytest.mark.parametrize("name", FITS)
def test_a_log_is_fitted(name: str, run: Run) -> None:
    write, kind, notes = FITS[name]
    free = () if "by default" in name else ("--free", "c_l1,zero_lift_angle,drag_factor")
    code, told = fitted(run, name, write(), *free)
    assert code == 0, told
    assert fit_record(Path("fit.toml"))["kind"] == kind
    assert all(note in " ".join(told.split()) for note in notes), told


MOTORS = [f"motor[{k}]" for k in range(4)]
REFUSED: dict[str, tuple[Callable[[], str], str, str]] = {
    "ardupilot, no telemetry": (
        lambda: write_dataflash(LOG, Path("log.bin"), leave_out=("ESC",)),
        "throttle (RCOU) never changes (1500)",
        "give a flight with armed motors",
    ),
    "betaflight, another range": (
        lambda: betaflight(more="throttle_range = [0, 1]"),
        "outside its range of 0 to 1",
        "write throttle_range = [at rest, at full throttle]",
    ),
    "betaflight, three motors": (
        lambda: betaflight(more=f"throttle_range = [48, 2047]\nthrottle = {MOTORS[:3]}"),
        "throttle lists 3 columns, the vehicle has 4 rotors",
        "name one column per rotor",
    ),
    "betaflight, range not stated": (
        lambda: betaflight(more=f"\nthrottle = {MOTORS}"),
        "no throttle_range",
        "add throttle_range = [1000, 2000], at rest and at full throttle",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_log_is_refused_with_a_remedy(name: str, run: Run) -> None:
    write, fault, remedy = REFUSED[name]
    code, told = fitted(run, name, write())
    assert code == 2 and not Path("fit.toml").exists()
    (line,) = [line for line in told.splitlines() if line.startswith("propmap: error: ")]
    assert fault in line and remedy in line
