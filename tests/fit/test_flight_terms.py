"""What each term of a flight fit is worth: gains with honest errors, and what is unseen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.fit import comparison
from propmap.fit.comparison import (
    AxisErrors,
    RecordedFlight,
    Step,
    fit_terms,
    gain,
    judged,
    measured_off,
)
from propmap.fit.parameters import FIRST_GUESS, SECTION, Choice
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


def test_samples_without_loads_do_not_count() -> None:
    off = held(0.3, 1.0, 5)
    broken = off.copy()
    broken[100:150] = np.nan
    fall, _ = gain([AxisErrors(broken, off)], [AxisErrors(0.5 * broken, off)], [flight("one")])
    assert np.isfinite(fall) and fall > 0.0
    assert np.isfinite(AxisErrors(broken, off).rms).all()


def test_a_prediction_that_comes_with_the_flight() -> None:
    one = flight("one")
    assert measured_off(VEHICLE, one) is None
    weight = np.tile([0.0, 0.0, VEHICLE.mass * GRAVITY], (COUNT, 1))
    off = measured_off(VEHICLE, replace(one, prediction=weight + 0.2, raw_prediction=weight - 0.1))
    assert off is not None
    np.testing.assert_allclose(off.rms, 0.2)
    np.testing.assert_allclose(off.raw_rms, 0.1)


def test_each_flight_is_left_out_once(monkeypatch: pytest.MonkeyPatch) -> None:
    fitted_to = []

    class Model:
        def __init__(self, vehicle: Vehicle, log: FlightLog, _: object) -> None:
            fitted_to.append(log.source)
            self.vehicle, self.log = vehicle, log

    class Found:
        values = FIRST_GUESS | {name: getattr(LAW, name) for name in SECTION}

    monkeypatch.setattr("propmap.fit.flight.ForceModel", Model)
    monkeypatch.setattr("propmap.fit.flight.vertical_rows", lambda *_: "vertical")
    monkeypatch.setattr("propmap.fit.flight.balance_rows", lambda *_: "balance")
    monkeypatch.setattr(comparison, "fit", lambda *_: Found)
    zero = np.zeros((COUNT, 3))
    monkeypatch.setattr(
        comparison, "flight_forces", lambda *_: type("F", (), {"model": zero, "hover": zero})
    )
    flights = [flight(name) for name in ("a", "b", "c")]
    steps = [Step("one", Choice(("c_l1",)), vertical=True), Step("two", Choice(("c_l1", "c_d")))]
    found = fit_terms(VEHICLE, flights, steps, LAW, samples=50)
    assert [f.left_out for f in found] == [0, 1, 2, 0, 1, 2]
    assert fitted_to == 2 * ["b, c", "a, c", "a, b"]
    assert set(found[-1].values) == {"c_l1", "c_d"}
    alone = fit_terms(VEHICLE, flights[:1], steps, LAW, samples=50)
    assert [f.left_out for f in alone] == [None, None]
