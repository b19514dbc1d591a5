"""A learned residual: finds what is missing, leaves pure noise alone, and fades outside."""

from __future__ import annotations

import json

import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.fit.learned_residual import FADE, LearnedResidual, features, learn
from propmap.typing import Floats
from propmap.vehicle.log import FlightLog
from propmap.vehicle.vehicle import Mount, Vehicle

RATE, SECONDS = 20, 120
COUNT = RATE * SECONDS
VEHICLE = Vehicle(
    "test",
    1.0,
    propmap.propeller("apc-8x6e"),
    tuple(Mount((x, y, 0.0)) for x in (0.15, -0.15) for y in (0.15, -0.15)),
)


def smooth(rng: np.random.Generator, columns: int, seconds: float = 1.0) -> Floats:
    """Signals (n, columns) of deviation about 1 that change within so many seconds."""
    steps = rng.standard_normal((int(SECONDS / seconds) + 2, columns))
    at, known = np.arange(COUNT) / RATE, np.arange(len(steps)) * seconds
    return np.stack([np.interp(at, known, column) for column in steps.T], axis=1)


def flown(seed: int, fastest: float = 4.0) -> FlightLog:
    rng = np.random.default_rng(seed)
    up = np.tile([0.0, 0.0, 1.0], (COUNT, 1))
    velocity, rates = fastest * smooth(rng, 3), smooth(rng, 3)
    omega = 600.0 + 40.0 * smooth(rng, 4)
    return FlightLog(f"flight {seed}", np.arange(COUNT) / RATE, velocity, rates, up, up, omega)


def noise(seed: int, size: float = 0.1) -> Floats:
    """Alike for a second."""
    steps = np.random.default_rng(1000 + seed).normal(0.0, size, (SECONDS, 3))
    return np.repeat(steps, RATE, axis=0)


def missing(log: FlightLog) -> Floats:
    """What the physics lacks [N]: drag along x, and a download of sideways flow."""
    force = np.zeros((len(log), 3))
    force[:, 0] = -4e-5 * log.velocity[:, 0] * np.sqrt(np.mean(log.rotor_speed**2, axis=1)) * 4.0
    force[:, 2] = -0.02 * log.velocity[:, 1] ** 2
    return force


def test_a_missing_term_is_found_on_a_flight_that_was_not_seen() -> None:
    seen, unseen = flown(1), flown(2)
    found = learn(VEHICLE, seen, missing(seen) + noise(1))
    assert found.pays == (True, False, True)
    assert all(found.with_it[[0, 2]] < 0.7 * found.without[[0, 2]])
    added = found.at(VEHICLE, unseen)
    inside = added.status == "ok"
    assert inside.mean() > 0.5
    off = (added.force - missing(unseen))[inside]
    truth = missing(unseen)[inside]
    assert np.sqrt(np.mean(off[:, 0] ** 2)) < 0.25 * np.sqrt(np.mean(truth[:, 0] ** 2))
    assert np.sqrt(np.mean(off[:, 2] ** 2)) < 0.25 * np.sqrt(np.mean(truth[:, 2] ** 2))
    np.testing.assert_array_equal(added.force[:, 1], 0.0)
    # What is left is the noise, and the deviation says so.
    left = (missing(unseen) + noise(2) - added.force)[inside] / added.deviation[inside]
    assert np.all((np.sqrt(np.mean(left**2, axis=0)) > 0.7) & (np.abs(left) < 8.0).all(axis=0))
    assert np.all(np.sqrt(np.mean(left**2, axis=0)) < 1.5)


def test_pure_noise_does_not_pay_though_it_is_alike_for_a_second() -> None:
    words = [learn(VEHICLE, flown(seed), noise(seed)).pays for seed in range(10, 30)]
    assert np.sum(words) <= 2
    none = learn(VEHICLE, flown(3), noise(3))
    if not any(none.pays):
        np.testing.assert_array_equal(none.at(VEHICLE, flown(4)).force, 0.0)
    assert "does not pay, left out" in " ".join(none.sentences())


def test_outside_the_envelope_it_is_clipped_and_fades_away() -> None:
    seen = flown(1)
    found = learn(VEHICLE, seen, missing(seen) + noise(1))
    fastest = np.argmax(seen.velocity[:, 0])
    one = seen.picked(np.array([fastest]))
    speeds = np.linspace(1.0, 3.0, 60)
    forces, strengths = [], []
    for factor in speeds:
        added = found.at(VEHICLE, _faster(one, factor))
        forces.append(added.force[0])
        strengths.append(added.strength[0])
    assert strengths[0] == 1.0 and strengths[-1] == 0.0
    assert np.all(np.diff(strengths) <= 0.0)
    np.testing.assert_array_equal(forces[-1], 0.0)
    # Clipped before it fades: it never grows past the envelope.
    assert np.max(np.abs(np.array(forces)[:, 0])) <= abs(forces[0][0]) * 1.001
    assert found.at(VEHICLE, _faster(one, 3.0)).status[0] == "off"
    assert np.max(np.abs(np.diff(strengths))) < 1.0 and FADE < 1.0


def _faster(log: FlightLog, factor: float) -> FlightLog:
    velocity = log.velocity * np.array([factor, 1.0, 1.0])
    return FlightLog(
        log.source, log.time, velocity, log.rates, log.up, log.specific_force, log.rotor_speed
    )


def test_features_have_no_dimension() -> None:
    """The flight of a vehicle twice as large, at half the rotor speed and the same speeds."""
    log = flown(1)
    blade = VEHICLE.propeller
    large = propmap.Propeller(
        "twice", 2, 2.0 * blade.station, 2.0 * blade.chord, blade.twist, 2.0 * blade.root
    )
    places = tuple(Mount((2.0 * m.position[0], 2.0 * m.position[1], 0.0)) for m in VEHICLE.mounts)
    twice = Vehicle("twice", 1.0, large, places)
    slower = FlightLog(
        "slower", log.time, log.velocity, log.rates / 2.0, log.up, log.up, log.rotor_speed / 2.0
    )
    for (name, one), other in zip(
        features(VEHICLE, log).items(), features(twice, slower).values(), strict=True
    ):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12, err_msg=name)


def test_it_comes_back_from_a_file_and_damage_is_told() -> None:
    seen = flown(1)
    found = learn(VEHICLE, seen, missing(seen) + noise(1))
    table = json.loads(json.dumps(found.table()))
    again = LearnedResidual.of_table(table)
    np.testing.assert_array_equal(again.at(VEHICLE, seen).force, found.at(VEHICLE, seen).force)
    for damage in ({"weights": [[1.0]]}, {"names": 3}, {"low": "x"}):
        with pytest.raises(InputError, match="learned residual is damaged"):
            LearnedResidual.of_table({**table, **damage})


def test_a_short_flight_is_refused() -> None:
    short = flown(1).picked(slice(0, 200))
    with pytest.raises(InputError, match=r"10 stretches of 1 s; learn a residual from 20"):
        learn(VEHICLE, short, noise(1)[:200])
