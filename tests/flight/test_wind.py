"""The wind over simulated flights is found within its band, and the band grows without evidence."""

from __future__ import annotations

import functools
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from propmap.cli import main
from propmap.errors import InputError
from propmap.fit.files import FitFile, read_fit
from propmap.flight.simulate import log_table
from propmap.flight.wind import (
    FIRST,
    UP,
    VERTICAL,
    WHITE,
    WindEstimate,
    _Balance,
    bands,
    estimate_wind,
)
from propmap.model.envelope import Envelope
from propmap.vehicle.log import FlightLog, low_passed

from . import windy
from .synthetic import vehicle_text


def estimated(log: FlightLog, fit: FitFile | None = None) -> WindEstimate:
    return estimate_wind(fit or windy.fit_of(), windy.VEHICLE, low_passed(log, windy.CUTOFF))


@functools.cache
def still(path: str, wind: tuple[float, float, float], heading: float = 0.0) -> FlightLog:
    """A flight in steady wind, without differences between flights."""
    mean = np.array([wind])
    return windy.flights(path, mean, 0.0, 12.0, 3, differing=False, heading=heading)[0].log


def test_gusts_are_in_the_band() -> None:
    mean = np.array([[5.0, -3.0, 0.0], [0.0, 0.0, 0.3]])
    inside, z_scores = [], []
    for flown in windy.flights("aggressive", mean, 4.0, 10.0, seed=7, differing=False):
        found = estimated(flown.log)
        true = flown.wind[np.searchsorted(flown.log.time, found.log.time)]
        known = np.isfinite(found.wind[:, 0])
        assert known.mean() > 0.8
        inside.append((np.abs(found.wind - true) <= bands(found.covariance))[known])
        z_scores.append((found.mean - true.mean(axis=0)) / found.mean_half_width)
        # The estimate follows the gusts: its error is smaller than the gusts.
        off, moving = (found.wind - true)[known], (true - true.mean(axis=0))[known]
        assert np.mean(off[:, :2] ** 2) < 0.5 * np.mean(moving[:, :2] ** 2)
    assert np.mean(np.concatenate(inside)) > 0.9
    assert np.sqrt(np.mean(np.square(z_scores))) < 1.0


@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_wind_from_the_north_comes_from_the_north(heading: float) -> None:
    found = estimated(still("cruise", (0.0, -6.0, 0.0), heading))
    speed, half, source, wide = found.source
    assert abs(speed - 6.0) < half < 3.0
    assert abs(math.remainder(source, 2.0 * math.pi)) < wide < 0.5
    assert np.abs(found.mean - [0.0, -6.0, 0.0]).max() < 1.0
    assert found.remarks == ()


def test_still_air_has_no_wind_and_no_direction() -> None:
    found = estimated(still("hover", (0.0, 0.0, 0.0)))
    assert (np.abs(found.mean) < found.mean_half_width).all()
    assert math.isnan(found.source[2]) and "undetermined direction" in found.summary
    assert np.hypot(*found.gusts[:2]) < 1.0
    # A mean of exactly zero has a direction by chance only, and keeps its band.
    nothing = replace(found, mean=np.zeros(3)).source
    assert nothing[1] == pytest.approx(found.mean_half_width[0]) and math.isnan(nothing[2])


def test_without_drag_the_wind_is_not_determined() -> None:
    """Without in-plane force, hover leaves the horizontal wind at its prior."""
    bare = windy.LAW.with_corrections(["pitt-peters", "installed:factor=0"])
    hover = still("hover", (0.0, 0.0, 0.0))
    blind, seen = estimated(hover, windy.fit_of(bare)), estimated(hover)
    least = bands(blind.covariance)[:, :2].min()
    assert least > 1.5 * bands(seen.covariance)[:, :2].max()
    assert blind.well_determined == 0.0


