"""Balances of whole flights: wakes, sensor and hover scale as parameters; a twin experiment."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.fit.comparison import flight_forces, residual_trends
from propmap.fit.fit import Settings, fit
from propmap.fit.flight import ForceModel, HoverScale, balance_rows, level_rows
from propmap.fit.parameters import FIRST_GUESS, SECTION, Choice
from propmap.units import GRAVITY
from propmap.vehicle.log import FlightLog, joined, low_passed
from propmap.vehicle.vehicle import Mount, Vehicle, Wakes

LAW = propmap.airfoil("paper-apc")
SCALE = {"thrust_scale[1]": 1.03, "thrust_scale[2]": 0.98}
LAW_VALUES = {name: getattr(LAW, name) for name in SECTION}
ARM = 0.15
VEHICLE = Vehicle(
    "test",
    0.826,  # what four rotors carry at 560 rad/s
    propmap.propeller("apc-8x6e"),
    tuple(
        Mount((x, y, 0.02), spin=spin)
        for x, y, spin in (
            (ARM, ARM, "cw"),
            (ARM, -ARM, "ccw"),
            (-ARM, ARM, "ccw"),
            (-ARM, -ARM, "cw"),
        )
    ),
)
FREE = (
    "c_l1",
    "drag_area_z",
    "sensor_x",
    "sensor_y",
    "sensor_z",
    "clock_offset",
    "wake_ahead",
    "wake_downwash",
)
TRUTH = {
    "drag_area_z": 0.01,
    "sensor_x": -0.02,
    "sensor_y": 0.03,
    "sensor_z": 0.015,
    "clock_offset": 0.004,
    "wake_ahead": 1.8,
    "wake_beside": 0.6,
    "wake_downwash": 0.7,
    "wake_share": 1.2,
}


def forces(log: FlightLog, more: dict[str, float], vehicle: Vehicle = VEHICLE) -> np.ndarray:
    """All forces [N] (n, 3) with the true section law and these parameters."""
    return ForceModel(vehicle, log, LAW).at(FIRST_GUESS | LAW_VALUES | more, ()).force


def manoeuvre(seed: int, count: int = 120) -> FlightLog:
    """A climb with quick turns after a hover, all signals smooth; without an accelerometer yet.

    It stays out of descent, where loads have kinks.
    """
    rng = np.random.default_rng(seed)
    time = np.linspace(0.0, 6.0, 600)
    moving = np.clip(time - 1.0, 0.0, 1.0)[:, None]

    def waves(size: float) -> np.ndarray:
        rate, phase = rng.uniform(0.5, 4.0, (2, 1, 3)), rng.uniform(0.0, 6.0, (2, 1, 3))
        return size * moving * np.sum(np.sin(rate * time[None, :, None] + phase), axis=0)

    velocity = waves(4.0) * [1.0, 1.0, 0.2] + 2.5 * moving * [0.0, 0.0, 1.0]
    up = np.array([0.0, 0.0, 1.0]) + waves(0.1)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    rotors = 560.0 + 15.0 * np.hstack([waves(1.0), waves(1.0)[:, :1]])
    still = np.full_like(velocity, GRAVITY) * up
    log = low_passed(FlightLog("twin", time, velocity, waves(1.0), up, still, rotors), 0.0)
    return log.picked(slice(None, None, time.size // count))


def flown(scales: tuple[float, ...] = (1.0,), noise: float = 0.0) -> FlightLog:
    """Flights whose accelerometer reads what the true parameters make of them."""
    parts = []
    for seed, scale in enumerate(scales):
        log = manoeuvre(seed)
        jerk = np.cos(log.time)[:, None] * np.array([20.0, -10.0, 15.0])
        log = replace(log, specific_force_rate=jerk)
        alone = {name: value for name, value in TRUTH.items() if name.startswith("wake_")}
        rotors = forces(log, alone)
        others = forces(log, TRUTH) - rotors
        force = scale * rotors + others
        mess = noise * np.random.default_rng(100 + seed).standard_normal(force.shape)
        parts.append(replace(log, specific_force=(force + mess) / VEHICLE.mass))
    return joined(parts)


pytestmark = pytest.mark.slow


def test_slopes_of_all_parameters_against_differences() -> None:
    log = flown((1.03, 0.98))
    model = ForceModel(VEHICLE, log, LAW)
    free = (*FREE, "wake_beside", "wake_share", "rotor_speed_scale", *SCALE, "clock_offset[2]")
    values = FIRST_GUESS | LAW_VALUES | TRUTH | SCALE | {"clock_offset[2]": 0.003}
    values |= {"rotor_speed_scale": 1.01}
    found = model.at(values, free)
    for k, name in enumerate(free):
        h = 1e-4 * max(abs(values[name]), 0.1)
        up, down = (model.at({**values, name: values[name] + d}, free).loads for d in (h, -h))
        difference = (up - down) / (2.0 * h)
        size = np.max(np.abs(difference[:, :3]))
        assert size > 0.0, name
        off = np.abs(found.slopes[k] - difference)[:, :3] / size
        # At a few points a difference quotient spans a jump of the loads, within their accuracy.
        assert np.quantile(off, 0.95) < 5e-3, name


def test_without_wakes_nothing_changes_and_without_gains_nothing_is_added() -> None:
    log = manoeuvre(0, 20)
    plain = forces(log, {})
    none = {f"wake_{name}": 0.0 for name in ("ahead", "beside", "downwash")}
    np.testing.assert_array_equal(forces(log, none), plain)
    by_file = forces(log, {}, replace(VEHICLE, wakes=Wakes(2.0, 1.0, 1.0)))
    named = {"wake_ahead": 2.0, "wake_beside": 1.0, "wake_downwash": 1.0}
    np.testing.assert_array_equal(forces(log, named), by_file)
    assert np.max(np.abs(by_file - plain)) > 0.05


def test_the_same_forces_are_checked_as_were_fitted() -> None:
    log = flown((1.03, 0.98))
    own = TRUTH | SCALE | {"rotor_speed_scale": 1.01, "clock_offset[2]": 0.003}
    values = FIRST_GUESS | LAW_VALUES | own
    model = ForceModel(VEHICLE, log, LAW)
    found = flight_forces(VEHICLE, log, LAW, own)
    np.testing.assert_allclose(found.model, model.at(values, ()).loads, atol=2e-2)
    measured = HoverScale.of(VEHICLE, log).scales
    assert measured["thrust_scale[1]"] / measured["thrust_scale[2]"] == pytest.approx(
        1.03 / 0.98, abs=0.01
    )


def test_a_twin_is_found_again() -> None:
    """Known constants, sensor, gains and scales; the intervals of the identified hold the truth."""
    fixed = {n: v for n, v in (LAW_VALUES | TRUTH | SCALE).items() if n not in FREE}
    choice = Choice(FREE, fixed)
    for noise in (0.0, 0.05):
        log = flown((1.03, 0.98), noise)
        rows = balance_rows(ForceModel(VEHICLE, log, LAW), choice)
        found = fit(rows, choice, Settings(starts=1, folds=0))
        for name, x, low, high in zip(
            FREE, found.x, found.uncertainty.low, found.uncertainty.high, strict=True
        ):
            truth = (LAW_VALUES | TRUTH)[name]
            if noise == 0.0:
                assert abs(x - truth) < 0.01 * choice.column("spread")[FREE.index(name)], name
            else:
                assert low - 0.5 * (high - low) < truth < high + 0.5 * (high - low), name
        assert all("grows" in text or "falls" in text for text in residual_trends(found, log))


def test_a_sensor_has_no_part_in_steady_segments() -> None:
    model = ForceModel(VEHICLE, manoeuvre(0, 20), LAW)
    with pytest.raises(InputError, match="sensor_x has no effect in steady segments"):
        level_rows(model, Choice(("c_l1", "sensor_x")))


def test_a_parameter_of_a_flight_that_is_not_there() -> None:
    log = manoeuvre(0, 20)
    model = ForceModel(VEHICLE, log, LAW)
    with pytest.raises(InputError, match=r"'thrust_scale\[2\]' names no flight of the logs"):
        model.at(FIRST_GUESS | LAW_VALUES, ("c_l1", "thrust_scale[2]"))


def test_segments_of_two_flights_are_not_one() -> None:
    log = joined([manoeuvre(0, 20), manoeuvre(1, 20)])
    rows = balance_rows(ForceModel(VEHICLE, log, LAW), Choice(("c_l1",)))
    first, second = rows.group[: rows.group.size // 2], rows.group[rows.group.size // 2 :]  # type: ignore[index]
    assert not set(first.tolist()) & set(second.tolist())
