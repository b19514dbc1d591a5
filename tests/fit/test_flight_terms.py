"""What each term of a flight fit is worth: gains with honest errors, and what is unseen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.fit.comparison import (
    AxisErrors,
    RecordedFlight,
    Step,
    fit_terms,
    gain,
    judged,
    measured_off,
)
from propmap.fit.parameters import SECTION, Choice
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.log import FlightLog
from propmap.vehicle.vehicle import Mount, Vehicle

RATE, SECONDS = 50, 40
COUNT = RATE * SECONDS
LAW = propmap.airfoil("paper-apc")
VEHICLE = Vehicle("test", 1.0, propmap.propeller("apc-8x6e"), (Mount((0.0, 0.0, 0.0)),))


def flight(name: str, count: int = COUNT) -> RecordedFlight:
    still = np.zeros((count, 3))
    up = still + np.array([0.0, 0.0, 1.0])
    time, omega = np.arange(count) / RATE, np.full((count, 1), 700.0)
    log = FlightLog(name, time, still, still, up, GRAVITY * up, omega)
    return RecordedFlight(name, log, log)


def held(size: float, seconds: float, seed: int) -> Floats:
    """Errors (n, 3) [N] that stay alike for so many seconds."""
    steps = np.random.default_rng(seed).normal(0.0, size, (int(SECONDS / seconds) + 1, 3))
    return np.repeat(steps, int(RATE * seconds), axis=0)[:COUNT]


def test_a_term_that_takes_an_error_away_pays_by_its_square() -> None:
    rest, taken = held(0.1, 1.0, 1), np.zeros((COUNT, 3))
    taken[:, 2] = 0.5 * np.sign(np.sin(2.0 * np.pi * np.arange(COUNT) / RATE / 3.0))
    old, new = AxisErrors(rest + taken, rest), AxisErrors(rest, rest)
    fall, deviation = gain([old], [new], [flight("one")])
    assert fall == pytest.approx(0.25, abs=4.0 * deviation) and deviation < 0.02
    assert judged(fall, deviation) == "pays"
    back = gain([new], [old], [flight("one")])
    assert back[0] == pytest.approx(-fall) and judged(*back) == "makes it worse"
    # Samples without loads do not count.
    missing = rest + taken
    missing[100:150] = np.nan
    fall, _ = gain([AxisErrors(missing, rest)], [AxisErrors(0.5 * missing, rest)], [flight("one")])
    assert fall > 0.0 and np.isfinite(AxisErrors(missing, rest).rms).all()
    # A prediction that comes with the flight has errors of its own.
    weight = np.tile([0.0, 0.0, VEHICLE.mass * GRAVITY], (COUNT, 1))
    other = replace(flight("one"), prediction=weight + 0.2, raw_prediction=weight - 0.1)
    off = measured_off(VEHICLE, other)
    assert off is not None and measured_off(VEHICLE, flight("one")) is None
    np.testing.assert_allclose([off.rms, off.raw_rms], [[0.2] * 3, [0.1] * 3])


def test_noise_alone_hardly_ever_pays_though_it_is_alike_for_a_second() -> None:
    words = []
    for seed in range(200):
        old, new = (AxisErrors(held(0.3, 1.0, 2 * seed + k), np.zeros((1, 3))) for k in (0, 1))
        words.append(judged(*gain([old], [new], [flight("one")])))
    # Two standard errors to one side: 2 in a hundred, and a few more for 40 segments.
    assert words.count("pays") <= 12
    # Errors of single samples would make every tenth of these, or more, pay.
    each = held(0.3, 1.0, 0)
    apart = np.std(np.sum(each**2, axis=1)) / np.sqrt(COUNT)
    blocked = gain([AxisErrors(each, each)], [AxisErrors(0.0 * each, each)], [flight("one")])[1]
    assert blocked > 4.0 * apart


def test_each_flight_is_left_out_once() -> None:
    """Flights with more and more thrust: without a strong one the fitted lift is lower."""
    vehicle = replace(VEHICLE, mass=0.34)
    flights = []
    for seed, (name, factor) in enumerate((("a", 1.0), ("b", 1.1), ("c", 1.2))):
        one = flight(name, 300)
        force = factor * one.passed.specific_force + held(0.2, 1.0, seed)[:300]
        log = replace(one.passed, specific_force=force)
        flights.append(RecordedFlight(name, log, log))
    fixed = {name: getattr(LAW, name) for name in SECTION}
    free = ("c_l1", "c_d0")
    steps = [
        Step("one", Choice(free[:1], {n: v for n, v in fixed.items() if n not in free[:1]})),
        Step("two", Choice(free, {n: v for n, v in fixed.items() if n not in free})),
    ]
    found = fit_terms(vehicle, flights, steps, LAW, samples=20)
    assert [f.left_out for f in found] == [0, 1, 2, 0, 1, 2]
    without_a, without_b, without_c = (one.values["c_l1"] for one in found[:3])
    assert without_a > without_b > without_c
    assert set(found[-1].values) == {"c_l1", "c_d0"}
    alone = fit_terms(vehicle, flights[:1], steps[:1], LAW, samples=20)
    assert [f.left_out for f in alone] == [None]