def test_the_smoother_is_the_conditional_distribution() -> None:
    """Mean and covariance are those of all samples at once, also without loads in a gap."""
    rng = np.random.default_rng(3)
    time = np.cumsum(rng.uniform(0.1, 0.6, 14))
    by_wind, target = rng.normal(0.0, 1.0, (14, 3, 3)), rng.normal(0.0, 2.0, (14, 3, 3))
    by_wind[5:9, 0, 0] = np.nan
    scales, common = np.log([0.3, 0.1, 0.2, 0.5, 1.0]), np.diag([0.5, 2.0])
    balance = _Balance.of(time, by_wind, target)
    found = balance.smoothed(scales, common)

    since = np.minimum.outer(time, time) - time[0]
    lag = np.abs(np.subtract.outer(time, time))
    prior = np.zeros((14, 3, 14, 3))
    error = np.zeros((14, 3, 14, 3))
    for k in range(3):
        prior[:, k, :, k] = FIRST**2 + np.exp(scales[0]) * since
        error[:, k, :, k] = (1.0 - WHITE**2) * np.exp(-lag / np.exp(scales[2 + k]))
        error[:, k, :, k] += WHITE**2 * np.eye(14)
    prior[:, 2, :, 2] = np.exp(scales[1] - lag / VERTICAL)
    prior, error = prior.reshape(42, 42), error.reshape(42, 42)
    kept = np.repeat(np.isfinite(by_wind[:, 0, 0]), 3)
    slopes = np.zeros((42, 42))
    for k in range(14):
        slopes[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = by_wind[k]
    slopes, off = slopes[kept], target.reshape(42, 3)[kept]
    gain = prior @ slopes.T @ np.linalg.inv(slopes @ prior @ slopes.T + error[np.ix_(kept, kept)])
    mean, covariance = gain @ off, prior - gain @ slopes @ prior
    # The mean over time, with the wind at the start of each interval.
    share = np.kron(np.diff(time) / (time[-1] - time[0]), np.eye(3))
    of_mean = share @ covariance[:-3, :-3] @ share.T
    # The prior of the mean vertical wind also determines the common parameters.
    up = share @ mean[:-3]
    expected = UP**2 + 0.1 * min(1.0, 2.0 * VERTICAL / (time[-1] - time[0])) - of_mean[2, 2]
    weight = up[2, 1:] / expected
    posterior = np.linalg.inv(np.linalg.inv(common) + np.outer(weight, up[2, 1:]))
    errors = np.append(1.0, -posterior @ weight * up[2, 0])
    covariance = covariance + mean[:, 1:] @ posterior @ mean[:, 1:].T
    of_mean = of_mean + up[:, 1:] @ posterior @ up[:, 1:].T
    np.testing.assert_allclose(found.wind.ravel(), mean @ errors, atol=1e-8)
    half = bands(found.covariance)
    np.testing.assert_allclose(half.ravel(), bands(covariance), rtol=1e-8)
    np.testing.assert_allclose(found.mean, up @ errors, atol=1e-8)
    np.testing.assert_allclose(found.mean_covariance, of_mean, atol=1e-8)
    alone = bands(balance.smoothed(scales, 0.0 * common).covariance).sum(axis=1)
    assert alone[7] > max(alone[3], alone[11])


def test_the_band_contains_the_effect_of_a_trim() -> None:
    """Trimmed by 0.01 rad, an accelerometer reads a force of 0.01 m g, like the drag of a wind."""
    log = still("hover", (3.0, 0.0, 0.0))
    found = estimated(log)
    tilted = log.specific_force - np.cross([0.0, 0.01, 0.0], log.specific_force)
    moved = estimated(replace(log, specific_force=tilted))
    change = np.linalg.norm(moved.wind[0, :2] - found.wind[0, :2])
    assert 0.15 < change < np.max(bands(found.covariance)[0, :2])


def test_another_vehicle_has_a_doubt() -> None:
    log = still("hover", (0.0, 0.0, 0.0))
    heavy = replace(log, specific_force=1.25 * log.specific_force)
    found = estimated(heavy)
    assert any("whether this is the vehicle of the fit" in text for text in found.remarks)
    # The excess of lift appears as vertical wind only.
    half = bands(found.mean_covariance)
    assert np.all(np.abs(found.mean[:2]) < half[:2]) and found.mean[2] > 5.0


def test_an_error_of_the_thrust_is_no_lasting_vertical_wind() -> None:
    """With 1 % more thrust, the mean vertical wind and its error stay within the band."""
    log = still("hover", (0.0, 0.0, 0.0))
    found, more = (
        estimated(replace(log, specific_force=scale * log.specific_force)) for scale in (1.0, 1.01)
    )
    assert 0.0 < more.mean[2] - found.mean[2] < 0.2
    assert abs(more.mean[2]) < more.mean_half_width[2] < 0.7


def test_a_flight_has_its_own_scale_even_if_its_name_is_that_of_a_fitted_flight() -> None:
    log = still("hover", (0.0, 0.0, 0.0))
    other = replace(log, flights=("another",))
    assert log.flights == ("1",)  # the fit contains thrust_scale[1]
    assert np.array_equal(estimated(log).mean_half_width, estimated(other).mean_half_width)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"specific_force": np.full((600, 3), np.nan)}, "no specific force or heading"),
        ({"east": np.full((600, 3), np.nan)}, "no specific force or heading; log accelerometer"),
    ],
)
def test_a_log_without_a_signal_is_refused(change: dict[str, np.ndarray], told: str) -> None:
    log = still("hover", (0.0, 0.0, 0.0))
    with pytest.raises(InputError, match=told):
        estimated(replace(log, **change))  # type: ignore[arg-type]


