"""Times of trims and of a ranking, and errors of predicted power: `make bench ONLY=aircraft`.

Writes results/aircraft.json.  It also contains two studies that the documentation shows: the
delivery quadcopter with several propellers, and the transition of the tailsitter.

Measured power: electrical power of an 8 in propeller in TU Delft's open-jet tunnel (arXiv
2507.03456, CC BY 4.0).  Its shaft power is about 0.874 times the electrical power.  Section
constants are identified from every second steady state; the other half is predicted.  Three
constants of motor and controller are then fitted to the first half.  This part is omitted without
the data.
"""

from __future__ import annotations

import csv
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import propmap
from benchmarks.results_file import machine, write_results
from propmap.aircraft.performance import performance
from propmap.aircraft.ranking import Ranking, Task, catalogue_candidates
from propmap.aircraft.sensitivity import spread
from propmap.aircraft.trim import Aircraft
from propmap.catalogue.expected import expected_constants
from propmap.cli.trim import plain
from propmap.fit.fit import Settings, fit
from propmap.fit.parameters import SECTION, Choice
from propmap.fit.tunnel import TunnelData, section_with, tunnel_rows
from propmap.table.build import build_table
from propmap.units import GRAVITY, RPM
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.vehicle import Vehicle

EXAMPLE = Path(__file__).parent.parent / "examples" / "aircraft" / "delivery.toml"
DATA = Path(__file__).parents[2] / "shared" / "data" / "power"
SPEEDS = np.linspace(0.0, 20.0, 30)
REPEATS = 5

PROPELLERS = ("uiuc-apcsf-11x4.7", "uiuc-gwsdd-11x7", "uiuc-apce-11x5.5", "uiuc-apcsf-10x4.7")
NAMED = ("hover", "least_power", "best_range", "fastest")
HEADWIND = 5.0
TRANSITION = np.arange(0.0, 21.0, 2.0)
"""Speeds of the tailsitter in its transition [m/s]."""

TABLE_TOLERANCE = 0.05
"""Tolerance of the timed table.  It affects the time of the build, but not the time of a query."""

SHAFT_SHARE = 0.874
RADIUS = 0.1016
LEAST_POWER, MOST_ADVANCE, LEAST_SAMPLES = 12.0, 0.95, 30
"""Minimum power [W], maximum advance ratio J and minimum number of samples of a steady state.  At
lower power, most of it is lost in the motor."""

FREE = ("c_l1", "zero_lift_angle", "c_d0")


def least(action: Callable[[], object]) -> tuple[float, float]:
    """Return the shortest wall and processor time [s] of ``REPEATS`` calls of ``action``.

    A first call, which compiles, is not timed.
    """
    action()
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter(), time.process_time()
        action()
        times.append((time.perf_counter() - start[0], time.process_time() - start[1]))
    return min(t[0] for t in times), min(t[1] for t in times)


def trims(vehicle: Vehicle) -> dict[str, Any]:
    """Measure the times of 30 trims with the rotor and with a table."""
    law, _ = expected_constants(None)
    corrections = propmap.model_corrections("recommended")
    model = propmap.Model(vehicle.propeller, law, vehicle.air, corrections)
    rotor = propmap.Rotor(model)
    table = build_table(
        propmap.Rotor(model),
        omega=(350.0, 800.0),
        speed=(0.0, 22.0),
        beta=(0.0, 1.7),
        tolerance=TABLE_TOLERANCE,
    )
    found = {}
    for name, loads in (("rotor", rotor), ("table", table)):
        aircraft = Aircraft(vehicle, loads)
        states = aircraft.steady(SPEEDS)
        wall, processor = least(lambda aircraft=aircraft: aircraft.steady(SPEEDS))  # type: ignore[misc]
        found[name] = {
            "speeds": SPEEDS.size,
            "wall_s": round(wall, 4),
            "processor_s": round(processor, 4),
            "found": int(states.found.sum()),
            "largest_residual": float(np.nanmax(states.residual)),
        }
    return found


def ranked(vehicle: Vehicle) -> dict[str, Any]:
    """Measure the time of a ranking of the whole catalogue, without compilation."""
    candidates = catalogue_candidates()
    ranking = Ranking(vehicle, Task("cruise", 12.0), propmap.model_corrections("recommended"))
    ranking.judged(candidates[::10])
    start = time.perf_counter(), time.process_time()
    judged = ranking.judged(candidates)
    ranking.with_deviations([one for one in judged if one.feasible][:10])
    return {
        "propellers": len(candidates),
        "feasible": sum(one.feasible for one in judged),
        "wall_s": round(time.perf_counter() - start[0], 2),
        "processor_s": round(time.process_time() - start[1], 2),
    }


def aircraft_with(name: str, vehicle: Vehicle) -> Aircraft:
    """Return the vehicle with a catalogue propeller and its constants."""
    model = propmap.catalogue_model(name, air=vehicle.air)
    flown = replace(vehicle, propeller=model.propeller)
    return Aircraft(flown, propmap.Rotor(model))


def study(vehicle: Vehicle) -> list[dict[str, Any]]:
    """Return named states of the delivery quadcopter with several propellers.

    They are computed in still air, and the best range also against wind.
    """
    found = []
    for name in PROPELLERS:
        craft = aircraft_with(name, vehicle)
        states = craft.steady(SPEEDS)
        still = performance(craft, states, bands=True)
        windy = performance(craft, states, wind=HEADWIND, bands=True)
        named = {key: getattr(still, key) for key in NAMED}
        named["against_wind"] = windy.best_range
        found.append(
            {"propeller": name, "limit": still.limit}
            | {key: plain(state) for key, state in named.items()}
        )
    return found


