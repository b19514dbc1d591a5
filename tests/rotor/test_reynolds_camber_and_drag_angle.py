"""The section law's two terms that are not in the paper: against the literal reference, in limits
that need no reference, and through files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import propmap as pm
from propmap.model.airfoil import Airfoil
from tests.oracle.literal_rotor import literal_loads
from tests.oracle.literal_section import drag_coefficient

BLADE = pm.propeller("apc-8x6e")
LAW = Airfoil(
    *(5.3, 2.0, 2.4, 0.29),
    zero_lift_angle=-0.05,
    c_d0=0.02,
    reynolds_camber=-0.02,
    drag_angle=0.07,
)
RPM = np.pi / 30.0

POINTS = {
    "rest, slow": (2000.0, 0.0, 0.0),
    "rest, fast": (7000.0, 0.0, 0.0),
    "axial": (5000.0, 9.0, 0.0),
    "oblique": (4000.0, 7.0, 65.0),
    "descent": (6000.0, 4.0, 130.0),
}


def rotor_of(airfoil: Airfoil, air: pm.Air | None = None) -> pm.Rotor:
    return pm.Rotor(pm.Model(BLADE, airfoil, air or pm.Air()))


@pytest.mark.parametrize(
    "where",
    [pytest.param(p, marks=[pytest.mark.slow] * (p in ("axial", "descent"))) for p in POINTS],
)
def test_loads_are_those_of_the_literal_reference(where: str) -> None:
    rpm, speed, beta = POINTS[where]
    omega, beta = rpm * RPM, np.radians(beta)
    rotor = rotor_of(LAW)
    loads, static = rotor.loads(omega, speed, beta), rotor.loads(omega, 0.0, 0.0)
    section = {"c_l1": 5.3, "c_l2": 2.0, "c_d": 2.4, "alpha_0": 0.29, "c_d0": 0.02}
    section |= {"reynolds_camber": -0.02, "drag_angle": 0.07}
    expected = literal_loads(
        *(BLADE.station, BLADE.chord, BLADE.twist, BLADE.blades, section, 1.225, 1.983e-5, omega),
        *(speed * np.cos(beta), speed * np.sin(beta) if speed and beta else 0.0),
        zero_lift_angle=-0.05,
    )
    # What "standard" promises, of the loads at rest.
    for name, size in (("thrust", static.thrust), ("torque", static.torque)):
        assert getattr(loads, name) == pytest.approx(expected[name], abs=1e-3 * float(size)), name
    assert loads.drag == pytest.approx(expected["drag"], abs=1e-3 * float(static.thrust))
    # The terms matter by far more than the tolerance.
    for name in ("reynolds_camber", "drag_angle"):
        off = rotor_of(LAW.with_parameters(**{name: 0.0})).loads(omega, speed, beta)
        moved = abs(off.thrust - loads.thrust) / static.thrust
        turned = abs(off.torque - loads.torque) / static.torque
        assert max(moved, turned) > 3e-3, name


def test_without_friction_only_the_camber_tells_one_speed_of_rotation_from_another() -> None:
    plain = LAW.with_parameters(c_p=0.0, reynolds_camber=0.0)
    omega = np.array([200.0, 500.0, 900.0])

    def coefficient(airfoil: Airfoil) -> np.ndarray:
        return np.asarray(rotor_of(airfoil).loads(omega, 0.0, 0.0).thrust) / omega**2

    assert np.ptp(coefficient(plain)) / coefficient(plain)[0] < 1e-9
    rises = coefficient(plain.with_parameters(reynolds_camber=-0.02))
    assert (np.diff(rises) > 0.005 * rises[0]).all()


@pytest.mark.parametrize(("viscosity", "reynolds"), [(2e-3, 1e4), (2e-9, 1.2e5)])
def test_beyond_the_range_of_reynolds_numbers_the_camber_stays(
    viscosity: float, reynolds: float
) -> None:
    """Where Re is outside 1e4 to 1.2e5 all along the blade, the term is another zero-lift angle,
    and the pressure drag stays where it is."""
    air = pm.Air(viscosity=viscosity)
    turned = -0.05 - 0.02 * np.log(reynolds / 5e4)
    drag_angle = LAW.zero_lift_angle + LAW.drag_angle - turned
    same = LAW.with_parameters(reynolds_camber=0.0, zero_lift_angle=turned, drag_angle=drag_angle)
    flow = (np.array([500.0, 600.0]), np.array([0.0, 8.0]), 1.0)
    # The tip, where the chord and with it Re end in zero, carries nothing.
    found, expected = (rotor_of(law, air).loads(*flow) for law in (LAW, same))
    for load in ("thrust", "torque", "drag"):
        size = np.abs(getattr(expected, load)).max()
        assert getattr(found, load) == pytest.approx(getattr(expected, load), abs=2e-4 * size)


def test_the_inflow_field_tells_angles_from_the_chord_line() -> None:
    """alpha is theta - phi, whatever the camber."""
    rotor = rotor_of(LAW)
    field = rotor.inflow(400.0, 6.0, 0.0, azimuth=[0.0])
    twist = np.interp(field.radius, BLADE.station, BLADE.twist)
    through = 6.0 + np.asarray(field.inflow)
    phi = np.arctan2(through, 400.0 * field.radius)
    # Linear interpolation of the twist, where the blade's is a cubic.
    assert np.ravel(field.alpha) == pytest.approx(np.ravel(twist - phi), abs=3e-3)


def test_pressure_drag_is_least_at_its_own_angle() -> None:
    law = replace(LAW, c_p=0.0, reynolds_camber=0.0)
    alpha = np.linspace(-0.2, 0.3, 5001)
    _, drag = law.coefficients(alpha, 5e4)
    section = {"c_d": 2.4, "c_d0": 0.02, "c_p": 0.0}
    expected = drag_coefficient(alpha + 0.05 - 0.07, 5e4, section)
    np.testing.assert_allclose(drag, expected, rtol=1e-12)
    assert alpha[np.argmin(drag)] == pytest.approx(-0.05 + 0.07, abs=1e-4)


def test_files_name_the_terms_only_where_they_are_not_zero(tmp_path: Path) -> None:
    path = tmp_path / "law.toml"
    path.write_text(LAW.to_toml(), encoding="utf-8")
    assert pm.airfoil(path) == LAW
    assert "reynolds_camber = -0.02" in LAW.to_toml() and "drag_angle = 0.07" in LAW.to_toml()
    paper = pm.airfoil("paper-apc")
    assert "reynolds_camber" not in paper.to_toml() and "drag_angle" not in paper.to_toml()
    zero = paper.with_parameters(reynolds_camber=0.0, drag_angle=0.0)
    assert zero.fingerprint() == paper.fingerprint() != LAW.fingerprint()
