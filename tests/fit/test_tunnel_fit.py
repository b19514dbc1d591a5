"""Fits to tunnel data: a twin, UIUC's axial rows and both forms of the oblique campaign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.fit.comparison import compare_tunnel, failing_assumptions
from propmap.fit.fit import Fitted, Settings, fit
from propmap.fit.least_squares import Rows
from propmap.fit.parameters import Choice
from propmap.fit.tunnel import TunnelData, first_guess, merged, model_with, read_tunnel, tunnel_rows
from propmap.loads import LOADS
from propmap.model.airfoil import PAPER_FOUR, parameter_set
from propmap.model.corrections import MODELS

from .synthetic_rows import rms_of

PROPELLER, AIR = propmap.propeller("apc-8x6e"), propmap.Air()
FIVE = (*PAPER_FOUR, "zero_lift_angle")
TRUTH = {"c_l1": 5.2, "c_l2": 1.5, "c_d": 1.6, "alpha_0": 0.36, "zero_lift_angle": -0.06}
MODEL = propmap.Model(PROPELLER, first_guess(), AIR)
LAW = first_guess().with_parameters(**TRUTH)


@dataclass(frozen=True)
class Done:
    data: TunnelData
    loads: tuple[str, ...]
    fitted: Fitted

    def rows(self, choice: Choice) -> Rows:
        return tunnel_rows(MODEL, self.data, choice, loads=self.loads)

    def coefficient_rms(self, name: str) -> float:
        """Values of C_T = T/(rho n^2 D^4), or C_P = 2 pi Q/(rho n^2 D^5)."""
        rows, turns = self.fitted.rows, self.data.omega / (2.0 * np.pi)
        mine = rows.load == rows.names.index(name)
        size = AIR.density * turns**2 * PROPELLER.diameter**4
        if name == "torque":
            size = size * PROPELLER.diameter / (2.0 * np.pi)
        return float(np.sqrt(np.mean((self.fitted.residual[mine] / size[rows.point[mine]]) ** 2)))


def done(
    data: TunnelData, free: Sequence[str], loads: tuple[str, ...] = (), starts: int = 1
) -> Done:
    choice = Choice(tuple(free))
    rows = tunnel_rows(MODEL, data, choice, loads=loads)
    return Done(data, loads, fit(rows, choice, Settings(starts=starts)))


@pytest.fixture(scope="module")
def twin() -> TunnelData:
    """Loads of a known section law, climbing, static and oblique."""
    # Advance ratios up to 0.24.
    speed = np.concatenate([np.linspace(0.0, 14.0, 12), np.linspace(2.0, 10.0, 14)])
    beta = np.radians(np.concatenate([np.zeros(12), np.resize([20.0, 40.0, 60.0, 85.0], 14)]))
    omega = np.resize([450.0, 550.0, 650.0], 26)
    found = propmap.Rotor(propmap.Model(PROPELLER, LAW, AIR)).loads(omega, speed, beta)
    # The paper's rotor has no force across and no pitching moment.
    loads = {name: values for name in LOADS if (values := getattr(found, name)).any()}
    return TunnelData("twin", omega, speed, beta, loads)


@pytest.fixture(scope="module")
def uiuc() -> TunnelData:
    return read_tunnel(["uiuc-8x6e"], PROPELLER, AIR)


def test_a_noise_free_twin_gives_back_its_parameters(twin: TunnelData) -> None:
    twin_fit = done(twin, FIVE, starts=2)
    fitted = twin_fit.fitted
    for name, value in TRUTH.items():
        # The search computes stall along the blade wherever it may occur, the rotor where it is
        # foreseen: they agree to 0.1 % of the static loads.
        assert fitted.values[name] == pytest.approx(value, rel=5e-3), name
    for k, name in enumerate(fitted.rows.names):
        size = np.sqrt(np.mean(twin_fit.data.loads[name] ** 2))
        assert rms_of(fitted, k) < 1e-3 * size
    assert all(fitted.uncertainty.identified)
    truth = np.array([TRUTH[name] for name in FIVE])
    assert (fitted.uncertainty.low <= truth).all() and (truth <= fitted.uncertainty.high).all()
    assert failing_assumptions(fitted, twin_fit.rows) == []


def test_cambered_uiuc_within_the_project_s_limits(uiuc: TunnelData) -> None:
    uiuc_fit = done(uiuc, FIVE)
    assert uiuc_fit.coefficient_rms("thrust") <= 0.006
    assert uiuc_fit.coefficient_rms("torque") <= 0.005
    fitted = uiuc_fit.fitted
    for k in range(2):
        assert rms_of(fitted, k) <= fitted.cross_validated[k] <= 1.15 * rms_of(fitted, k)
    assert fitted.values["zero_lift_angle"] == pytest.approx(-0.09, abs=0.02)
    verdicts = dict(zip(FIVE, fitted.uncertainty.identified, strict=True))
    assert verdicts["c_l1"] and verdicts["zero_lift_angle"]
    found = compare_tunnel(model_with(MODEL, fitted.values), uiuc)
    assert set(found) == {"thrust_N", "torque_Nm"}
    for k, name in enumerate(("thrust_N", "torque_Nm")):
        whole = found[name].all
        assert whole.rows == len(uiuc)
        assert whole.rms == pytest.approx(rms_of(fitted, k), rel=0.02)
        assert whole.hover_rms > 3.0 * whole.rms
        assert sum(e.rows for e in found[name].by_speed.values()) == whole.rows


def test_data_of_a_propeller_with_another_number_of_blades_are_noted() -> None:
    two, three = (
        read_tunnel(["uiuc-8x6e"], propmap.propeller("apc-8x6e", blades=n), propmap.Air()).remarks
        for n in (2, 3)
    )
    told = "has 2 blades, R = 0.1016 m; apc-8x6e has 3 blades"
    assert not any(told in text for text in two) and any(told in text for text in three)


def test_without_camber_the_fit_fails_and_says_why(uiuc: TunnelData) -> None:
    four = done(uiuc, PAPER_FOUR)
    assert four.coefficient_rms("thrust") > 0.02
    told = failing_assumptions(four.fitted, four.rows)
    assert told and "wrong assumption: C_L(0) = 0, an uncambered section;" in told[0]
    assert "zero_lift_angle" in told[0]
    assert not any("mount_area" in sentence for sentence in told)


def test_the_bundled_constants_are_those_of_the_polynomials() -> None:
    bundled = parameter_set("apc-8x6e-2019")
    free = ("c_l1", "c_d", "alpha_0", "zero_lift_angle", "c_d0")
    choice = Choice(free, {"c_l2": bundled.c_l2}, start={n: getattr(bundled, n) for n in free})
    data = read_tunnel(["gill-dandrea-2019-8x6e"], PROPELLER, AIR)
    model = MODEL.with_airfoil(first_guess().with_corrections(MODELS["recommended"]))
    rows = tunnel_rows(model, data, choice, loads=("thrust", "torque"))
    fitted = fit(rows, choice, Settings(starts=1, folds=0))
    for k, name in enumerate(free):
        half = 0.5 * (fitted.uncertainty.high[k] - fitted.uncertainty.low[k])
        assert abs(fitted.x[k] - getattr(bundled, name)) < 0.1 * half, name


def rows_for(data: TunnelData, **options: object) -> Rows:
    choice = options.pop("choice", Choice(FIVE))
    return tunnel_rows(MODEL, data, choice, **options)  # type: ignore[arg-type]


def test_rows_leave_out_what_was_not_measured(twin: TunnelData) -> None:
    thrust = twin.loads["thrust"].copy()
    thrust[[2, 5]] = np.nan
    data = replace(twin, loads={"thrust": thrust, "drag": twin.loads["drag"]})
    rows = rows_for(data)
    assert rows.names == ("thrust", "drag") and rows.units == ("N", "N")
    assert np.count_nonzero(rows.load == 0) == 24 and np.count_nonzero(rows.load == 1) == 26
    assert not {2, 5} & set(rows.point[rows.load == 0].tolist())
    np.testing.assert_array_equal(rows.speed, data.speed[rows.point])


def test_residuals_are_compared_as_coefficients(twin: TunnelData) -> None:
    rows = rows_for(twin)
    scaled = rows.measured / rows.scale
    for k in range(4):
        assert np.sqrt(np.mean(scaled[rows.load == k] ** 2)) == pytest.approx(1.0)
        per_speed = rows.scale[rows.load == k] / twin.omega[rows.point[rows.load == k]] ** 2
        np.testing.assert_allclose(per_speed, per_speed[0])
    heavy = rows_for(twin, weights={"torque": 3.0})
    ratio = rows.scale / heavy.scale
    np.testing.assert_allclose(ratio, np.where(rows.load == list(LOADS).index("torque"), 3.0, 1.0))


def test_sets_with_different_loads_are_merged() -> None:
    one = np.ones(2)
    first = TunnelData("a", 400 * one, one, 0 * one, {"thrust": one})
    second = TunnelData("b", 500 * one, 2 * one, one, {"torque": 2 * one, "thrust": 3 * one})
    both = merged([first, second])
    assert both.source == "a, b" and len(both) == 4
    assert tuple(both.loads) == ("thrust", "torque")
    np.testing.assert_array_equal(both.loads["thrust"], [1, 1, 3, 3])
    np.testing.assert_array_equal(both.loads["torque"], [np.nan, np.nan, 2, 2])
    np.testing.assert_array_equal(both.omega, [400, 400, 500, 500])


def test_refusals(twin: TunnelData) -> None:
    thrust = replace(twin, loads={"thrust": twin.loads["thrust"]})
    for options, says in (
        ({"loads": ("lift",)}, "'lift' is not a load; choose from thrust"),
        ({"loads": ("drag",)}, "twin has no drag; fit thrust"),
        ({"choice": Choice(("lift_area",))}, "lift_area has no effect in a tunnel test"),
        ({"choice": Choice(("c_l1", "wing_c_l1"))}, "wing_c_l1 has no effect in a tunnel test"),
        ({"choice": Choice(("mount_area",))}, "mount_area is free but drag is not fitted"),
    ):
        with pytest.raises(InputError, match=says):
            rows_for(thrust, **options)
    still = replace(twin, loads=twin.loads | {"side_force": 0.0 * twin.omega})
    with pytest.raises(InputError, match=r"every value of side_force is zero.*--loads"):
        rows_for(still)
    with pytest.raises(InputError, match="has no thrust"):
        rows_for(replace(twin, loads={"thrust": np.full(26, np.nan)}), loads=("thrust",))