def transition(vehicle: Vehicle) -> list[dict[str, Any]]:
    """Return states of a tailsitter from hover to cruise, with the share of lift on the wing."""
    craft = aircraft_with(vehicle.propeller.name, vehicle)
    states = craft.steady(TRANSITION, margin=False)
    sure = spread(craft, states)
    _, hubs = craft.rotor_motion(states)
    found = []
    for k, speed in enumerate(states.speed.tolist()):
        axial = float(hubs[k, 0] @ craft.rotors.axis[0])
        weight = vehicle.mass * GRAVITY
        lifted = float(states.thrust[k].sum() * np.cos(states.pitch[k]))
        found.append(
            {
                "speed": speed,
                "beta_deg": float(np.degrees(np.arccos(axial / speed))) if speed else None,
                "pitch_deg": float(np.degrees(states.pitch[k])),
                "rpm": float(states.rotor_speed[k, 0] / RPM),
                "power": float(states.shaft_power[k]),
                "power_std": float(sure.shaft_power[k]) if sure else None,
                "wing_share": 1.0 - lifted / weight,
                "status": str(states.status[k]),
            }
        )
    return found


def steady_rows() -> dict[str, np.ndarray]:
    """Return omega, speed and electrical power, as means over samples of equal speeds."""
    with (DATA / "wt_10Hz.csv").open(encoding="utf-8") as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    groups: dict[tuple[float, float], list[dict[str, float]]] = {}
    for row in rows:
        groups.setdefault((round(row["airspeed"]), round(row["rpm"] / 250.0)), []).append(row)
    found = []
    for group in (groups[key] for key in sorted(groups)):
        rpm, speed = (float(np.mean([r[k] for r in group])) for k in ("rpm", "airspeed"))
        power = float(np.mean([r["voltage"] * r["current"] for r in group]))
        advance = speed / max(rpm / 60.0 * 2.0 * RADIUS, 1e-9)
        if len(group) >= LEAST_SAMPLES and power > LEAST_POWER and advance < MOST_ADVANCE:
            found.append((rpm * np.pi / 30.0, speed, power))
    omega, speeds, powers = np.array(found).T
    return {"omega": omega, "speed": speeds, "power": powers}


def measured_power() -> dict[str, Any]:
    """Return the errors of predicted power on the held-out half, with each half held out once."""
    with (DATA / "propeller_geometry.csv").open(encoding="utf-8") as file:
        blade = [[float(v) for v in row.values()] for row in csv.DictReader(file)]
    station, chord, twist = np.array(blade).T
    propeller = propmap.Propeller("tunnel", 2, station * RADIUS, chord * RADIUS, np.radians(twist))
    law, _ = expected_constants(None)
    base = propmap.Model(propeller, law)
    rows = steady_rows()
    omega, speed, power = rows["omega"], rows["speed"], rows["power"]
    shaft = SHAFT_SHARE * power
    unfitted = propmap.Rotor(base).loads(omega, speed, 0.0).power
    halves = []
    for first in (0, 1):
        train = np.arange(omega.size) % 2 == first
        data = TunnelData(
            "tunnel",
            omega[train],
            speed[train],
            np.zeros(int(train.sum())),
            {"torque": shaft[train] / omega[train]},
        )
        given: Any = {name: getattr(law, name) for name in SECTION}
        choice = Choice(
            FREE,
            fixed={k: v for k, v in given.items() if k not in FREE},
            start={k: given[k] for k in FREE},
        )
        values = fit(tunnel_rows(base, data, choice), choice, Settings(starts=1, folds=0)).values
        rotor = propmap.Rotor(base.with_airfoil(section_with(law, values)))
        predicted = rotor.loads(omega, speed, 0.0).power
        # R i^2, i_0 omega/Kv and their cross term, with i = Kv Q + i_0.
        torque = predicted / omega
        terms = np.stack([torque**2, omega, torque], axis=1)
        weight = 1.0 / power[train]
        losses = np.linalg.lstsq(
            terms[train] * weight[:, None], (power - predicted)[train] * weight, rcond=None
        )[0]
        by_share = errors(predicted[~train] / SHAFT_SHARE, power[~train])
        by_motor = errors((predicted + terms @ losses)[~train], power[~train])
        halves.append(
            {
                "constants": {k: round(float(values[k]), 4) for k in FREE},
                "states": int((~train).sum()),
                "shaft": errors(predicted[~train], shaft[~train]),
                "electrical_by_the_share": by_share,
                "electrical_by_a_motor": by_motor,
                "motor_explains": round(
                    1.0 - (by_motor["rms_relative"] / by_share["rms_relative"]) ** 2, 3
                ),
            }
        )
    return {"unfitted_shaft": errors(unfitted, shaft), "halves": halves}


def errors(predicted: np.ndarray, measured: np.ndarray) -> dict[str, float]:
    """Return the rms error over the rms power, and the rms of the relative error."""
    off = predicted - measured
    return {
        "rms_of_rms": round(float(np.sqrt(np.mean(off**2) / np.mean(measured**2))), 4),
        "rms_relative": round(float(np.sqrt(np.mean((off / measured) ** 2))), 4),
    }


def main() -> None:
    """Measure times and errors, print and write the results."""
    vehicle = read_vehicle(EXAMPLE).vehicle
    found: dict[str, Any] = {
        "machine": machine(),
        "trim": trims(vehicle),
        "choose": ranked(vehicle),
        "study": study(vehicle),
        "transition": transition(read_vehicle(EXAMPLE.parent / "tailsitter.toml").vehicle),
    }
    if DATA.exists():
        found["power"] = measured_power()
    for name, value in found.items():
        print(name, value)
    print(write_results("aircraft.json", found))


if __name__ == "__main__":
    main()
