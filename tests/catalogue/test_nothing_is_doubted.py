"""Nothing that comes with propmap, and none of the reference data, is called implausible."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from propmap import catalogue
from propmap.model.air import Air
from propmap.model.plausibility import (
    air_warnings,
    blade_warnings,
    load_warnings,
    point_warnings,
)
from propmap.model.propeller import Propeller

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
INCH = 0.0254
RPM = np.pi / 30.0

Table = list[dict[str, str]]


def table(name: str, separator: str = ",") -> Table:
    path = DATA / name
    if not path.is_file():
        pytest.skip(f"{name} is not here")
    lines = path.read_text(encoding="utf-8-sig").splitlines()
    return list(csv.DictReader([line for line in lines if line[:1] != "#"], delimiter=separator))


def column(rows: Table, name: str) -> np.ndarray:
    return np.array([float(row[name]) for row in rows])


def doubts(
    blade: Propeller, points: tuple[np.ndarray, ...], loads: dict[str, np.ndarray], air: Air
) -> list[str]:
    return [
        *blade_warnings(blade),
        *air_warnings(air),
        *point_warnings(blade, *points),
        *load_warnings(blade, air, *points, loads),
    ]


def test_every_set_of_the_uiuc_database() -> None:
    """Thrust with torque, thrust alone and torque alone."""
    stations: dict[str, Table] = {}
    for row in table("uiuc/geometry.csv"):
        stations.setdefault(row["BladeName"], []).append(row)
    sets: dict[str, Table] = {}
    for row in table("uiuc/loads.csv"):
        sets.setdefault(row["PropName"], []).append(row)
    found, judged = [], 0
    for name, rows in sets.items():
        if rows[0]["BladeName"] not in stations:
            continue
        at = stations[rows[0]["BladeName"]]
        share, first = np.unique(column(at, "r/R"), return_index=True)
        radius = 0.5 * INCH * float(rows[0]["D"])
        blade = Propeller(
            name,
            int(float(rows[0]["B"])),
            share * radius,
            column(at, "c/R")[first] * radius,
            np.radians(column(at, "beta")[first]),
        )
        turns = column(rows, "N") / 60.0
        force = Air().density * turns**2 * blade.diameter**4
        torque = column(rows, "CP") * force * blade.diameter / (2.0 * np.pi)
        loads = {"thrust": column(rows, "CT") * force, "torque": torque}
        speed = column(rows, "J") * turns * blade.diameter
        points = 2.0 * np.pi * turns, speed, np.zeros_like(turns)
        for some in (loads, *({key: value} for key, value in loads.items())):
            found += [f"{name}: {doubt}" for doubt in doubts(blade, points, some, Air())]
        judged += 1
    assert found == []
    assert judged == 134


@pytest.mark.parametrize("name", ["apc_8x6e_published_fit", "apc_8x6e_published_polynomials"])
def test_oblique_flow(name: str) -> None:
    rows = table(f"oblique/{name}.csv")
    points = column(rows, "rpm") * RPM, column(rows, "speed_mps"), column(rows, "beta_deg")
    points = (*points[:2], np.radians(points[2]))
    loads = {
        "thrust": column(rows, "thrust_N"),
        "drag": column(rows, "drag_N"),
        "torque": column(rows, "torque_Nm"),
    }
    assert doubts(catalogue.load("apc-8x6e"), points, loads, Air()) == []
