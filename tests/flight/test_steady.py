"""Steady segments: what counts, what does not, and what is said where there is none."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.flight.steady import airborne, operating_points, steady_segments
from propmap.vehicle.log import FlightLog

from .synthetic import CHANGE, HOLD, SPEEDS, flight

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


def test_segments_do_not_overlap_and_last_long_enough() -> None:
    for seconds in (0.5, 1.0, 3.0):
        segments = steady_segments(LOG, seconds=seconds)
        for segment in segments:
            assert np.ptp(LOG.time[segment]) >= seconds - 1e-6
        for first, second in itertools.pairwise(segments):
            assert first.stop <= second.start


def test_noise_does_not_end_a_segment() -> None:
    log = cruise()
    noise = np.random.default_rng(1).normal(0.0, 0.1, log.rates.shape)
    assert steady_segments(replace(log, rates=noise)) == [slice(0, len(log))]


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


def test_a_band_must_be_positive() -> None:
    with pytest.raises(InputError, match="speed_band is 0"):
        steady_segments(LOG, speed_band=0.0)


def test_operating_points_are_averages() -> None:
    log = cruise()
    rotor_speed = log.rotor_speed + np.where(np.arange(len(log)) % 2, 3.0, -3.0)[:, None]
    points = operating_points(
        replace(log, rotor_speed=rotor_speed), [slice(0, 200), slice(300, 700)]
    )
    assert len(points) == 2
    np.testing.assert_allclose(points.rotor_speed, 1100.0)
    np.testing.assert_allclose(points.time, [0.995, 4.995])
    np.testing.assert_allclose(points.velocity, [[6.0, 0.0, 0.0]] * 2)
