"""Forces of blade elements and annuli, eqs. (1)-(10), written out in NumPy beside the disk.

Reverse flow, air from below, stall and descent are among the points.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import propmap as pm
from propmap.model.corrections import Installed
from tests.oracle.literal_rotor import LiteralRotor
from tests.oracle.literal_wake import LiteralWake, static_inflow, vortex_ring
from tests.oracle.points import MU, RHO, SECTIONS
from tests.oracle.sampled import airfoil_of

BLADE = pm.propeller("apc-8x6e", blades=3)
APC = SECTIONS["apc"]
LAWS = {
    "apc": (APC, 0.0),
    "cambered": (APC, -0.06),
    "simplified": (APC | {"attached": 0.0}, 0.0),
}
"""Sections and their zero-lift angles [rad]."""

FLOWS = {
    "hover": (600.0, 0.0, 0.0),
    "fast climb": (500.0, 25.0, 0.3),
    "edgewise": (300.0, 18.0, 0.5 * np.pi),
    "standing rotor": (0.0, 12.0, 1.2),
    "shallow descent": (500.0, 12.0, 1.8),
    "slow rotor, descent": (80.0, 15.0, 2.2),
    "vortex ring": (600.0, 5.0, 2.9),
    "windmill": (450.0, 16.0, 3.0),
    "windmill, axial": (450.0, 16.0, np.pi),
}
every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())
every_flow = pytest.mark.parametrize("flow", FLOWS.values(), ids=FLOWS.keys())


def rotor(*texts: str) -> pm.Rotor:
    corrections = tuple(pm.correction(text) for text in texts)
    return pm.Rotor(pm.Model(BLADE, airfoil_of(APC), corrections=corrections))


def literal(
    flow: tuple[float, ...], section: dict[str, float], zero_lift_angle: float
) -> LiteralRotor:
    momentum = LiteralWake(RHO, *flow, BLADE.blades, BLADE.radius)
    shape = (BLADE.station, BLADE.chord, BLADE.twist, BLADE.blades, section, momentum, (0.0, 0.0))
    return LiteralRotor(*shape, RHO, MU, *flow, zero_lift_angle, 24, 0.004)


RADIUS = np.concatenate([np.linspace(BLADE.root, BLADE.radius, 41)[:-1], [0.1012]])
TURN = 2.0 * np.pi * (np.arange(48) + 0.5) / 48


def motion(flow: tuple[float, float, float]) -> tuple[float, float, float]:
    omega, speed, beta = flow
    across = 0.0 if beta == np.pi else speed * np.sin(beta)
    return omega, speed * np.cos(beta), across


@every_law
@every_flow
def test_forces_of_elements_are_equations_1_to_5(
    law: tuple[dict[str, float], float], flow: tuple[float, float, float]
) -> None:
    one = pm.Rotor(pm.Model(BLADE, airfoil_of(*law)))
    field = one.inflow(*flow, radius=RADIUS, azimuth=TURN)
    omega, along, across = motion(flow)
    y, sine, v_i = RADIUS[:, None], np.sin(TURN), field.inflow[:, None]
    u_t = omega * y + across * sine  # (1)
    u_p = np.broadcast_to(along + v_i, u_t.shape)  # (2)
    np.testing.assert_allclose(field.u_tangential, u_t, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(field.u_normal, u_p, rtol=1e-12, atol=1e-12)
    assert (field.reverse == (u_t < 0.0)).all()
    twist = PchipInterpolator(BLADE.station, BLADE.twist)(y)
    off = np.angle(np.exp(1j * (field.alpha - twist + np.arctan2(u_p, u_t))))
    assert np.abs(off).max() < 1e-11
    known = literal((omega, along, across), *law)
    rings = zip(RADIUS, field.inflow, strict=True)
    elements = [known.element(float(r), np.array([v]), TURN) for r, v in rings]
    phi, lift, drag = (np.concatenate(part) for part in zip(*elements, strict=True))
    normal = lift * np.cos(phi) - drag * np.sin(phi)
    tangential = lift * np.sin(phi) + drag * np.cos(phi)
    # Rounding of the angles, times the blend's M.
    size = np.abs(normal).max() + 1e-9
    np.testing.assert_allclose(field.normal_force, normal, atol=1e-10 * size)
    # The means are over the nodes of the loads; these are 48, too few where blades stand still.
    if omega > 0.0:
        for found, want, scale in (
            (field.thrust_per_radius, normal.mean(1), 1.0),
            (field.torque_per_radius, RADIUS * tangential.mean(1), BLADE.radius),  # (7)
            (field.drag_per_radius, (tangential * sine).mean(1), 1.0),  # (6)
        ):
            np.testing.assert_allclose(found, BLADE.blades * want, atol=1e-3 * size * scale)


@pytest.mark.parametrize(
    "texts",
    [
        *((), ("tip-loss",), ("hub-loss",), ("tip-loss", "hub-loss")),
        ("stall-delay:strength=12", "prandtl-glauert:sound_mps=150"),
    ],
)
@every_flow
def test_annuli_have_the_momentum_of_equation_10(
    texts: tuple[str, ...], flow: tuple[float, float, float]
) -> None:
    """With Prandtl's factors, and beyond its turn mirrored on the windmill branch."""
    one = rotor(*texts)
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
    rings = zip(RADIUS[inner], field.inflow[inner], strict=True)
    want = np.array([float(wake.thrust(y, np.array([v]))[0]) for y, v in rings])
    size = np.abs(want).max()
    np.testing.assert_allclose(field.thrust_per_radius[inner], want, atol=1e-8 * size)


