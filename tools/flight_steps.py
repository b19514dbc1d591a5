"""Print what each term of a whole-flight fit is worth on a flight that it has not seen.

Usage: python -m tools.flight_steps VEHICLE.toml FLIGHT.csv FLIGHT.csv

Terms are added one at a time; each is fitted to one flight and checked on the other, and the other
way about.  Beside them stand the hover model and, where the files have them (columns neurobem_fx,
_fy, _fz), the data set's own prediction.  Errors are root mean squares [N] along x, y and z of all
samples in flight, of low-passed signals; the last fit's are told without the low-pass as well.
The figures go into benchmarks/results/flight_steps.json.
"""

from __future__ import annotations

import json
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from propmap.arrays.types import Floats
from propmap.cli.flight_options import BLADE, flight_priors, with_flight_priors
from propmap.cli.prior_options import section_prior
from propmap.engine.compilation import keep_compiled
from propmap.fit.comparison import FlightForces, flight_forces
from propmap.fit.fitted import Settings, fit
from propmap.fit.flight import balance_rows
from propmap.fit.force_model import ForceModel
from propmap.fit.parameters import (
    BODY,
    FIRST_GUESS,
    FLEX,
    MOUNT,
    SECTION,
    SENSOR,
    WAKES,
    Choice,
    constants_of,
)
from propmap.fit.section_prior import SectionPrior
from propmap.fit.thrust_scale import HoverScale
from propmap.fit.tunnel import model_with
from propmap.flight.steady import airborne
from propmap.io.atomic_file import replacing
from propmap.model.model import Model
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.logs import read_flight_log
from propmap.vehicle.time_derivatives import CUTOFF, low_passed
from propmap.vehicle.vehicle import Vehicle
from propmap.vehicle.vehicle_toml import VehicleFile, read_vehicle

RESULTS = Path(__file__).resolve().parent.parent / "benchmarks" / "results" / "flight_steps.json"
SAMPLES = 300
ALMOST_NONE = 1e-9
"""Area [m^2] of a mount that drags nothing, so that one compiled program serves all steps."""

DRAGS = ("drag_area_x", "drag_area_y", "drag_area_z")
DOWN = ("download_area_x", "download_area_y")
MOUNTED = (*BLADE, *MOUNT, "drag_area_z")
STEPS: dict[str, tuple[tuple[str, ...], bool]] = {
    "blade and body drag": ((*BLADE, *DRAGS), False),
    "and the accelerometer's place and clock": ((*BLADE, *DRAGS, *SENSOR), False),
    "mounts for body drag in x and y": ((*MOUNTED, *SENSOR), False),
    "and the wakes": ((*MOUNTED, *SENSOR, *WAKES), False),
    "and blades that give way": ((*MOUNTED, *SENSOR, *WAKES, *FLEX), False),
    "and the body's download": ((*MOUNTED, *DOWN, *SENSOR, *WAKES, *FLEX), False),
    "and a thrust scale of each flight": ((*MOUNTED, *DOWN, *SENSOR, *WAKES, *FLEX), True),
}
"""Free parameters, and whether thrust is scaled by hover."""


def flying(path: Path, file: VehicleFile, cutoff: float) -> FlightLog:
    """The samples in flight."""
    log = low_passed(read_flight_log(path, file), cutoff)
    return log.picked(airborne(log))


def fitted_values(
    vehicle: Vehicle, log: FlightLog, prior: SectionPrior, free: tuple[str, ...]
) -> dict[str, float]:
    """All parameters by name of a fit to a part of the samples of one flight."""
    picked = np.unique(np.linspace(0, len(log) - 1, SAMPLES).astype(int))
    fixed = {n: getattr(prior.airfoil, n) for n in SECTION if n not in free}
    if "mount_area" not in free:
        fixed["mount_area"] = ALMOST_NONE
    start = {n: getattr(prior.airfoil, n) for n in SECTION if n in free}
    known = flight_priors(vehicle, log, hover=False)
    choice = with_flight_priors(Choice(free, fixed, {}, start, prior), known)
    law = prior.airfoil.with_corrections(["pitt-peters"])
    model = ForceModel(vehicle, log.picked(picked), law)
    return fit(balance_rows(model, choice), choice, Settings(starts=1, folds=0)).values


