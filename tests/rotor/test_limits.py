"""Limits and symmetries with known answers."""

from __future__ import annotations

import numpy as np
import pytest

import propmap as pm
from propmap.hover import HoverModel
from propmap.loads import LOADS
from propmap.rotor import Rotor

BLADE = pm.propeller("apc-8x6e")
APC = pm.airfoil("paper-apc")
OMEGA = np.array([300.0, 600.0, 900.0])


def rotor_of(model: pm.Model, accuracy: str = "standard") -> Rotor:
    """Rotor of the accuracy asked for."""
    return pm.Rotor(model, accuracy=accuracy)


@pytest.fixture(scope="module")
def rotor() -> Rotor:
    return rotor_of(pm.Model(BLADE, APC))


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
    rotor = rotor_of(pm.Model(blade, law), accuracy="fine")
    assert rotor.inflow(omega, 0.0, 0.0).inflow == pytest.approx(v, rel=2e-4)
    area = np.pi * (0.1**2 - 0.03**2)
    loads = rotor.loads(omega, 0.0, 0.0)
    assert float(loads.thrust) == pytest.approx(2 * 1.225 * area * v * v, rel=2e-4)
    # Without drag all power is induced: P = T v.
    assert float(loads.power) == pytest.approx(float(loads.thrust) * v, rel=2e-4)


def test_fast_climb_power_is_thrust_times_velocity_through_the_disk() -> None:
    law = pm.Airfoil(0.0, 6.0, 0.0, 0.3, c_d0=0.0, c_p=0.0, lift_law="simplified")
    rotor = rotor_of(pm.Model(BLADE, law), accuracy="fine")
    field = rotor.inflow(600.0, 6.0, 0.0, radius=np.linspace(BLADE.root, BLADE.radius, 400))
    through = np.trapezoid(field.thrust_per_radius * (6.0 + field.inflow), field.radius)
    assert float(rotor.loads(600.0, 6.0, 0.0).power) == pytest.approx(through, rel=1e-4)


def test_axial_flow_has_no_load_by_the_inplane_velocity(rotor: Rotor) -> None:
    loads = rotor.loads(OMEGA, 8.0, 0.0)
    for name, load in LOADS.items():
        assert np.all((getattr(loads, name) == 0.0) == load.inplane), name


def test_mirror_image_in_beta(rotor: Rotor) -> None:
    one, other = rotor.loads(OMEGA, 9.0, 1.1), rotor.loads(OMEGA, 9.0, 2.0 * np.pi - 1.1)
    for name in LOADS:
        assert getattr(one, name) == pytest.approx(getattr(other, name), rel=1e-12)


def test_velocity_vector_and_angles_say_the_same(rotor: Rotor) -> None:
    speed, beta, heading = 9.0, 1.1, 2.5
    across = speed * np.sin(beta)
    vector = [across * np.cos(heading), across * np.sin(heading), speed * np.cos(beta)]
    by_vector, by_angle = rotor.loads_at_velocity(OMEGA, vector), rotor.loads(OMEGA, speed, beta)
    assert by_vector.thrust == pytest.approx(by_angle.thrust, rel=1e-12)
    assert by_vector.drag == pytest.approx(by_angle.drag, rel=1e-12)


def test_mirrored_rotation(rotor: Rotor) -> None:
    """Seen in a mirror along the flight direction, ccw becomes cw: y and the moments' x, z flip."""
    left = rotor.wrench(600.0, [8.0, 3.0, 2.0], spin="ccw")
    right = rotor.wrench(600.0, [8.0, -3.0, 2.0], spin="cw")
    assert left.force == pytest.approx(right.force * [1, -1, 1], rel=1e-12)
    assert left.moment == pytest.approx(right.moment * [-1, 1, -1], rel=1e-12)


def test_signs_of_the_wrench(rotor: Rotor) -> None:
    """ccw, flying forward: drag backwards, torque reaction -z, the right side is lifted."""
    wrench = rotor.wrench(600.0, [10.0, 0.0, 0.0], spin="ccw")
    assert wrench.force[2] > 0.0 > wrench.force[0]
    assert wrench.force[1] == 0.0
    assert wrench.moment[2] < 0.0
    assert wrench.moment[0] < 0.0  # FLU: lifting the right side rolls to the left, about -x


def test_loads_scale_with_density_at_fixed_reynolds_number(rotor: Rotor) -> None:
    thin = rotor_of(pm.Model(BLADE, APC, pm.Air(0.6125, 1.983e-5 / 2)))
    for beta in (0.0, 1.2):
        full, half = rotor.loads(OMEGA, 9.0, beta), thin.loads(OMEGA, 9.0, beta)
        for name in LOADS:
            assert getattr(half, name) == pytest.approx(0.5 * getattr(full, name), rel=1e-10)


