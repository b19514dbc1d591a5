"""Forty slips that people make in columns of measured loads: eight kinds in each of five columns.

The right cause is named in at least 36 of them, and no wrong one is named alone.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.catalogue.lookup import measurement
from propmap.errors import InputError
from propmap.fit.tunnel import tunnel_warnings

RPM = np.pi / 30.0
GRAVITY, POUND, INCH = 9.80665, 4.4482216152605, 0.0254


def measured(name: str, few: int) -> dict[str, np.ndarray]:
    """Rows of the catalogue's measurement, in the columns of a file."""
    m = measurement(name)
    rows = np.linspace(0, m.omega.size - 1, few).astype(int)
    if name.startswith("uiuc"):
        flying = np.flatnonzero(np.isclose(m.omega, m.omega[0], rtol=1e-3) & (m.speed > 0.0))
        rows = np.concatenate([flying[: few // 2], np.flatnonzero(m.speed == 0.0)[: few // 2]])
    density = propmap.Air().density / m.air_density
    found = {
        "rpm": m.omega / RPM,
        "speed_mps": m.speed,
        "beta_deg": np.degrees(m.beta),
        "thrust_N": m.loads["thrust"] * density,
        "torque_Nm": m.loads["torque"] * density,
    }
    return {column: values[rows] for column, values in found.items()}


AXIAL = measured("uiuc-8x6e", 40)
OBLIQUE = measured("gill-dandrea-2019-8x6e", 120)
POWER = {**AXIAL, "power_W": AXIAL["torque_Nm"] * AXIAL["rpm"] * RPM}
del POWER["torque_Nm"]


def times(column: str, factor: float, text: dict[str, np.ndarray] | None = None) -> str:
    base = text or (POWER if column == "power_W" else AXIAL)
    return table({**base, column: base[column] * factor})


def table(columns: dict[str, np.ndarray]) -> str:
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    return "\n".join([",".join(columns), *(",".join(map(repr, row)) for row in rows)]) + "\n"


SLIPS: dict[str, dict[str, tuple[str, str]]] = {
    "rpm": {
        "rad/s": (times("rpm", RPM), "rad/s"),
        "per second": (times("rpm", 1.0 / 60.0), "revolutions per second"),
        "converted twice": (times("rpm", 1.0 / RPM), "rad/s twice"),
        "thousands": (times("rpm", 1e-3), "thousands"),
        "7 pole pairs": (times("rpm", 7.0), "electrical rpm, of 7 pole pairs"),
        "4 pole pairs": (times("rpm", 4.0), "electrical rpm of about [345] pole pairs"),
        "11 pole pairs": (times("rpm", 11.0), "electrical rpm"),
        "sign": (times("rpm", -1.0), "is negative; .*spin's direction"),
    },
    "thrust": {
        "grams": (times("thrust_N", 1e3 / GRAVITY), "grams"),
        "kilograms": (times("thrust_N", 1.0 / GRAVITY), "kilograms"),
        "millinewtons": (times("thrust_N", 1e3), "millinewtons"),
        "ounces": (times("thrust_N", 16.0 / POUND), "ounces"),
        "pounds": (times("thrust_N", 1.0 / POUND), "pounds"),
        "four rotors": (times("thrust_N", 4.0), "that of about [34] rotors"),
        "two rotors": (times("thrust_N", 2.0), "that of about 2 rotors"),
        "sign": (times("thrust_N", -1.0), "sign looks reversed"),
    },
    "torque": {
        "N cm": (times("torque_Nm", 1e2), "N cm"),
        "mN m": (times("torque_Nm", 1e3), "N mm"),
        "kg cm": (times("torque_Nm", 1e2 / GRAVITY), "kg cm"),
        "ounce-inches": (times("torque_Nm", 16.0 / (POUND * INCH)), "ounce-inches"),
        "pound-inches": (times("torque_Nm", 1.0 / (POUND * INCH)), "pound-inches"),
        "four rotors": (times("torque_Nm", 4.0), "that of about [345] rotors"),
        "electrical": (times("torque_Nm", 2.5), "electrical power"),
        "sign": (times("torque_Nm", -1.0), "sign looks reversed"),
    },
    "power": {
        "kilowatts": (times("power_W", 1e-3), "kilowatts"),
        "milliwatts": (times("power_W", 1e3), "milliwatts"),
        "horsepower": (times("power_W", 1.0 / 745.7), "horsepower"),
        "electrical": (times("power_W", 1.6), "electrical power"),
        "electrical, half lost": (times("power_W", 2.4), "electrical power"),
        "four rotors": (times("power_W", 4.0), "that of about [345] rotors"),
        "four rotors in all": (
            table({**POWER, **{k: 4.0 * POWER[k] for k in ("thrust_N", "power_W")}}),
            "that of about [345] rotors",
        ),
        "sign": (times("power_W", -1.0), "sign looks reversed"),
    },
    "flow": {
        "km/h": (times("speed_mps", 3.6), "km/h"),
        "miles": (times("speed_mps", 1.0 / 0.44704), "miles an hour"),
        "knots": (times("speed_mps", 3600.0 / 1852.0), "knots"),
        "feet": (times("speed_mps", 1.0 / 0.3048), "feet per second"),
        "cm/s": (times("speed_mps", 100.0), "cm/s"),
        "from the disk": (
            table({**OBLIQUE, "beta_deg": 90.0 - OBLIQUE["beta_deg"]}),
            "measured from the disk plane",
        ),
        "radians": (times("beta_deg", np.pi / 180.0, OBLIQUE), "looks like radians"),
        "sign": (times("speed_mps", -1.0), "is negative; .*direction is --beta"),
    },
}


def told_of(text: str, folder: Path) -> str:
    path = folder / "stand.csv"
    path.write_text(text)
    try:
        return " ".join(tunnel_warnings([str(path)], propmap.propeller("apc-8x6e"), propmap.Air()))
    except InputError as error:
        return str(error)


@pytest.mark.parametrize("good", [AXIAL, OBLIQUE, POWER])
def test_what_is_right_is_not_doubted(good: dict[str, np.ndarray], tmp_path: Path) -> None:
    whose = "stand.csv: power is taken to be the shaft's, not the battery's"
    assert told_of(table(good), tmp_path) == (whose if good is POWER else "")


def test_forty_slips_by_their_causes(tmp_path: Path) -> None:
    named, wrong = [], []
    for column, slips in SLIPS.items():
        assert len(slips) == 8
        for slip, (text, cause) in slips.items():
            told = told_of(text, tmp_path)
            if re.search(cause, told):
                named.append((column, slip))
            elif re.search("looks? (like|reversed|as if)|may be", told):
                wrong.append((column, slip, told))
    assert wrong == []
    assert len(named) >= 36
