"""The paper's section III: level-flight balance, its residuals, least squares, body terms."""

from __future__ import annotations

import numpy as np
import pytest

import propmap
from propmap.fit.comparison import body_terms_verdict
from propmap.fit.fit import Fitted, Settings, fit
from propmap.fit.flight import ForceModel, level_rows
from propmap.fit.least_squares import Rows, search
from propmap.fit.parameters import FIRST_GUESS, SECTION, Choice
from propmap.model.airfoil import PAPER_FOUR
from propmap.units import GRAVITY
from propmap.vehicle.log import FlightLog
from propmap.vehicle.vehicle import Vehicle

from .flight_twin import VEHICLE
from .synthetic_rows import Floats, linear_model, rows_of

LAW = propmap.airfoil("paper-apc")
BLADE = propmap.propeller("apc-8x6e")
QUADROTOR = Vehicle("paper", 0.9, BLADE, VEHICLE.mounts)
VALUES = FIRST_GUESS | {n: getattr(LAW, n) for n in SECTION}
TWO = Choice(("c_l1", "alpha_0"))

SPEED = np.array([2.0, 6.0, 10.0])
LEAN = np.radians([3.0, 11.0, 24.0])
"""Angles [rad] of the axes to the flight direction."""

OMEGA = np.array([[520.0, 530.0, 560.0, 555.0], [500.0, 505.0, 570.0, 560.0], [640.0] * 4])


def flights(chosen: slice) -> FlightLog:
    """Steady level flights, nose first, in the frame of the leaning vehicle."""
    speed, lean = SPEED[chosen], LEAN[chosen]
    none = np.zeros_like(speed)
    up = np.stack([-np.sin(lean), none, np.cos(lean)], axis=1)
    return FlightLog(
        "paper",
        np.arange(speed.size, dtype=float),
        np.stack([speed * np.cos(lean), none, speed * np.sin(lean)], axis=1),
        np.zeros((speed.size, 3)),
        up,
        GRAVITY * up,
        OMEGA[chosen],
    )


def epsilon(chosen: slice = slice(None)) -> Floats:
    rows = level_rows(ForceModel(QUADROTOR, flights(chosen), LAW), TWO)
    value, _ = rows.model(VALUES, TWO.free)
    return np.asarray(value - rows.measured)


def test_level_rows_are_equation_16() -> None:
    """Written out from the loads of each rotor: sum T sin(beta) + sum D cos(beta) - m g."""
    rotor = propmap.Rotor(propmap.Model(BLADE, LAW))
    # V is horizontal and the axis leans into it: beta is short of a right angle by the lean.
    beta = 0.5 * np.pi - LEAN
    loads = rotor.loads(OMEGA, SPEED[:, None], beta[:, None])
    expected = (
        np.sum(loads.thrust * np.sin(beta)[:, None] + loads.drag * np.cos(beta)[:, None], axis=1)
        - QUADROTOR.mass * GRAVITY
    )
    # Twice the accuracy of the loads, of ten newtons.
    np.testing.assert_allclose(epsilon(), expected, atol=0.02)
    # Without the drag's part the last flight would be off by more than that.
    assert abs(np.sum(loads.drag * np.cos(beta)[:, None], axis=1)[-1]) > 0.1


def test_residuals_of_n_flights_are_equation_17() -> None:
    """One number per flight, in order, each depending on its own flight alone."""
    found = epsilon()
    assert found.shape == (3,)
    np.testing.assert_allclose(epsilon(slice(1, 2)), found[1:2], rtol=1e-9, atol=1e-12)


def test_the_search_is_equation_18() -> None:
    """It starts at x0 = (2 pi, 2, 0, 0.47) and minimizes eps^T eps, as a direct solution does."""
    choice = Choice()
    assert choice.free == PAPER_FOUR
    np.testing.assert_array_equal(choice.first, [2.0 * np.pi, 2.0, 0.0, 0.47])
    rng = np.random.default_rng(18)
    columns = rng.normal(size=(20, 4))
    truth = np.array([5.3, 1.7, 1.8, 0.36])
    measured = columns @ truth + 0.01 * rng.normal(size=20)
    rows = rows_of(linear_model(dict(zip(PAPER_FOUR, columns.T, strict=True))), measured)
    minimum = search(rows, choice, [choice.first])
    direct = np.linalg.lstsq(columns, measured, rcond=None)[0]
    np.testing.assert_allclose(minimum.x, direct, atol=1e-6)
    least = float(np.sum((columns @ direct - measured) ** 2))
    assert float(minimum.residual @ minimum.residual) == pytest.approx(least, rel=1e-6)


@pytest.mark.parametrize(("area", "improves"), [(0.03, True), (0.0, False)])
def test_body_terms_pay_where_they_act(area: float, improves: bool) -> None:
    """Section III.A: lift and drag of the body are kept only where the data ask for them."""
    rng = np.random.default_rng(3)
    columns = dict(zip(("c_l1", "alpha_0", "lift_area"), rng.normal(size=(3, 40)), strict=True))
    columns["lift_area"] = columns["lift_area"] * 100.0
    model = linear_model(columns)
    value, _ = model(VALUES | {"lift_area": area}, ("c_l1",))
    rows = rows_of(model, np.asarray(value) + 0.05 * rng.normal(size=40))

    def rows_for(_: Choice) -> Rows:
        return rows

    fitted: Fitted = fit(rows, TWO, Settings(starts=1, folds=0))
    (lift,) = (text for text in body_terms_verdict(fitted, rows_for) if "lift_area" in text)
    assert lift.startswith("lift_area improves" if improves else "lift_area does not improve")
