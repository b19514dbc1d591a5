"""Accuracy and coverage of the estimated wind, for the documentation: twins, and real flights.

Usage: python -m tools.wind_of_flights FOLDER

The twins are simulated flights in gusts.  Their estimates use the true constants of the vehicle, or
fits to simulated flights in still air.  The true wind is low-pass filtered like the flights.
FOLDER contains the real flights, one CSV file each: neuralfly_CONTROLLER_WIND.csv (O'Connell et
al., Neural-Fly, Science Robotics 2022) and the two neurobem_*.csv (Bauersfeld et al., NeuroBEM, RSS
2021).  The tool writes benchmarks/results/wind.json.
"""

from __future__ import annotations

import contextlib
import io
import json
import re
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from propmap.cli import main as propmap
from propmap.cli.fit_flight import read_flights
from propmap.fit.files import FitFile, read_fit
from propmap.flight.simulate import log_table
from propmap.flight.wind import WindEstimate, bands, estimate_wind
from propmap.io.csv import replacing
from propmap.typing import Floats
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import low_passed
from tests.flight import windy
from tests.flight.synthetic import vehicle_text

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results" / "wind.json"
NEURALFLY, NEUROBEM = (
    str(ROOT / "examples" / n / "vehicle.toml") for n in ("neuralfly", "neurobem")
)
SPEEDS = {"nowind": 0.0, "35wind": 4.2, "70wind": 8.5}
"""Nominal wind against the first axis of the world, by the name of the flight [m/s]."""
CONTROLLERS, SLOW, FAST = ("NF", "baseline"), "20210218171908", "20210218172600"
GUSTS, SECONDS = (1.0, 3.0, 6.0), 25.0
TWINS, FITS, TWINS_OF_FIT = 36, 6, 6  # simulated flights and fits in each row


def main(folder: str) -> None:
    """Estimate all winds, and write their errors."""
    with tempfile.TemporaryDirectory() as place:
        found = {
            "twins": twins(Path(place)),
            "neurobem": neurobem(Path(folder), Path(place)),
            "neuralfly": neuralfly(Path(folder), Path(place)),
        }
    with replacing(RESULTS) as path:
        path.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    print(RESULTS)


def fitted(logs: Sequence[Path], vehicle: str, fit: Path, *options: str) -> Path:
    """Fit flights, without printing."""
    asked = ["fit", "flight", *map(str, logs), "--vehicle", vehicle, "-o", str(fit), *options]
    with contextlib.redirect_stdout(io.StringIO()):
        if propmap(asked):
            raise SystemExit(1)
    return fit


def row(name: str, found: Sequence[WindEstimate], truth: Sequence[Floats]) -> dict[str, Any]:
    """Errors of the wind east, north, up [m/s], and shares in the 95 % bands, over flights."""
    off = np.concatenate([one.wind - true for one, true in zip(found, truth, strict=True)])
    half = np.concatenate([bands(one.covariance) for one in found])
    known = np.isfinite(off[:, 0])
    means = [one.mean - true.mean(axis=0) for one, true in zip(found, truth, strict=True)]
    widths = [one.mean_half_width for one in found]
    inside = [np.abs(m) <= w for m, w in zip(means, widths, strict=True)]
    one = {
        "flight": name,
        "converged": round(float(known.mean()), 3),
        "rms": rounded(np.sqrt(np.mean(off[known] ** 2, axis=0))),
        "in_band": rounded((np.abs(off) <= half)[known].mean(axis=0), 3),
        "half_width": rounded(half[known].mean(axis=0)),
        "mean_error": rounded(
            np.sqrt(np.nanmean(np.square(means), axis=0)) if len(means) > 1 else means[0]
        ),
        "mean_half_width": rounded(np.nanmean(widths, axis=0) if len(means) > 1 else widths[0]),
        "mean_in_band": rounded(np.mean(inside, axis=0)),
        "well_determined": round(float(np.mean([w.well_determined for w in found])), 3),
    }
    print(one, flush=True)
    return one


def rounded(values: Floats, digits: int = 2) -> list[float | None]:
    """Values for a JSON file."""
    return [round(float(v), digits) if np.isfinite(v) else None for v in values]


