"""Steady states balance forces and moments, beside a balance that shares only the rotor's loads."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import root
from scipy.spatial.transform import Rotation

import propmap
from propmap.aircraft.trim import Aircraft, SteadyStates
from propmap.errors import InputError
from propmap.vehicle.vehicle import Body, Mount, Vehicle, Wing

from .conftest import aircraft_of, quadcopter, rotor_of

GRAVITY = 9.80665
SPEEDS = np.array([0.0, 6.0, 14.0])


def forces_and_moments(
    vehicle: Vehicle,
    rotor: propmap.Rotor,
    attitude: tuple[float, float],
    omega: np.ndarray,
    flight: tuple[float, float, float],
) -> tuple[np.ndarray, np.ndarray]:
    """Forces of rotors, body and weight with its centrifugal force, in the world's frame.

    Written with rotation matrices and ``Rotor.wrench``; vehicles whose axes are vertical.
    """
    pitch, roll = attitude
    speed, climb, turn = flight
    # About the left by the pitch, nose down; then about the own x axis, right side down.
    body_to_world = Rotation.from_euler("YX", [pitch, roll]).as_matrix()
    to_body = body_to_world.T
    velocity = to_body @ [speed, 0.0, climb]
    rates = to_body @ [0.0, 0.0, turn]
    force, moment = np.zeros(3), np.zeros(3)
    for mount, w in zip(vehicle.mounts, omega, strict=True):
        arm = np.array(mount.position)
        wrench = rotor.wrench(w, velocity + np.cross(rates, arm), mount.spin)
        force += wrench.force
        moment += wrench.moment + np.cross(arm, wrench.force)
    area = np.array(vehicle.body.drag_area)
    force -= 0.5 * vehicle.air.density * area * np.abs(velocity) * velocity
    inertial = vehicle.mass * np.array([0.0, speed * turn, GRAVITY])
    return body_to_world @ force - inertial, moment


def one(states: SteadyStates, k: int) -> tuple[tuple[float, float], np.ndarray]:
    return (float(states.pitch[k]), float(states.roll[k])), states.rotor_speed[k]


@pytest.fixture(scope="module")
def level(aircraft: Aircraft) -> SteadyStates:
    return aircraft.steady(SPEEDS)


def test_level_flight_balances(vehicle: Vehicle, level: SteadyStates) -> None:
    rotor, weight = rotor_of(vehicle), vehicle.mass * GRAVITY
    assert level.status.tolist() == ["ok"] * 3
    for k, speed in enumerate(SPEEDS.tolist()):
        force, moment = forces_and_moments(vehicle, rotor, *one(level, k), (speed, 0.0, 0.0))
        assert np.abs(force).max() < 1e-8 * weight
        assert np.abs(moment).max() < 1e-8 * weight * 0.23


def test_the_same_root_by_scipy(vehicle: Vehicle, level: SteadyStates) -> None:
    rotor, weight = rotor_of(vehicle), vehicle.mass * GRAVITY

    def unbalanced(x: np.ndarray) -> np.ndarray:
        found = forces_and_moments(vehicle, rotor, (x[0], x[1]), 600.0 * x[2:], (14.0, 0.0, 0.0))
        return np.concatenate([found[0] / weight, found[1] / weight])

    found = root(unbalanced, [0.1, 0.02, 1.0, 1.1, 1.0, 1.1], tol=1e-11)
    assert found.success
    assert level.pitch[2] == pytest.approx(found.x[0], abs=1e-8)
    assert level.roll[2] == pytest.approx(found.x[1], abs=1e-8)
    assert level.rotor_speed[2] == pytest.approx(600.0 * found.x[2:], rel=1e-8)


def test_a_symmetric_vehicle_flies_symmetrically(level: SteadyStates) -> None:
    assert np.abs(level.roll).max() < 1e-12
    front_left, rear_left, rear_right, front_right = level.rotor_speed.T
    assert front_left == pytest.approx(front_right, rel=1e-10)
    assert rear_left == pytest.approx(rear_right, rel=1e-10)
    assert (rear_left > front_left)[1:].all()  # the rotors' moments lift the nose
    assert level.rotor_speed[0] == pytest.approx(level.rotor_speed[0, 0], rel=1e-10)
    assert level.pitch[0] == pytest.approx(0.0, abs=1e-10)


def test_hover_is_thrust_equal_to_weight(vehicle: Vehicle, level: SteadyStates) -> None:
    still = rotor_of(vehicle).loads(level.rotor_speed[0], 0.0, 0.0)
    assert still.thrust.sum() == pytest.approx(vehicle.mass * GRAVITY, rel=1e-8)
    assert level.shaft_power[0] == pytest.approx(still.power.sum(), rel=1e-8)


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


def test_hover_power_against_momentum_theory(vehicle: Vehicle) -> None:
    """T v_h over the power is the figure of merit of the rotor's own static loads; at an equal disk
    loading it does not change with the mass, but for Reynolds number."""
    light, heavy = (aircraft_of(replace(vehicle, mass=m)).steady(0.0) for m in (0.9, 1.8))
    area = math.pi * vehicle.propeller.radius**2
    merit = []
    for mass, states in ((0.9, light), (1.8, heavy)):
        thrust = mass * GRAVITY / 4.0
        ideal = 4.0 * thrust * math.sqrt(thrust / (2.0 * vehicle.air.density * area))
        merit.append(ideal / float(states.shaft_power[0]))
    assert 0.4 < merit[0] < 0.8
    assert merit[1] == pytest.approx(merit[0], rel=0.03)


def test_a_coordinated_turn(vehicle: Vehicle, aircraft: Aircraft) -> None:
    bank, speed = math.radians(35.0), 10.0
    right, left = (aircraft.steady(speed, bank=b) for b in (bank, -bank))
    turn = -GRAVITY * math.tan(bank) / speed
    force, moment = forces_and_moments(
        vehicle, rotor_of(vehicle), *one(right, 0), (speed, 0.0, turn)
    )
    weight = vehicle.mass * GRAVITY
    assert np.abs(force).max() < 1e-8 * weight and np.abs(moment).max() < 1e-8 * weight
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
        force, _ = forces_and_moments(
            vehicle, rotor_of(vehicle), *one(states, 0), (0.0, climb, 0.0)
        )
        assert np.abs(force).max() < 1e-7
    gained = float(fast.shaft_power[0] - slow.shaft_power[0])
    # More than half of the weight's work: the induced power falls as the rotor climbs.
    assert 0.5 * 2.0 < gained / (vehicle.mass * GRAVITY) < 3.0 * 2.0


def test_descent_into_the_vortex_ring_is_marked(aircraft: Aircraft) -> None:
    states = aircraft.steady(0.0, climb=[-3.0, 1.0])
    assert states.status.tolist() == ["vortex_ring", "ok"]


def test_rotors_of_a_hexacopter_share_the_load(vehicle: Vehicle) -> None:
    places = [(math.cos(a), math.sin(a)) for a in np.radians(np.arange(30.0, 390.0, 60.0))]
    mounts = tuple(
        Mount((0.3 * x, 0.3 * y, 0.0), spin=("cw", "ccw")[k % 2]) for k, (x, y) in enumerate(places)
    )
    craft = aircraft_of(replace(vehicle, mounts=mounts))
    states = craft.steady([0.0, 8.0])
    assert states.status.tolist() == ["ok", "ok"]
    assert states.rotor_speed[0] == pytest.approx(states.rotor_speed[0, 0], rel=1e-9)
    assert np.abs(states.moment).max() < 1e-7


def test_a_center_of_mass_ahead_loads_the_front(vehicle: Vehicle) -> None:
    mounts = tuple(
        replace(m, position=(m.position[0] - 0.03, m.position[1], m.position[2]))
        for m in vehicle.mounts
    )
    states = aircraft_of(replace(vehicle, mounts=mounts)).steady(0.0)
    front, rear = states.thrust[0, [0, 3]].sum(), states.thrust[0, [1, 2]].sum()
    # Moments about the center of mass.
    assert front * (0.16 - 0.03) == pytest.approx(rear * (0.16 + 0.03), rel=1e-7)


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


def test_a_wing_carries(vehicle: Vehicle) -> None:
    """A tailsitter: nose up in hover, and on its wing in fast flight, with rotors along x."""
    wing = Wing(0.25, incidence=math.pi / 2.0, c_l1=4.5, c_l2=1.0, alpha_0=0.25)
    tailsitter = replace(vehicle, wing=wing, body=Body((0.3, 0.02, 0.02)))
    states = aircraft_of(tailsitter).steady([0.0, 4.0, 16.0, 18.0])
    assert states.status[[0, 3]].tolist() == ["ok", "ok"]
    assert states.pitch[0] == pytest.approx(0.0, abs=1e-9)
    assert math.radians(70.0) < states.pitch[3] < math.radians(90.0)
    assert states.thrust[3].sum() < 0.5 * vehicle.mass * GRAVITY


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


def test_what_cannot_be_balanced_has_no_number(vehicle: Vehicle) -> None:
    """Rotors that lean so far that only an impossible attitude would carry the weight."""
    states = aircraft_of(
        replace(vehicle, body=Body((3.0, 3.0, 3.0)), powertrain=quadcopter().powertrain)
    ).steady(60.0)
    assert states.status[0] != "ok"
    assert np.isnan(states.shaft_power[0]) and np.isnan(states.pitch[0])


def test_power_falls_then_rises_and_drag_area_costs(vehicle: Vehicle) -> None:
    speeds = np.array([0.0, 9.0, 22.0])
    power = [
        aircraft_of(replace(vehicle, body=Body((area,) * 3))).steady(speeds).shaft_power
        for area in (0.005, 0.02)
    ]
    assert power[0][1] < power[0][0] and power[0][1] < power[0][2]
    assert (power[1][1:] > power[0][1:]).all()
    assert power[1][0] == pytest.approx(power[0][0], rel=1e-9)


def test_induced_power_falls_as_one_over_speed(vehicle: Vehicle) -> None:
    """In fast edgewise flight T v_i goes as T^2/(2 rho A V): Glauert's high-speed limit."""
    craft = aircraft_of(replace(vehicle, body=Body()))
    states = craft.steady([14.0, 18.0])
    rotor, inflow = rotor_of(vehicle), []
    for k, speed in enumerate((14.0, 18.0)):
        pitch = float(states.pitch[k])
        found = rotor.loads(states.rotor_speed[k], speed, math.pi / 2.0 - pitch)
        inflow.append(float((found.thrust * found.mean_inflow).sum()))
    thrust = states.thrust.sum(axis=1)
    assert inflow[1] / inflow[0] == pytest.approx(
        (thrust[1] / thrust[0]) ** 2 * 14.0 / 18.0, rel=0.05
    )


