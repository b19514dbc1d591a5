"""One mission, one controller, four simulators, two models: `make bench ONLY=cross_check`.

Hover, 12 m/s forward, brake, descend at 3 m/s: a quadrotor of examples/quadrotor.toml on a load
table of its propellers, and on their hover model, flown in SciPy, RotorPy, MuJoCo and Drake with
10, 5 and 2.5 ms a step.  What halving a step changes tells an integrator's error, and what two
simulators may differ by.  Writes results/cross_check.json.
"""

from __future__ import annotations

import itertools
import math
import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import propmap
from benchmarks.cross_check.mission import (
    FASTEST,
    MISSION,
    PERIOD,
    SLOWEST,
    TIME_CONSTANT,
    Controller,
    Course,
    Flight,
    Simulator,
    State,
    apart,
    fly,
    start,
)
from benchmarks.cross_check.simulators import Drake, MuJoCo, RotorPy, SciPy
from benchmarks.results_file import machine, write_results
from propmap.aircraft.trim import Aircraft
from propmap.flight.simulate import trim
from propmap.hover import HoverModel
from propmap.model.airfoil import Airfoil
from propmap.model.corrections import Installed, as_text
from propmap.rotor import Rotor
from propmap.table import LoadTable, build_table
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.log import pitch_and_roll
from propmap.vehicle.vehicle import Vehicle

VEHICLE = Path(__file__).parents[2] / "examples" / "quadrotor.toml"
PROPELLER = "APC 8x6E"
SPEED, BETA, TOLERANCE = (0.0, 16.0), (0.0, math.pi), 0.02
"""Envelope of the table, besides the rotor speeds that the controller may command."""

STEPS = (1, 2, 4)  # in a period
ENDS = np.cumsum([leg.change + leg.hold for leg in MISSION.legs])
STEADY = dict(zip(("hover", "cruise", "descent"), ENDS[[0, 1, 3]].tolist(), strict=True))
"""When the mission has flown steadily for longest, in each way [s]."""

EVERY = 10  # periods from one row of the result's series to the next


Made = Callable[[Vehicle, Any, State], Simulator]


class Integrator(NamedTuple):
    """A simulator and the order of its integrator."""

    made: Made
    method: str
    order: int


INTEGRATORS = {
    "RotorPy": Integrator(RotorPy, "RK45", 5),
    "MuJoCo": Integrator(MuJoCo, "RK4", 4),
    "Drake": Integrator(Drake, "RK3", 3),
    "MuJoCo, forces held": Integrator(partial(MuJoCo, held=True), "Euler", 1),
}

SMOOTH = 3
"""Order up to which differences can be counted on to fall: the table's pieces join in their slopes,
and the second derivatives jump."""

Largest = dict[str, float]  # by quantity, of ``apart``


class Problem:
    """A vehicle with one model of its rotors, and the course that it flies."""

    def __init__(self, vehicle: Vehicle, loads: Any, hover: HoverModel, course: Course) -> None:
        self.vehicle, self.loads, self.hover, self.course = vehicle, loads, hover, course
        self.start = start(course, hover.omega)

    def fly(self, made: Made, steps: int) -> Flight:
        """Fly in one simulator."""
        controller = Controller(self.vehicle, self.hover, self.course)
        return fly(made(self.vehicle, self.loads, self.start), controller, steps)


def largest(one: Flight, other: Flight) -> Largest:
    """Return the largest differences of two flights."""
    return {name: float(values.max()) for name, values in apart(one, other).items()}


def allowed(flights: Mapping[int, Flight], order: int) -> Largest:
    """Return twice Richardson's estimate of the finest flight's error."""
    middle, fine = list(flights.values())[-2:]
    share = 2.0 / (2.0 ** min(order, SMOOTH) - 1.0)
    return {name: share * change for name, change in largest(middle, fine).items()}


