"""The page on a fit: what it concludes, and what its bands are."""

from __future__ import annotations

import re
from html import unescape

import msgspec
import numpy as np
import pytest
from matplotlib.figure import Figure

import propmap
from propmap.fit.comparison import compared
from propmap.fit.files import FitFile, FitRecord
from propmap.loads import LOADS
from propmap.report import fit_curves, fit_page
from propmap.report.fit_curves import DRAWS, drawn_changes, held, load_lines
from propmap.report.fit_page import angles_without_data, overall, speed_rows
from propmap.report.html import PAGE, FigureRecord
from tests.fit.fit_records import ENVELOPE, covered, load, parameter, record


def file_of(fit: FitRecord) -> FitFile:
    return FitFile(propmap.airfoil("paper-apc"), None, fit)


def told(
    fit: FitRecord, monkeypatch: pytest.MonkeyPatch, given: fit_page.GivenData | None = None
) -> str:
    """The text of the page, without load curves and pictures."""
    nothing = FigureRecord("fit-loads", [], Figure), {"rpm": 5000.0, "draws": 0, "motor": ""}
    monkeypatch.setattr(fit_curves, "load_lines", lambda *_: nothing)
    monkeypatch.setattr("propmap.report.html.as_svg", lambda _: b"<svg/>")
    html = fit_page.fit_pages(file_of(fit), "fit.toml", "abc", given)[PAGE]
    assert isinstance(html, str)
    text = unescape(re.sub(r"<[^>]+>", " ", html)).replace("\N{NO-BREAK SPACE}", " ")
    return " ".join(text.split())


def test_the_verdict_follows_the_errors() -> None:
    for rms, hover, crossed, level in (
        (0.02, 0.3, 0.022, "good"),
        (0.06, 0.3, 0.061, "caution"),
        (0.2, 0.5, 0.21, "bad"),
        (0.02, 0.3, 0.08, "caution"),  # It follows the noise.
        (0.04, 0.03, 0.04, "caution"),  # The hover model is no worse.
    ):
        assert overall(record(loads=[load("thrust", rms, hover, crossed)])) == level
    # One speed alone is never trusted.
    assert overall(record(speed=(7.0, 7.5))) == "caution"


