"""Steady states balance forces and moments, beside a balance that shares only the rotor's loads."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.aircraft.trim import Aircraft, SteadyStates
from propmap.errors import InputError
from propmap.units import GRAVITY, RPM
from propmap.vehicle.powertrain import Powertrain
from propmap.vehicle.vehicle import Body, Mount, Vehicle, Wing
from propmap.vehicle.vehicle_forces import free_stream_force

from .conftest import ARM, aircraft_of, quadcopter, rotor_of, unbalanced

SPEEDS = np.array([0.0, 6.0, 14.0])


@pytest.fixture(scope="module")
def level(aircraft: Aircraft) -> SteadyStates:
    return aircraft.steady(SPEEDS)


def test_level_flight_balances(vehicle: Vehicle, level: SteadyStates) -> None:
    assert level.status.tolist() == ["ok"] * 3
    for k, speed in enumerate(SPEEDS.tolist()):
        assert np.abs(unbalanced(vehicle, level, k, (speed, 0.0, 0.0))).max() < 1e-8
    still = rotor_of(vehicle).loads(level.rotor_speed[0], 0.0, 0.0)
    assert still.thrust.sum() == pytest.approx(vehicle.mass * GRAVITY, rel=1e-8)
    assert level.shaft_power[0] == pytest.approx(still.power.sum(), rel=1e-8)


def test_a_symmetric_vehicle_flies_symmetrically(aircraft: Aircraft, level: SteadyStates) -> None:
    assert np.abs(level.roll).max() < 1e-12
    front_left, rear_left, rear_right, front_right = level.rotor_speed.T
    assert front_left == pytest.approx(front_right, rel=1e-10)
    assert rear_left == pytest.approx(rear_right, rel=1e-10)
    assert (rear_left > front_left)[1:].all()  # the rotors' moments lift the nose
    assert level.rotor_speed[0] == pytest.approx(level.rotor_speed[0, 0], rel=1e-10)
    assert level.pitch[0] == pytest.approx(0.0, abs=1e-10)
    # A start nearby changes nothing.
    found, plain = (aircraft.steady([10.0], near=near) for near in (level, None))
    assert found.rotor_speed == pytest.approx(plain.rotor_speed, rel=1e-8)


def test_hover_power_of_constant_loading_is_that_of_momentum_theory() -> None:
    """A blade with twist in inverse proportion to its radius and without section drag has the same
    inflow everywhere but at its root: hover takes W sqrt(W/4 / (2 rho A))."""
    radius = 0.12
    station = np.linspace(0.02, 1.0, 40) * radius
    twist = np.arctan(0.12 * radius / station)
    blade = propmap.Propeller("ideal", 2, station, np.full(40, 0.012), twist)
    law = propmap.Airfoil(c_l1=5.7, c_l2=1.0, c_d=0.0, alpha_0=0.6, c_d0=0.0, c_p=0.0)
    for mass in (0.6, 2.4):
        vehicle = quadcopter(propeller=blade, mass=mass)
        rotor = propmap.Rotor(propmap.Model(blade, law, vehicle.air))
        states = Aircraft(vehicle, rotor).steady(0.0, margin=False)
        weight = mass * GRAVITY
        disk = 2.0 * vehicle.air.density * math.pi * radius**2
        ideal = weight * math.sqrt(weight / 4.0 / disk)
        assert states.shaft_power[0] == pytest.approx(ideal, rel=0.005)


def test_a_coordinated_turn(vehicle: Vehicle, aircraft: Aircraft) -> None:
    bank, speed = math.radians(35.0), 10.0
    right, left = (aircraft.steady(speed, bank=b) for b in (bank, -bank))
    turn = -GRAVITY * math.tan(bank) / speed
    assert np.abs(unbalanced(vehicle, right, 0, (speed, 0.0, turn))).max() < 1e-8
    # What carries it is the weight times the load factor 1/cos(bank): vertical and to the right.
    assert float(right.roll[0]) == pytest.approx(bank, abs=math.radians(1.0))
    assert right.shaft_power[0] > aircraft.steady(speed).shaft_power[0]
    # A left turn is the mirror image.
    assert left.roll == pytest.approx(-right.roll, rel=1e-8)
    assert left.pitch == pytest.approx(right.pitch, rel=1e-8)
    assert left.rotor_speed[0] == pytest.approx(right.rotor_speed[0][[3, 2, 1, 0]], rel=1e-8)


def test_the_load_factor_of_a_turn(vehicle: Vehicle) -> None:
    """Without drag and rotor drag, the hover model's thrust is the weight over cos(bank)."""
    craft = aircraft_of(replace(vehicle, body=Body())).with_hover_model()
    bank = np.radians([0.0, 20.0, 60.0])
    thrust = craft.steady([8.0, 8.0, 8.0], bank=bank).thrust.sum(axis=1)
    assert thrust == pytest.approx(vehicle.mass * GRAVITY / np.cos(bank), rel=1e-8)


def test_climb_takes_the_power_of_the_climb(vehicle: Vehicle, aircraft: Aircraft) -> None:
    slow, fast = (aircraft.steady(0.0, climb=w) for w in (2.0, 4.0))
    for states, climb in ((slow, 2.0), (fast, 4.0)):
        assert np.abs(unbalanced(vehicle, states, 0, (0.0, climb, 0.0))).max() < 1e-8
    gained = float(fast.shaft_power[0] - slow.shaft_power[0])
    # More than half of the weight's work: the induced power falls as the rotor climbs.
    assert 0.5 * 2.0 < gained / (vehicle.mass * GRAVITY) < 3.0 * 2.0
    descent = aircraft.steady(0.0, climb=[-3.0, 1.0])
    assert descent.status.tolist() == ["vortex_ring", "ok"]


