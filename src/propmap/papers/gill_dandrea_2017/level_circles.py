"""The paper's flight experiment: level circles on a tether, with the sets of Table I.

The logs of those flights are not public, so the flights are computed: the truth is this model with
the set of Table I, plus an unknown vertical force of known size for all that the model leaves out.
These numbers say what the hover model gets wrong where this model is right, and how well an
identification finds the parameters again; they do not test this model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.baselines.hover import HoverModel
from propmap.fit.fit import Fitted, Settings, fit
from propmap.fit.flight import ForceModel, body_force, hover_loads, level_rows
from propmap.fit.parameters import Choice
from propmap.fit.tunnel import first_guess
from propmap.flight.simulate import trim, true_values
from propmap.model.airfoil import PAPER_FOUR, Airfoil, parameter_set
from propmap.model.model import Model
from propmap.papers.gill_dandrea_2017.blades import blade
from propmap.papers.gill_dandrea_2017.paper import FASTEST, FLIGHTS, RADIUS, TETHER
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.log import FlightLog, pitch_and_roll
from propmap.vehicle.vehicle import Body, Mount, Vehicle
from propmap.vehicle.wakes import hub_flow

BLADE = "apc-8x4.5mr"
"""Used for both propellers, scaled to 10 cm: their own blades are not published."""

ARM = 0.12
"""[m] of the rotors from the axes: assumed."""

FORCE_ERROR = 0.01
"""Standard deviation of the unknown vertical force of a flight, as a share of the weight."""

SEEDS = {"paper-soft": 2017, "paper-stiff": 2018}
"""Of the unknown forces, so that the two sets meet different ones."""

FAILS = (0.05, 0.1)
"""Errors of the vertical force, as shares of the weight, at which the hover model fails."""

SPEEDS = np.linspace(0.0, FASTEST, 30)
"""[m/s]."""


@dataclass(frozen=True, eq=False)
class Circles:
    """Level circles at n speeds; every array is (n,), and loads are sums over the rotors.

    Attributes
    ----------
    speed, rotor_speed, pitch : ndarray
        [m/s]; [rad/s]; nose down [rad].
    thrust, drag, torque, hover_thrust, hover_torque : ndarray
        Of this model and of the hover model [N], [N m].
    hover_error : ndarray
        Vertical force by the hover model, with that of the frame, less the weight [N].
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
    """An identification from n simulated flights.

    Attributes
    ----------
    fitted : Fitted
        What was found.
    speed : ndarray, shape (n,)
        Of the flights [m/s].
    error, hover_error : ndarray, shape (n,)
        Vertical force by the identified and by the hover model, less the weight [N].
    """

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

    @property
    def failures(self) -> dict[Case, HoverFailure]:
        """Where the hover model fails, by case."""
        return {case: hover_failure(found, case.mass) for case, found in self.circles.items()}


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
        hover_error=_hover_error(vehicle, points, law),
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
    return Twin(fitted, speeds, fitted.residual, _hover_error(vehicle, points, law))


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


def _hover_error(vehicle: Vehicle, points: FlightLog, law: Airfoil) -> Floats:
    body, _ = body_force(vehicle, points, true_values(vehicle, law), ())
    force = hover_loads(_hover(vehicle, law), hub_flow(vehicle, points))[:, :3] + body
    return np.asarray(np.sum(force * points.up, axis=1) - vehicle.mass * GRAVITY)
