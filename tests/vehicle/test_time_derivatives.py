"""Low-passed logs: what is slow stays where it is, what is fast goes, derivatives are right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.vehicle.log import FlightLog, low_passed


def log(time: np.ndarray, slow: float, fast: float = 0.0) -> FlightLog:
    """All signals a sine of 0.5 Hz, and one of 25 Hz; rotor speeds squared are."""
    wave = slow * np.sin(np.pi * time) + fast * np.sin(50.0 * np.pi * time)
    three = np.stack([wave, 2.0 * wave, -wave], axis=1)
    up = np.tile([0.0, 0.0, 1.0], (time.size, 1))
    rotors = np.sqrt(1e6 + 1e4 * np.stack([wave] * 4, axis=1))
    return FlightLog("test", time, three, three, up, three, rotors)


TIME = np.arange(0.0, 8.0, 0.01)
INSIDE = slice(100, -100)


def test_fast_signals_go_and_slow_ones_are_not_shifted() -> None:
    found, slow = low_passed(log(TIME, 1.0, 0.5), 6.0), log(TIME, 1.0)
    for name in ("velocity", "rates", "specific_force", "rotor_speed"):
        now, wanted = getattr(found, name)[INSIDE], getattr(slow, name)[INSIDE]
        np.testing.assert_allclose(now, wanted, rtol=1e-2, atol=5e-3, err_msg=name)
    np.testing.assert_allclose(np.linalg.norm(found.up, axis=1), 1.0)
    wanted = np.pi * np.cos(np.pi * TIME)
    for slopes in (found.angular_acceleration, found.specific_force_rate):
        np.testing.assert_allclose(slopes[INSIDE, 0], wanted[INSIDE], atol=0.1)
        np.testing.assert_allclose(slopes[INSIDE, 1], 2.0 * wanted[INSIDE], atol=0.2)


def test_without_a_cut_off_signals_are_as_they_were_but_derivatives_are_known() -> None:
    raw = log(TIME, 1.0, 0.5)
    found = low_passed(raw, 0.0)
    np.testing.assert_array_equal(found.velocity, raw.velocity)
    np.testing.assert_allclose(found.rotor_speed, raw.rotor_speed, rtol=1e-12)
    assert np.isfinite(found.angular_acceleration).all()
    # Too few samples per second for the cut-off.
    slow = log(np.arange(0.0, 8.0, 0.2), 1.0)
    np.testing.assert_array_equal(low_passed(slow, 6.0).velocity, slow.velocity)


def test_nothing_flows_across_a_gap() -> None:
    time = np.concatenate([TIME[:400], TIME[400:] + 5.0])
    steps = log(time, 0.0)
    velocity = np.where(time[:, None] > 4.5, 7.0, 0.0) * np.ones(3)
    found = low_passed(replace(steps, velocity=velocity, rates=velocity), 6.0)
    np.testing.assert_allclose(found.velocity, velocity, atol=1e-9)
    np.testing.assert_allclose(found.angular_acceleration, 0.0, atol=1e-9)


@pytest.mark.parametrize("cutoff", [-1.0, np.nan])
def test_a_cut_off_that_is_no_frequency_is_refused(cutoff: float) -> None:
    with pytest.raises(InputError, match="give a positive frequency, or 0 for"):
        low_passed(log(TIME, 1.0), cutoff)
