"""Forces of blade elements and annuli, eqs. (1)-(10), written out in NumPy beside the disk.

Reverse flow, air from below, stall and descent are among the points.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import propmap as pm
from tests.oracle.literal_wake import LiteralWake, static_inflow, vortex_ring
from tests.oracle.paper_physics import RHO, TABLE_I, Law, drag, forces, lift_law

BLADE = pm.propeller("apc-8x6e", blades=3)
APC = TABLE_I["apc"]
LAWS = {
    **TABLE_I,
    "cambered": replace(APC, zero_lift_angle=-0.06),
    "simplified": replace(APC, attached=0.0),
}
FLOWS = {
    "hover": (600.0, 0.0, 0.0),
    "fast climb": (500.0, 25.0, 0.3),
    "edgewise": (300.0, 18.0, 0.5 * np.pi),
    "slow rotor": (80.0, 15.0, 1.4),
    "standing rotor": (0.0, 12.0, 1.2),
    "shallow descent": (500.0, 12.0, 1.8),
    "slow rotor, descent": (80.0, 15.0, 2.2),
    "vortex ring": (600.0, 5.0, 2.9),
    "windmill": (450.0, 16.0, 3.0),
    "windmill, axial": (450.0, 16.0, np.pi),
}
every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())
every_flow = pytest.mark.parametrize("flow", FLOWS.values(), ids=FLOWS.keys())


def airfoil(law: Law) -> pm.Airfoil:
    numbers = {k: v for k, v in vars(law).items() if k not in ("attached", "plate")}
    return pm.Airfoil(**numbers, lift_law=lift_law(law))


def rotor(law: Law, *texts: str) -> pm.Rotor:
    corrections = tuple(pm.correction(text) for text in texts)
    return pm.Rotor(pm.Model(BLADE, airfoil(law), corrections=corrections))


RADIUS = np.concatenate([np.linspace(BLADE.root, BLADE.radius, 41)[:-1], [0.1012]])
SHAPE = tuple(PchipInterpolator(BLADE.station, v)(RADIUS) for v in (BLADE.chord, BLADE.twist))
TURN = 2.0 * np.pi * (np.arange(48) + 0.5) / 48


def motion(flow: tuple[float, float, float]) -> tuple[float, float, float]:
    omega, speed, beta = flow
    across = 0.0 if beta == np.pi else speed * np.sin(beta)
    return omega, speed * np.cos(beta), across


@every_law
@every_flow
def test_forces_of_elements_are_equations_1_to_5(
    law: Law, flow: tuple[float, float, float]
) -> None:
    field = rotor(law).inflow(*flow, radius=RADIUS, azimuth=TURN)
    omega, along, across = motion(flow)
    element = tuple(a[:, None] for a in (RADIUS, *SHAPE))
    sine, v_i = np.sin(TURN), field.inflow[:, None]
    u_t = omega * element[0] + across * sine  # (1)
    u_p = np.broadcast_to(along + v_i, u_t.shape)  # (2)
    np.testing.assert_allclose(field.u_tangential, u_t, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(field.u_normal, u_p, rtol=1e-12, atol=1e-12)
    alpha = element[2] - np.arctan2(u_p, u_t)
    off = np.angle(np.exp(1j * (field.alpha - alpha)))
    assert np.abs(off).max() < 1e-11
    normal, tangential = (
        RHO * force for force in forces(law, element, (omega, along, across), v_i, sine)
    )
    # Rounding of the angles, times the blend's M.
    size = np.abs(normal).max() + 1e-9
    np.testing.assert_allclose(field.normal_force, normal, atol=1e-10 * size)
    blades = BLADE.blades
    # The means are over the nodes of the loads; these are 48, too few where blades stand still.
    if omega > 0.0:
        np.testing.assert_allclose(
            field.thrust_per_radius, blades * normal.mean(1), atol=1e-3 * size
        )
        np.testing.assert_allclose(
            field.torque_per_radius,
            blades * RADIUS * tangential.mean(1),  # (7)
            atol=1e-3 * size * BLADE.radius,
        )
        np.testing.assert_allclose(
            field.drag_per_radius,
            blades * (tangential * sine).mean(1),  # (6)
            atol=1e-3 * size,
        )
    assert (field.reverse == (u_t < 0.0)).all()


def test_the_flows_cover_reverse_flow_and_flow_from_below() -> None:
    signs = set()
    for flow in FLOWS.values():
        field = rotor(APC).inflow(*flow, radius=RADIUS, azimuth=TURN)
        u_t, u_p = (np.sign(v).ravel() for v in (field.u_tangential, field.u_normal))
        signs |= set(zip(u_t.tolist(), u_p.tolist(), strict=True))
    assert {(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)} <= signs


@pytest.mark.parametrize("texts", [(), ("tip-loss",), ("hub-loss",), ("tip-loss", "hub-loss")])
@every_flow
def test_annuli_have_the_momentum_of_equation_10(
    texts: tuple[str, ...], flow: tuple[float, float, float]
) -> None:
    """With Prandtl's factors, and beyond its turn mirrored on the windmill branch."""
    one = rotor(APC, *texts)
    loads, field = one.loads(*flow), one.inflow(*flow, radius=RADIUS)
    ring = float(loads.vortex_ring)
    if ring > 0.0 or flow[0] == 0.0:
        return  # momentum theory has no say, or a standing blade no angle phi of rotation
    omega, along, across = motion(flow)
    wake = LiteralWake(
        *(RHO, omega, along, across, BLADE.blades, BLADE.radius),
        tip_loss="tip-loss" in texts,
        hub_radius=BLADE.root if "hub-loss" in texts else None,
        windmill=along < -0.95 * float(one.hover_inflow(omega)),
    )
    inner = slice(1, None)
    want = np.array(
        [
            float(wake.thrust(y, np.array([v]))[0])
            for y, v in zip(RADIUS[inner], field.inflow[inner], strict=True)
        ]
    )
    size = np.abs(want).max()
    np.testing.assert_allclose(field.thrust_per_radius[inner], want, atol=1e-8 * size)


