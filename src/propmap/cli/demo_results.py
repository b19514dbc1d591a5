"""What ``propmap demo`` computes and writes."""

from __future__ import annotations

import os
import timeit
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

import propmap
from propmap.arrays.types import Floats
from propmap.catalogue.lookup import propeller
from propmap.catalogue.measurements import measurement
from propmap.cli.operating_points import RPM
from propmap.cli.output import csv_text, json_text, write_text
from propmap.loads import LOADS
from propmap.model.airfoil import parameter_set
from propmap.model.model import Model
from propmap.report.comparison import Comparison, LoadErrors, compare
from propmap.rotor import Rotor

PROPELLER, AIRFOIL = "apc-8x6e", "paper-apc"
TUNNEL, OBLIQUE = "uiuc-8x6e", "gill-dandrea-2019-8x6e-fit"
CURVES = np.radians([0.0, 30.0, 60.0, 90.0])
DISK = (4000.0 * RPM, 14.0, np.radians(80.0))
"""An operating point with stall and reverse flow to be seen: [rad/s], [m/s], [rad]."""

REPEATS = 3

COPIES = 10
"""A batch fills blocks of equal size, so few points cost more each than many."""


@dataclass(frozen=True)
class Group:
    """Errors over some points of a data set; beta_deg where they share one."""

    title: str
    data_set: str
    beta_deg: float | None
    errors: list[LoadErrors]


@dataclass(frozen=True)
class Timing:
    """Best of three calls with so many points at once, after a first one."""

    points: int
    seconds_per_point: float


@dataclass(frozen=True, eq=False)
class Results:
    """Comparisons at every point, errors by data set and of the oblique one by angle, and the time
    of these points at once and of ten times as many."""

    rotor: Rotor
    comparisons: tuple[Comparison, Comparison]
    groups: list[Group]
    by_angle: list[Group]
    timings: list[Timing]
    cores: int

    def notes(self) -> list[str]:
        """What is off, and why, with this run's figures."""
        thrust, torque = self._bias("thrust"), self._bias("torque")
        return [
            "The paper's section law has no camber (zero-lift angle 0), the blade has: mean "
            f"thrust is off by {thrust}, mean torque by {torque}. Constants fitted together with "
            "a zero-lift angle, about -4 degrees, mend most of it.",
            f"Rotor drag of the 2019 fit is {self.drag_ratio():.1f} times the theory's with these "
            "parameters. Sources disagree: the 2017 paper's own measurements and Ribner's fin "
            "analogy (NACA TR 819) are near the theory. Nothing is tuned here.",
            "The oblique data are a published smooth fit of measurements, not raw points.",
        ]

    def _bias(self, load: str) -> str:
        """Mean error over the mean measured load, in words, by data set."""
        found = []
        for group in self.groups:
            (errors,) = (one for one in group.errors if one.load == load)
            found.append(f"{errors.model.mean / errors.measured_mean:+.0%} {group.title}")
        return ", ".join(found)

    def drag_ratio(self) -> float:
        """Rotor drag of the oblique data over the predicted one [-], rms over rms."""
        both = self.comparisons[1]
        sizes = [np.square(drag["drag"]).sum() for drag in (both.measured, both.predicted)]
        return float(np.sqrt(sizes[0] / sizes[1]))


