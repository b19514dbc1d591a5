"""The section law's terms that are not in the paper: against the literal reference, in limits
that need no reference, and through files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import propmap as pm
from propmap.model.airfoil import Airfoil
from tests.oracle.literal_rotor import literal_loads

BLADE = pm.propeller("apc-8x6e")
LAW = Airfoil(
    *(5.3, 2.0, 2.4, 0.29),
    zero_lift_angle=-0.05,
    c_d0=0.02,
    reynolds_camber=-0.02,
    reynolds_lift=0.12,
    reynolds_drag=-0.35,
    drag_angle=0.07,
)
LITERAL = {
    (2000.0, 0.0, 0.0): (0.248374737, 0.0, 0.00565211884),
    (7000.0, 0.0, 0.0): (3.56873583, 0.0, 0.0627014993),
    (5000.0, 9.0, 0.0): (0.940754313, 0.0, 0.024231384),
    (4000.0, 7.0, 65.0): (1.05884751, 0.0884423043, 0.0211772862),
    (6000.0, 4.0, 130.0): (2.5025066, 0.0573952256, 0.0442590393),
}
"""Thrust [N], drag [N] and torque [N m] of the literal reference at rpm, m/s and degrees."""


def rotor_of(airfoil: Airfoil, air: pm.Air | None = None) -> pm.Rotor:
    return pm.Rotor(pm.Model(BLADE, airfoil, air or pm.Air()))


def test_loads_are_those_of_the_literal_reference() -> None:
    points, want = np.array(list(LITERAL)), np.array(list(LITERAL.values()))
    omega, speed, beta = points[:, 0] * np.pi / 30.0, points[:, 1], np.radians(points[:, 2])

    def loads(law: Airfoil, speed: np.ndarray) -> np.ndarray:
        found = rotor_of(law).loads(omega, speed, beta)
        return np.stack([found.thrust, found.drag, found.torque], axis=-1)

    # What "standard" promises, relative to the loads at rest.
    rest, found = loads(LAW, 0.0 * speed), loads(LAW, speed)
    scale = rest[:, [0, 0, 2]]
    assert np.abs((found - want) / scale).max() < 1e-3
    # The terms matter by far more than the tolerance.
    for name in ("reynolds_camber", "reynolds_lift", "reynolds_drag", "drag_angle"):
        off = loads(LAW.with_parameters(**{name: 0.0}), speed)
        assert np.median(np.abs((off - found) / scale)[:, [0, 2]].max(axis=1)) > 3e-3, name


@pytest.mark.slow
@pytest.mark.parametrize("point", LITERAL)
def test_the_frozen_loads_are_those_of_the_literal_code(point: tuple[float, float, float]) -> None:
    rpm, speed, beta = point
    section = {"c_l1": 5.3, "c_l2": 2.0, "c_d": 2.4, "alpha_0": 0.29, "c_d0": 0.02}
    section |= {"reynolds_camber": -0.02, "drag_angle": 0.07}
    section |= {"reynolds_lift": 0.12, "reynolds_drag": -0.35}
    found = literal_loads(
        *(BLADE.station, BLADE.chord, BLADE.twist, BLADE.blades, section, 1.225, 1.983e-5),
        *(rpm * np.pi / 30.0, speed * np.cos(np.radians(beta)), speed * np.sin(np.radians(beta))),
        zero_lift_angle=-0.05,
    )
    names = ("thrust", "drag", "torque")
    assert [found[name] for name in names] == pytest.approx(LITERAL[point], rel=1e-7, abs=1e-12)


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


def test_files_name_the_terms_only_where_they_are_not_zero(tmp_path: Path) -> None:
    path = tmp_path / "law.toml"
    path.write_text(LAW.to_toml(), encoding="utf-8")
    assert pm.airfoil(path) == LAW
    assert "reynolds_camber = -0.02" in LAW.to_toml() and "drag_angle = 0.07" in LAW.to_toml()
    paper = pm.airfoil("paper-apc")
    assert "reynolds_camber" not in paper.to_toml() and "drag_angle" not in paper.to_toml()
    zero = paper.with_parameters(reynolds_camber=0.0, drag_angle=0.0)
    assert zero.fingerprint() == paper.fingerprint() != LAW.fingerprint()
