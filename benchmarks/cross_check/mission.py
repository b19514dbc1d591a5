"""The mission, the controller that flies it, and what is recorded of a flight."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.integrate import newton_cotes
from scipy.spatial.transform import Rotation

from propmap import Vehicle, VehicleForces, VehicleWrench
from propmap.hover import HoverModel
from propmap.results import spin_sign
from propmap.typing import Floats
from propmap.units import GRAVITY

PERIOD = 0.01
"""Time for which the controller's commands are held [s]."""

TIME_CONSTANT = 0.03
"""With which rotors follow their commands [s]."""

SLOWEST, FASTEST = 400.0, 1000.0
"""Rotor speeds that the controller may command [rad/s]."""

UP = np.array([0.0, 0.0, 1.0])


class State(NamedTuple):
    """A vehicle in the world, whose z points up; its own axes are x forward, y left, z up."""

    position: Floats  # of the center of mass, (3,) [m]
    velocity: Floats  # (3,) [m/s], in the world's axes as the position
    attitude: Floats  # from the vehicle's axes to the world's, (3, 3)
    rates: Floats  # how fast it turns, in its own axes, (3,) [rad/s]
    omega: Floats  # rotor speeds, (k,) [rad/s]


# --- Where it should be --------------------------------------------------------------------------


class Leg(NamedTuple):
    """A change of velocity, the vehicle's own heading forward, then constant velocity."""

    forward: float  # [m/s] at its end
    climb: float  # [m/s] at its end
    change: float  # time of the change [s]
    hold: float  # time of constant velocity [s]


class Course(NamedTuple):
    """Legs one after the other, from rest at the origin, along one heading."""

    legs: tuple[Leg, ...]
    heading: float  # from the world's x axis to the left [rad]

    @property
    def duration(self) -> float:
        """Time of all legs [s]."""
        return sum(leg.change + leg.hold for leg in self.legs)

    def at(self, time: float) -> tuple[Floats, Floats, Floats]:
        """Return position, velocity and acceleration wanted at a ``time`` [s], (3,) each.

        A change is 10 s^3 - 15 s^4 + 6 s^5 of its time: no jump of the acceleration nor of its
        rate.
        """
        ahead = np.array([np.cos(self.heading), np.sin(self.heading), 0.0])
        position, velocity, acceleration = np.zeros((3, 3))
        for leg in self.legs:
            change = leg.forward * ahead + leg.climb * UP - velocity
            s = float(np.clip(time / leg.change, 0.0, 1.0))
            shift = s**4 * (2.5 - 3.0 * s + s**2) * leg.change
            position = position + velocity * min(time, leg.change) + change * shift
            acceleration = change * 30.0 * (s * (1.0 - s)) ** 2 / leg.change
            velocity = velocity + change * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
            time -= leg.change
            if time <= 0.0:
                break
            position = position + velocity * min(time, leg.hold)
            time -= leg.hold
            if time <= 0.0:
                break
        return position, velocity, acceleration


MISSION = Course(
    (
        Leg(0.0, 0.0, 1.0, 3.0),
        Leg(12.0, 0.0, 4.0, 5.0),
        Leg(0.0, 0.0, 4.0, 1.0),
        Leg(0.0, -3.0, 1.5, 3.0),
        Leg(0.0, 0.0, 1.0, 1.5),
    ),
    heading=0.5,
)
"""Hover, 12 m/s forward, brake, descend at 3 m/s, hover."""


# --- What keeps it there -------------------------------------------------------------------------


class Controller:
    """A cascade: position, velocity, attitude, rates, each in proportion to its error.

    The velocity's error has an integral besides.  As an autopilot, it knows of its rotors what they
    do in hover, by which wanted thrust and moments become rotor speeds.
    """

    POSITION, VELOCITY, INTEGRAL = 1.0, 2.5, 1.5  # [1/s], [1/s], [1/s^2]
    ATTITUDE, RATES = 6.0, 20.0  # [1/s], [1/s]

    def __init__(self, vehicle: Vehicle, hover: HoverModel, course: Course) -> None:
        assert vehicle.inertia is not None
        self.mass, self.inertia, self.course = vehicle.mass, np.array(vehicle.inertia), course
        x, y, _ = vehicle.hub_positions.T
        # Against the spin: what the air does to a rotor turns the vehicle the other way.
        yaw = [-spin_sign(mount.spin) for mount in vehicle.mounts]
        thrust = hover.k_thrust * np.array([np.ones_like(x), y, -x])
        self.squares = np.linalg.inv(np.vstack([thrust, hover.k_torque * np.array(yaw)]))
        self.integral = np.zeros(3)

    def __call__(self, time: float, state: State) -> Floats:
        """Return commanded rotor speeds (k,) [rad/s] for the period that begins at ``time``."""
        position, velocity, acceleration = self.course.at(time)
        error = velocity + self.POSITION * (position - state.position) - state.velocity
        self.integral = self.integral + error * PERIOD
        wanted = acceleration + self.VELOCITY * error + self.INTEGRAL * self.integral
        force = self.mass * (wanted + GRAVITY * UP)
        # Thrust along the wanted force, the nose along the course.
        z = force / np.linalg.norm(force)
        y = np.cross(z, [np.cos(self.course.heading), np.sin(self.course.heading), 0.0])
        y /= np.linalg.norm(y)
        target = np.column_stack([np.cross(y, z), y, z])
        off = target.T @ state.attitude
        lean = 0.5 * np.array([off[2, 1] - off[1, 2], off[0, 2] - off[2, 0], off[1, 0] - off[0, 1]])
        turning = self.inertia * self.RATES * (-self.ATTITUDE * lean - state.rates)
        moment = turning + np.cross(state.rates, self.inertia * state.rates)
        squares = self.squares @ np.append(force @ state.attitude[:, 2], moment)
        return np.clip(np.sqrt(np.maximum(squares, 0.0)), SLOWEST, FASTEST)


