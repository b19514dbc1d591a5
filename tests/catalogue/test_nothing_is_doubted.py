"""Nothing that comes with propmap, and none of the reference data, is called implausible."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from propmap import catalogue
from propmap.catalogue.lookup import measurement, measurement_names
from propmap.model.air import Air
from propmap.model.plausibility import (
    CHORD,
    RADIUS,
    TWIST,
    air_warnings,
    at_share,
    blade_warnings,
    load_warnings,
    point_warnings,
)
from propmap.model.propeller import WIDEST_CHORD, Propeller

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


@pytest.mark.parametrize("name", catalogue.names())
def test_blades_of_the_catalogue(name: str) -> None:
    blade = catalogue.load(name)
    assert blade_warnings(blade) == []
    chord, twist = at_share(blade, 0.75)
    # The ranges have room, but not so much that they say nothing.
    assert 1.1 * CHORD.low < chord / blade.radius < CHORD.high / 1.1
    assert 1.1 * WIDEST_CHORD.low < blade.chord.max() / blade.radius < WIDEST_CHORD.high / 1.1
    assert 2.0 * TWIST.low < np.degrees(twist) < TWIST.high / 1.2
    assert 2.0 * RADIUS.low < blade.radius < RADIUS.high / 2.0


@pytest.mark.parametrize("name", measurement_names())
def test_measurements_of_the_catalogue(name: str) -> None:
    m = measurement(name)
    points = m.omega, m.speed, m.beta
    air = Air(density=m.air_density)
    assert doubts(catalogue.load(m.propeller), points, dict(m.loads), air) == []


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_large_propeller_at_rest() -> None:
    """T-Motor 28 in; the stations of its geometry end at 0.9 of the radius."""
    rows = table("static/tmotor28_data.csv", ";")
    text = (DATA / "static/tmotor28.ini").read_text()
    figures = {
        line.partition("=")[0].strip(): line.partition("=")[2].split()
        for line in text.splitlines()
        if "=" in line
    }
    blade = Propeller(
        "tmotor28",
        2,
        np.array([*figures["radius"], "0.3556"], dtype=float),
        np.array([*figures["chord"], "0.02"], dtype=float),
        np.radians(np.array([*figures["pitch"], "6.0"], dtype=float)),
    )
    omega = column(rows, "omega")
    points = omega, 0.0 * omega, 0.0 * omega
    loads = {"thrust": column(rows, "T(N)"), "torque": column(rows, "Q(Nm)")}
    assert doubts(blade, points, loads, Air()) == []


@pytest.mark.slow
def test_electrical_power_in_a_tunnel() -> None:
    """TU Delft, 8 in: shaft power is about 0.874 of the electrical."""
    geometry, rows = table("power/propeller_geometry.csv"), table("power/wt_10Hz.csv")
    radius = 4.0 * INCH
    blade = Propeller(
        "delft",
        2,
        column(geometry, "r_over_R") * radius,
        column(geometry, "c_over_R") * radius,
        np.radians(column(geometry, "beta_deg")),
    )
    omega = column(rows, "rpm") * RPM
    power = 0.874 * column(rows, "voltage") * column(rows, "current")
    turning = omega > 0.0
    points = omega[turning], column(rows, "airspeed")[turning], 0.0 * omega[turning]
    assert blade_warnings(blade) == []
    assert point_warnings(blade, *points) == []
    assert load_warnings(blade, Air(), *points, {"torque": power[turning] / points[0]}) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["neurobem_20210218171908", "neurobem_20210218172600"])
def test_flights(name: str) -> None:
    """The blade is known roughly; all rotors, all the time."""
    rows = table(f"flight/{name}.csv")
    radius = 0.0648
    station = np.linspace(0.15, 1.0, 12) * radius
    blade = Propeller(
        "5.1 in", 3, station, np.linspace(0.017, 0.008, 12), np.linspace(0.4006, 0.2610, 12)
    )
    velocity = np.stack([column(rows, f"vel_{axis}") for axis in "xyz"], axis=1)
    speed = np.linalg.norm(velocity, axis=1)
    beta = np.arccos(np.clip(velocity[:, 2] / np.maximum(speed, 1e-9), -1.0, 1.0))
    assert blade_warnings(blade) == []
    for rotor in range(1, 5):
        assert point_warnings(blade, column(rows, f"mot{rotor}"), speed, beta) == []
