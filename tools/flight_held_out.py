"""Compute errors of predicted forces and moments on held-out flights, and coverage of the bands.

Usage: python -m tools.flight_held_out VEHICLE.toml FLIGHT.csv FLIGHT.csv

The tool fits each flight with `propmap fit flight` and checks the fit on the other flight with
`propmap check`.  For comparison, it adds inflow states to the loads of the fit, and it fits a
linear model of the moments.  It also computes the frequency response of the measured moments to
differences of the rotor thrusts.  It writes
benchmarks/results/flight_held_out.json.
"""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import csd

from propmap.catalogue.lookup import airfoil
from propmap.cli.fit_flight import BODY_PLATE, read_flights
from propmap.dynamic_inflow import DynamicInflow
from propmap.fit import comparison
from propmap.fit.files import read_fit
from propmap.fit.flight import AXES, MOMENTS, HoverScale, wakes_with
from propmap.fit.least_squares import rms
from propmap.fit.moments import FACTORS, measured_moment
from propmap.io.csv import replacing
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.vehicle.files import VehicleFile, read_vehicle
from propmap.vehicle.log import DERIVATIVE_CUTOFF, FlightLog, hub_flow, low_pass
from propmap.vehicle.wakes import in_wakes

RESULTS = Path(__file__).resolve().parent.parent / "benchmarks" / "results" / "flight_held_out.json"
EDGES = (0.0, 0.5, 1.0, 3.0, 14.0)  # edges of the frequency bands [Hz]


def main(vehicle: str, *flights: str) -> None:
    """Fit each flight, check the fit on the other flight, and write the results."""
    file, rows, factors = read_vehicle(vehicle), [], []
    for seen, unseen in (flights, flights[::-1]):
        with tempfile.TemporaryDirectory() as folder:
            fit = Path(folder) / "fit.toml"
            loads = fit_and_check(vehicle, seen, unseen, fit)
            found = read_fit(fit)
            # The same fit with a body force proportional to |v_z| v_z instead of V v_z.
            lagging = errors_with_inflow_states(fit, unseen, file)
            free = ",".join(found.record.free).replace(BODY_PLATE, "drag_area_z")
            given = ("--free", free, "--prior-from", "population")
            quadratic = fit_and_check(vehicle, seen, unseen, fit, *given)
        known = found.values
        factors.append({"fitted": Path(seen).stem} | {name: known[name] for name in FACTORS})
        linear = linear_errors(file, low_passed(seen, file), low_passed(unseen, file))
        for name, one in loads.items():
            load, _, unit = name.rpartition("_")
            rows.append(
                {
                    "fitted": Path(seen).stem,
                    "unseen": Path(unseen).stem,
                    "load": load,
                    "unit": unit.replace("Nm", "N m"),
                    "measured": one["rms"] / one["relative_rms"],
                    "propmap": one["rms"],
                    "hover_model": one["hover_rms"],
                    "linear": linear.get(load),
                    "inflow_states": lagging[load],
                    "quadratic_along_z": quadratic[name]["rms"],
                    "in_band": one["in_band"],
                }
            )
    with replacing(RESULTS) as place:
        turned = [one for path in flights for one in responses(path, file)]
        results = {"rows": rows, "factors": factors, "responses": turned}
        place.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    print(RESULTS)


def fit_and_check(vehicle: str, seen: str, unseen: str, fit: Path, *options: str) -> dict[str, Any]:
    """Fit one flight, and return the errors of the loads on the other flight."""
    told("fit", "flight", seen, "--vehicle", vehicle, "-o", str(fit), *options)
    text = told("check", str(fit), unseen, "--vehicle", vehicle, "--format", "json")
    return dict(json.loads(text)["loads"])


