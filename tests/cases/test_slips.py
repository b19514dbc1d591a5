"""Forty slips in columns of measured loads: at least 36 causes are named, and no wrong one."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

import propmap
from propmap.catalogue.lookup import measurement
from propmap.errors import InputError
from propmap.fit.tunnel import data_warnings, measured_loads
from propmap.model.plausibility import blade_warnings
from propmap.units import GRAVITY, INCH

Columns = dict[str, np.ndarray]
RPM = np.pi / 30.0
POUND = 4.4482216152605
AIR = propmap.Air()
BLADE = propmap.propeller("apc-8x6e")


def measured(name: str) -> Columns:
    """The catalogue's measurement, in the columns of a file."""
    m = measurement(name)
    density = AIR.density / m.air_density
    return {
        "rpm": m.omega / RPM,
        "speed_mps": m.speed,
        "beta_deg": np.degrees(m.beta),
        "thrust_N": m.loads["thrust"] * density,
        "torque_Nm": m.loads["torque"] * density,
    }


def one_speed_and_rest(columns: Columns) -> Columns:
    flying = np.isclose(columns["rpm"], columns["rpm"][0], rtol=1e-3) & (columns["speed_mps"] > 0.0)
    still = columns["speed_mps"] == 0.0
    rows = np.concatenate([np.flatnonzero(flying)[:20], np.flatnonzero(still)[:20]])
    return {column: values[rows] for column, values in columns.items()}


def by_power(columns: Columns) -> Columns:
    power = columns["torque_Nm"] * columns["rpm"] * RPM
    return {k: v for k, v in columns.items() if k != "torque_Nm"} | {"power_W": power}


AXIAL = one_speed_and_rest(measured("uiuc-8x6e"))
OBLIQUE = measured("gill-dandrea-2019-8x6e")
ROTORS, ELECTRICAL = r"the total of about \d rotors", "electrical power"
PAIRS = "electrical rpm,? of (about )?{} pole pairs"

# By column: name of the slip, factor between the written and the right values, named cause.
FACTORS: dict[str, list[tuple[str, float, str]]] = {
    "rpm": [
        ("rad/s", RPM, "rad/s"),
        ("per second", 1.0 / 60.0, "revolutions per second"),
        ("converted twice", 1.0 / RPM, "rad/s twice"),
        ("thousands", 1e-3, "thousands"),
        ("4 pole pairs", 4.0, PAIRS.format("[3457]")),
        ("7 pole pairs", 7.0, PAIRS.format("(6|7|8)")),
        ("11 pole pairs", 11.0, PAIRS.format("(7|1[0-4])")),
        ("sign", -1.0, "is negative; .*both spin directions"),
    ],
    "thrust_N": [
        ("grams", 1e3 / GRAVITY, "grams"),
        ("kilograms", 1.0 / GRAVITY, "kilograms"),
        ("millinewtons", 1e3, "millinewtons"),
        ("ounces", 16.0 / POUND, "ounces"),
        ("pounds", 1.0 / POUND, "pounds"),
        ("four rotors", 4.0, ROTORS),
        ("two rotors", 2.0, ROTORS),
        ("sign", -1.0, "sign looks reversed"),
    ],
    "torque_Nm": [
        ("N cm", 1e2, "N cm"),
        ("mN m", 1e3, "N mm"),
        ("kg cm", 1e2 / GRAVITY, "kg cm"),
        ("ounce-inches", 16.0 / (POUND * INCH), "ounce-inches"),
        ("pound-inches", 1.0 / (POUND * INCH), "pound-inches"),
        ("four rotors", 4.0, ROTORS),
        ("electrical", 2.5, ELECTRICAL),
        ("sign", -1.0, "sign looks reversed"),
    ],
    "power_W": [
        ("kilowatts", 1e-3, "kilowatts"),
        ("milliwatts", 1e3, "milliwatts"),
        ("horsepower", 1.0 / 745.7, "horsepower"),
        ("electrical", 1.6, ELECTRICAL),
        ("electrical, half lost", 2.0, ELECTRICAL),
        ("four rotors", 4.0, ROTORS),
        ("electrical, of four rotors", 4.0 * 1.5, f"{ELECTRICAL}|{ROTORS}"),
        ("sign", -1.0, "sign looks reversed"),
    ],
    "speed_mps": [
        ("km/h", 3.6, "km/h"),
        ("miles", 1.0 / 0.44704, "miles per hour"),
        ("knots", 3600.0 / 1852.0, "knots"),
        ("feet", 1.0 / 0.3048, "feet per second"),
        ("cm/s", 100.0, "cm/s"),
        ("sign", -1.0, "is negative; .*direction is --beta"),
    ],
}