def twins(place: Path) -> list[dict[str, Any]]:
    """Errors over simulated flights, with the true constants of the vehicle, and by fits."""
    true, fits = [windy.fit_of()], still(place)
    rows = [gusty(true, path, gust, TWINS) for path in windy.PATHS for gust in GUSTS]
    by_fits = [gusty(fits, path, GUSTS[1], TWINS_OF_FIT) for path in windy.PATHS]
    return [{"fit": "true constants"} | one for one in rows] + [
        {"fit": "fitted"} | one for one in by_fits
    ]


def still(place: Path) -> list[FitFile]:
    """Return fits, each to one simulated flight in still air on each path."""
    vehicle = place / "twin.toml"
    # All rotors of the simulation turn at one speed, so its moments do not balance.
    text = re.sub("(?m)^inertia.*\n", "", vehicle_text(log_table(4)))
    vehicle.write_text(text, encoding="utf-8")
    logs: list[list[Path]] = [[] for _ in range(FITS)]
    for k, path in enumerate(windy.PATHS):
        for fit, flown in enumerate(windy.flights(path, np.zeros((FITS, 3)), 0.0, SECONDS, k)):
            logs[fit].append(place / f"{fit}-{path}.csv")
            windy.write(flown.log, logs[fit][-1])
    files = [place / f"twin-{fit}.toml" for fit in range(FITS)]
    return [
        read_fit(fitted(each, str(vehicle), file, *windy.QUICK))
        for each, file in zip(logs, files, strict=True)
    ]


def gusty(fits: Sequence[FitFile], path: str, gust: float, count: int) -> dict[str, Any]:
    """Return errors over the simulated flights on one path, ``count`` flights for each fit."""
    found, truth = [], []
    for seed, fit in enumerate(fits):
        of_gust = int(10 * gust)
        rng = np.random.default_rng([seed, of_gust])
        mean = rng.normal(0.0, [4.0, 4.0, 0.2], (count, 3))
        for one in windy.flights(path, mean, gust, SECONDS, 1000 * seed + of_gust):
            log, air = (
                low_passed(each, windy.CUTOFF)
                for each in (one.log, replace(one.log, velocity=one.wind))
            )
            found.append(estimate_wind(fit, windy.VEHICLE, log))
            truth.append(air.velocity[np.searchsorted(log.time, found[-1].log.time)])
    return row(f"{path}, gusts of {gust:g} m/s", found, truth)


def estimated(fit: Path, log: Path, vehicle: str, through: float = 0.0) -> WindEstimate:
    """Estimate the wind over a log whose velocity exceeds that over the ground by ``through``."""
    file, known = read_vehicle(vehicle), read_fit(fit)
    file = replace(file, log=replace(file.log, wind=(through, 0.0, 0.0)))
    read = read_flights([log], file, "balance", low_pass=known.low_pass, curve=known.curve)
    return estimate_wind(known, file.vehicle, read.log)


def real(name: str, found: WindEstimate, through: float = 0.0) -> dict[str, Any]:
    """Errors of the wind over a real flight."""
    return row(name, [found], [np.tile([-through, 0.0, 0.0], (len(found.wind), 1))])


def neurobem(folder: Path, place: Path) -> list[dict[str, Any]]:
    """Errors indoors, without wind, by a fit of the other flight."""
    logs = {name: folder / f"neurobem_{name}.csv" for name in (SLOW, FAST)}
    rows = []
    for name, other in ((SLOW, FAST), (FAST, SLOW)):
        fit = fitted([logs[other]], NEUROBEM, place / f"{other}.toml")
        rows.append(real(name[8:], estimated(fit, logs[name], NEUROBEM)))
    return rows


def neuralfly(folder: Path, place: Path) -> list[dict[str, Any]]:
    """Errors in the tunnel, by fits of the flights without wind, and also of those in slow wind."""
    logs = {
        (one, wind): folder / f"neuralfly_{one}_{wind}.csv"
        for wind in SPEEDS
        for one in CONTROLLERS
    }
    rows = []
    for seen in (("nowind",), ("nowind", "35wind")):
        mine = [path for (_, wind), path in logs.items() if wind in seen]
        fit = fitted(mine, NEURALFLY, place / f"{'-'.join(seen)}.toml")
        for (one, wind), path in logs.items():
            found = estimated(fit, path, NEURALFLY, SPEEDS[wind])
            about = {"fit": " and ".join(seen), "fitted": wind in seen, "wind": SPEEDS[wind]}
            rows.append(about | real(f"{one}, {wind}", found, SPEEDS[wind]))
    return rows


if __name__ == "__main__":
    main(*sys.argv[1:])
