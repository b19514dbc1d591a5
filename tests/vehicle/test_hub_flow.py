"""Forces and moments of rotors that stand askew, against the same made in each rotor's frame."""

from __future__ import annotations

import numpy as np

import propmap
from propmap.loads import LOADS
from propmap.results import hub_wrench
from propmap.vehicle.vehicle import Mount, Vehicle
from propmap.vehicle.wakes import HubFlow, hub_flow_at, hub_wrenches, rotor_forces, rotor_wrench

ASKEW = np.array([[0.3, -0.2, 0.9], [0.0, 0.0, 1.0], [-0.6, 0.1, 0.5]])
AXES = ASKEW / np.linalg.norm(ASKEW, axis=1, keepdims=True)
PLACES = ((0.2, 0.1, 0.03), (-0.1, 0.25, -0.02), (0.0, -0.2, 0.1))
SPINS = ("ccw", "cw", "cw")
SAMPLES = 7


def flow_and_loads() -> tuple[Vehicle, HubFlow, np.ndarray, np.ndarray]:
    """Any motion, the hubs' velocities, and any loads (L, n, m)."""
    mounts = tuple(
        Mount(place, tuple(axis), spin)
        for place, axis, spin in zip(PLACES, AXES, SPINS, strict=True)
    )
    vehicle = Vehicle("askew", 1.0, propmap.propeller("apc-8x6e"), mounts)
    rng = np.random.default_rng(0)
    velocity, rates = rng.normal(0.0, 5.0, (2, SAMPLES, 3))
    flow = hub_flow_at(vehicle, rng.uniform(300.0, 800.0, (SAMPLES, 3)), velocity, rates)
    hubs = velocity[:, None] + np.cross(rates[:, None], np.array(PLACES))
    return vehicle, flow, hubs, rng.normal(0.0, 1.0, (len(LOADS), SAMPLES, 3))


def test_force_and_moment_of_each_rotor_are_those_of_its_own_frame() -> None:
    _, flow, hubs, loads = flow_and_loads()
    np.testing.assert_allclose(flow.velocity, hubs, atol=1e-12)
    force, moment = hub_wrenches(flow, loads)
    for rotor, (axis, spin) in enumerate(zip(AXES, SPINS, strict=True)):
        x = np.cross(axis, [0.3, 1.0, -0.2])
        x /= np.linalg.norm(x)
        frame = np.stack([x, np.cross(axis, x), axis])
        seen = hubs[:, rotor] @ frame.T
        across = seen * [1.0, 1.0, 0.0]
        direction = across / np.linalg.norm(across, axis=1, keepdims=True)
        want = hub_wrench(loads[:, :, rotor], direction, 1.0 if spin == "ccw" else -1.0)
        np.testing.assert_allclose(force[:, rotor], want.force @ frame, atol=1e-12)
        np.testing.assert_allclose(moment[:, rotor], want.moment @ frame, atol=1e-12)


def test_forces_are_those_of_thrust_and_drag() -> None:
    _, flow, _, loads = flow_and_loads()
    order = list(LOADS)
    loads[[order.index(name) for name in order if name not in ("thrust", "drag")]] = 0.0
    force, _ = rotor_wrench(flow, np.stack([loads, -2.0 * loads], axis=1))
    plain = rotor_forces(flow, *loads[:2])
    np.testing.assert_allclose(force, [plain, -2.0 * plain], atol=1e-12)