def test_other_fits_and_logs_without_flight_are_refused() -> None:
    log = still("hover", (0.0, 0.0, 0.0))
    with pytest.raises(InputError, match=r"tunnel fit.*--method balance"):
        estimated(log, windy.fit_of(kind="tunnel"))
    with pytest.raises(InputError, match="0 samples in flight"):
        estimate_wind(windy.fit_of(), windy.VEHICLE, log.picked(slice(0)))


def test_beyond_the_data_of_the_fit_the_bands_are_wider() -> None:
    """The fit contains V/(Omega R) up to 0.02, and the wind alone is more than twice as fast.

    The error beyond the data is the same for all samples, so the band of the mean contains it.
    """
    narrow = Envelope((0.0, 100.0), (0.0, 0.02), (0.0, 0.02), (-0.02, 0.02), (1000.0, 20000.0))
    log = still("hover", (0.0, -6.0, 0.0))
    found, known = estimated(log, windy.fit_of(envelope=narrow)), estimated(log)
    assert set(found.status) <= {"extrapolated", "weak"} and "fitted data" in found.remarks[0]
    assert np.all(np.abs(found.mean - [0.0, -6.0, 0.0]) < found.mean_half_width)
    assert np.all(found.mean_half_width[:2] > 2.0 * known.mean_half_width[:2])


@pytest.mark.slow
def test_a_fit_to_slow_flight_does_not_extrapolate_its_error_of_the_thrust(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In slow flight, a loss of thrust up to 8 % is no force of the body.

    As a force of the body, it would grow with the square of the airspeed, like a vertical wind.
    """
    monkeypatch.setitem(windy.PATHS, "slow", (2.0, 0.6, 0.3))
    slow = windy.flights("slow", np.zeros((1, 3)), seconds=12.0, differing=False)[0].log
    less = 1.0 - 0.08 * np.minimum(slow.speed / 2.5, 1.0) ** 2
    slow = replace(slow, specific_force=less[:, None] * slow.specific_force)
    log, vehicle, fit = (str(tmp_path / name) for name in ("slow.csv", "quad.toml", "fit.toml"))
    windy.write(slow, Path(log))
    text = re.sub("(?m)^inertia.*\n", "", vehicle_text(log_table(4)))
    Path(vehicle).write_text(text)
    more = ["--vehicle", vehicle, "-o", fit, *windy.QUICK, "--samples", "150"]
    assert main(["fit", "flight", log, *more]) == 0
    known = read_fit(Path(fit))
    assert "plate_area" not in known.record.free
    true = np.array([0.0, -9.0, 0.0])
    found = estimated(still("hover", (0.0, -9.0, 0.0)), known)
    assert np.all(np.abs(found.mean - true) < found.mean_half_width)
    assert abs(found.mean[2]) < 0.3 and found.mean_half_width[2] < 2.5
    assert np.mean(np.abs(found.wind - true) <= bands(found.covariance)) > 0.95