def test_starting_nearby_changes_nothing(aircraft: Aircraft, level: SteadyStates) -> None:
    found = aircraft.steady([10.0], near=level)
    plain = aircraft.steady([10.0])
    assert found.rotor_speed == pytest.approx(plain.rotor_speed, rel=1e-8)


def test_thrust_margin_is_thrust_at_the_limit(vehicle: Vehicle) -> None:
    craft = aircraft_of(
        replace(vehicle, powertrain=type(vehicle.powertrain)()), maximum_rotor_speed=900.0
    )
    states = craft.steady(0.0)
    at_limit = rotor_of(vehicle).loads(900.0, 0.0, 0.0).thrust * 4.0
    assert states.thrust_margin[0] == pytest.approx(at_limit / (vehicle.mass * GRAVITY), rel=1e-4)


def test_bad_input(aircraft: Aircraft, vehicle: Vehicle) -> None:
    with pytest.raises(InputError, match="speed is negative"):
        aircraft.steady(-1.0)
    with pytest.raises(InputError, match="not finite"):
        aircraft.steady(math.nan)
    with pytest.raises(InputError, match="80 degrees"):
        aircraft.steady(5.0, bank=1.5)
    with pytest.raises(InputError, match="a turn needs speed"):
        aircraft.steady(0.0, bank=0.2)
    with pytest.raises(InputError, match="axes"):
        aircraft.steady([[1.0]])
    with pytest.raises(InputError, match="charge"):
        aircraft_of(vehicle, charge=1.2)
    with pytest.raises(InputError, match="largest rotor speed"):
        aircraft_of(vehicle, maximum_rotor_speed=0.0)
    other = replace(vehicle, propeller=propmap.propeller("apc-9x6e"))
    with pytest.raises(InputError, match="another propeller"):
        Aircraft(other, rotor_of(vehicle))
