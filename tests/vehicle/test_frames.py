"""Frames by hand: what a vehicle in a known attitude must read, in each pair of frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from propmap.vehicle.log import FlightLog, Signal, common_clock, interpolated
from propmap.vehicle.log_readers import read_flight_log
from tests.flight.synthetic import vehicle_with

C30 = np.cos(np.radians(30.0))
COLUMNS = """[log.columns]
time = "t"
velocity = ["vx", "vy", "vz"]
rates = ["p", "q", "r"]
roll = "roll"
pitch = "pitch"
yaw = "yaw"
rotor_speed = ["m1", "m2", "m3", "m4"]
"""


def read(folder: Path, frames: str, angles: list[float], velocity: list[float]) -> FlightLog:
    """A log of one attitude [degrees] and velocity, with rates of 0.1, 0.2, 0.3 rad/s."""
    body, world, velocity_in = frames.split()
    row = [*velocity, 0.1, 0.2, 0.3, *np.radians(angles).tolist(), 900, 900, 900, 900]
    lines = ["t,vx,vy,vz,p,q,r,roll,pitch,yaw,m1,m2,m3,m4"]
    lines += [",".join(map(str, [k * 0.01, *row])) for k in range(12)]
    (folder / "a.csv").write_text("\n".join(lines), encoding="utf-8")
    table = (
        f'[log]\nbody_frame = "{body}"\nworld_frame = "{world}"\n'
        f'velocity_in = "{velocity_in}"\nrotor_unit = "rad/s"\n{COLUMNS}'
    )
    return read_flight_log(folder / "a.csv", vehicle_with(table, folder))


CASES = {
    "nose up": ("frd ned body", [0, 30, 0], [0, 0, 0], [0.5, 0, C30], [0, 0, 0]),
    "right down": ("flu enu body", [30, 0, 0], [0, 0, 0], [0, 0.5, C30], [0, 0, 0]),
    "heading east, moving north": ("frd ned world", [0, 0, 90], [5, 0, 1], [0, 0, 1], [0, 5, -1]),
    "heading north, moving east": ("flu enu world", [0, 0, 90], [5, 0, 1], [0, 0, 1], [0, -5, 1]),
    "body velocity": ("frd ned body", [0, 0, 45], [4, 2, 1], [0, 0, 1], [4, -2, -1]),
    # FRD in ENU, level and heading east: turned half a turn about east.
    "frd in enu": ("frd enu world", [180, 0, 0], [1, 2, 3], [0, 0, 1], [1, 2, 3]),
    "flu in ned": ("flu ned world", [180, 0, 0], [1, 2, 3], [0, 0, 1], [1, -2, -3]),
}


@pytest.mark.parametrize("name", CASES)
def test_attitude_and_velocity(name: str, tmp_path: Path) -> None:
    frames, angles, velocity, up, expected = CASES[name]
    log = read(tmp_path, frames, angles, velocity)
    np.testing.assert_allclose(log.up[0], up, atol=1e-12)
    np.testing.assert_allclose(log.velocity[0], expected, atol=1e-12)
    signs = [1, 1, 1] if frames.startswith("flu") else [1, -1, -1]
    np.testing.assert_allclose(log.rates[0], np.array([0.1, 0.2, 0.3]) * signs)
    assert np.isnan(log.specific_force).all()


def test_the_clock_is_that_of_the_slowest_leading_signal() -> None:
    def ramp(name: str, start: float, end: float, rate: float) -> Signal:
        time = np.arange(round((end - start) * rate) + 1) / rate + start
        return Signal(name, time, 2.0 * time[:, None])

    fast, slow = ramp("attitude", 0.0, 10.0, 200.0), ramp("velocity", 0.5, 9.0, 25.0)
    slower = ramp("force", 0.0, 8.0, 10.0)
    time = common_clock([fast, slow], [slower], "log")
    np.testing.assert_allclose(time, slow.time[slow.time <= 8.0])
    for signal in (fast, slow, slower):
        np.testing.assert_allclose(interpolated(signal, time)[:, 0], 2.0 * time)
    keep = (fast.time < 3.0) | (fast.time > 3.3)
    broken = Signal("attitude", fast.time[keep], fast.values[keep])
    cut = common_clock([broken, slow], [slower], "log")
    assert cut.size == time.size - np.sum((time >= 3.0) & (time <= 3.3))
