"""Logs of PX4, ArduPilot, Betaflight and ROS as people have them: a fit, or a line and a remedy."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog
from propmap.vehicle.log_readers import read_flight_log
from propmap.vehicle.throttle import lagged
from tests.flight import agile
from tests.flight.commands import commands
from tests.flight.synthetic import NEUROBEM, flight, vehicle_text, vehicle_with
from tests.vehicle.write_dataflash import write_dataflash
from tests.vehicle.write_logs import InFrames, write_bag
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

SLOTS = (None, 3, 1, None, 4, 2)
DRIVEN = commands(LOG, noise=0.01)
FROM_THROTTLE = "rotor speeds are computed from throttle by a fitted curve"


def px4(log: FlightLog, *leave_out: str, **more: Any) -> str:
    tables = topics_of(log, PROFILE, **more)
    for name in leave_out:
        del tables[name]
    write_px4_log(tables, Path("log.ulg"))
    return ""


def cut_short() -> str:
    table = write_dataflash(LOG, Path("log.bin"), outputs=dict(enumerate(SLOTS, start=1)))
    whole = Path("log.bin").read_bytes()
    Path("log.bin").write_bytes(whole[: int(0.95 * len(whole))])
    return table


def betaflight(low: float = 48.0, high: float = 2047.0, more: str = "") -> str:
    """As of blackbox_decode --unit-frame-time s --unit-rotation rad/s ..., with motion capture."""
    seen = InFrames(LOG, "flu", "enu")
    angles = seen.rotation.as_euler("ZYX")[:, ::-1]
    columns = {"loopIteration": np.arange(LOG.time.size), "time (s)": LOG.time}
    columns |= {f"gyroADC[{k}] (rad/s)": LOG.rates[:, k] for k in range(3)}
    columns |= {f"accSmooth[{k}] (m/s/s)": LOG.specific_force[:, k] for k in range(3)}
    columns |= {f"motor[{k}]": low + (high - low) * DRIVEN.share[:, k] for k in range(4)}
    columns["vbatLatest (V)"] = DRIVEN.voltage
    columns |= {n: angles[:, k] for k, n in enumerate(("roll", "pitch", "heading"))}
    columns |= {f"mocap_v{a}": seen.world_velocity[:, k] for k, a in enumerate("xyz")}
    agile.write(columns, Path("log.csv"))
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
    "px4, six slots": (
        lambda: px4(LOG, order=SLOTS),
        "level flight",
        ["esc_status has 6 slots; those of motors 1 to 4 are read"],
    ),
    "ardupilot, six outputs, cut short": (
        cut_short,
        "level flight",
        ["ESC has 6 instances; those of motors 1 to 4 are read"],
    ),
    "px4, commands and all that is free by default": (
        lambda: px4(LOG, "esc_status", driven=DRIVEN),
        "flight",
        [FROM_THROTTLE],
    ),
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
    "px4, electrical rpm": (
        lambda: px4(replace(LOG, rotor_speed=7.0 * LOG.rotor_speed)),
        "they look like electrical rpm of motors with about",
        'write rotor_unit = "erpm"',
    ),
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