# --- A flight and its energies -------------------------------------------------------------------


class Simulator(Protocol):
    """What moves a vehicle by its own integrator, where the air does what ``forces`` say."""

    forces: VehicleForces

    @property
    def state(self) -> State:
        """Return the state now."""
        ...

    def advance(self, command: Floats, step: float) -> None:
        """Go on for one ``step`` [s] with rotor speeds ``command`` (k,) [rad/s] wanted."""
        ...


@dataclass(frozen=True)
class Flight:
    """What a vehicle did: states at the ends of steps, some steps in each of the n periods."""

    vehicle: Vehicle
    steps: int  # in a period
    states: State  # arrays with a first axis 1 + n steps
    wrench: VehicleWrench  # of the air, at these states

    @property
    def time(self) -> Floats:
        """The ends of the periods [s], which all arrays below are at, (1 + n,)."""
        return np.asarray(PERIOD * np.arange(self.at_ends.position.shape[0]))

    @property
    def at_ends(self) -> State:
        """States there."""
        return State(*(values[:: self.steps] for values in self.states))

    @property
    def pitch(self) -> Floats:
        """Angle of the vehicle's x axis below the horizon [rad]."""
        return -np.arcsin(np.clip(self.at_ends.attitude[:, 2, 0], -1.0, 1.0))

    @property
    def stored(self) -> Floats:
        """Kinetic and potential energy less that at the start [J]."""
        at, mass = self.at_ends, self.vehicle.mass
        moving = 0.5 * mass * np.sum(at.velocity**2, axis=1)
        turning = 0.5 * np.sum(np.array(self.vehicle.inertia) * at.rates**2, axis=1)
        energy = moving + turning + mass * GRAVITY * at.position[:, 2]
        return energy - energy[0]

    @property
    def work(self) -> Floats:
        """Work of the air on the vehicle since the start [J]."""
        force = np.einsum("nij,nj->ni", self.states.attitude, self.wrench.force)
        power = np.sum(force * self.states.velocity, axis=1)
        return self._integral(power + np.sum(self.wrench.moment * self.states.rates, axis=1))

    @property
    def used(self) -> Floats:
        """Energy that the shafts have taken since the start [J]."""
        return self._integral(self.wrench.power)

    def _integral(self, power: Floats) -> Floats:
        """Integrate by a polynomial through each period's samples: commands jump between them."""
        weights = newton_cotes(self.steps, 1)[0] * PERIOD / self.steps
        each = sliding_window_view(power, self.steps + 1)[:: self.steps] @ weights
        return np.append(0.0, np.cumsum(each))


def fly(simulator: Simulator, controller: Controller, steps: int) -> Flight:
    """Fly the controller's course in a ``simulator``, with so many ``steps`` in each period."""
    found = [simulator.state]
    for n in range(round(controller.course.duration / PERIOD)):
        command = controller(n * PERIOD, found[-1])
        for _ in range(steps):
            simulator.advance(command, PERIOD / steps)
            found.append(simulator.state)
    states = State(*(np.array(values) for values in zip(*found, strict=True)))
    through = np.einsum("nji,nj->ni", states.attitude, states.velocity)
    wrench = simulator.forces.wrench(states.omega, through, states.rates)
    return Flight(simulator.forces.vehicle, steps, states, wrench)


def apart(one: Flight, other: Flight) -> dict[str, Floats]:
    """Return how far two flights are apart at the ends of periods [m], [m/s], [rad], [J]."""
    a, b = one.at_ends, other.at_ends
    turn = Rotation.from_matrix(a.attitude).inv() * Rotation.from_matrix(b.attitude)
    return {
        "position": np.linalg.norm(a.position - b.position, axis=1),
        "velocity": np.linalg.norm(a.velocity - b.velocity, axis=1),
        "attitude": turn.magnitude(),
        "energy": np.abs(one.used - other.used),
    }


def start(course: Course, hover_speed: float) -> State:
    """Return a state near hover that is off about every axis and along it."""
    return State(
        position=np.array([0.3, -0.2, 0.1]),
        velocity=np.array([0.1, 0.2, -0.3]),
        attitude=Rotation.from_euler("ZYX", [course.heading + 0.2, -0.08, 0.1]).as_matrix(),
        rates=np.array([0.2, -0.3, 0.4]),
        omega=np.full(4, hover_speed),
    )