def forces(
    vehicle: Vehicle,
    log: FlightLog,
    prior: SectionPrior,
    values: dict[str, float],
    seen: FlightLog | None = None,
) -> FlightForces:
    """What a fit says of a flight; its thrust is scaled by its hover over that of one ``seen``."""
    base = Model(vehicle.propeller, prior.airfoil.with_corrections(["pitt-peters"]), vehicle.air)
    found = model_with(base, values)
    law = replace(constants_of(found.airfoil), corrections=tuple(found.correction_texts))
    reference = None if seen is None else HoverScale.of(vehicle, seen).reference
    scales = HoverScale.of(vehicle, log, reference).scales if reference else {}
    others = {n: values[n] for n in (BODY | SENSOR | WAKES) if n in values}
    return flight_forces(vehicle, log, law, FIRST_GUESS | others | scales)


def errors(model: Floats, vehicle: Vehicle, log: FlightLog) -> list[float]:
    """Root mean squares [N] along the three axes."""
    off = model[:, :3] - vehicle.mass * log.specific_force
    return [round(float(x), 3) for x in np.sqrt(np.nanmean(off**2, axis=0))]


def own_prediction(path: Path, log: FlightLog, cutoff: float) -> Floats | None:
    """The data set's own forces [N] at the samples of the log, low-passed as they are."""
    table = np.genfromtxt(path, delimiter=",", names=True)
    names = ("neurobem_fx", "neurobem_fy", "neurobem_fz")
    if not set(names) <= set(table.dtype.names or ()):
        return None
    raw = np.stack([table[name] for name in names], axis=1)
    three = np.zeros_like(raw)
    up = three + np.array([0.0, 0.0, 1.0])
    carrier = FlightLog("own", table["t"], raw, three, up, three, np.ones((len(raw), 1)))
    return low_passed(carrier, cutoff).velocity[np.isin(table["t"], log.time)]


def main(vehicle_path: str, *flights: str) -> None:
    """Fit, check, print and file."""
    keep_compiled()
    file, paths = read_vehicle(vehicle_path), [Path(item) for item in flights]
    vehicle = file.vehicle
    prior = section_prior(None, vehicle.propeller.name, by_default=True)
    assert prior is not None
    logs = [flying(path, file, CUTOFF) for path in paths]
    told: dict[str, Any] = {"low_pass_hz": CUTOFF, "samples_fitted": SAMPLES, "steps": []}
    for label, (free, scaled) in STEPS.items():
        for seen, unseen in ((0, 1), (1, 0)):
            begin = time.process_time()
            values = fitted_values(vehicle, logs[seen], prior, free)
            took = time.process_time() - begin
            of = logs[seen] if scaled else None
            found = [forces(vehicle, log, prior, values, of) for log in logs]
            off = [errors(f.model, vehicle, g) for f, g in zip(found, logs, strict=True)]
            step = {
                "step": label,
                "fitted": paths[seen].stem,
                "seen_N": off[seen],
                "unseen_N": off[unseen],
                "values": {name: float(f"{values[name]:.4g}") for name in free},
                "processor_s": round(took, 1),
            }
            told["steps"].append(step)
            print(f"{label:42s} {paths[seen].stem}: {off[seen]}, unseen {off[unseen]}", flush=True)
    for k, (path, log) in enumerate(zip(paths, logs, strict=True)):
        own = own_prediction(path, log, CUTOFF)
        reference = {
            "hover_N": errors(found[k].hover, vehicle, log),
            "own_N": None if own is None else errors(own, vehicle, log),
        }
        told[path.stem] = reference
        print(path.stem, reference)
    raw = [flying(path, file, 0.0) for path in paths]
    told["last_fit_without_low_pass_N"] = [
        errors(forces(vehicle, log, prior, values, of).model, vehicle, log) for log in raw
    ]
    print("the last fit without low-pass:", told["last_fit_without_low_pass_N"])
    with replacing(RESULTS) as place:
        place.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
