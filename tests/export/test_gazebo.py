"""Target ``gazebo``: the equations of both plugins give the loads of the rotor."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.aircraft.trim import Aircraft
from propmap.errors import InputError
from propmap.export import export_table, export_vehicle
from propmap.loads import LOADS
from propmap.table import LoadTable
from propmap.vehicle.powertrain import Battery, Motor, Powertrain
from propmap.vehicle.vehicle import Body, Mount, Vehicle

from .conftest import OMEGA, SPINS, VELOCITIES, Both, hub_wrench, invented_content, share

COMMON = {
    *("jointName", "linkName", "turningDirection", "timeConstantUp", "timeConstantDown"),
    *("maxRotVelocity", "motorConstant", "momentConstant", "commandSubTopic", "motorNumber"),
    *("rotorDragCoefficient", "rollingMomentCoefficient", "motorSpeedPubTopic"),
    "rotorVelocitySlowdownSim",
}
ELEMENTS = {
    "gz": COMMON | {"actuator_number", "motorType"},
    "gazebo_classic": COMMON | {"robotNamespace", "reversible", "maxRelativeAirspeed"},
}
"""Elements that the sources of the plugins read.  Without robotNamespace, that of gz-sim takes the
name of the model; joint_control_pid has no effect in the other one."""

KINDS = sorted(ELEMENTS)
CORNERS = ((0.16, 0.16), (-0.16, 0.16), (-0.16, -0.16), (0.16, -0.16))
QUAD = Vehicle(
    "quad",
    1.2,
    propmap.propeller("apc-8x6e"),
    tuple(
        Mount((x, y, 0.02), spin=s) for (x, y), s in zip(CORNERS, 2 * ["cw", "ccw"], strict=True)
    ),
    body=Body(drag_area=(0.015, 0.015, 0.03)),
)


def plugins(folder: Path, kind: str) -> list[ET.Element]:
    (path,) = folder.glob(f"*_{kind}.sdf")
    root = ET.parse(path).getroot()
    assert root.tag == "model" and {child.tag for child in root} == {"plugin"}
    return list(root)


def written(plugin: ET.Element) -> dict[str, float]:
    """The numbers of a plugin, with 1 for ccw and -1 for cw."""
    found = {each.tag: each.text or "" for each in plugin}
    found["turningDirection"] = str(SPINS[found["turningDirection"]])
    return {tag: float(text) for tag, text in found.items() if re.fullmatch(r"[-+.\de]+", text)}


def equations(kind: str, p: dict[str, float], omega: float, velocity: np.ndarray) -> np.ndarray:
    """Force and moment (n, 6) as the source of the plugin computes them, z along the thrust."""
    direction, joint_axis = p["turningDirection"], np.array([0.0, 0.0, 1.0])
    joint_velocity = direction * omega / p["rotorVelocitySlowdownSim"]
    real = joint_velocity * p["rotorVelocitySlowdownSim"]
    along = velocity @ joint_axis
    across = velocity - along[:, None] * joint_axis
    if kind == "gz":
        thrust = np.full(
            len(velocity), direction * np.sign(real) * real * real * p["motorConstant"]
        )
        applied, turned = thrust, 1.0
    else:
        thrust = np.full(len(velocity), abs(real * abs(real) * p["motorConstant"]))
        scalar = np.clip(1.0 - abs(along) / p["maxRelativeAirspeed"], 0.0, 1.0)
        applied, turned = thrust * scalar, direction
    force = applied[:, None] * joint_axis - abs(real) * p["rotorDragCoefficient"] * across
    moment = -direction * thrust[:, None] * p["momentConstant"] * joint_axis
    moment = moment - abs(real) * turned * p["rollingMomentCoefficient"] * across
    return np.concatenate([force, moment], axis=-1)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("spin", SPINS)
def test_the_plugins_have_four_of_six_loads(
    oblique: Both, tmp_path: Path, spin: str, kind: str
) -> None:
    rotor, table = oblique
    export_table(table, "gazebo", tmp_path)
    both = {
        plugin.findtext("turningDirection"): written(plugin) for plugin in plugins(tmp_path, kind)
    }
    assert both.keys() == SPINS.keys()
    parameters = both[spin]
    assert parameters["maxRotVelocity"] == pytest.approx(table.envelope["omega"][1])
    # At rest, at another rotor speed than that of the constants: the Reynolds number matters.
    still = equations(kind, parameters, OMEGA, np.zeros((1, 3)))
    rest = rotor.wrench(OMEGA, (0.0, 0.0, 0.0), spin)
    assert still[0, 2] == pytest.approx(rest.force[2], rel=0.01)
    assert still[0, 5] == pytest.approx(rest.moment[2], rel=0.03)
    loads = rotor.loads_at_velocity(OMEGA, VELOCITIES)
    across = VELOCITIES * [1.0, 1.0, 0.0]
    left = np.cross([0.0, 0.0, 1.0], across / np.linalg.norm(across, axis=1)[:, None])
    side = SPINS[spin] * loads.side_force[:, None] * left
    lost = np.concatenate([side, -loads.pitch_moment[:, None] * left], axis=-1)
    found = equations(kind, parameters, OMEGA, VELOCITIES)
    error = share(found, hub_wrench(rotor, spin) - lost)
    assert error[:, [0, 1, 3, 4]].max() < 0.006
    assert error[:, 2].max() < (0.3 if kind == "gz" else 0.06)
    # The slope of the drag over the in-plane velocity, near hover.
    slow = rotor.loads(OMEGA, 1.0, np.pi / 2.0)
    assert parameters["rotorDragCoefficient"] * OMEGA == pytest.approx(slow.drag, rel=0.15)


@pytest.mark.parametrize("kind", KINDS)
def test_a_vehicle_has_a_plugin_per_rotor(oblique: Both, tmp_path: Path, kind: str) -> None:
    rotor, table = oblique
    export_vehicle(QUAD, table, "gazebo", tmp_path)
    found = plugins(tmp_path, kind)
    assert [plugin.findtext("turningDirection") for plugin in found] == 2 * ["cw", "ccw"]
    hover = Aircraft(QUAD, rotor).steady(0.0, margin=False)
    omega = float(hover.rotor_speed.mean())
    for k, (plugin, spin) in enumerate(zip(found, 2 * ["cw", "ccw"], strict=True)):
        assert {each.tag for each in plugin} == ELEMENTS[kind]
        assert plugin.findtext("jointName") == f"rotor_{k}_joint"
        assert plugin.findtext("linkName") == f"rotor_{k}"
        assert plugin.findtext("motorNumber") == str(k)
        still = equations(kind, written(plugin), omega, np.zeros((1, 3)))[0]
        # Hover: the plugins carry the weight, and have the torque of the rotor.
        assert 4.0 * still[2] == pytest.approx(QUAD.mass * 9.80665, rel=2e-3)
        torque = rotor.wrench(omega, (0.0, 0.0, 0.0), spin).moment[2]
        assert still[5] == pytest.approx(torque, rel=4e-3)


def test_the_note_states_the_errors_in_level_flight(oblique: Both, tmp_path: Path) -> None:
    rotor, table = oblique
    note = export_vehicle(QUAD, table, "gazebo", tmp_path)[-1].read_text()
    blocks = re.findall(
        r"^over the 4 rotors in level flight at (\d+) m/s\n(.*?)\n\n", note, re.M | re.S
    )
    # The table ends at 6 m/s.
    assert [speed for speed, _ in blocks] == ["0", "5"]
    assert "No trimmed level flight was found at: 10 m/s" in " ".join(note.split())
    shown = {row.split()[0]: row.split()[1:] for row in blocks[1][1].splitlines()[1:]}
    assert list(shown) == list(LOADS)
    (first, *_) = plugins(tmp_path, "gz")
    craft = Aircraft(QUAD, rotor)
    states = craft.steady(5.0, margin=False)
    omega, hubs = craft.rotor_motion(states)
    loads = rotor.loads_at_velocity(omega[0, 0], hubs[0, 0])
    inplane = float(np.hypot(*hubs[0, 0, :2]))
    p, static = written(first), rotor.loads(omega[0, 0], 0.0, 0.0)
    errors = {
        "thrust": p["motorConstant"] * omega[0, 0] ** 2 / loads.thrust - 1.0,
        "drag": (p["rotorDragCoefficient"] * omega[0, 0] * inplane - loads.drag) / static.thrust,
        "side_force": -loads.side_force / static.thrust,
    }
    for load, error in errors.items():
        assert float(shown[load][1].strip("%")) == pytest.approx(100.0 * abs(error), abs=0.5), load
    classic = re.search(
        r"in the order of the conditions below: ([\d.]+)%, ([\d.]+)%\.", " ".join(note.split())
    )
    assert classic is not None and float(classic[1]) < 0.1


def test_names_are_escaped_and_numbered(oblique: Both, tmp_path: Path) -> None:
    _, table = oblique
    named = replace(QUAD, name='a & b <c> -- "d"')
    names = {"joint": 'arm "{}" <&> --', "link": "{}&<'"}
    export_vehicle(named, table, "gazebo", tmp_path, **names)
    for kind in KINDS:
        found = plugins(tmp_path, kind)
        assert [p.findtext("jointName") for p in found] == [f'arm "{k}" <&> --' for k in range(4)]
        assert [p.findtext("linkName") for p in found] == [f"{k}&<'" for k in range(4)]
    with pytest.raises(InputError, match="joint name 'arm' does not contain"):
        export_table(table, "gazebo", tmp_path / "no", joint="arm")
    assert not (tmp_path / "no").exists()


def test_full_throttle_limits_the_command(tmp_path: Path) -> None:
    motor = Motor(speed_constant=90.0, resistance=0.1, no_load_current=(0.5,))
    powered = replace(
        QUAD, powertrain=Powertrain(motor=motor, battery=Battery(cells=3, capacity=9e3))
    )
    table = LoadTable(invented_content(of=powered))
    export_vehicle(powered, table, "gazebo", tmp_path)
    for plugin in plugins(tmp_path, "gz"):
        # Below the speed without load, and not the end of the table.
        assert 600.0 < written(plugin)["maxRotVelocity"] < 90.0 * 12.6
        assert written(plugin)["maxRotVelocity"] != pytest.approx(table.envelope["omega"][1])
