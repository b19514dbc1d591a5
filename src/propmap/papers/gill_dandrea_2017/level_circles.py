"""The paper's flight experiment: level circles on a tether, with the sets of Table I.

No log of those flights is at hand.  The flights are computed: the truth is this model with the
set of Table I, and an unknown vertical force of a known size stands for all that it leaves out.
So these numbers say what the hover model gets wrong where this model holds, and how well an
identification finds the parameters again; they do not test this model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.arrays.types import Floats
from propmap.baselines.hover import HoverModel
from propmap.fit.body_forces import body_force
from propmap.fit.fitted import Fitted, Settings, fit
from propmap.fit.flight import ForceModel, level_rows
from propmap.fit.parameters import PAPER_FOUR, Choice
from propmap.fit.tunnel import first_guess
from propmap.flight.trim import trim, true_values
from propmap.model.airfoil import Airfoil, parameter_set
from propmap.model.model import Model
from propmap.papers.gill_dandrea_2017.blades import blade
from propmap.papers.gill_dandrea_2017.paper import FASTEST, FLIGHTS, RADIUS, TETHER
from propmap.rotor import Rotor
from propmap.vehicle.flight_log import GRAVITY, FlightLog, pitch_and_roll
from propmap.vehicle.hub_flow import hub_flow, rotor_forces
from propmap.vehicle.vehicle import Body, Mount, Vehicle

BLADE = "apc-8x4.5mr"
"""Whose blade stands for both propellers, scaled to 10 cm: their own are not published."""

ARM = 0.12
"""[m] of the rotors from the axes: assumed."""

FORCE_ERROR = 0.01
"""Standard deviation of the unknown vertical force of a flight, as a share of the weight."""

SEEDS = {"paper-soft": 2017, "paper-stiff": 2018}
"""Of the unknown forces, so that the two sets meet different ones."""

FAILS = (0.05, 0.1)
"""Errors of the vertical force, as shares of the weight, at which the hover model fails."""


@dataclass(frozen=True, eq=False)
class Circles:
    """Level circles at n speeds [m/s]; loads are sums over the rotors in [N] and [N m].

    pitch [rad], nose down.  rotor_speed [rad/s].  error, hover_error : vertical force of rotors
    and frame less the weight [N]; that of the model itself is what the trim left over.
    """

    speed: Floats
    rotor_speed: Floats
    pitch: Floats
    thrust: Floats
    drag: Floats
    torque: Floats
    hover_thrust: Floats
    hover_torque: Floats
    hover_error: Floats


@dataclass(frozen=True, eq=False)
class Twin:
    """An identification from simulated flights: the truth, what was found, errors left.

    speed (n,) [m/s].  error, hover_error : (n,) [N], vertical force by the identified and by the
    hover model less the weight.
    """

    truth: Airfoil
    fitted: Fitted
    speed: Floats
    error: Floats
    hover_error: Floats


@dataclass(frozen=True)
class Case:
    """What the paper does not give and is assumed: mass [kg], drag area of the frame [m^2]."""

    mass: float
    drag_area: float


ASSUMED = Case(0.5, 0.01)
"""A light quadrotor with 10 cm rotors."""

CASES = (ASSUMED, *(Case(0.5, area) for area in (0.0, 0.02, 0.04)), Case(1.0, 0.01))
"""For which the hover model's error is looked at."""

SPEEDS = np.linspace(0.0, FASTEST, 30)
"""[m/s]."""


@dataclass(frozen=True)
class HoverFailure:
    """Speeds [m/s] from which the hover model's error exceeds ``FAILS`` of the weight, and at
    which it turns from too little to too much; None where it never does."""

    exceeds: tuple[float | None, ...]
    sign_changes: float | None


@dataclass(frozen=True, eq=False)
class SetFlown:
    """One set of Table I: circles in every case of ``CASES``, and the twin experiment."""

    circles: dict[Case, Circles]
    twin: Twin


def quadrotor(case: Case = ASSUMED) -> Vehicle:
    """The vehicle; its frame drags alike along all axes."""
    places = ((ARM, ARM, "cw"), (ARM, -ARM, "ccw"), (-ARM, ARM, "ccw"), (-ARM, -ARM, "cw"))
    mounts = tuple(Mount((x, y, 0.0), spin=spin) for x, y, spin in places)
    body = Body(drag_area=(case.drag_area,) * 3)
    return Vehicle("tethered quadrotor", case.mass, blade(BLADE, RADIUS), mounts, body=body)


