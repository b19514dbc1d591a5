"""Vehicle files: what they say, and what is wrong with them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.model.corrections import Installed
from propmap.vehicle.files import VehicleFile, read_vehicle
from propmap.vehicle.vehicle import Body, Wakes, Wing
from tests.io import samples

VEHICLE = """schema = 1
name = "test"
frame = "frd"
mass = 1.5
propeller = "apc-8x6e"

[air]
density = 1.1

[[rotors]]
position = [0.1, 0.2, 0.05]
spin = "ccw"

[[rotors]]
position = [-0.1, -0.2, 0.0]
axis = [0.6, 0.0, -0.8]
spin = "cw"

[body]
drag_area = [0.01, 0.01, 0.02]

[wing]
area = 0.2
incidence = 0.05

[wakes]
ahead = 2.5
share = 0.7

[sensor]
position = [0.02, 0.03, 0.01]

[log]
body_frame = "frd"
world_frame = "ned"
velocity_in = "world"
rotor_unit = "erpm"
pole_pairs = 7
rotor_order = [2, 1]
wind = [1.0, 2, 0]

[log.columns]
time = "t"
velocity = ["u", "v", "w"]
rotor_speed = ["a", "b"]

[log.topics]
imu = "/imu"
"""


def read(text: str, folder: Path) -> VehicleFile:
    path = folder / "vehicle.toml"
    path.write_text(text, encoding="utf-8")
    return read_vehicle(path)


def test_a_vehicle_file(tmp_path: Path) -> None:
    found = read(VEHICLE, tmp_path)
    vehicle, log = found.vehicle, found.log
    assert (vehicle.name, vehicle.mass, vehicle.propeller.name) == ("test", 1.5, "apc-8x6e")
    assert (vehicle.air.density, vehicle.air.viscosity) == (1.1, 1.983e-5)
    first, second = vehicle.mounts
    # From forward, right, down to forward, left, up.
    assert first.position == (0.1, -0.2, -0.05) and first.axis == (0.0, 0.0, 1.0)
    assert second.position == (-0.1, 0.2, 0.0) and second.axis == (0.6, 0.0, 0.8)
    assert (first.spin, second.spin) == ("ccw", "cw")
    assert vehicle.body == Body(drag_area=(0.01, 0.01, 0.02))
    assert vehicle.wing == Wing(area=0.2, incidence=0.05)
    assert vehicle.wakes == Wakes(ahead=2.5, beside=1.0, downwash=1.0, share=0.7)
    assert vehicle.sensor == (0.02, -0.03, -0.01)
    assert (log.body_frame, log.world_frame, log.velocity_in) == ("frd", "ned", "world")
    np.testing.assert_allclose(log.rotor_factor(log.stated("rotor_unit")), np.pi / 210.0)
    assert log.rotor_order == (2, 1) and log.wind == (1.0, 2.0, 0.0)
    assert log.columns == {"time": ("t",), "velocity": ("u", "v", "w"), "rotor_speed": ("a", "b")}
    assert log.topics == {"imu": "/imu"}


def test_what_may_be_left_out(tmp_path: Path) -> None:
    found = read(VEHICLE.partition("[body]")[0].replace("[air]\ndensity = 1.1\n", ""), tmp_path)
    assert found.vehicle.body == Body() and found.vehicle.wing is None
    assert found.vehicle.wakes is None and found.vehicle.sensor == (0.0, 0.0, 0.0)
    assert found.vehicle.air.density == 1.225
    assert found.log.body_frame is None and found.log.columns == {}


def test_a_geometry_beside_the_vehicle_file(tmp_path: Path) -> None:
    (tmp_path / "blade.txt").write_text(samples.UIUC, encoding="utf-8")
    text = VEHICLE.replace('propeller = "apc-8x6e"\n', "").replace(
        "[air]", '[propeller]\ngeometry = "blade.txt"\nblades = 2\nradius = 0.1\n\n[air]'
    )
    blade = read(text, tmp_path).vehicle.propeller
    assert blade.blades == 2 and blade.radius == pytest.approx(0.1)
    (tmp_path / "blade.csv").write_text(samples.CSV, encoding="utf-8")
    text = VEHICLE.replace("apc-8x6e", "blade.csv")
    assert read(text, tmp_path).vehicle.propeller.name == "hand-made"


CASES = {
    "mass forgotten": ("mass = 1.5\n", "", "no mass", "add mass = the take-off mass in kg"),
    "mass in g": ("mass = 1.5", "mass = 1500.0", "mass is 1500.0 kg", "take-off mass in kg"),
    "no frame": ('frame = "frd"\nmass', "mass", "no frame", 'add frame = "flu" or "frd"'),
    "unknown key in a table": ("density", "densty", "[air]", "did you mean density?"),
    "no geometry file beside": ("apc-8x6e", "nothing.csv", "/nothing.csv: no such file"),
    "unit vector wrong": ("0.6, 0.0, -0.8", "0.6, 0.0, -0.9", "rotor 2", "unit vector, such as"),
    "text in a vector": ("[0.1, 0.2, 0.05]", '[0.1, "x", 0]', "[[rotors]] 1", "'x'", "in m"),
    "negative density": ("density = 1.1", "density = -1.1", "vehicle.toml: [air]", "positive"),
    "a rotor's place in mm": ("[0.1, 0.2, 0.05]", "[100, 200, 50]", "position has '100'", "not mm"),
    "a span that is a chord": (
        "area = 0.2",
        "area = 0.2\nspan = 0.3",
        "span is 0.3 m",
        "from tip to tip",
    ),
    "half a pole": ("pole_pairs = 7", "pole_pairs = 7.5", "pole_pairs is '7.5'", "whole number"),
    "three columns": ('["a", "b"]', '["a", "b", "c"]', "lists 3 columns, the vehicle has 2 rotors"),
    "unknown topic": ('imu = "/imu"', 'imo = "/imu"', "[log.topics]", "did you mean imu?"),
    "spin": ('"ccw"', '"left"', "[[rotors]] 1: spin is 'left'", '"ccw" or "cw"'),
    "zero wing area": ("area = 0.2", "area = 0", "[wing]: area is '0'", "remove [wing]"),
    "rotor 0": ("[2, 1]", "[1, 0]", "rotor_order is '[1, 0]'", "each number from 1 to 2 once"),
    "inertia of two axes": ("mass = 1.5", "mass = 1.5\ninertia = [2.5, 2.1]", "a list of length 3"),
    "inertia of no body": (
        "mass = 1.5",
        "mass = 1.5\ninertia = [1e-3, 1e-3, 4e-3]",
        "larger than the sum of the others",
    ),
    "no mount area": (
        "[body]",
        "[mount]\n[body]",
        "[mount]: no area; add area = an area in m^2, or",
    ),
    "mount area as text": (
        "[body]",
        '[mount]\narea = "large"\n[body]',
        "area is 'large', expected a number or a list; write area = an area in m^2",
    ),
    "negative drag": ("[0.01, 0.01, 0.02]", "[0.01, -1, 0]", "[body]", "areas of 0 or more"),
    "a gain of upwash below 0": ("ahead = 2.5", "ahead = -1", "[wakes]: ahead is '-1'", "0 to 20"),
    "sensor in mm": ("[0.02, 0.03, 0.01]", "[20, 30, 10]", "[sensor]", "in m from the center"),
    "inertia of 0": ("mass = 1.5", "mass = 1.5\ninertia = [2.5e-3, 0.0, 4e-3]", "above zero"),
    "a rotor's inertia": ("mass = 1.5", "mass = 1.5\nrotor_inertia = -1e-5", "rotor_inertia"),
    "negative plate": ("[body]", "[body]\nplate_area = -0.01", "0 or more"),
}


@pytest.mark.parametrize("name", CASES)
def test_bad_vehicle_files(name: str, tmp_path: Path) -> None:
    old, new, *parts = CASES[name]
    assert old in VEHICLE
    with pytest.raises(InputError) as caught:
        read(VEHICLE.replace(old, new), tmp_path)
    message = str(caught.value)
    assert message.isprintable(), "one line, no control characters"
    assert "vehicle.toml" in message or name == "no geometry file beside"
    for part in parts:
        assert part in message


def test_no_rotor_and_no_file(tmp_path: Path) -> None:
    top = VEHICLE.partition("[air]")[0]
    with pytest.raises(InputError, match=r"the vehicle has no rotor; add a \[\[rotors\]\] table"):
        read(top, tmp_path)
    with pytest.raises(InputError, match=r"rotors is '3', expected a list; write \[\[rotors\]\]"):
        read(top + "rotors = 3\n", tmp_path)
    with pytest.raises(InputError, match="body is '3', expected a table"):
        read(VEHICLE.partition("[body]")[0].replace("mass", "body = 3\nmass"), tmp_path)
    with pytest.raises(InputError, match="expected the vehicle; give a vehicle file"):
        read("", tmp_path)
    with pytest.raises(InputError, match=r"in TOML, with schema, name, frame, mass, propeller$"):
        read('<robot name="x"><link name="base_link"/></robot>', tmp_path)
    with pytest.raises(InputError, match="no such file"):
        read_vehicle(tmp_path / "nowhere.toml")


MOUNT = "\n[mount]\narea = 0.0014\n\n[body]"


def test_what_the_rotors_are_mounted_on(tmp_path: Path) -> None:
    drags = [m.drag for m in read(VEHICLE.replace("\n[body]", MOUNT), tmp_path).vehicle.mounts]
    assert drags == [Installed(1.0, 0.0014), Installed(1.0, 0.0014)]
    each = MOUNT.replace("0.0014", "[0.001, 0]\nwake = 1.5")
    drags = [m.drag for m in read(VEHICLE.replace("\n[body]", each), tmp_path).vehicle.mounts]
    assert drags == [Installed(1.0, 0.001, wake=1.5), Installed(1.0, 0.0, wake=1.5)]
    assert [m.drag for m in read(VEHICLE, tmp_path).vehicle.mounts] == [None, None]
