"""Compute errors of fits from throttle, on measured flights and on a simulated flight.

Usage: python -m tools.throttle_flights FOLDER

FOLDER contains the flights neuralfly_CONTROLLER_WIND.csv (O'Connell et al., Neural-Fly, Science
Robotics 2022), each as one CSV file.  The tool fits the flights in slow wind and checks the fit on
all flights.  It also fits a simulated flight from throttle and from rotor speeds, and compares the
two fits.  It writes benchmarks/results/throttle.json.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from propmap.cli import main as propmap
from propmap.fit.files import read_fit
from propmap.io.csv import replacing
from tests.fit.throttle_twin import differences, fit_both

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benchmarks" / "results" / "throttle.json"
VEHICLE = str(ROOT / "examples" / "neuralfly" / "vehicle.toml")
WITHOUT = {
    "complete model": [],
    "without motor lag": ["--fix", "motor_lag=0"],
    "without accelerometer tilt": ["--fix", "sensor_tilt_x=0", "--fix", "sensor_tilt_y=0"],
    "without hover throttle": [],
}
SEEN, UNSEEN, CONTROLLERS = ("nowind", "35wind"), ("70wind",), ("NF", "baseline")


def main(folder: str) -> None:
    """Fit the flights, check the fits, and write the results."""
    with tempfile.TemporaryDirectory() as place:
        logs = {
            (one, wind): str(Path(folder) / f"neuralfly_{one}_{wind}.csv")
            for wind in (*SEEN, *UNSEEN)
            for one in CONTROLLERS
        }
        found = {
            "without": without(logs, Path(place)),
            "flights": flights(logs, Path(place)),
            "twins": twins(Path(place)),
        }
    with replacing(RESULTS) as path:
        path.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    print(RESULTS)


Logs = dict[tuple[str, str], str]


def fitted(logs: Logs, fit: Path, vehicle: str, *options: str) -> None:
    """Fit the flights in slow wind and write the file ``fit``."""
    slow = [path for (_, wind), path in logs.items() if wind in SEEN]
    output("fit", "flight", *slow, "--vehicle", vehicle, "-o", str(fit), *options)


def without(logs: Logs, place: Path) -> dict[str, list[float]]:
    """Return cross-validated errors along x, y and z [N], with parts of the model omitted."""
    bare = place / "without_hover_throttle.toml"
    lines = Path(VEHICLE).read_text(encoding="utf-8").splitlines()
    kept = (line for line in lines if not line.startswith("hover_throttle"))
    bare.write_text("\n".join(kept), encoding="utf-8")
    found = {}
    for k, (name, options) in enumerate(WITHOUT.items()):
        fit = place / f"fit_{k}.toml"
        fitted(logs, fit, str(bare) if "hover throttle" in name else VEHICLE, *options)
        loads = read_fit(fit).record.loads
        found[name] = [round(load.cross_validated, 3) for load in loads]
    return found


def flights(logs: Logs, place: Path) -> list[dict[str, Any]]:
    """Return the errors along x, y and z [N] of each flight, and the coverage of the bands."""
    fit = str(place / "fit_0.toml")
    rows = []
    for (one, wind), path in logs.items():
        found = json.loads(output("check", fit, path, "--vehicle", VEHICLE, "--format", "json"))
        loads = [found["loads"][f"force_{axis}_N"] for axis in "xyz"]
        kept = ("rms", "bias", "in_band", "hover_rms")
        rows.append(
            {"flight": f"{one}, {wind}", "fitted": wind in SEEN}
            | {key: [round(load[key], 3) for load in loads] for key in kept}
        )
    return rows


def twins(place: Path) -> dict[str, float]:
    """Return the differences of forces and bands between fits from throttle and rotor speeds."""
    with contextlib.redirect_stdout(io.StringIO()):
        fit_both(place)
    return {name: round(value, 4) for name, value in differences(place).items()}


def output(*arguments: str) -> str:
    """Run a propmap command and return its printed output."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        if propmap(list(arguments)):
            raise SystemExit(1)
    return printed.getvalue()


if __name__ == "__main__":
    main(*sys.argv[1:])
