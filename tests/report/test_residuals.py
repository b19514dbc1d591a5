"""What a model leaves over, against every candidate: strongest first, honest bars, in words."""

from __future__ import annotations

import csv
import io
import re
from html import unescape

import numpy as np
import pytest
from matplotlib.figure import Figure

import propmap
from propmap.fit.comparison import SpeedErrors, candidates, trends
from propmap.fit.files import FitFile
from propmap.fit.least_squares import by_band, errors
from propmap.report import fit_curves, fit_page
from propmap.report.fit_page import GivenData, binned, residuals, sentences
from propmap.report.html import PAGE, REPORT_FILES, FigureRecord
from propmap.typing import Floats
from propmap.vehicle.log import FlightLog, joined
from tests.fit.fit_records import load, record

RNG = np.random.default_rng(1)
COUNT, RATE = 3000, 50.0


def wandering(seconds: float) -> Floats:
    """Noise that is alike within so many seconds; (n,), of deviation 1."""
    steps = RNG.standard_normal(int(COUNT / RATE / seconds) + 2)
    return np.repeat(steps, int(RATE * seconds))[:COUNT]


def flown() -> FlightLog:
    velocity = np.stack([5.0 * wandering(0.5), 2.0 * wandering(0.5), wandering(0.5)], axis=1)
    rates = np.stack([wandering(0.2) for _ in range(3)], axis=1)
    up = np.tile([0.0, 0.0, 1.0], (COUNT, 1))
    speeds = 1000.0 + 50.0 * np.stack([wandering(0.2) for _ in range(4)], axis=1)
    return FlightLog("made up", np.arange(COUNT) / RATE, velocity, rates, up, 9.8 * up, speeds)


LOG = flown()
LEFT = 0.3 + 0.05 * LOG.climb_rate + 0.1 * wandering(1.0) + 0.01 * RNG.standard_normal(COUNT)
"""Grows with the climb rate, with an error that is alike for a second."""

TRENDS = trends(LOG, "force_z", "N", LEFT, LOG.segments(1.0))


def test_the_strongest_is_first_and_told_with_its_slope() -> None:
    shares = [trend.share for trend in TRENDS]
    assert shares == sorted(shares, reverse=True)
    assert {trend.variable for trend in TRENDS} == set(candidates(LOG))
    # The climb rate is the velocity along z here, of which descent is a part; nothing else is told.
    first = {
        "velocity along the body's z axis",
        "climb rate",
        "descent speed along the body's z axis",
    }
    assert {trend.variable.removesuffix(" [m/s]") for trend in TRENDS[:3]} == first
    climb = next(trend for trend in TRENDS if trend.variable.startswith("climb"))
    assert climb.sure and climb.slope == pytest.approx(0.05, abs=3.0 * climb.error)
    told = sentences([TRENDS])
    assert 2 <= len(told) <= 3 and any("increases with the climb rate" in text for text in told)
    assert "N per m/s" in told[0] and all("force_z" in text for text in told)


def test_errors_of_means_count_a_second_as_one() -> None:
    """50 samples that err alike are worth one."""
    trend = next(one for one in TRENDS if one.variable.startswith("time"))
    found = binned(trend)
    assert found["samples"].sum() == COUNT and found["mean_in_unit"].size == 8
    within = [trend.residual[(trend.at >= a) & (trend.at <= b)]
              for a, b in zip(found["bin_from"], found["bin_to"], strict=True)]  # fmt: skip
    alone = np.array([part.std() / np.sqrt(part.size) for part in within])
    ratio = found["mean_error_in_unit"] / alone
    # The square root of the samples per second, less what the climb rate does within one.
    assert np.all(ratio > 4.0) and np.all(ratio < np.sqrt(RATE))
    means = np.array([part.mean() for part in within])
    np.testing.assert_allclose(found["mean_in_unit"], means, atol=0.01)


def test_a_variable_that_hardly_changes_has_few_bins() -> None:
    still = FlightLog(**{**LOG.__dict__, "velocity": np.zeros_like(LOG.velocity)})
    for trend in trends(still, "force_x", "N", LEFT, still.segments(1.0)):
        found = binned(trend)
        assert found["samples"].sum() == COUNT
        assert all(np.isfinite(values).all() for values in found.values())
        if "velocity" in trend.variable:
            assert found["mean_in_unit"].size == 1 and not trend.sure


def test_samples_without_a_residual_are_left_out_and_flights_are_apart() -> None:
    some = np.where(np.arange(COUNT) % 3 == 0, np.nan, LEFT)
    one = trends(LOG, "force_z", "N", some, LOG.segments(1.0))[0]
    assert one.at.size == one.residual.size == one.block.size == COUNT - COUNT // 3
    assert np.unique(joined([LOG, LOG]).segments(1.0)).size == 2 * COUNT / RATE


def test_the_page_has_a_picture_and_a_sheet_of_each_force(monkeypatch: pytest.MonkeyPatch) -> None:
    nothing = FigureRecord("fit-loads", [], Figure), {"rpm": 5000.0, "draws": 0, "motor": ""}
    monkeypatch.setattr(fit_curves, "load_lines", lambda *_: nothing)
    monkeypatch.setattr("propmap.report.html.as_svg", lambda _: b"<svg/>")
    measured = 7.6 + 0.0 * LEFT
    compared = SpeedErrors(
        errors(measured + LEFT, measured, measured),
        by_band(measured + LEFT, measured, LOG.speed, measured),
    )
    calm = trends(LOG, "force_x", "N", 0.1 * wandering(1.0), LOG.segments(1.0))
    given = GivenData([], {"force_z_N": compared}, residuals=[calm, TRENDS])
    fit = FitFile(propmap.airfoil("paper-apc"), None, record(loads=[load("force_z", 0.02, 0.3)]))
    files = fit_page.fit_pages(fit, "fit.toml", "abc", given)
    assert set(files) <= REPORT_FILES
    assert {"fit-residuals-1.svg", "fit-residuals-2.svg", "fit-residuals-1.csv"} <= set(files)
    text = unescape(re.sub(r"<[^>]+>", " ", str(files[PAGE])))
    for told in sentences([calm, TRENDS]):
        assert told[1:] in text
    assert "strongest dependence first" in text
    first = next(csv.DictReader(io.StringIO(str(files["fit-residuals-2.csv"]))))
    assert first["variable"] == TRENDS[0].variable.partition(" [")[0]
    assert float(first["slope"]) == pytest.approx(TRENDS[0].slope, rel=1e-4)
    assert residuals("fit-residuals-2", TRENDS).csv() == files["fit-residuals-2.csv"]
