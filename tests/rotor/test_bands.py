"""Standard deviations of the loads: against draws, by their sources, and where they are unknown."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

import propmap as pm
from propmap.bands import INPLANE, NEAR_GROUND, OBLIQUE, RING, TUNNEL_GAIN
from propmap.catalogue.expected import ExpectedBlade, expected_constants, size_of
from propmap.catalogue.identified import identified
from propmap.catalogue.lookup import meant_by
from propmap.loads import LOADS
from propmap.model.airfoil import SectionCovariance, SectionUncertainty
from propmap.model.corrections import TYPICAL_AREA, TYPICAL_FACTOR, Installed
from propmap.model.envelope import Envelope
from propmap.results import LoadValues
from tools.descent import descents

POINTS = (np.array([500.0, 600.0, 700.0]), np.array([6.0, 10.0, 14.0]), np.array([0.4, 1.2, 1.5]))
DESCENTS = Path(__file__).resolve().parents[3] / "shared/data/static/descent_shetty_selig.csv"
NAMES = tuple(each.name for each in fields(LoadValues))


@pytest.fixture(scope="module")
def model() -> pm.Model:
    """An identified propeller in oblique flow."""
    known = identified("uiuc-apce-10x5", 2)
    assert known is not None
    blade = pm.propeller("uiuc-apce-10x5")
    return pm.Model(blade, known.airfoil, corrections=pm.model_corrections("recommended"))


def known_law(model: pm.Model) -> tuple[pm.Airfoil, SectionUncertainty]:
    law = model.airfoil
    assert isinstance(law, pm.Airfoil) and law.uncertainty is not None
    return law, law.uncertainty


def _with(model: pm.Model, known: SectionUncertainty | None) -> pm.Model:
    return model.with_airfoil(known_law(model)[0].with_parameters(uncertainty=known))


@pytest.mark.slow
def test_loads_of_drawn_constants_spread_as_said(model: pm.Model) -> None:
    """The meaning of a covariance: draw constants and look at the loads."""
    law, known = known_law(model)
    names = known.covariance.names
    small = SectionCovariance(names, known.covariance.matrix / 9.0)
    uncertain = _with(model, SectionUncertainty(small))
    told = pm.Rotor(uncertain).loads(*POINTS).std_by_source["parameters"]
    random, found = np.random.default_rng(3), []
    for draw in random.multivariate_normal(np.zeros(len(names)), small.matrix, 250).tolist():
        changed = {name: getattr(law, name) + by for name, by in zip(names, draw, strict=True)}
        other = model.with_airfoil(law.with_parameters(**changed))
        loads = pm.Rotor(other).loads(*POINTS)
        found.append([getattr(loads, name) for name in NAMES])
    for name, want in zip(NAMES, np.std(found, axis=0), strict=True):
        # 250 draws: 4.5 % of a standard deviation, and three times that.
        np.testing.assert_allclose(getattr(told, name), want, rtol=0.14, err_msg=name)


def test_what_is_not_known_of_the_blade_is_told_apart(model: pm.Model) -> None:
    _, identified_law = known_law(model)
    own = identified_law.covariance
    whole = SectionCovariance(own.names, 5.0 * own.matrix)
    plain, told = (
        pm.Rotor(_with(model, known)).loads(*POINTS).std_by_source
        for known in (SectionUncertainty(own), SectionUncertainty(whole, with_blade=own))
    )
    assert "geometry" not in plain
    for name in NAMES:
        want = getattr(plain["parameters"], name)
        np.testing.assert_allclose(getattr(told["parameters"], name), want, rtol=1e-3)
        np.testing.assert_allclose(getattr(told["geometry"], name), 2.0 * want, rtol=1e-3)
    with pytest.raises(pm.InputError, match="for the same constants"):
        SectionUncertainty(whole, with_blade=own.of(["c_l1"]))


def test_sources_add_up_in_squares_and_make_the_interval(model: pm.Model) -> None:
    loads = pm.Rotor(model).loads(*POINTS)
    assert set(loads.std_by_source) == {"parameters", "discrepancy", "tunnel"}
    low, high = loads.interval(0.95)
    for name in NAMES:
        parts = [getattr(one, name) for one in loads.std_by_source.values()]
        assert (parts[0] > 0.0).all() and (np.sum(parts[1:], axis=0) > 0.0).all()
        std, middle = getattr(loads.std, name), getattr(loads, name)
        np.testing.assert_allclose(std, np.sqrt(np.sum(np.square(parts), axis=0)), rtol=1e-12)
        np.testing.assert_allclose(getattr(high, name) - middle, 1.959964 * std, rtol=1e-6)
        np.testing.assert_allclose(middle - getattr(low, name), 1.959964 * std, rtol=1e-6)
    np.testing.assert_allclose(loads.std.power, loads.std.torque * POINTS[0], rtol=1e-12)
    for share in (0.0, 1.0, np.nan):
        with pytest.raises(pm.InputError, match="probability such as"):
            loads.interval(share)


def test_what_the_other_sources_are(model: pm.Model) -> None:
    _, known = known_law(model)
    rotor, omega = pm.Rotor(model), 600.0
    tip = omega * model.propeller.radius
    found = rotor.loads(omega, np.array([0.0, 0.1 * tip]), 0.0)
    by = found.std_by_source
    n, diameter = omega / (2.0 * np.pi), model.propeller.diameter
    force = model.air.density * n**2 * diameter**4
    expected = known.thrust_coefficient * force
    assert by["discrepancy"].thrust[0] == pytest.approx(expected, rel=1e-9)
    expected = known.power_coefficient * force * diameter / (2.0 * np.pi)
    assert by["discrepancy"].torque[0] == pytest.approx(expected, rel=1e-9)
    np.testing.assert_allclose(by["tunnel"].thrust, TUNNEL_GAIN * found.thrust, rtol=1e-12)
    np.testing.assert_allclose(by["tunnel"].torque, TUNNEL_GAIN * found.torque, rtol=1e-12)
    # In axial flow there are no loads in the disk plane to be unsure of.
    for name, load in LOADS.items():
        if load.inplane:
            assert (getattr(found.std, name) == 0.0).all()
    # In oblique flow the theory errs by a share of the load that grows with the advance ratio.
    advance = np.array([0.1, 0.2])
    edgewise = rotor.loads(omega, advance * tip, 0.5 * np.pi)
    advance = advance / np.hypot(1.0, advance)
    axial = known.thrust_coefficient * force * np.array([1.0 + 0.01, 1.0 + 0.04])
    want = np.hypot(axial, OBLIQUE["thrust"] * advance * edgewise.thrust)
    np.testing.assert_allclose(edgewise.std_by_source["discrepancy"].thrust, want, rtol=1e-9)
    want = INPLANE["side_force"] * advance * edgewise.thrust
    np.testing.assert_allclose(edgewise.std_by_source["discrepancy"].side_force, want, rtol=1e-9)
    own = _with(model, replace(known, another_tunnel=False))
    assert "tunnel" not in pm.Rotor(own).loads(omega, 1.0, 0.0).std_by_source


def test_a_fit_has_the_error_of_the_theory_beyond_its_own_oblique_flow(model: pm.Model) -> None:
    """The residuals of a fit contain this error up to the largest advance ratio of its data."""
    _, known = known_law(model)
    omega, ratios = 600.0, np.array([0.05, 0.1, 0.2])
    speed = ratios * omega * model.propeller.radius

    exact = replace(known, thrust_coefficient=0.0)
    axial = Envelope((0.0, 100.0), (0.0, 0.0), (0.0, 0.5), (0.0, 0.5), (3000.0, 6000.0))
    flown = replace(axial, edgewise_ratio=(0.0, 0.1))
    advance = ratios / np.hypot(1.0, ratios)
    for covered, most in ((axial, 0.0), (flown, advance[1])):
        own = replace(exact, another_tunnel=False, envelope=covered)
        loads = pm.Rotor(_with(model, own)).loads(omega, speed, 0.5 * np.pi)
        want = OBLIQUE["thrust"] * np.maximum(advance - most, 0.0) * loads.thrust
        np.testing.assert_allclose(loads.std_by_source["discrepancy"].thrust, want, rtol=1e-9)


def test_what_is_not_stated_of_the_mount_is_uncertain() -> None:
    """To first order in the factor and the area, as differences of the model have it."""
    model = pm.catalogue_model("apc 8x6e")
    flow = (600.0, 12.0, 1.3)
    found = pm.Rotor(model).loads(*flow)
    bare = pm.Rotor(model.with_mount(Installed(1.0, 0.0))).loads(*flow).drag
    mounted = pm.Rotor(model.with_mount(Installed(0.0))).loads(*flow).drag
    want = np.hypot(TYPICAL_FACTOR[1] * bare, TYPICAL_AREA[1] / TYPICAL_AREA[0] * mounted)
    std = found.std_by_source["installation"]
    # The disk's inflow is taken from its thrust, the rotor's from all annuli.
    assert float(std.drag) == pytest.approx(float(want), rel=5e-3)
    assert std.thrust == 0.0 and std.torque == 0.0
    known = model.with_mount(Installed(2.0, 0.001))
    assert pm.Rotor(known).loads(*flow).std_by_source["installation"].drag == 0.0


def test_a_blade_that_was_not_measured_is_less_sure() -> None:
    def share(name: str) -> float:
        meant, blade = meant_by(name), pm.propeller(name)
        family, geometry = getattr(meant, "family", None), "measured"
        if isinstance(meant, ExpectedBlade):
            geometry = "family" if family else "population"
        law = expected_constants(family, size_of(meant, blade), geometry).airfoil
        model = pm.Model(blade, law)
        loads = pm.Rotor(model).loads(1200.0, 10.0, 1.3)
        return float(loads.std.thrust / loads.thrust)

    assert share("uiuc-apce-10x5") < share("apc 10x4.4e") < share("10x4.4")


def test_changed_constants_have_no_covariance(model: pm.Model) -> None:
    law, known = known_law(model)
    assert law.with_corrections(["pitt-peters"]).uncertainty is known
    assert law.with_parameters(uncertainty=None) == law
    changed = law.with_parameters(c_l1=5.0)
    assert changed.uncertainty is None
    loads = pm.Rotor(model.with_airfoil(changed)).loads(600.0, 5.0, 1.0)
    assert loads.std_by_source == {}
    with pytest.raises(pm.InputError, match="constants have no covariance"):
        _ = loads.std


def test_shapes_are_those_of_the_points_and_at_rest_all_is_zero(model: pm.Model) -> None:
    rotor = pm.Rotor(model)
    still = rotor.loads(np.array([0.0, 100.0]), 0.0, 0.0).std
    assert all(getattr(still, name)[0] == 0.0 for name in NAMES) and still.thrust[1] > 0.0
    one = rotor.loads(600.0, 5.0, 1.0)
    assert one.std.thrust.shape == ()
    grid = rotor.loads(600.0, np.array([0.0, 5.0])[:, None], np.array([0.0, 1.0, 2.0]))
    assert grid.std.torque.shape == (2, 3)
    assert grid.std.thrust[1, 1] == pytest.approx(float(one.std.thrust), rel=1e-9)


def test_a_parameter_file_carries_how_well_its_constants_are_known(
    model: pm.Model, tmp_path: Path
) -> None:
    """A parameter file carries no covariance; the constants themselves are the same."""
    law, known = known_law(model)
    path = tmp_path / "constants.toml"
    path.write_text(law.to_toml())
    assert pm.airfoil(path) == law
    there = pm.airfoil(path).uncertainty  # type: ignore[union-attr]
    assert there is not None and there.as_dict() == known.as_dict()
    path.write_text(path.read_text().replace("another_tunnel", "other"))
    with pytest.raises(pm.InputError, match=r"constants.toml: the table \[uncertainty\]"):
        pm.airfoil(path)


@pytest.mark.skipif(not DESCENTS.exists(), reason="needs the reference data")
def test_bands_hold_measured_thrust_in_descent() -> None:
    rows = list(descents(DESCENTS))
    assert sum(one.inside for one in rows) >= 12 and len(rows) == 13
    ring = [one.predicted / one.measured - 1.0 for one in rows if one.ring > 0.0]
    assert np.sqrt(np.mean(np.square(ring))) == pytest.approx(RING, abs=0.005)


def test_bands_are_wider_in_the_vortex_ring_and_on_the_ground() -> None:
    rotor = pm.Rotor(pm.catalogue_model("APC 8x6E"))
    hover = rotor.loads(600.0, 0.0, 0.0)
    radius, inflow = (
        rotor.model.propeller.radius,
        np.sqrt(hover.thrust / (2.0 * 1.225 * np.pi * rotor.model.propeller.radius**2)),
    )
    share = hover.std_by_source["discrepancy"].thrust / hover.thrust
    ring = rotor.loads(600.0, inflow, np.pi)
    wide = ring.std_by_source["discrepancy"].thrust / ring.thrust
    assert wide == pytest.approx(np.hypot(share, RING), rel=0.03)
    near = rotor.loads(600.0, 0.0, 0.0, height=0.686 * radius)
    wide = near.std_by_source["discrepancy"].thrust / near.thrust
    assert wide**2 - NEAR_GROUND**2 * np.exp(-2.0) == pytest.approx((share / 1.156) ** 2, rel=0.02)