def test_what_rotors_cannot_balance_is_told(vehicle: Vehicle) -> None:
    """One rotor ahead of a wing: thrust alone; the rest is for control surfaces."""
    single = replace(vehicle, mounts=(Mount((0.1, 0.0, 0.0), spin="ccw"),), mass=0.3)
    states = aircraft_of(single).steady(0.0)
    assert states.status.tolist() == ["ok"]
    torque = float(states.torque[0, 0])
    # Against the turning of the rotor, and the weight's lever about y.
    assert states.moment[0] == pytest.approx(
        [0.0, -0.1 * 0.3 * GRAVITY, -torque], rel=1e-6, abs=1e-9
    )


def test_yaw_authority_is_torque_over_thrust_and_arm(vehicle: Vehicle) -> None:
    """With arms of 1 m, yaw is less than 2 % of roll, and the rotors still balance it."""
    for side in (ARM, 1.0):
        wide = [
            replace(m, position=tuple(side / ARM * np.array(m.position))) for m in vehicle.mounts
        ]
        craft = aircraft_of(replace(vehicle, mounts=tuple(wide)))
        hover = craft.steady(0.0)
        by_hand = float(hover.torque[0, 0] / hover.thrust[0, 0]) / side
        assert craft.balance.allocation.yaw_over_roll == pytest.approx(by_hand, rel=0.01)
        # The yaw of the other rotors balances a rotor that is tilted sideways.
        wide[0] = replace(wide[0], axis=(math.sin(0.002), 0.0, math.cos(0.002)))
        tilted = aircraft_of(replace(vehicle, mounts=tuple(wide)))
        states = tilted.steady(0.0)
        assert tilted.notes == [] and np.abs(states.moment).max() < 1e-7
        yaw = side * 0.002 * float(states.thrust[0, 0])
        spins = np.array([-1.0, 1.0, -1.0, 1.0])  # cw rotors turn the vehicle to the left
        assert spins @ states.torque[0] == pytest.approx(-yaw, rel=0.01)


def test_equal_spins_along_the_sides_leave_yaw_uncommanded(vehicle: Vehicle) -> None:
    spins = ("cw", "cw", "ccw", "ccw")  # front left, rear left, rear right, front right
    mounts = (replace(m, spin=s) for m, s in zip(vehicle.mounts, spins, strict=True))
    craft = aircraft_of(replace(vehicle, mounts=tuple(mounts)))
    assert craft.steady([0.0, 8.0]).status.tolist() == ["ok", "ok"]
    (note,) = craft.notes
    assert "cannot command yaw without roll (0% of yaw is independent)" in note


def test_limits_are_statuses_not_numbers(vehicle: Vehicle) -> None:
    slow = aircraft_of(vehicle, maximum_rotor_speed=640.0).steady([8.0, 20.0])
    assert slow.status.tolist() == ["ok", "rpm_limit"]
    assert slow.used["rpm_limit"][1] > 1.0
    for name in ("pitch", "shaft_power", "electrical_power", "residual"):
        values = getattr(slow, name)
        assert np.isfinite(values[0]) and np.isnan(values[1]), name
    assert np.isnan(slow.rotor_speed[1]).all()
    assert slow.thrust_margin[0] > 1.0 > slow.thrust_margin[1] > 0.5
    weak = replace(vehicle.powertrain, motor=replace(vehicle.powertrain.motor, maximum_current=5.0))
    states = aircraft_of(replace(vehicle, powertrain=weak)).steady(0.0)
    assert states.status.tolist() == ["motor_current_limit"]
    heavy = aircraft_of(replace(vehicle, mass=12.0)).steady(0.0)
    assert heavy.status[0] in ("voltage_limit", "motor_current_limit", "battery_limit")
    assert np.isnan(heavy.shaft_power[0])
    assert heavy.thrust_margin[0] < 1.0  # less thrust than weight


def test_thrust_margin_is_thrust_at_the_limit(vehicle: Vehicle) -> None:
    craft = aircraft_of(
        replace(vehicle, powertrain=type(vehicle.powertrain)()), maximum_rotor_speed=900.0
    )
    states = craft.steady(0.0)
    at_limit = rotor_of(vehicle).loads(900.0, 0.0, 0.0).thrust * 4.0
    assert states.thrust_margin[0] == pytest.approx(at_limit / (vehicle.mass * GRAVITY), rel=1e-4)


def test_bad_input(aircraft: Aircraft, vehicle: Vehicle) -> None:
    for arguments, told in (
        ({"speed": -1.0}, "speed is negative"),
        ({"speed": math.nan}, "not finite"),
        ({"speed": 5.0, "bank": 1.5}, "80 degrees"),
        ({"speed": 0.0, "bank": 0.2}, "a turn needs speed"),
        ({"speed": [[1.0]]}, "axes"),
    ):
        with pytest.raises(InputError, match=told):
            aircraft.steady(**arguments)
    with pytest.raises(InputError, match="charge"):
        aircraft_of(vehicle, charge=1.2)
    with pytest.raises(InputError, match="largest rotor speed"):
        aircraft_of(vehicle, maximum_rotor_speed=0.0)
    other = replace(vehicle, propeller=propmap.propeller("apc-9x6e"))
    with pytest.raises(InputError, match="another propeller"):
        Aircraft(other, rotor_of(vehicle))


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
    # A quadcopter that is too heavy does not stall.
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
