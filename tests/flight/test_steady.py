"""Steady segments of logs, and tables of operating points."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from propmap.errors import InputError
from propmap.flight.steady import airborne, read_level_table, steady_segments
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog

from .synthetic import CHANGE, HOLD, NEUROBEM, SPEEDS, flight

LOG = flight()


def cruise(seconds: float = 10.0) -> FlightLog:
    """Level flight straight ahead at 6 m/s."""
    time = np.arange(0.0, seconds, 0.01)
    ones = np.ones((time.size, 1))
    return FlightLog(
        source="cruise",
        time=time,
        velocity=ones * [6.0, 0.0, 0.0],
        rates=ones * [0.0, 0.0, 0.0],
        up=ones * [0.0, 0.0, 1.0],
        specific_force=ones * [0.0, 0.0, 9.81],
        rotor_speed=ones * np.full(4, 1100.0),
    )


def test_each_speed_is_a_segment_and_the_changes_are_not() -> None:
    segments = steady_segments(LOG)
    assert len(segments) == len(SPEEDS)
    for k, segment in enumerate(segments):
        begin = k * (HOLD + CHANGE)
        time = LOG.time[segment]
        assert time[0] <= begin + 0.5 and time[-1] >= begin + HOLD - 0.5
        assert np.ptp(LOG.speed[segment]) < 0.7
    short = steady_segments(LOG, seconds=0.5)
    assert all(np.ptp(LOG.time[segment]) >= 0.5 - 1e-6 for segment in short)
    assert all(first.stop <= second.start for first, second in itertools.pairwise(short))
    log = cruise()
    noise = np.random.default_rng(1).normal(0.0, 0.1, log.rates.shape)
    assert steady_segments(replace(log, rates=noise)) == [slice(0, len(log))]
    with pytest.raises(InputError, match="speed_band is 0"):
        steady_segments(LOG, speed_band=0.0)


@pytest.mark.parametrize(
    ("field", "column", "limit"),
    [("velocity", 1, "speed_band"), ("rates", 0, "rate_band"), ("up", 1, "tilt_band")],
)
def test_what_is_not_steady(field: str, column: int, limit: str) -> None:
    """A slow swing of 3 s, twice as wide as the band allows."""
    log = cruise()
    swing = getattr(log, field).copy()
    width = {"speed_band": 0.5, "rate_band": 0.3, "tilt_band": 0.1}[limit]
    swing[:, column] += width * np.sin(2.0 * np.pi * log.time / 3.0)
    with pytest.raises(InputError) as caught:
        steady_segments(replace(log, **{field: swing}), seconds=2.0)
    assert limit in str(caught.value) and "the longest lasts" in str(caught.value)
    assert f"raise {limit} or lower seconds" in str(caught.value)
    assert steady_segments(replace(log, **{field: swing}), seconds=2.0, **{limit: 3.0 * width})


def test_a_climb_that_changes_is_not_steady() -> None:
    """The vehicle's own velocity stays, its attitude changes within the tilt's band."""
    log = cruise()
    velocity = np.tile([40.0, 0.0, 0.0], (len(log), 1))
    lean = 0.04 * np.sin(2.0 * np.pi * log.time / 3.0)
    up = np.stack([np.sin(lean), 0.0 * lean, np.cos(lean)], axis=1)
    with pytest.raises(InputError, match=r"ended by climb_band = 0\.5"):
        steady_segments(replace(log, velocity=velocity, up=up))


def test_a_gap_ends_a_segment() -> None:
    log = cruise()
    late = replace(log, time=np.where(log.time < 5.0, log.time, log.time + 0.4))
    assert steady_segments(late) == [slice(0, 500), slice(500, len(log))]
    with pytest.raises(InputError, match=r"no steady segment of 6 s: the longest lasts 4\.99 s"):
        steady_segments(late, seconds=6.0)


def test_the_ground_is_not_hover() -> None:
    log = cruise()
    grounded = log.time < 4.0
    velocity = np.where(grounded[:, None], 0.0, log.velocity)
    rotor_speed = np.where(grounded[:, None], 300.0, log.rotor_speed)
    landed = replace(log, velocity=velocity, rotor_speed=rotor_speed)
    np.testing.assert_array_equal(airborne(landed), ~grounded)
    assert steady_segments(landed) == [slice(400, len(log))]
    still = replace(log, rotor_speed=0.0 * log.rotor_speed)
    with pytest.raises(InputError, match="the rotors never carry the vehicle"):
        steady_segments(still)


HEADER = "speed_mps,pitch_deg,rpm_1,rpm_2,rpm_3,rpm_4"
GOOD = f"{HEADER}\n0,0,9000,9100,9200,9300\n5,10,9500,9500,9500,9500\n"


def read(text: str, folder: Path) -> FlightLog:
    (folder / "points.csv").write_text(text, encoding="utf-8")
    return read_level_table(folder / "points.csv", read_vehicle(NEUROBEM).vehicle)


def test_bank_climb_and_turn(tmp_path: Path) -> None:
    text = "roll_deg,note,climb_mps,yaw_rate_dps," + GOOD.replace("\n0", "\n20,a,0,0,0").replace(
        "\n5", "\n-20,b,1.5,30,5"
    )
    points = read(text, tmp_path)
    np.testing.assert_array_equal(points.time, [0.0, 1.0])
    rpm = np.array([9000.0, 9100.0, 9200.0, 9300.0])
    np.testing.assert_allclose(points.rotor_speed[0], rpm * np.pi / 30.0)
    assert np.isnan(points.specific_force).all()
    # Right side down, the vertical is towards the left.
    s, c = np.sin(np.radians(20.0)), np.cos(np.radians(20.0))
    np.testing.assert_allclose(points.up[0], [0, s, c])
    # Nose down, the air comes from above.
    assert read(GOOD, tmp_path).velocity[1, 2] == pytest.approx(5.0 * np.sin(np.radians(10.0)))
    to_world = Rotation.from_euler("YX", [10.0, -20.0], degrees=True)
    np.testing.assert_allclose(to_world.apply(points.velocity[1]), [5, 0, 1.5], atol=1e-12)
    np.testing.assert_allclose(to_world.apply(points.up[1]), [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(to_world.apply(points.rates[1]), [0, 0, np.radians(30)], atol=1e-12)
    np.testing.assert_allclose(points.climb_rate, [0, 1.5], atol=1e-12)


CASES = {
    "no speed": (GOOD.replace("speed_mps", "speed"), "line 1: column speed_mps is missing"),
    "three rotors": (GOOD.replace(",rpm_4", ",x"), "3 columns rpm_1, rpm_2 ..., the vehicle has 4"),
    "text": (GOOD.replace("9200", "fast"), "line 2, column rpm_3", "'fast'", "finite number"),
    "negative rpm": (GOOD.replace("9200", "-9200"), "line 2, column rpm_3", "give 0 or more"),
    "steep": (GOOD.replace(",10,", ",100,"), "line 3, column pitch_deg", "0 in hover"),
    "empty": ("", "the file is empty", "table of operating points"),
}


@pytest.mark.parametrize("name", CASES)
def test_bad_tables(name: str, tmp_path: Path) -> None:
    text, *parts = CASES[name]
    with pytest.raises(InputError) as caught:
        read(text, tmp_path)
    message = str(caught.value)
    assert message.isprintable()
    for part in ["points.csv", *parts]:
        assert part in message
