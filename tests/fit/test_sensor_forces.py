"""An accelerometer off the center of mass, against a body whose points are followed in space."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import propmap
from propmap.errors import InputError
from propmap.fit.flight import (
    BIAS,
    CLOCK,
    OFFSET,
    TILT,
    HoverScale,
    at_samples,
    of_others,
    sensor_force,
)
from propmap.fit.parameters import of_flight
from propmap.units import GRAVITY
from propmap.vehicle.log import FlightLog, joined
from propmap.vehicle.vehicle import Mount, Vehicle

VEHICLE = Vehicle("test", 0.8, propmap.propeller("apc-8x6e"), (Mount((0.0, 0.0, 0.0)),))
PLACE = np.array([0.03, -0.05, 0.02])
TIME = np.arange(0.0, 4.0, 1e-3)


def turning() -> tuple[Rotation, FlightLog]:
    """A body that tumbles about its resting center of mass, and its log."""
    angles = np.stack([np.sin(2.0 * TIME), 0.7 * np.cos(3.0 * TIME), 0.5 * TIME], axis=1)
    attitude = Rotation.from_euler("xyz", angles)
    step = attitude[:-1].inv() * attitude[1:]
    between = step.as_rotvec() / 1e-3
    rates = np.vstack([between[:1], 0.5 * (between[1:] + between[:-1]), between[-1:]])
    up = attitude.inv().apply([0.0, 0.0, 1.0])
    still = np.zeros_like(up)
    one = np.full((TIME.size, 1), 600.0)
    found = FlightLog("test", TIME, still, rates, up, GRAVITY * up, one)
    slopes = np.gradient(rates, TIME, axis=0)
    jerk = np.gradient(found.specific_force, TIME, axis=0)
    return attitude, replace(found, angular_acceleration=slopes, specific_force_rate=jerk)


def test_the_acceleration_of_a_point_of_a_turning_body() -> None:
    attitude, log = turning()
    path = attitude.apply(PLACE)
    acceleration = np.gradient(np.gradient(path, TIME, axis=0), TIME, axis=0)
    wanted = VEHICLE.mass * attitude.inv().apply(acceleration)
    values = dict(zip(OFFSET, PLACE.tolist(), strict=True))
    found, slopes = sensor_force(VEHICLE, log, values, OFFSET)
    inside = slice(10, -10)
    np.testing.assert_allclose(found[inside], wanted[inside], atol=2e-3)
    np.testing.assert_allclose(np.einsum("k,knj->nj", PLACE, slopes), found)
    by_file, _ = sensor_force(replace(VEHICLE, sensor=tuple(PLACE)), log, {}, ())
    np.testing.assert_allclose(by_file, found)


def test_a_turned_sensor_with_a_bias_reads_the_force_in_its_own_axes() -> None:
    _, log = turning()
    log = replace(log, specific_force=log.specific_force + np.array([1.0, -2.0, 0.0]))
    angles, bias = np.array([0.004, -0.006]), np.array([0.1, -0.2, 0.3])
    axes = Rotation.from_rotvec([*angles, 0.0])
    wanted = axes.inv().apply(log.specific_force) + bias - log.specific_force
    names = (*TILT, *BIAS)
    values = dict(zip(names, [*angles, *bias], strict=True))
    found, slopes = sensor_force(VEHICLE, log, values, names)
    # To first order in the angles.
    np.testing.assert_allclose(found, VEHICLE.mass * wanted, atol=2e-3)
    np.testing.assert_allclose(np.einsum("k,knj->nj", [*angles, *bias], slopes), found, atol=1e-12)
    # A trim of the second flight turns the force at the samples of this flight only.
    both = joined([log, log])
    own = of_flight(TILT[0], both.flights[1])
    trimmed, slopes = sensor_force(VEHICLE, both, {own: 0.004}, (own, TILT[0]))
    turned, _ = sensor_force(VEHICLE, log, {TILT[0]: 0.004}, ())
    np.testing.assert_allclose(trimmed, np.concatenate([0.0 * turned, turned]))
    np.testing.assert_allclose(0.004 * slopes, [trimmed, np.concatenate([turned, 0.0 * turned])])
    # They need no time derivatives, as the sensor's place does.
    bare = replace(log, angular_acceleration=np.full_like(log.rates, np.nan))
    np.testing.assert_array_equal(sensor_force(VEHICLE, bare, values, names)[0], found)
    with pytest.raises(InputError, match="a log with time derivatives"):
        sensor_force(VEHICLE, bare, {}, ("sensor_x",))


def test_late_stamps_read_what_was_before() -> None:
    _, log = turning()
    late = 5e-3
    measured = np.stack([np.interp(TIME - late, TIME, a) for a in log.specific_force.T], axis=1)
    wanted = VEHICLE.mass * (measured - log.specific_force)
    found, slopes = sensor_force(VEHICLE, log, {CLOCK: late}, (CLOCK,))
    inside = slice(20, -20)
    np.testing.assert_allclose(found[inside], wanted[inside], atol=0.02 * np.abs(wanted).max())
    np.testing.assert_allclose(late * slopes[0], found)
    # Other flights have the mean of the clocks of a fit.
    values = {"clock_offset": 0.0, "clock_offset[a]": 0.004, "clock_offset[b]": 0.002, "c_l1": 5.0}
    others = of_others(values)
    assert others["clock_offset"] == pytest.approx(0.003) and others["c_l1"] == 5.0


def hovering(seconds: float) -> FlightLog:
    time = np.arange(0.0, 5.0, 0.01)
    still, up = np.zeros((time.size, 3)), np.tile([0.0, 0.0, 1.0], (time.size, 1))
    velocity = still + np.where(time < seconds, 0.0, 6.0)[:, None] * [1.0, 0.0, 0.0]
    return FlightLog(
        "test", time, velocity, still, up, GRAVITY * up, np.full((time.size, 4), 600.0)
    )


def test_each_flight_s_thrust_is_scaled_by_its_own_hover() -> None:
    flights = [hovering(2.0), hovering(0.2), hovering(3.0)]
    # A flight that needs lower rotor speeds for its weight has more thrust per square of them.
    factors = (1.05, 1.3, 0.97)
    slower = [
        replace(log, rotor_speed=log.rotor_speed / np.sqrt(k))
        for log, k in zip(flights, factors, strict=True)
    ]
    log = joined(slower)
    found = HoverScale.of(VEHICLE, log)
    # The second hovers for too short a time; the reference is the mean of the others.
    first, second, third = (f"thrust_scale[{k}]" for k in (1, 2, 3))
    assert found.scales == {first: pytest.approx(1.05 / 1.01), third: pytest.approx(0.97 / 1.01)}
    weight = VEHICLE.mass * GRAVITY
    assert found.reference == pytest.approx(1.01 * weight / (4 * 600.0**2), rel=1e-6)
    at = at_samples("thrust_scale", found.scales, log)
    np.testing.assert_allclose([at[0], at[-1]], [1.05 / 1.01, 0.97 / 1.01])
    np.testing.assert_allclose(at[log.flight == 1], 1.0)
    # Before a fit, a flight's own hover tells more of it than other flights do.
    priors = found.priors
    assert priors[first].mean == pytest.approx(1.05 / 1.01) and priors[second].mean == 1.0
    assert priors[first].deviation < priors[second].deviation
    # A fit that finds all flights 2 % stronger has so much less at the scale 1.
    fitted = found.reference_at({first: 1.02, third: 1.02})
    assert fitted == pytest.approx((found.reference or 0.0) / 1.02)
    # Two hundredths a hover may be off by itself.
    assert set(found.remarkable) == {first, third}
    near = HoverScale.of(VEHICLE, slower[0], (found.reference or 0.0) * 1.03)
    assert near.scales == {first: pytest.approx(1.05 / 1.01 / 1.03)} and near.remarkable == {}
    alone = HoverScale.of(VEHICLE, slower[0])
    assert alone.scales == {first: pytest.approx(1.0)} and alone.priors == {}
    known = HoverScale.of(VEHICLE, slower[0], found.reference)
    assert known.scales == {first: pytest.approx(1.05 / 1.01)}
    # Three times the thrust is another unit of the rotor speeds, not a battery.
    assert HoverScale.of(VEHICLE, slower[0], 3.0 * (found.reference or 0.0)).scales == {}