def test_the_static_inflow_is_equation_12() -> None:
    one = rotor()
    for omega in (200.0, 600.0):
        thrust = float(one.loads(omega, 0.0, 0.0).thrust)
        want = static_inflow(thrust, RHO, BLADE.radius)
        assert float(one.hover_inflow(omega)) == pytest.approx(want, rel=1e-12)
    assert float(one.hover_inflow(0.0)) == 0.0
    windmilling = pm.Propeller("flat", 2, BLADE.station, BLADE.chord, -0.3 + 0.0 * BLADE.twist)
    down = pm.Rotor(pm.Model(windmilling, airfoil_of(APC)))
    assert float(down.loads(500.0, 0.0, 0.0).thrust) < 0.0
    assert float(down.hover_inflow(500.0)) == 0.0


def test_the_share_of_the_vortex_ring_is_that_of_its_smooth_steps() -> None:
    """Onset 0.2 to 0.45 v_h, exit 1.5 to 2 v_h of descent, fade 0.5 to 0.95 v_h in the plane."""
    one, omega = rotor(), 600.0
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


def test_without_static_thrust_there_is_no_ring_and_all_is_finite() -> None:
    flat = pm.Propeller("flat", 2, BLADE.station, BLADE.chord, 0.0 * BLADE.twist)
    one = pm.Rotor(pm.Model(flat, airfoil_of(APC)))
    along, across = np.array([(-5.0, 3.0), (0.0, 4.0), (3.0, 0.0), (-9.0, 0.0)]).T
    found = one.gradients(one.parameters, 500.0, along, across)
    assert np.isfinite(found.loads).all() and np.isfinite(found.slopes).all()
    velocity = np.stack([across, 0.0 * across, along], axis=-1)
    assert (one.loads_at_velocity(500.0, velocity).vortex_ring == 0.0).all()


def test_a_pointed_tip_has_finite_loads_and_derivatives() -> None:
    station, twist = np.array([0.02, 0.04, 0.07, 0.1]), np.array([0.5, 0.4, 0.3, 0.2])
    blade = pm.Propeller("pointed", 2, station, np.array([0.02, 0.02, 0.015, 0.0]), twist)
    one = pm.Rotor(pm.Model(blade, airfoil_of(APC)))
    field = one.inflow(500.0, 3.0, 1.0, radius=[0.05, 0.1])
    assert np.abs(field.normal_force[1]).max() < 1e-9
    found = one.gradients(one.parameters, 500.0, [0.0, 2.0, 2.0], [0.0, 0.0, 5.0])
    assert np.isfinite(found.loads).all() and np.isfinite(found.slopes).all()


@pytest.mark.parametrize(
    "flow", [(628.0, 12.0, 1.2), (628.0, 6.0, 0.5 * np.pi), (500.0, 8.0, 2.6), (628.0, 5.0, 0.0)]
)
@pytest.mark.parametrize("corrections", [None, ()], ids=["recommended", "paper, root cut out"])
def test_fields_add_up_to_the_loads(
    corrections: tuple[()] | None, flow: tuple[float, float, float]
) -> None:
    """With friction along the blade and inflow that varies around the disk, and without."""
    model = pm.catalogue_model("apc-8x6e", corrections=corrections)
    if corrections is None:
        model = model.with_mount(Installed(1.0, 0.0))
    else:
        model = replace(model, propeller=model.propeller.with_root_cutout(0.04))
    rotor, blade = pm.Rotor(model), model.propeller
    radius = np.linspace(blade.root, blade.radius, 400)
    field, loads = rotor.inflow(*flow, radius=radius), rotor.loads(*flow)

    def along(values: np.ndarray) -> float:
        return float(np.trapezoid(values, radius))

    def around(values: np.ndarray) -> np.ndarray:
        return np.trapezoid(values, field.azimuth, axis=1) / (2.0 * np.pi)

    force, psi = blade.blades * field.normal_force, field.azimuth
    # The trapezoid rule and the radial nodes of the loads differ by less than 1e-4.
    assert along(field.thrust_per_radius) == pytest.approx(loads.thrust, rel=2e-4)
    assert along(field.torque_per_radius) == pytest.approx(loads.torque, rel=2e-4)
    assert along(field.drag_per_radius) == pytest.approx(loads.drag, rel=2e-3, abs=1e-9)
    assert along(around(force)) == pytest.approx(loads.thrust, rel=2e-4)
    size = 2e-4 * float(loads.thrust) * blade.radius
    assert along(radius * around(force * np.sin(psi))) == pytest.approx(loads.roll_moment, abs=size)
    assert -along(radius * around(force * np.cos(psi))) == pytest.approx(
        loads.pitch_moment, abs=size
    )
    np.testing.assert_allclose(around(field.local_inflow), field.inflow, rtol=1e-9)
