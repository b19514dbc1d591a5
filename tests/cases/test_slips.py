"""Forty slips that people make in columns of measured loads: eight kinds in each of five columns.

The right cause is named in at least 36 of them, and no wrong one is named alone.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.catalogue.lookup import measurement
from propmap.errors import InputError
from propmap.fit.tunnel import data_warnings, measured_loads
from propmap.model.propeller import Propeller
from tests.catalogue.test_nothing_is_doubted import INCH, column, table

Columns = dict[str, np.ndarray]
RPM = np.pi / 30.0
GRAVITY, POUND = 9.80665, 4.4482216152605
AIR = propmap.Air()


def measured(name: str, rows: Callable[[Columns], np.ndarray]) -> Columns:
    """Some rows of the catalogue's measurement, in the columns of a file."""
    m = measurement(name)
    density = AIR.density / m.air_density
    found = {
        "rpm": m.omega / RPM,
        "speed_mps": m.speed,
        "beta_deg": np.degrees(m.beta),
        "thrust_N": m.loads["thrust"] * density,
        "torque_Nm": m.loads["torque"] * density,
    }
    chosen = rows(found)
    return {column: values[chosen] for column, values in found.items()}


def one_speed_and_rest(columns: Columns) -> np.ndarray:
    flying = np.isclose(columns["rpm"], columns["rpm"][0], rtol=1e-3) & (columns["speed_mps"] > 0.0)
    still = columns["speed_mps"] == 0.0
    return np.concatenate([np.flatnonzero(flying)[:20], np.flatnonzero(still)[:20]])


def by_power(columns: Columns) -> Columns:
    power = columns["torque_Nm"] * columns["rpm"] * RPM
    return {k: v for k, v in columns.items() if k != "torque_Nm"} | {"power_W": power}


AXIAL = measured("uiuc-8x6e", one_speed_and_rest)
OBLIQUE = measured("gill-dandrea-2019-8x6e", lambda c: np.arange(c["rpm"].size))
ROTORS, ELECTRICAL = r"the total of about \d rotors", "electrical power"
PAIRS = "electrical rpm,? of (about )?{} pole pairs"

# By column: its name and, by slip, the factor between what it holds and should, and the cause.
FACTORS: dict[str, tuple[str, dict[str, tuple[float, str]]]] = {
    "rpm": (
        "rpm",
        {
            "rad/s": (RPM, "rad/s"),
            "per second": (1.0 / 60.0, "revolutions per second"),
            "converted twice": (1.0 / RPM, "rad/s twice"),
            "thousands": (1e-3, "thousands"),
            "4 pole pairs": (4.0, PAIRS.format("[3457]")),
            "7 pole pairs": (7.0, PAIRS.format("(6|7|8)")),
            "11 pole pairs": (11.0, PAIRS.format("(7|1[0-4])")),
            "sign": (-1.0, "is negative; .*both spin directions"),
        },
    ),
    "thrust": (
        "thrust_N",
        {
            "grams": (1e3 / GRAVITY, "grams"),
            "kilograms": (1.0 / GRAVITY, "kilograms"),
            "millinewtons": (1e3, "millinewtons"),
            "ounces": (16.0 / POUND, "ounces"),
            "pounds": (1.0 / POUND, "pounds"),
            "four rotors": (4.0, ROTORS),
            "two rotors": (2.0, ROTORS),
            "sign": (-1.0, "sign looks reversed"),
        },
    ),
    "torque": (
        "torque_Nm",
        {
            "N cm": (1e2, "N cm"),
            "mN m": (1e3, "N mm"),
            "kg cm": (1e2 / GRAVITY, "kg cm"),
            "ounce-inches": (16.0 / (POUND * INCH), "ounce-inches"),
            "pound-inches": (1.0 / (POUND * INCH), "pound-inches"),
            "four rotors": (4.0, ROTORS),
            "electrical": (2.5, ELECTRICAL),
            "sign": (-1.0, "sign looks reversed"),
        },
    ),
    "power": (
        "power_W",
        {
            "kilowatts": (1e-3, "kilowatts"),
            "milliwatts": (1e3, "milliwatts"),
            "horsepower": (1.0 / 745.7, "horsepower"),
            "electrical": (1.6, ELECTRICAL),
            "electrical, half lost": (2.0, ELECTRICAL),
            "four rotors": (4.0, ROTORS),
            "electrical, of four rotors": (4.0 * 1.5, f"{ELECTRICAL}|{ROTORS}"),
            "sign": (-1.0, "sign looks reversed"),
        },
    ),
    "flow": (
        "speed_mps",
        {
            "km/h": (3.6, "km/h"),
            "miles": (1.0 / 0.44704, "miles per hour"),
            "knots": (3600.0 / 1852.0, "knots"),
            "feet": (1.0 / 0.3048, "feet per second"),
            "cm/s": (100.0, "cm/s"),
            "sign": (-1.0, "is negative; .*direction is --beta"),
        },
    ),
}
ANGLES = {
    "from the disk": (lambda beta: 90.0 - beta, "measured from the disk plane"),
    "radians": (np.radians, "looks like radians"),
}


