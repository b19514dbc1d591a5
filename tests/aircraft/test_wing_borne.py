"""On a wing: of two attitudes that balance the cheaper one, stall as a status, induced drag."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from propmap.aircraft.performance import performance
from propmap.aircraft.trim import Aircraft
from propmap.units import RPM
from propmap.vehicle.powertrain import Powertrain
from propmap.vehicle.vehicle import Body, Mount, Vehicle, Wing
from propmap.vehicle.vehicle_forces import free_stream_force

from .conftest import aircraft_of, quadcopter

GRAVITY = 9.80665
WING = Wing(0.24, math.pi / 2.0, c_l1=4.5, c_l2=1.0, alpha_0=0.25, span=1.2)


@pytest.fixture(scope="module")
def tailsitter() -> Aircraft:
    mounts = tuple(Mount((0.0, y, 0.1), spin=spin) for y, spin in ((0.25, "ccw"), (-0.25, "cw")))
    return aircraft_of(
        quadcopter(mass=1.1, mounts=mounts, wing=WING, body=Body((0.25, 0.02, 0.012)))
    )


def plane(**changes: object) -> Vehicle:
    pulling = (Mount((0.2, 0.0, 0.0), axis=(1.0, 0.0, 0.0)),)
    return quadcopter(
        mass=1.1,
        mounts=pulling,
        wing=replace(WING, incidence=0.03),
        body=Body((0.012, 0.02, 0.25)),
        **changes,
    )


def test_no_gap_where_two_attitudes_balance(tailsitter: Aircraft) -> None:
    """From 9 m/s on a wing of 0.24 m^2 carries 1.1 kg at a few degrees; the same speeds can be
    flown with it stalled at twice the power or more, where a search from hover ends."""
    speeds = np.arange(8.0, 17.0)
    states = tailsitter.steady(speeds, margin=False)
    assert set(states.status.tolist()) == {"ok"}
    alpha = WING.incidence - states.pitch
    attached = alpha < 0.21
    assert attached.tolist() == [False] + [True] * 8
    # Lift and the rotors' thrust across the path are the weight.
    carried = 0.5 * 1.225 * speeds**2 * WING.area * WING.c_l1 * alpha
    lifted = carried + np.cos(states.pitch) * states.thrust.sum(axis=1)
    assert lifted[2:] == pytest.approx(1.1 * GRAVITY, rel=0.05)
    assert states.shaft_power[1] < 0.5 * states.shaft_power[0]


@pytest.mark.slow
def test_least_power_is_at_the_edge_of_stall(tailsitter: Aircraft) -> None:
    found = performance(tailsitter, tailsitter.steady([0.0, 10.0], margin=False))
    assert found.least_power is not None
    v = found.least_power.speed
    beside = tailsitter.steady([v - 0.4, v, v + 0.8], margin=False).power
    assert beside[1] <= beside[0] and beside[1] <= beside[2]


def test_slower_than_stall_there_is_no_number() -> None:
    """The stall speed is that of the wing's largest lift, sqrt(2 W/(rho S C_L))."""
    craft = aircraft_of(plane(powertrain=Powertrain()), maximum_rotor_speed=7000.0 * RPM)
    angles = np.linspace(0.0, 0.5, 2001)
    still = np.stack([np.cos(angles), 0.0 * angles, -np.sin(angles)], axis=1)
    force = free_stream_force(Body(), replace(WING, incidence=0.0, span=None), 1.225, still)
    largest = float(np.linalg.norm(force, axis=1).max())
    stall = math.sqrt(1.1 * GRAVITY / largest)
    states = craft.steady(np.array([0.0, 0.7, 1.15]) * stall, margin=False)
    assert states.status.tolist() == ["stall", "stall", "ok"]
    assert np.isnan(states.shaft_power[:2]).all()


def test_a_quadcopter_that_is_too_heavy_does_not_stall() -> None:
    heavy = aircraft_of(quadcopter(wing=replace(WING, incidence=0.1)), maximum_rotor_speed=300.0)
    assert heavy.steady(0.0, margin=False).status.tolist() == ["rpm_limit"]


def test_lift_has_the_drag_of_an_elliptic_wing() -> None:
    """D = L^2/(pi q b^2), and the lift as without it."""
    speed, alpha, density = 11.0, 0.12, 1.2
    velocity = speed * np.array([math.cos(alpha), 0.0, -math.sin(alpha)])
    plain, induced = (
        free_stream_force(Body(), replace(WING, incidence=0.0, span=span), density, velocity)
        for span in (None, 1.2)
    )
    q, lift = 0.5 * density * speed**2, float(np.linalg.norm(plain))
    wanted = lift**2 / (math.pi * q * 1.2**2)
    assert induced - plain == pytest.approx(-wanted * velocity / speed, rel=1e-9)