def hover_of(vehicle: Vehicle, table: LoadTable) -> HoverModel:
    """Take the hover model of the table's rotors where they carry the vehicle at rest."""
    omega = np.linspace(SLOWEST, FASTEST, 6001)
    share, still = vehicle.mass * GRAVITY / len(vehicle.mounts), table.loads(omega, 0.0, 0.0)
    n = int(np.argmax(still.thrust >= share))
    squares = omega[n] ** 2
    return HoverModel(still.thrust[n] / squares, still.torque[n] / squares, omega[n])


def cross_checked(problem: Problem) -> tuple[dict[str, Any], dict[str, Flight]]:
    """Fly in all simulators: what they differ by, and the flights with the smallest steps."""
    exact = problem.fly(SciPy, STEPS[-1])
    rough = problem.fly(partial(SciPy, tolerance=1e-8), STEPS[-2])
    finest, may = {"SciPy": exact}, {"SciPy": largest(exact, rough)}
    integrators = {}
    for name, (made, method, order) in INTEGRATORS.items():
        begin = time.process_time()
        flights = {steps: problem.fly(made, steps) for steps in STEPS}
        finest[name], may[name] = flights[STEPS[-1]], allowed(flights, order)
        integrators[name] = {
            "method": method,
            "order": order,
            "from_scipy": [largest(flight, exact) for flight in flights.values()],
        }
        print(name, integrators[name], f"{time.process_time() - begin:.0f} s", flush=True)
    pairs = {}
    for one, other in itertools.combinations(finest, 2):
        found = largest(finest[one], finest[other])
        limit = {name: may[one][name] + may[other][name] for name in found}
        pairs[f"{one} - {other}"] = {"found": found, "allowed": limit}
    return {"integrators": integrators, "pairs": pairs, "energy": energies(finest)}, finest


def energies(flights: Mapping[str, Flight]) -> dict[str, Any]:
    """Return the energy balance of each flight [J]."""
    return {
        name: {
            "stored": float(flight.stored[-1]),
            "work": float(flight.work[-1]),
            "largest_imbalance": float(np.abs(flight.stored - flight.work).max()),
            "used": float(flight.used[-1]),
        }
        for name, flight in flights.items()
    }


def position_error(flight: Flight, course: Course) -> Floats:
    """Return the distance from where the course wants it [m]."""
    wanted = np.array([course.at(at)[0] for at in flight.time])
    return np.linalg.norm(flight.at_ends.position - wanted, axis=1)


def told(flight: Flight, course: Course) -> dict[str, float]:
    """Return what one would read off a flight's instruments."""
    front, rear = flight.at_ends.omega[:, 0], flight.at_ends.omega[:, 1]
    power, degrees = flight.wrench.power[:: flight.steps], np.degrees(flight.pitch)
    error = position_error(flight, course)
    found: dict[str, float] = {}
    for leg, at in STEADY.items():
        n = round(at / PERIOD)
        values = (degrees[n], front[n], rear[n], power[n])
        names = ("pitch_deg", "front", "rear", "power")
        found |= {f"{leg}_{name}": float(value) for name, value in zip(names, values, strict=True)}
    braking = (flight.time >= ENDS[1]) & (flight.time <= ENDS[2])
    found["braking_nose_up_deg"] = float(-degrees[braking].min())
    found["largest_error"] = float(error[flight.time >= ENDS[0]].max())
    found["energy"] = float(flight.used[-1])
    return found


def series(flight: Flight, course: Course) -> dict[str, list[float]]:
    """Return columns for a picture."""
    columns = {
        "time": flight.time,
        "pitch_deg": np.degrees(flight.pitch),
        "front": flight.at_ends.omega[:, 0],
        "rear": flight.at_ends.omega[:, 1],
        "power": flight.wrench.power[:: flight.steps],
        "error": position_error(flight, course),
    }
    return {name: np.round(values[::EVERY], 4).tolist() for name, values in columns.items()}