@pytest.mark.parametrize(
    ("share", "off", "level"),
    [(0.02, 1.0, "Reliable"), (0.2, 0.04, "Use with care"), (0.2, 1.0, "Not reliable")],
)
def test_a_use_beyond_the_data_is_no_yes(
    share: float, off: float, level: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    count = 100
    inplane = np.where(np.arange(count) < share * count, 30.0, 3.0)
    beyond = ENVELOPE.beyond(np.full(count, 500.0), np.zeros(count), inplane, 0.1)
    measured = np.ones(count)
    model = measured + np.where(beyond.samples, off, 0.01)
    errors = compared(model, measured, inplane, measured + 2.0, beyond)
    given = fit_page.GivenData([], {"thrust_N": errors}, beyond=beyond)
    text = told(record(), monkeypatch, given)
    assert f"{level}. Within the fitted data" in text
    assert ("The given data exceed the fitted range." in text) == (level != "Reliable")
    if level != "Reliable":
        assert "20.0% of the rows are outside the fitted data: V sin(beta)" in text
        assert f"errors of these samples are thrust {off:g} N (0.01 within the data)." in text


def test_every_speed_has_its_own_answer() -> None:
    rows = speed_rows(record())
    # 1 % below 3 m/s, 8 % above 6: the whole is 2 %.
    assert [row[-1] for row in rows] == ["Reliable", "Use with care"]
    assert rows[1][2] == "8 / 30"


def test_what_was_not_fitted_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    text = told(record(), monkeypatch)
    assert "The fit used no data on rotor drag, torque, rolling moment" in text
    assert "rotor drag of bare blades is accurate to about 20 %" in text
    # The worst load decides.
    fit = record(loads=[load("thrust", 0.02, 0.3, 0.02), load("torque", 0.3, 0.6, 0.3)])
    assert overall(fit) == "bad"
    text = told(fit, monkeypatch)
    assert "Within the fitted data (0.0 to 9.0 m/s, 4000 to 6000 rpm, β from 0° to 90°)" in text
    assert "thrust 2 % (hover model 30 %), torque 30 % (hover model 60 %). These errors" in text
    rest = [load(name, 0.02, 0.3) for name in LOADS if name != "roll_moment"]
    text = told(record(loads=rest), monkeypatch)
    assert "rolling moment: this load is an extrapolation at every airspeed" in text
    flown = told(record(kind="flight", loads=[load("force_z", 0.02, 0.3)]), monkeypatch)
    assert "torque and moments of a single rotor were not measured" in flown


def test_a_moment_no_better_than_none_is_not_to_be_used(monkeypatch: pytest.MonkeyPatch) -> None:
    useful = load("moment_x", 0.7, 3.0)
    across = msgspec.structs.replace(load("force_y", 0.04, 0.05), relative_rms=0.04 / 0.05)
    found = record(kind="flight", loads=[across, load("force_z", 0.02, 0.3), useful])
    # Forces are compared with the largest of them, moments are no answer for the forces.
    assert overall(found) == "good"
    assert "moment about x 70 % (hover model 300 %)" in told(found, monkeypatch)
    useless = load("moment_z", 0.9, 3.0, 1.1)
    found = record(kind="flight", loads=[load("force_z", 0.02, 0.3), useful, useless])
    assert overall(found) == "caution"
    one = np.ones(4)
    given = {"moment_z_Nm": compared(one, -one, one, np.zeros(4), None)}
    text = told(found, monkeypatch, fit_page.GivenData([], given))
    assert "The error of moment_z is 110 % of the measured moment" in text
    assert "The error of moment_z is 200 % of the measured moment" in text
    assert text.count("do not use the") == 2 and "error of moment_x" not in text


def test_angles_without_data_are_extrapolation(monkeypatch: pytest.MonkeyPatch) -> None:
    sparse = covered(150.0, 0.2, points=0)
    fit = record(angles=[covered(0.0, 0.2), covered(90.0, 0.25), sparse])
    assert angles_without_data(fit) == "30° to 60° and 120° to 180°"
    text = told(fit, monkeypatch)
    assert "advance ratios above 0.25; angles 30° to 60° and 120° to 180° (no data)" in text
    at_rest = told(record(angles=[], at_rest=covered(0.0, 0.01)), monkeypatch)
    assert "every airspeed above zero is extrapolation" in at_rest


def test_draws_have_the_covariance_and_keep_to_the_bounds() -> None:
    matrix = np.array([[0.04, 0.018], [0.018, 0.01]])
    names, changes = drawn_changes(record(covariance=matrix))
    assert names == ("c_l1", "c_d") and changes.shape == (DRAWS, 2)
    np.testing.assert_allclose(np.cov(changes.T), matrix, rtol=0.25)
    cornered = [parameter("c_l1", 5.0, 0.5, 12.0), parameter("c_d", 0.0, 0.0, 10.0)]
    _, changes = drawn_changes(record(parameters=cornered, covariance=matrix))
    assert changes[:, 1].min() >= 0.0
    # Held back on one side, the other parameter follows by their correlation.
    assert changes[:, 0].mean() > 0.05
    unknown = record(covariance=np.diag([0.04, np.inf]))
    assert drawn_changes(unknown)[0] == ("c_l1",) and held(unknown) == ["c_d"]
    narrow = [parameter("c_l1", 5.0, 5.0 - 1e-9, 5.0 + 1e-9), *unknown.parameters[1:]]
    assert len(drawn_changes(record(parameters=narrow))[1]) == 0


def test_a_band_is_what_the_derivative_makes_of_the_deviation() -> None:
    law = propmap.airfoil("paper-apc")
    value = law.c_l1
    fit = record(
        parameters=[parameter("c_l1", value, 0.5, 12.0)],
        covariance=np.array([[0.01]]),
        angles=[covered(80.0, 0.25)],
        at_rest=None,
    )
    file = file_of(fit)
    record_of_lines, facts = load_lines(file, None)
    (edgewise,) = (group for group in record_of_lines.groups if group["covered"].any())
    omega, speed = facts["rpm"] * np.pi / 30.0, edgewise["speed_mps"]
    tip = omega * file.model.propeller.radius
    assert speed[-1] == pytest.approx(1.25 * 0.25 * tip)
    inside = (0.01 * tip <= speed) & (speed <= 0.25 * tip)
    np.testing.assert_array_equal(edgewise["covered"], inside)
    k = 20
    point = (omega, speed[k], np.radians(edgewise["beta_deg"]))
    models = [file.model.with_airfoil(law.with_parameters(c_l1=value + c)) for c in (-0.1, 0.1)]
    less, more = (float(propmap.Rotor(model).loads(*point).thrust) for model in models)
    half = 1.96 * abs(more - less) / 2.0
    low, high = (edgewise[f"thrust_{end}_95_N"] for end in ("low", "high"))
    assert high[k] - low[k] == pytest.approx(2.0 * half, rel=0.2)
    assert (low <= edgewise["thrust_N"]).all() and (high >= edgewise["thrust_N"]).all()
