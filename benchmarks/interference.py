"""What the rotors' wakes on each other cost: `make bench ONLY=interference`.

Writes results/interference.json: processor time with and without the wakes, by turns in one run,
for a quadrotor in random motions.  One pair is the force model that a fit of whole flights steps
through, loads with their derivatives by all its parameters; the other the forces and moments alone.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.results_file import machine, write_results
from propmap.cli.fit import section_prior
from propmap.cli.fit_flight import BLADE
from propmap.fit.comparison import flight_forces
from propmap.fit.flight import ForceModel
from propmap.fit.parameters import BODY, FIRST_GUESS, FLEX, MOUNT, SECTION, WAKES
from propmap.typing import Floats
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog
from propmap.vehicle.vehicle import Vehicle

VEHICLE = Path(__file__).parent.parent / "examples" / "neurobem" / "vehicle.toml"
SAMPLES = {"fit": 300, "forces": 2048}
REPEATS = 9
FREE = (*BLADE, *MOUNT, *FLEX, *BODY)
STIFF = {"mount_area": 4e-4, "untwist": 0.01}
GAINS = {"wake_ahead": 2.0, "wake_beside": 1.0, "wake_downwash": 0.5, "wake_share": 1.0}


def flight(vehicle: Vehicle, samples: int) -> FlightLog:
    """Random motions, to 17 m/s and turning by some rad/s, a few of them in descent."""
    rng = np.random.default_rng(28)
    speed, bearing = rng.uniform(0.0, 17.0, samples), rng.uniform(-np.pi, np.pi, samples)
    climb = 0.25 * speed + rng.normal(0.0, 2.0, samples)
    velocity = np.stack([speed * np.cos(bearing), speed * np.sin(bearing), climb], axis=1)
    up = np.tile([0.0, 0.0, 1.0], (samples, 1))
    omega = rng.uniform(1200.0, 2200.0, (samples, len(vehicle.mounts)))
    rates, seconds = rng.normal(0.0, 2.0, (samples, 3)), np.linspace(0.0, 0.02 * samples, samples)
    return FlightLog("random motions", seconds, velocity, rates, up, 9.81 * up, omega)


def least(jobs: dict[str, Callable[[], Any]]) -> dict[str, float]:
    """Least processor time of each, by turns [s]; the first turn compiles."""
    found = dict.fromkeys(jobs, np.inf)
    for turn in range(1 + REPEATS):
        for name, job in jobs.items():
            start = time.process_time()
            job()
            if turn:
                found[name] = min(found[name], time.process_time() - start)
    return found


def main() -> None:
    """Measure, print, and write the results."""
    vehicle = read_vehicle(VEHICLE).vehicle
    prior = section_prior(None, vehicle.propeller.name, by_default=True)
    assert prior is not None
    law = prior.airfoil.with_corrections(["pitt-peters"])
    values = FIRST_GUESS | STIFF | {name: getattr(law, name) for name in SECTION}
    model = ForceModel(vehicle, flight(vehicle, SAMPLES["fit"]), law)
    log = flight(vehicle, SAMPLES["forces"])
    pairs: dict[str, dict[str, Callable[[], Any]]] = {
        "fit": {
            "without": lambda: model.at(values, FREE),
            "with": lambda: model.at(values | GAINS, (*FREE, *WAKES)),
        },
        "forces": {
            "without": lambda: flight_forces(vehicle, log, law, values),
            "with": lambda: flight_forces(vehicle, log, law, values | GAINS),
        },
    }
    rows = []
    for name, jobs in pairs.items():
        seconds = least(jobs)
        ratio = seconds["with"] / seconds["without"]
        added = _rms_added(*(jobs[key]() for key in ("with", "without")))
        rows.append({"what": name, "samples": SAMPLES[name], **seconds, "ratio": ratio})
        print(f"{name}: {ratio:.2f} times without; the wakes change z by {added:.2f} N rms")
    told = {"rows": rows, "machine": machine()}
    print(write_results("interference.json", told))


def _rms_added(with_wakes: Any, without: Any) -> float:
    """Root mean square of what the wakes add along z [N]."""

    def vertical(found: Any) -> Floats:
        forces: Floats = found.loads if hasattr(found, "loads") else found.model
        return forces[:, 2]

    return float(np.sqrt(np.nanmean((vertical(with_wakes) - vertical(without)) ** 2)))


if __name__ == "__main__":
    main()