def told_of(columns: Columns, folder: Path, blade: propmap.Propeller = BLADE) -> str:
    path, rows = folder / "stand.csv", zip(*(v.tolist() for v in columns.values()), strict=True)
    path.write_text("\n".join([",".join(columns), *(",".join(map(repr, r)) for r in rows)]) + "\n")
    try:
        return " ".join(data_warnings(measured_loads(path)(blade, AIR), blade, AIR))
    except InputError as error:
        return str(error)


def outcome(told: str, cause: str) -> str:
    if re.search(cause, told):
        return "named"
    return "wrong" if re.search("looks? (like|reversed|as if)|may be", told) else "silent"


def test_what_is_right_is_not_doubted(tmp_path: Path) -> None:
    assert told_of(AXIAL, tmp_path) == told_of(OBLIQUE, tmp_path) == ""
    whose = "stand.csv: power is assumed to be shaft power, not battery power"
    assert told_of(by_power(AXIAL), tmp_path) == whose


def test_forty_slips_by_their_causes(tmp_path: Path) -> None:
    every: dict[str, tuple[Columns, str]] = {}
    for name, factors in FACTORS.items():
        right = by_power(AXIAL) if name == "power_W" else AXIAL
        for slip, factor, cause in factors:
            every[f"{name}: {slip}"] = {**right, name: right[name] * factor}, cause
    beta, disk = OBLIQUE["beta_deg"], "measured from the disk plane"
    every["from the disk"] = {**OBLIQUE, "beta_deg": 90.0 - beta}, disk
    every["radians"] = {**OBLIQUE, "beta_deg": np.radians(beta)}, "looks like radians"
    assert len(every) == 40
    found = {slip: outcome(told_of(c, tmp_path), cause) for slip, (c, cause) in every.items()}
    assert [slip for slip, how in found.items() if how == "wrong"] == []
    assert Counter(found.values())["named"] >= 36


def test_a_better_propeller_is_not_doubted_and_two_rotors_are(tmp_path: Path) -> None:
    """A 28x9.2 of figure of merit 0.71, 1.5 times the thrust of a poor blade at its torque."""
    blade = propmap.propeller("28x9.2")
    omega = np.array([1900.0, 2600.0, 3300.0]) * RPM
    inflow = 0.06 * omega * blade.radius
    thrust = 2.0 * AIR.density * np.pi * blade.radius**2 * inflow**2
    rows = {"rpm": omega / RPM, "thrust_N": thrust, "torque_Nm": thrust * inflow / (0.71 * omega)}
    assert "rotors" not in told_of(rows, tmp_path, blade)
    doubled = told_of({**rows, "thrust_N": 2.0 * thrust}, tmp_path, blade)
    assert re.search(ROTORS, doubled) and "another propeller was measured" in doubled
    wrong = told_of({**rows, "rpm": rows["rpm"] / 8.0}, tmp_path, blade)
    assert "name the right propeller" in wrong


def test_thrust_alone_and_axial_flow(tmp_path: Path) -> None:
    alone = {name: values for name, values in AXIAL.items() if name != "torque_Nm"}
    assert told_of(alone, tmp_path) == ""
    for name, factor, cause in (
        ("thrust_N", 1e3 / GRAVITY, "thrust looks like grams"),
        ("rpm", RPM, "rpm in rad/s"),
        ("speed_mps", 3.6, "km/h"),
    ):
        assert cause in told_of({**alone, name: alone[name] * factor}, tmp_path)
    turned = {**AXIAL, "beta_deg": AXIAL["beta_deg"] + 90.0}
    assert "measured from the disk plane" in told_of(turned, tmp_path)


def test_a_diameter_for_the_radius_shows_in_the_loads(tmp_path: Path) -> None:
    """A blade in fractions of the radius looks right at any size."""
    large = replace(BLADE, station=2.0 * BLADE.station, chord=2.0 * BLADE.chord)
    assert blade_warnings(large) == []
    assert "a diameter in place of the radius" in told_of(AXIAL, tmp_path, large)