def test_the_static_inflow_is_equation_12() -> None:
    one = rotor(APC)
    for omega in (200.0, 600.0):
        thrust = float(one.loads(omega, 0.0, 0.0).thrust)
        want = static_inflow(thrust, RHO, BLADE.radius)
        assert float(one.hover_inflow(omega)) == pytest.approx(want, rel=1e-12)
    assert float(one.hover_inflow(0.0)) == 0.0
    windmilling = pm.Propeller("flat", 2, BLADE.station, BLADE.chord, -0.3 + 0.0 * BLADE.twist)
    down = pm.Rotor(pm.Model(windmilling, airfoil(APC)))
    assert float(down.loads(500.0, 0.0, 0.0).thrust) < 0.0
    assert float(down.hover_inflow(500.0)) == 0.0


def test_the_share_of_the_vortex_ring_is_that_of_its_smooth_steps() -> None:
    """Onset 0.2 to 0.45 v_h, exit 1.5 to 2 v_h of descent, fade 0.5 to 0.95 v_h in the plane."""
    one, omega = rotor(APC), 600.0
    v_h = float(one.hover_inflow(omega))
    z, x = np.meshgrid(np.linspace(-2.3, 0.3, 27), [0.0, 0.3, 0.6, 0.8, 0.94, 1.0])
    loads = one.loads(omega, v_h * np.hypot(z, x), np.arctan2(x, z))
    want = np.array(
        [vortex_ring(v_h * a, v_h * b, v_h)[0] for a, b in zip(z.ravel(), x.ravel(), strict=True)]
    )
    np.testing.assert_allclose(loads.vortex_ring.ravel(), want, atol=1e-12)
    assert loads.vortex_ring.max() == 1.0
    inside = loads.vortex_ring == 1.0
    measured = [vortex_ring(v_h * a, 0.0, v_h)[1] for a in z[inside]]
    np.testing.assert_allclose(loads.mean_inflow[inside], measured, rtol=1e-9)


