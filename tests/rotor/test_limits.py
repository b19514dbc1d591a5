"""Limits and symmetries with known answers; random operating points."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import propmap as pm
from propmap.hover import HoverModel
from propmap.loads import LOADS
from propmap.rotor import Rotor

BLADE = pm.propeller("apc-8x6e")
APC = pm.airfoil("paper-apc")
OMEGA = np.array([300.0, 600.0, 900.0])


@pytest.fixture(scope="module")
def rotor() -> Rotor:
    return pm.Rotor(pm.Model(BLADE, APC))


def test_ideal_hover_rotor_meets_momentum_theory() -> None:
    """A blade with constant inflow: chord times pitch angle times y^2 is constant along it.

    With the simplified lift c_l sin(a) cos(a), no drag and small angles, N_b c c_l y a Omega^2 y
    = 8 pi v^2 y asks for chord ~ 1/a; choosing a = 0.1 rad all along, theta = a + v/(Omega y)
    gives the same v at every station, and T = 2 rho A v^2 over the annulus.
    """
    law = pm.Airfoil(0.0, 2 * np.pi, 0.0, 0.3, c_d0=0.0, c_p=0.0, lift_law="simplified")
    omega, v, alpha, blades = 600.0, 4.0, 0.1, 2
    y = np.linspace(0.03, 0.1, 60)
    phi = np.arctan2(v, omega * y)
    square = (omega * y) ** 2 + v**2
    lift = 2 * np.pi * np.sin(alpha) * np.cos(alpha)
    chord = 4.0 * np.pi * y * v * v / (0.5 * blades * square * lift * np.cos(phi))
    blade = pm.Propeller("ideal", blades, y, chord, phi + alpha)
    rotor = pm.Rotor(pm.Model(blade, law), accuracy="fine")
    assert rotor.inflow(omega, 0.0, 0.0).inflow == pytest.approx(v, rel=2e-4)
    area = np.pi * (0.1**2 - 0.03**2)
    loads = rotor.loads(omega, 0.0, 0.0)
    assert float(loads.thrust) == pytest.approx(2 * 1.225 * area * v * v, rel=2e-4)
    # Without drag all power is induced: P = T v.
    assert float(loads.power) == pytest.approx(float(loads.thrust) * v, rel=2e-4)


def test_fast_climb_power_is_thrust_times_velocity_through_the_disk() -> None:
    law = pm.Airfoil(0.0, 6.0, 0.0, 0.3, c_d0=0.0, c_p=0.0, lift_law="simplified")
    rotor = pm.Rotor(pm.Model(BLADE, law), accuracy="fine")
    field = rotor.inflow(600.0, 6.0, 0.0, radius=np.linspace(BLADE.root, BLADE.radius, 400))
    through = np.trapezoid(field.thrust_per_radius * (6.0 + field.inflow), field.radius)
    assert float(rotor.loads(600.0, 6.0, 0.0).power) == pytest.approx(through, rel=1e-4)


def test_axial_flow_has_no_load_by_the_inplane_velocity(rotor: Rotor) -> None:
    loads = rotor.loads(OMEGA, 8.0, 0.0)
    for name, load in LOADS.items():
        assert np.all((getattr(loads, name) == 0.0) == load.inplane), name


def test_only_the_angle_to_the_axis_matters(rotor: Rotor) -> None:
    speed, beta, heading = 9.0, 1.1, 2.5
    across = speed * np.sin(beta)
    vector = [across * np.cos(heading), across * np.sin(heading), speed * np.cos(beta)]
    one = rotor.loads(OMEGA, speed, beta)
    others = (rotor.loads(OMEGA, speed, 2.0 * np.pi - beta), rotor.loads_at_velocity(OMEGA, vector))
    for other in others:
        for name in LOADS:
            assert getattr(one, name) == pytest.approx(getattr(other, name), rel=1e-12)


def test_mirrored_rotation() -> None:
    """Seen in a mirror along the flight direction, ccw becomes cw: y and the moments' x, z flip."""
    every = tuple(map(pm.correction, ("pitt-peters", "blade-to-hub", "radial-friction")))
    rotor = pm.Rotor(pm.Model(BLADE, APC, corrections=every))
    left = rotor.wrench(600.0, [8.0, 3.0, 2.0], spin="ccw")
    right = rotor.wrench(600.0, [8.0, -3.0, 2.0], spin="cw")
    assert left.force == pytest.approx(right.force * [1, -1, 1], rel=1e-12)
    assert left.moment == pytest.approx(right.moment * [-1, 1, -1], rel=1e-12)


def test_loads_scale_with_density_and_without_friction_with_speed_squared(rotor: Rotor) -> None:
    thin = pm.Rotor(pm.Model(BLADE, APC, pm.Air(0.6125, 1.983e-5 / 2)))
    for beta in (0.0, 1.2):
        full, half = rotor.loads(OMEGA, 9.0, beta), thin.loads(OMEGA, 9.0, beta)
        for name in LOADS:
            assert getattr(half, name) == pytest.approx(0.5 * getattr(full, name), rel=1e-10)
    smooth = pm.Rotor(pm.Model(BLADE, APC.with_parameters(c_p=0.0)))
    one, two = smooth.loads(400.0, 6.0, 1.0), smooth.loads(800.0, 12.0, 1.0)
    for name in ("thrust", "torque"):
        assert getattr(two, name) == pytest.approx(4.0 * getattr(one, name), rel=1e-10)


def test_hover_model_is_the_rotor_at_rest(rotor: Rotor) -> None:
    model = HoverModel.from_rotor(rotor, 600.0)
    still = rotor.loads(600.0, 0.0, 0.0)
    assert float(model.thrust(600.0)) == pytest.approx(float(still.thrust), rel=1e-12)
    assert float(model.torque(600.0)) == pytest.approx(float(still.torque), rel=1e-12)
    assert float(model.thrust(300.0)) == pytest.approx(float(still.thrust) / 4, rel=1e-12)


def test_rest_is_rest(rotor: Rotor) -> None:
    loads = rotor.loads(0.0, 0.0, 0.0)
    for name in (*LOADS, "power"):
        assert float(getattr(loads, name)) == 0.0
    assert loads.status == "ok"


@pytest.mark.parametrize(
    ("point", "told"),
    [
        ((100.0, -1.0, 0.0), "speed is negative"),
        ((100.0, 1.0, np.inf), "beta contains a value that is not finite"),
        (("fast", 1.0, 0.0), "omega"),
        ((np.ones(3), np.ones(2), 0.0), "shape"),
        ((np.array([100.0 + 1.0j]), 1.0, 1.0), "omega is .*: give a real number"),
        ((np.ma.array([100.0, 1e9], mask=[0, 1]), 1.0, 1.0), "omega has masked points: leave"),
    ],
)
def test_bad_operating_points_and_wrong_kinds_are_refused(
    rotor: Rotor, point: tuple[Any, ...], told: str
) -> None:
    with pytest.raises(pm.InputError, match=told):
        rotor.loads(*point)
    with pytest.raises(pm.InputError, match=r"propmap\.propeller"):
        pm.Rotor(pm.Model("apc-8x6e", APC))  # type: ignore[arg-type]
    with pytest.raises(pm.InputError, match="accuracy"):
        pm.Rotor(rotor.model, accuracy="best")
