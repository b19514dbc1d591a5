"""`propmap vehicle from-log`: the geometry of a PX4 log as a vehicle file, gaps marked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.vehicle.files import read_vehicle
from tests.vehicle.refusals import LOG
from tests.vehicle.write_px4_log import topics_of, write_px4_log

from .conftest import Run, refused

PX4 = Path(__file__).parents[2] / "examples" / "px4" / "vehicle.toml"
PLACES = ((0.17, 0.17), (-0.17, -0.17), (0.17, -0.17), (-0.17, 0.17))
"""In FRD, of that vehicle's rotors, of which the first two turn counter-clockwise."""


def logged(side: float = 0.17, **more: float) -> None:
    """Write a log whose parameters leave out those that are PX4's defaults."""
    stated: dict[str, float | int] = {"CA_ROTOR_COUNT": 4}
    for k, (x, y) in enumerate(PLACES):
        stated |= {f"CA_ROTOR{k}_PX": x * side / 0.17, f"CA_ROTOR{k}_PY": y * side / 0.17}
    stated |= {"CA_ROTOR2_KM": -0.05, "CA_ROTOR3_KM": -0.05}
    write_px4_log(topics_of(LOG, {}), Path("my quad.ulg"), {**stated, **more})


def test_the_geometry_is_that_of_the_log(run: Run) -> None:
    logged()
    done = run("vehicle", "from-log", "my quad.ulg", "-o", "drafted.toml")
    assert done.code == 0
    assert "note: fill in the values that the log does not contain: mass, propeller" in done.err
    with pytest.raises(InputError, match="mass"):
        read_vehicle("drafted.toml")
    text = Path("drafted.toml").read_text(encoding="utf-8")
    Path("drafted.toml").write_text(text.replace("# MISSING: ", ""), encoding="utf-8")
    drafted, wanted = read_vehicle("drafted.toml"), read_vehicle(PX4)
    assert drafted.vehicle.name == "my quad"
    assert drafted.vehicle.mounts == wanted.vehicle.mounts
    assert drafted.log.rotor_unit == "rpm"


def test_a_mass_and_tilted_rotors_are_taken_over(run: Run) -> None:
    logged(WEIGHT_GROSS=1.4, CA_ROTOR1_PZ=-0.05, CA_ROTOR1_AX=0.3, CA_ROTOR1_AZ=-0.4)
    done = run("vehicle", "from-log", "my quad.ulg")
    assert done.err == "note: fill in the values that the log does not contain: propeller\n"
    Path("drafted.toml").write_text(done.out.replace("# MISSING: ", ""), encoding="utf-8")
    vehicle = read_vehicle("drafted.toml").vehicle
    assert vehicle.mass == pytest.approx(1.4)
    np.testing.assert_allclose(vehicle.mounts[1].position, (-0.17, 0.17, 0.05))
    np.testing.assert_allclose(vehicle.mounts[1].axis, (0.6, 0.0, 0.8), atol=1e-6)


@pytest.mark.parametrize("commands", ["actuator_motors", ""])
def test_rotor_speeds_that_are_not_there_are_told(run: Run, commands: str) -> None:
    topics = {name: rows for name, rows in topics_of(LOG, {}).items() if name != "esc_status"}
    if commands:
        topics[commands] = topics_of(LOG, {})["esc_status"]
    write_px4_log(topics, Path("my quad.ulg"), {"CA_ROTOR_COUNT": 4, "CA_ROTOR0_PX": 0.2})
    done = run("vehicle", "from-log", "my quad.ulg")
    assert "\nrotor_unit" not in done.out
    assert ("propeller, rotor_unit" in done.err) is not bool(commands)
    told = "`propmap fit flight` uses the throttle of actuator_motors"
    assert (told in done.out) is bool(commands)


def test_generic_places_are_not_taken_for_metres(run: Run) -> None:
    """PX4's airframes that nobody measured have ones for the sides."""
    logged(side=1.0)
    done = run("vehicle", "from-log", "my quad.ulg")
    assert "# MISSING: position = [1.0, 1.0, 0.0]  # m; PX4's generic position" in done.out
    assert "mass, propeller, position" in done.err
    Path("there.toml").write_text("mine", encoding="utf-8")
    refused(run("vehicle", "from-log", "my quad.ulg", "-o", "there.toml"), "pass --force")


def test_rotors_that_cannot_command_yaw_are_noted(run: Run) -> None:
    """PX4's rotors 1 and 3 are in front, so this log has equal spins there and at the back."""
    logged(CA_ROTOR1_KM=-0.05, CA_ROTOR2_KM=0.05)
    words = "note: rotor speeds alone cannot command yaw without pitch (0% of yaw is independent)"
    assert words in run("vehicle", "from-log", "my quad.ulg").err


def test_what_cannot_be_drafted_is_one_line(run: Run) -> None:
    logged(CA_ROTOR_COUNT=0)
    told = "my quad.ulg: the log has no rotor parameters: CA_ROTOR_COUNT is missing"
    refused(run("vehicle", "from-log", "my quad.ulg"), told)
    Path("a.ulg").write_bytes(b"\xa3\x95\x80" * 99)
    refused(run("vehicle", "from-log", "a.ulg"), "a.ulg: not a ULog file")
    for name in ("a.bin", "a.log", "a.bag", "a.csv"):
        Path(name).write_bytes(b"\xa3\x95\x80" * 99)
        says = f"{name}: only ULogs of PX4 contain rotor positions", "[[rotors]] with position"
        refused(run("vehicle", "from-log", name), *says)