@pytest.mark.parametrize("flow", [(-5.0, 3.0), (0.0, 4.0), (3.0, 0.0), (-9.0, 0.0)])
def test_without_static_thrust_there_is_no_ring_and_all_is_finite(
    flow: tuple[float, float],
) -> None:
    flat = pm.Propeller("flat", 2, BLADE.station, BLADE.chord, 0.0 * BLADE.twist)
    one = pm.Rotor(pm.Model(flat, airfoil(APC)))
    found = one.gradients(one.parameters, 500.0, *flow)
    assert np.isfinite(found.loads).all()
    assert np.isfinite(found.slopes).all()
    assert float(one.loads_at_velocity(500.0, [flow[1], 0.0, flow[0]]).vortex_ring) == 0.0


def test_reverse_flow_at_the_retreating_root_pushes_down() -> None:
    """The trailing edge leads, and with a positive twist it is the lower one."""
    field = rotor(APC).inflow(100.0, 10.0, 0.5 * np.pi, radius=[0.03], azimuth=[1.5 * np.pi, 0.0])
    assert field.u_tangential[0, 0] == pytest.approx(-7.0)
    assert field.normal_force[0, 0] < 0.0 < field.normal_force[0, 1]


def test_friction_in_an_annulus_is_that_of_equation_4() -> None:
    """A blade edge on, without lift: only c_d0 and the 1/sqrt(Re) term remain."""
    flat = pm.Propeller("flat", 2, BLADE.station, BLADE.chord, 0.0 * BLADE.twist)
    one = pm.Rotor(pm.Model(flat, airfoil(APC)))
    field = one.inflow(500.0, 0.0, 0.0, radius=[0.08, 0.06])
    chord = PchipInterpolator(BLADE.station, BLADE.chord)(field.radius)
    u = 500.0 * field.radius
    c_d = drag(0.0, RHO * u * chord / 1.983e-5, APC)
    want = 2.0 * field.radius * 0.5 * RHO * u**2 * chord * c_d
    np.testing.assert_allclose(field.torque_per_radius, want, rtol=1e-10)
    np.testing.assert_allclose(field.thrust_per_radius, 0.0, atol=1e-12)


def test_a_pointed_tip_has_finite_loads_and_derivatives() -> None:
    station, twist = np.array([0.02, 0.04, 0.07, 0.1]), np.array([0.5, 0.4, 0.3, 0.2])
    blade = pm.Propeller("pointed", 2, station, np.array([0.02, 0.02, 0.015, 0.0]), twist)
    one = pm.Rotor(pm.Model(blade, airfoil(APC)))
    field = one.inflow(500.0, 3.0, 1.0, radius=[0.05, 0.1])
    assert np.abs(field.normal_force[1]).max() < 1e-9
    found = one.gradients(one.parameters, 500.0, [0.0, 2.0, 2.0], [0.0, 0.0, 5.0])
    assert np.isfinite(found.loads).all() and np.isfinite(found.slopes).all()


@pytest.mark.parametrize(("omega", "wind"), [(0.0, 0.0), (0.0, 9.0), (1e-9, 0.0), (1e-300, 1e-300)])
def test_a_blade_at_rest_has_finite_loads_and_derivatives(omega: float, wind: float) -> None:
    one = rotor(APC)
    for along, across in ((wind, 0.0), (0.0, wind), (-wind, 0.0)):
        found = one.gradients(one.parameters, omega, along, across)
        assert np.isfinite(found.loads).all() and np.isfinite(found.slopes).all()
        if wind == 0.0:
            assert np.abs(found.loads).max() < 1e-12
