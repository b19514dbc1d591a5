"""A table of operating points: its signs, and what is wrong with it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from propmap.errors import InputError
from propmap.flight.steady import read_level_table
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog

from .synthetic import NEUROBEM

VEHICLE = read_vehicle(NEUROBEM).vehicle
HEADER = "speed_mps,pitch_deg,rpm_1,rpm_2,rpm_3,rpm_4"
GOOD = f"{HEADER}\n0,0,9000,9100,9200,9300\n5,10,9500,9500,9500,9500\n"


def read(text: str, folder: Path) -> FlightLog:
    (folder / "points.csv").write_text(text, encoding="utf-8")
    return read_level_table(folder / "points.csv", VEHICLE)


def test_leaning_into_the_flight_direction(tmp_path: Path) -> None:
    points = read(GOOD, tmp_path)
    np.testing.assert_array_equal(points.time, [0.0, 1.0])
    np.testing.assert_allclose(points.up[0], [0, 0, 1])
    s, c = np.sin(np.radians(10.0)), np.cos(np.radians(10.0))
    # Nose down, the vertical is towards the tail, and the air comes from above.
    np.testing.assert_allclose(points.up[1], [-s, 0, c])
    np.testing.assert_allclose(points.velocity[1], [5 * c, 0, 5 * s])
    np.testing.assert_allclose(
        points.rotor_speed[0], np.array([9000, 9100, 9200, 9300]) * np.pi / 30
    )
    np.testing.assert_array_equal(points.rates, 0.0)
    assert np.isnan(points.specific_force).all()


def test_bank_climb_and_turn(tmp_path: Path) -> None:
    text = "roll_deg,note,climb_mps,yaw_rate_dps," + GOOD.replace("\n0", "\n20,a,0,0,0").replace(
        "\n5", "\n-20,b,1.5,30,5"
    )
    points = read(text, tmp_path)
    # Right side down, the vertical is towards the left.
    s, c = np.sin(np.radians(20.0)), np.cos(np.radians(20.0))
    np.testing.assert_allclose(points.up[0], [0, s, c])
    to_world = Rotation.from_euler("YX", [10.0, -20.0], degrees=True)
    np.testing.assert_allclose(to_world.apply(points.velocity[1]), [5, 0, 1.5], atol=1e-12)
    np.testing.assert_allclose(to_world.apply(points.up[1]), [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(to_world.apply(points.rates[1]), [0, 0, np.radians(30)], atol=1e-12)
    np.testing.assert_allclose(points.climb_rate, [0, 1.5], atol=1e-12)


CASES = {
    "no speed": (GOOD.replace("speed_mps", "speed"), "line 1: column speed_mps is missing"),
    "no pitch": (GOOD.replace("pitch_deg", "pitch"), "line 1: column pitch_deg is missing"),
    "three rotors": (GOOD.replace(",rpm_4", ",x"), "3 columns rpm_1, rpm_2 ..., the vehicle has 4"),
    "five rotors": (GOOD.replace("rpm_4", "rpm_4,rpm_5"), "5 columns", "name rpm_1, rpm_2, rpm_3"),
    "twice": (GOOD.replace("rpm_4", "rpm_4,pitch_deg"), "column pitch_deg occurs twice"),
    "text": (GOOD.replace("9200", "fast"), "line 2, column rpm_3", "'fast'", "finite number"),
    "empty cell": (GOOD.replace("9200", ""), "line 2, column rpm_3", "is nothing"),
    "short row": (GOOD.replace(",9500\n", "\n"), "line 3, column rpm_4", "is nothing"),
    "negative rpm": (GOOD.replace("9200", "-9200"), "line 2, column rpm_3", "give 0 or more"),
    "negative speed": (GOOD.replace("\n5", "\n-5"), "line 3, column speed_mps", "give 0 or more"),
    "steep": (GOOD.replace(",10,", ",100,"), "line 3, column pitch_deg", "0 in hover"),
    "header only": (HEADER, "add a row per point"),
    "empty": ("", "the file is empty", "table of operating points"),
    "quote": (GOOD.replace("9200", '"9200'), "save the file as plain CSV"),
}


@pytest.mark.parametrize("name", CASES)
def test_bad_tables(name: str, tmp_path: Path) -> None:
    text, *parts = CASES[name]
    with pytest.raises(InputError) as caught:
        read(text, tmp_path)
    message = str(caught.value)
    assert message.isprintable()
    for part in ["points.csv", *parts]:
        assert part in message