def compute() -> Results:
    """Compare, and time the whole batch."""
    tunnel, oblique = measurement(TUNNEL), measurement(OBLIQUE)
    blade, section = propeller(PROPELLER), parameter_set(AIRFOIL)
    rotors = [
        Rotor(Model(blade, section, propmap.Air(density=data.air_density)))
        for data in (tunnel, oblique)
    ]
    both = (compare(rotors[0], tunnel), compare(rotors[1], oblique))
    still = tunnel.speed == 0.0
    everything = np.full(oblique.speed.shape, True)
    groups = [
        Group("static", TUNNEL, None, both[0].errors(still)),
        Group("axial", TUNNEL, 0.0, both[0].errors(~still)),
        Group("oblique", OBLIQUE, None, both[1].errors(everything)),
    ]
    degrees = np.round(np.degrees(oblique.beta), 1)
    by_angle = [
        Group(f"oblique {beta:g}", OBLIQUE, float(beta), both[1].errors(degrees == beta))
        for beta in np.unique(degrees)
    ]
    fields = ("omega", "speed", "beta")
    flow = [np.concatenate([getattr(tunnel, f), getattr(oblique, f)]) for f in fields]
    timings = [_timing(rotors[1], flow, copies) for copies in (1, COPIES)]
    return Results(rotors[1], both, groups, by_angle, timings, os.cpu_count() or 1)


def write_tables(results: Results, folder: Path) -> None:
    """``demo.csv``, every point, and ``demo.json``, the errors."""
    rows = [row for one in results.comparisons for row in _rows(one)]
    write_text(csv_text(list(rows[0]), rows), folder / "demo.csv")
    groups = [asdict(group) for group in (*results.groups, *results.by_angle)]
    found = {
        "propmap_version": propmap.__version__,
        "propeller": results.rotor.model.propeller.name,
        "airfoil": results.rotor.model.airfoil.name,
        "air_density_kg_m3": results.rotor.model.air.density,
        "accuracy": results.rotor.accuracy,
        "relative_rms": "rms of the error over the rms of the measured load",
        "groups": groups,
        "drag_ratio": results.drag_ratio(),
        "notes": results.notes(),
        "timings": [asdict(timing) for timing in results.timings],
        "cores": results.cores,
    }
    write_text(json_text(found), folder / "demo.json")


def write_pictures(results: Results, folder: Path) -> tuple[Path, Path]:
    """Load curves at the rotational speed with most oblique points, and a disk; the paths."""
    from propmap.report.disk_picture import disk_picture
    from propmap.report.load_curves import MeasuredLoads, load_curves
    from propmap.report.style import save

    oblique = results.comparisons[1]
    data = oblique.measurement
    speeds, counts = np.unique(data.omega, return_counts=True)
    omega = float(speeds[np.argmax(counts)])
    mine = data.omega == omega
    points = MeasuredLoads(
        "fit of measurements, Gill & D'Andrea 2019",
        data.speed[mine],
        data.beta[mine],
        {load: values[mine] for load, values in oblique.measured.items()},
    )
    curves, disk = folder / "demo-loads.png", folder / "demo-disk.png"
    fastest = float(data.speed[mine].max())
    speed = np.linspace(0.0, fastest, 61)
    save(load_curves(results.rotor, omega, speed, CURVES.tolist(), points), curves)
    save(disk_picture(results.rotor, *DISK), disk)
    return curves, disk


def _timing(rotor: Rotor, flow: list[Floats], copies: int) -> Timing:
    batch = [np.tile(values, copies) for values in flow]
    rotor.loads(*batch)
    seconds = min(timeit.repeat(lambda: rotor.loads(*batch), number=1, repeat=REPEATS))
    return Timing(batch[0].size, seconds / batch[0].size)


def _rows(both: Comparison) -> list[dict[str, Any]]:
    data = both.measurement
    none = np.full(data.omega.size, None)
    columns: dict[str, Any] = {
        "data_set": np.full(data.omega.size, data.name),
        "rpm": data.omega / RPM,
        "speed_mps": data.speed,
        "beta_deg": np.degrees(data.beta),
    }
    for name, load in LOADS.items():
        columns[f"measured_{load.column}"] = both.measured.get(name, none)
        columns[f"predicted_{load.column}"] = both.predicted[name]
        columns[f"hover_{load.column}"] = both.hover[name]
    columns["status"] = both.status
    listed = [values.tolist() for values in columns.values()]
    return [dict(zip(columns, row, strict=True)) for row in zip(*listed, strict=True)]
