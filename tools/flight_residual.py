"""File what a learned residual is worth on a flight that it has not seen, for the documentation.

Usage: python -m tools.flight_residual FOLDER VEHICLE.toml FLIGHT.csv FLIGHT.csv

FOLDER is that of `propmap fit terms` on the same flights; the physics is that of its last step.
For each pair the residual is learned on the flights that were fitted to and checked on the one that
was left out.  The figures go into benchmarks/results/flight_residual.json.
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from propmap.cli.fit_flight import expected, flight_priors, read_pairs, steps
from propmap.fit.comparison import flight_forces
from propmap.fit.learned_residual import learn
from propmap.fit.parameters import BODY, FIRST_GUESS, SENSOR, WAKES, constants_of
from propmap.fit.tunnel import model_with
from propmap.io.csv import replacing
from propmap.model.model import Model
from propmap.typing import Floats
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import DERIVATIVE_CUTOFF, FlightLog
from propmap.vehicle.vehicle import Vehicle
from tools.flight_steps import rows

RESULTS = Path(__file__).resolve().parent.parent / "benchmarks" / "results"
SAMPLES = 1000
"""Samples of each flight, at most."""


def main(folder: str, vehicle_path: str, *paths: str) -> None:
    """Learn, check, print and file."""
    file = read_vehicle(vehicle_path)
    flights, _ = read_pairs([Path(p) for p in paths], file, DERIVATIVE_CUTOFF, None)
    prior = expected(None, file.vehicle)
    known = flight_priors(file.vehicle, flights[0].passed, hover=False)
    last = steps(file.vehicle, prior, known)[-1]
    base = Model(
        file.vehicle.propeller, prior.airfoil.with_corrections(["pitt-peters"]), file.vehicle.air
    )
    sheet = rows(Path(folder) / "fit-terms-values.csv")
    logs = [_picked(flight.passed) for flight in flights]
    checks: list[dict[str, Any]] = []
    for unseen, seen in ((1, 0), (0, 1)):
        mine = [
            r for r in sheet if r["step"] == last.name and r["left_out"] == flights[unseen].name
        ]
        free = {str(r["parameter"]): float(r["value"]) for r in mine}
        values = {**FIRST_GUESS, **last.choice.fixed, **free}
        left = [_left(file.vehicle, base, values, log) for log in logs]
        learned = learn(file.vehicle, logs[seen], left[seen])
        added = learned.at(file.vehicle, logs[unseen])
        checks.append(
            {
                "trained": flights[seen].name,
                "checked": flights[unseen].name,
                "physics_N": _rms(left[unseen]),
                "with_residual_N": _rms(left[unseen] - added.force),
                "pays_in_training": list(learned.pays),
                "left_out_without_N": learned.without.tolist(),
                "left_out_with_N": learned.with_it.tolist(),
                "ln_evidence": learned.evidence.tolist(),
                "share_faded_or_off": float(np.mean(added.status != "ok")),
            }
        )
        print(checks[-1], flush=True)
    with replacing(RESULTS / "flight_residual.json") as place:
        told = {"samples": SAMPLES, "low_pass_hz": DERIVATIVE_CUTOFF, "checks": checks}
        place.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")


def _picked(log: FlightLog) -> FlightLog:
    return log.picked(np.unique(np.linspace(0, len(log) - 1, SAMPLES).astype(int)))


def _left(vehicle: Vehicle, base: Model, values: dict[str, float], log: FlightLog) -> Floats:
    """Measured less modelled forces [N], (n, 3)."""
    found = model_with(base, values)
    others = {n: values[n] for n in BODY | SENSOR | WAKES if n in values}
    law = replace(constants_of(found.airfoil), corrections=tuple(found.correction_texts))
    forces = flight_forces(vehicle, log, law, FIRST_GUESS | others)
    left: Floats = vehicle.mass * log.specific_force - forces.model[:, :3]
    return left


def _rms(off: Floats) -> list[float]:
    return [float(x) for x in np.sqrt(np.nanmean(off**2, axis=0))]


if __name__ == "__main__":
    main(*sys.argv[1:])