def errors_with_inflow_states(fit: Path, unseen: str, file: VehicleFile) -> dict[str, float]:
    """Return rms errors of a fit on the other flight with the inflow of `DynamicInflow`, by load.

    The states advance with the recorded rotor speeds and velocities, in the wakes of the fit.  The
    difference from the steady loads is low-passed like all signals.
    """
    vehicle, fitted, law = file.vehicle, read_fit(fit), airfoil(fit)
    raw, log = (low_passed(unseen, file, cutoff) for cutoff in (0.0, fitted.low_pass))
    values, _ = comparison.values_for(fitted, vehicle, raw, [Path(unseen)])
    model, wakes = Model(vehicle.propeller, law, vehicle.air), wakes_with(vehicle, values)
    flow = hub_flow(vehicle, raw)
    assert wakes is not None
    near = in_wakes(vehicle, wakes, model, flow)
    spins = [mount.spin for mount in vehicle.mounts]
    rotor, steps = Rotor(model), np.diff(raw.time, append=raw.time[-1])
    dynamic = DynamicInflow(rotor, spin=spins)
    state = dynamic.steady(near.omega[0], near.velocity[0])
    change = np.zeros((len(raw), len(spins), 6))
    for k, step in enumerate(steps):
        found, state = dynamic.advance(state, step, near.omega[k], near.velocity[k])
        change[k] = np.concatenate([found.force, found.moment], axis=1)
    for k, spin in enumerate(spins):
        steady = rotor.wrench(near.omega[:, k], near.velocity[:, k], spin)
        change[:, k] -= np.concatenate([steady.force, steady.moment], axis=1)
    change[..., 3:] += np.cross(flow.position, change[..., :3])
    step = float(np.median(steps))
    relative, padding = 2.0 * fitted.low_pass * step, round(2.0 / (fitted.low_pass * step))
    moved = low_pass(change.sum(axis=1), relative, padding)
    moved[:, 3:] *= sum(values[name] * axes for name, axes in FACTORS.items())
    predicted = comparison.flight_forces(vehicle, log, law, values).model + moved
    both = vehicle.mass * log.specific_force, measured_moment(vehicle, log)
    off = predicted - np.concatenate(both, axis=1)
    return {name: rms(off[:, k]) for k, name in enumerate((*AXES, *MOMENTS))}


def told(*command: str) -> str:
    """Run a propmap command in a process and return its printed output."""
    every = [sys.executable, "-m", "propmap", *command]
    return subprocess.run(every, check=True, capture_output=True, text=True).stdout


def low_passed(path: str, file: VehicleFile, cutoff: float = DERIVATIVE_CUTOFF) -> FlightLog:
    """Return the samples in flight, filtered as in fits and checks."""
    return read_flights([Path(path)], file, "balance", low_pass=cutoff).log


def responses(path: str, file: VehicleFile) -> Iterator[dict[str, Any]]:
    """Yield the response of the measured moments about x and y to rotor thrusts times arms.

    Gain, phase lag and coherence are by frequency band.  The thrusts are those of the hover model,
    proportional to the squared rotor speeds.  The coherence is 1 if the thrusts explain the moment
    completely.
    """
    log, vehicle = low_passed(path, file, 0.0), file.vehicle
    flow, per_square = hub_flow(vehicle, log), HoverScale.of(vehicle, log).reference
    assert per_square is not None
    arms = per_square * np.square(flow.omega) @ np.cross(flow.position, flow.axis)
    moment, rate = measured_moment(vehicle, log), 1.0 / float(np.median(np.diff(log.time)))
    for k, axis in enumerate("xy"):
        pair = (arms[:, k], arms[:, k]), (arms[:, k], moment[:, k]), (moment[:, k], moment[:, k])
        (at, own), (_, both), (_, turning) = (csd(*one, rate, nperseg=256) for one in pair)
        for low, high in itertools.pairwise(EDGES):
            inside = (at >= low) & (at < high)
            a, b, c = (one[inside].sum() for one in (own, both, turning))
            yield {
                "flight": Path(path).stem,
                "axis": axis,
                "from_Hz": low,
                "to_Hz": high,
                "gain": float(abs(b / a)),
                "lag_deg": -float(np.degrees(np.angle(b))),
                "coherence": float(abs(b) ** 2 / (a * c).real),
            }


def linear_errors(file: VehicleFile, seen: FlightLog, unseen: FlightLog) -> dict[str, float]:
    """Fit a linear model of the moments to ``seen``; return its rms errors [N m] on ``unseen``."""
    known, wanted = (measured_moment(file.vehicle, log) for log in (seen, unseen))
    found = {}
    for k, axis in enumerate("xyz"):
        by, _, _, _ = np.linalg.lstsq(terms(file, seen)[k], known[:, k], rcond=None)
        found[f"moment_{axis}"] = rms(terms(file, unseen)[k] @ by - wanted[:, k])
    return found


def terms(file: VehicleFile, log: FlightLog) -> Floats:
    """Return the regressors of the linear model for the moments about x, y and z, (3, n, 5).

    They are the squared rotor speeds times arms (about z, times spins), the sum of the squared
    rotor speeds, and the sum of the rotor speeds times each velocity component.
    """
    flow = hub_flow(file.vehicle, log)
    squares = np.square(flow.omega)
    arms = np.cross(flow.position, flow.axis) - flow.spin[:, None] * flow.axis
    speeds = flow.omega.sum(axis=1, keepdims=True)
    common = [squares.sum(axis=1, keepdims=True), speeds * log.velocity]
    return np.stack([np.hstack([(squares @ arms)[:, [k]], *common]) for k in range(3)])


if __name__ == "__main__":
    main(*sys.argv[1:])