def slips(axial: Columns) -> Iterator[tuple[str, Columns, str]]:
    """Name, columns and cause of every slip in a factor."""
    for kind, (name, factors) in FACTORS.items():
        right = by_power(axial) if name == "power_W" else axial
        for slip, (factor, cause) in factors.items():
            yield f"{kind}: {slip}", {**right, name: right[name] * factor}, cause


def told_of(columns: Columns, blade: Propeller, folder: Path) -> str:
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


@pytest.fixture(scope="module")
def blade() -> Propeller:
    return propmap.propeller("apc-8x6e")


def test_what_is_right_is_not_doubted(blade: Propeller, tmp_path: Path) -> None:
    assert told_of(AXIAL, blade, tmp_path) == told_of(OBLIQUE, blade, tmp_path) == ""
    whose = "stand.csv: power is assumed to be shaft power, not battery power"
    assert told_of(by_power(AXIAL), blade, tmp_path) == whose


def test_forty_slips_by_their_causes(blade: Propeller, tmp_path: Path) -> None:
    every = list(slips(AXIAL))
    for slip, (turn, cause) in ANGLES.items():
        every.append((slip, {**OBLIQUE, "beta_deg": turn(OBLIQUE["beta_deg"])}, cause))
    assert len(every) == 40
    found = {slip: outcome(told_of(c, blade, tmp_path), cause) for slip, c, cause in every}
    assert [slip for slip, how in found.items() if how == "wrong"] == []
    assert Counter(found.values())["named"] >= 36


@pytest.mark.slow
def test_slips_of_every_fourth_propeller_of_uiuc(tmp_path: Path) -> None:
    """Propellers of the database that the usual ranges come from."""
    stations: dict[str, list[dict[str, str]]] = {}
    for row in table("uiuc/geometry.csv"):
        stations.setdefault(row["BladeName"], []).append(row)
    sets: dict[str, list[dict[str, str]]] = {}
    for row in table("uiuc/loads.csv"):
        if row["BladeName"] in stations:
            sets.setdefault(row["PropName"], []).append(row)
    found: Counter[str] = Counter()
    for name in list(sets)[::4]:
        rows, at = sets[name], stations[sets[name][0]["BladeName"]]
        share, first = np.unique(column(at, "r/R"), return_index=True)
        radius, turns = 0.5 * INCH * float(rows[0]["D"]), column(rows, "N") / 60.0
        chord, twist = column(at, "c/R")[first] * radius, np.radians(column(at, "beta")[first])
        blade = Propeller(name, int(float(rows[0]["B"])), share * radius, chord, twist)
        force = AIR.density * turns**2 * blade.diameter**4
        axial = {
            "rpm": turns * 60.0,
            "speed_mps": column(rows, "J") * turns * blade.diameter,
            "beta_deg": np.zeros_like(turns),
            "thrust_N": column(rows, "CT") * force,
            "torque_Nm": column(rows, "CP") * force * blade.diameter / (2.0 * np.pi),
        }
        found.update(outcome(told_of(c, blade, tmp_path), cause) for _, c, cause in slips(axial))
    assert found["named"] >= 0.9 * found.total()
    assert found["wrong"] <= 0.01 * found.total()