def steady(vehicle: Vehicle, table: LoadTable, rotor: Rotor) -> dict[str, Any]:
    """Return the same states from `propmap trim` and `propmap simulate`."""
    legs = [MISSION.legs[k] for k in (0, 1, 3)]
    forward, climb = ([getattr(leg, name) for leg in legs] for name in ("forward", "climb"))
    states = Aircraft(vehicle, table).steady(forward, climb, margin=False)
    found: dict[str, Any] = {
        leg: {
            "pitch_deg": float(np.degrees(states.pitch[k])),
            "front": float(states.rotor_speed[k, 0]),
            "rear": float(states.rotor_speed[k, 1]),
            "power": float(states.shaft_power[k]),
        }
        for k, leg in enumerate(STEADY)
    }
    section = rotor.model.airfoil
    assert isinstance(section, Airfoil)
    law = section.with_corrections([as_text(c) for c in rotor.model.corrections])
    circles = trim(vehicle, law, np.array([forward[1]]), radius=math.inf, tether=False)
    found["simulated_log"] = {
        "pitch_deg": float(np.degrees(pitch_and_roll(circles.up)[0][0])),
        "rotor_speed": float(circles.rotor_speed.mean()),
    }
    return found | {"rotor_drag": rotor_drag(vehicle, rotor, forward[1])}


def rotor_drag(vehicle: Vehicle, rotor: Rotor, speed: float) -> dict[str, float]:
    """Return how well the rotors' drag is known at a ``speed`` [m/s], and the pitch without that of
    their mounts."""
    aircraft, model = Aircraft(vehicle, rotor), rotor.model
    states = aircraft.steady(speed, margin=False)
    omega, hubs = aircraft.rotor_motion(states)
    loads = rotor.loads_at_velocity(omega, hubs)
    blades = tuple(c for c in model.corrections if not isinstance(c, Installed))
    bare = Aircraft(vehicle, Rotor(replace(model, corrections=blades)))
    return {
        "relative_std": float((loads.std.drag / loads.drag).mean()),
        "pitch_of_bare_blades_deg": float(np.degrees(bare.steady(speed, margin=False).pitch[0])),
    }


def measure() -> dict[str, Any]:
    """All figures."""
    vehicle, rotor = (
        propmap.read_vehicle(VEHICLE).vehicle,
        Rotor(propmap.catalogue_model(PROPELLER)),
    )
    table = build_table(
        rotor, omega=(SLOWEST, FASTEST), speed=SPEED, beta=BETA, tolerance=TOLERANCE
    )
    hover = hover_of(vehicle, table)
    found: dict[str, Any] = {
        "machine": machine(),
        "vehicle": VEHICLE.name,
        "section": rotor.model.airfoil.name,
        "period_s": PERIOD,
        "steps_ms": [1e3 * PERIOD / steps for steps in STEPS],
        "time_constant_s": TIME_CONSTANT,
        "duration_s": MISSION.duration,
        "table": {"tolerance": TOLERANCE, "max_error": table.certificate["max_error"]},
        "steady": steady(vehicle, table, rotor),
    }
    for name, loads in (("propmap", table), ("hover", hover)):
        checked, flights = cross_checked(Problem(vehicle, loads, hover, MISSION))
        exact = flights["SciPy"]
        found[name] = checked | {
            "told": {which: told(flight, MISSION) for which, flight in flights.items()},
            "status": dict(Counter(exact.wrench.status.tolist())),
            "series": series(exact, MISSION),
        }
    return found


def main() -> None:
    """Measure, print, and write the results."""
    found = measure()
    for name in ("propmap", "hover"):
        print(name, found[name]["told"]["SciPy"], found[name]["energy"], sep="\n")
        for pair, one in found[name]["pairs"].items():
            shares = {q: one["found"][q] / one["allowed"][q] for q in one["found"]}
            print(pair, {q: f"{share:.2f}" for q, share in shares.items()})
    print(write_results("cross_check.json", found))


if __name__ == "__main__":
    main()