def fly(name: str) -> SetFlown:
    """Fly one set of Table I."""
    law = parameter_set(name)
    found = {case: circles(quadrotor(case), law, SPEEDS) for case in CASES}
    return SetFlown(found, twin(law, SEEDS[name]))


def circles(vehicle: Vehicle, law: Airfoil, speeds: Floats) -> Circles:
    """Trim the vehicle on level circles and compare the hover model at the same rotor speeds.

    The hover model takes its constants from the rotors at rest, at their speed in hover.
    """
    points = trim(vehicle, law, speeds, radius=TETHER)
    rotor = Rotor(Model(vehicle.propeller, law, vehicle.air))
    flow = hub_flow(vehicle, points)
    velocity = np.stack([flow.inplane, 0.0 * flow.inplane, flow.axial], axis=-1)
    loads = rotor.loads_at_velocity(flow.omega, velocity)
    hover = _hover(vehicle, law)
    return Circles(
        speed=speeds,
        rotor_speed=points.rotor_speed[:, 0],
        pitch=pitch_and_roll(points.up)[0],
        thrust=loads.thrust.sum(axis=1),
        drag=loads.drag.sum(axis=1),
        torque=loads.torque.sum(axis=1),
        hover_thrust=hover.thrust(flow.omega).sum(axis=1),
        hover_torque=hover.torque(flow.omega).sum(axis=1),
        hover_error=_hover_error(vehicle, points, law, hover),
    )


def twin(law: Airfoil, seed: int) -> Twin:
    """Twenty circles with unknown forces, and the paper's four parameters from them, eq. (18)."""
    vehicle = quadrotor()
    speeds = np.linspace(0.5, FASTEST, FLIGHTS)
    unknown = FORCE_ERROR * np.random.default_rng(seed).standard_normal(FLIGHTS)
    points = trim(vehicle, law, speeds, radius=TETHER, disturbance=unknown)
    choice = Choice(PAPER_FOUR)
    rows = level_rows(ForceModel(vehicle, points, first_guess()), choice)
    fitted = fit(rows, choice, Settings(starts=2, folds=0))
    hover = _hover(vehicle, law)
    return Twin(law, fitted, speeds, fitted.residual, _hover_error(vehicle, points, law, hover))


def static_inflow(case: Case) -> float:
    """v_h [m/s] of a rotor that carries a quarter of the weight, eq. (12)."""
    area = np.pi * RADIUS**2
    return float(np.sqrt(case.mass * GRAVITY / (4 * 2.0 * quadrotor(case).air.density * area)))


def hover_failure(found: Circles, mass: float) -> HoverFailure:
    """Where the hover model fails, between the speeds flown by linear interpolation."""
    share = found.hover_error / (mass * GRAVITY)
    exceeds = tuple(first_crossing(found.speed, np.abs(share) - level) for level in FAILS)
    # From where it is clearly too little, so that rounding in hover is no change of sign.
    low = int(np.argmax(share < -FAILS[0])) if (share < -FAILS[0]).any() else share.size
    return HoverFailure(exceeds, first_crossing(found.speed[low:], share[low:]))


def first_crossing(x: Floats, y: Floats) -> float | None:
    """The first x at which y (n,) rises through zero; None where it does not."""
    for k in range(1, x.size):
        if y[k - 1] < 0.0 <= y[k]:
            return float(x[k] - (x[k] - x[k - 1]) * y[k] / (y[k] - y[k - 1]))
    return None


def _hover(vehicle: Vehicle, law: Airfoil) -> HoverModel:
    rotor = Rotor(Model(vehicle.propeller, law, vehicle.air))
    still = HoverModel.of(rotor)
    each = vehicle.mass * GRAVITY / len(vehicle.mounts)
    return HoverModel.of(rotor, float(np.sqrt(each / still.k_thrust)))


def _hover_error(vehicle: Vehicle, points: FlightLog, law: Airfoil, hover: HoverModel) -> Floats:
    flow = hub_flow(vehicle, points)
    thrust = hover.thrust(flow.omega)
    body, _ = body_force(vehicle, points, true_values(vehicle, law), ())
    force = rotor_forces(flow, thrust, np.zeros_like(thrust)) + body
    return np.asarray(np.sum(force * points.up, axis=1) - vehicle.mass * GRAVITY)
