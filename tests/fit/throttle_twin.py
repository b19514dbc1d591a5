"""Twins: a flight with rotor speeds, and the same with commands to the motors in place of them.

Level circles with the noise of sensors.  The commands are by another curve than that of a fit, see
``tests.flight.commands``, with noise of a hundredth.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from propmap.cli import main
from propmap.cli.fit_flight import read_flights
from propmap.fit.comparison import flight_forces, force_errors, values_for
from propmap.fit.files import FitFile, read_fit
from propmap.flight.simulate import SensorNoise, fly, log_csv, log_table, trim
from propmap.model.airfoil import parameter_set
from propmap.typing import Floats
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog
from propmap.vehicle.throttle import CURVE
from tests.flight.commands import Commands, commands
from tests.flight.synthetic import NEUROBEM, vehicle_text

VEHICLE = read_vehicle(NEUROBEM).vehicle
LAW = parameter_set("paper-apc").with_corrections(["pitt-peters", "installed:factor=1.9"])
SPEEDS = np.array([0.5, 3.0, 6.0, 9.0])
FREE = "c_l1,zero_lift_angle,c_d0,drag_factor,mount_area,drag_area_z"
RATE = 50.0
KINDS = {"speeds": "", "throttle": f",{','.join(CURVE)}"}
"""What a log has, and what is free besides."""


def flown(seed: int, dwell: float = 5.0) -> tuple[FlightLog, Commands]:
    """A log with noise, and the commands to its motors; ``dwell`` seconds at each speed."""
    points = trim(VEHICLE, LAW, SPEEDS, radius=12.0, tether=False)
    smooth = fly(points, dwell=dwell, rate=RATE, noise=SensorNoise(rotor_speed=0.0), seed=seed)
    rng = np.random.default_rng(seed)
    noisy = 1.0 + SensorNoise().rotor_speed * rng.standard_normal(smooth.rotor_speed.shape)
    return replace(smooth, rotor_speed=smooth.rotor_speed * noisy), commands(smooth, 0.01)


def write(log: FlightLog, driven: Commands | None, path: Path) -> None:
    """Write a CSV file, with pulses and voltage in place of the rotor speeds where ``driven``."""
    lines = list(csv.reader(log_csv(log).splitlines()))
    if driven is not None:
        more = np.column_stack([1000.0 + 1000.0 * driven.share, driven.voltage])
        heads = [*(f"pwm_{k}" for k in range(1, 5)), "volts"]
        cells = [heads, *([f"{x:.6f}" for x in row] for row in more)]
        lines = [[*row[:-4], *new] for row, new in zip(lines, cells, strict=True)]
    path.write_text("\n".join(",".join(row) for row in lines) + "\n")


def fit_both(folder: Path, dwell: float = 5.0, samples: int = 150, folds: int = 3) -> None:
    """Write vehicle files and two flights with columns of each kind, and fit the first flight."""
    table = log_table(4)
    named, _, speeds = table.partition("rotor_speed")
    driven = "throttle" + speeds.replace("rotor_", "pwm_").replace("_radps", "")
    limits = named.replace("[log]", "[log]\nthrottle_range = [1000, 2000]")
    texts = {"speeds": table, "throttle": f'{limits}{driven}battery_voltage = "volts"\n'}
    for kind, text in texts.items():
        (folder / f"{kind}.toml").write_text(vehicle_text(text))
    for seed, name in ((1, "seen"), (2, "unseen")):
        log, motors = flown(seed, dwell)
        write(log, None, folder / f"{name}_speeds.csv")
        write(log, motors, folder / f"{name}_throttle.csv")
    for kind, more in KINDS.items():
        log_file, vehicle = str(folder / f"seen_{kind}.csv"), str(folder / f"{kind}.toml")
        way = ["--vehicle", vehicle, "--method", "balance", "--prior-from", "population"]
        few = ["--starts", "1", "--folds", str(folds), "--samples", str(samples)]
        fit = str(folder / f"{kind}_fit.toml")
        assert main(["fit", "flight", log_file, *way, "--free", FREE + more, *few, "-o", fit]) == 0


@dataclass(frozen=True, eq=False)
class Predicted:
    """A fit, and its forces (n, 3) [N] on the flight that was not fitted, with deviations."""

    fit: FitFile
    forces: Floats
    deviations: Floats


def predicted(folder: Path, kind: str) -> Predicted:
    """What the fit of one kind says, after ``fit_both``."""
    file, path = read_fit(folder / f"{kind}_fit.toml"), folder / f"unseen_{kind}.csv"
    vehicle = read_vehicle(folder / f"{kind}.toml")
    log = read_flights([path], vehicle, "balance", low_pass=6.0, curve=file.curve).log
    values, _ = values_for(file, vehicle.vehicle, log, [path])
    errors = force_errors(file, vehicle.vehicle, log, values)
    assert errors is not None
    forces = flight_forces(vehicle.vehicle, log, file.airfoil, values).model
    return Predicted(file, forces[:, :3], errors.deviations[:, :3])


def differences(folder: Path) -> dict[str, float]:
    """How the forces from throttle and their bands differ from those from rotor speeds.

    All are root mean squares over the flight: the largest difference of an axis' force over the
    largest force, the widths of the bands over each other, and the share of the samples whose
    difference lies in the band, of the worst axis.
    """
    one, other = (predicted(folder, kind) for kind in KINDS)

    def size(values: Floats) -> Floats:
        return np.asarray(np.sqrt(np.mean(values**2, axis=0)))

    off = other.forces - one.forces
    inside = np.abs(off) < 1.96 * other.deviations
    return {
        "force": float(size(off).max() / size(one.forces).max()),
        "band": float(np.max(size(other.deviations) / size(one.deviations))),
        "inside": float(np.mean(inside, axis=0).min()),
    }