def test_loads_scale_with_speed_squared_without_friction() -> None:
    rotor = rotor_of(pm.Model(BLADE, APC.with_parameters(c_p=0.0)))
    one, two = rotor.loads(400.0, 6.0, 1.0), rotor.loads(800.0, 12.0, 1.0)
    assert float(two.thrust) == pytest.approx(4.0 * float(one.thrust), rel=1e-10)
    assert float(two.torque) == pytest.approx(4.0 * float(one.torque), rel=1e-10)


def test_simplified_lift_is_the_blend_with_stall_at_zero() -> None:
    """Footnote 1: with sigma = 1 everywhere eq. (3) is c_l sin(a) cos(a)."""
    simple = rotor_of(pm.Model(BLADE, pm.Airfoil(5.0, 5.0, 1.8, 0.36, lift_law="simplified")))
    early = rotor_of(pm.Model(BLADE, pm.Airfoil(5.0, 5.0, 1.8, 0.02, sharpness=500.0)))
    a, b = simple.loads(600.0, 9.0, 0.8), early.loads(600.0, 9.0, 0.8)
    assert float(a.thrust) == pytest.approx(float(b.thrust), rel=2e-3)


@pytest.mark.slow
def test_batch_equals_loop_of_scalars() -> None:
    rotor = pm.Rotor(pm.Model(BLADE, APC))
    rng = np.random.default_rng(7)
    omega, speed = rng.uniform(200, 1000, 24), rng.uniform(0, 20, 24)
    beta = rng.uniform(0, np.pi, 24)
    batch = rotor.loads(omega, speed, beta)
    for k in range(24):
        single = rotor.loads(omega[k], speed[k], beta[k])
        assert single.thrust.shape == ()
        for name in LOADS:
            want = float(getattr(batch, name)[k])
            assert float(getattr(single, name)) == pytest.approx(want, rel=1e-12, abs=1e-14)
        assert single.status == batch.status[k]


def test_camber_acts_like_pitch(rotor: Rotor) -> None:
    """Turning the blade and its zero-lift line together leaves angles of attack alone."""
    turned = pm.Propeller("turned", 2, BLADE.station, BLADE.chord, BLADE.twist + 0.05)
    cambered = rotor_of(pm.Model(turned, APC.with_parameters(zero_lift_angle=0.05)))
    a, b = rotor.loads(OMEGA, 9.0, 1.0), cambered.loads(OMEGA, 9.0, 1.0)
    assert b.thrust == pytest.approx(a.thrust, rel=1e-11)


def test_every_input_moves_the_loads(rotor: Rotor) -> None:
    base = float(rotor.loads(600.0, 6.0, 1.0).torque)
    changed = {
        "air": rotor_of(pm.Model(BLADE, APC, pm.Air(1.0))),
        "viscosity": rotor_of(pm.Model(BLADE, APC, pm.Air(1.225, 3e-5))),
        "cut-out": rotor_of(pm.Model(BLADE.with_root_cutout(0.04), APC)),
        "blades": rotor_of(pm.Model(pm.propeller("apc-8x6e", blades=3), APC)),
        **{
            name: rotor_of(
                pm.Model(BLADE, APC.with_parameters(**{name: getattr(APC, name) * 1.1 + 0.01}))
            )
            for name in ("c_l1", "c_l2", "c_d", "alpha_0", "zero_lift_angle", "c_d0", "c_p")
        },
    }
    for name, other in changed.items():
        assert abs(float(other.loads(600.0, 6.0, 1.0).torque) - base) > 1e-7 * base, name


def test_hover_model_is_the_rotor_at_rest(rotor: Rotor) -> None:
    model = HoverModel.from_rotor(rotor, 600.0)
    still = rotor.loads(600.0, 0.0, 0.0)
    assert float(model.thrust(600.0)) == pytest.approx(float(still.thrust), rel=1e-12)
    assert float(model.torque(600.0)) == pytest.approx(float(still.torque), rel=1e-12)
    assert float(model.thrust(300.0)) == pytest.approx(float(still.thrust) / 4, rel=1e-12)


def test_inflow_field_is_consistent_with_the_loads(rotor: Rotor) -> None:
    radius = np.linspace(BLADE.root, BLADE.radius, 800)
    field = rotor.inflow(600.0, 10.0, 1.2, radius=radius)
    loads = rotor.loads(600.0, 10.0, 1.2)
    thrust = np.trapezoid(field.thrust_per_radius, radius)
    assert thrust == pytest.approx(float(loads.thrust), rel=1e-3)
    drag = np.trapezoid(field.drag_per_radius, radius)
    assert drag == pytest.approx(float(loads.drag), rel=1e-3)
    advancing = int(np.argmin(np.abs(field.azimuth - np.pi / 2)))
    retreating = int(np.argmin(np.abs(field.azimuth - 3 * np.pi / 2)))
    assert field.u_tangential[-1, advancing] > field.u_tangential[-1, retreating]
