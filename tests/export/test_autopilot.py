"""Parameters of PX4 and ArduPilot: their equations, written again here, against level flights."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import propmap
from propmap.aircraft.trim import Aircraft
from propmap.errors import InputError
from propmap.export.autopilot import autopilot_parameters, export_autopilot
from propmap.export.steady_loads import inplane_forces
from propmap.model.airfoil import SectionCovariance, SectionUncertainty
from propmap.table import LoadTable
from propmap.units import RPM
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.powertrain import Battery, Motor, Powertrain
from propmap.vehicle.vehicle import Body, Mount, Vehicle, Wakes, Wing
from tests.aircraft.conftest import POWERTRAIN, aircraft_of, quadcopter

from .conftest import invented_content

G = 9.80665
AREAS = (0.015, 0.03, 0.03)
ARM = 0.16
SPEEDS = np.array([4.0, 8.0])
PX4_X = ((1, -1, "ccw"), (-1, 1, "ccw"), (1, 1, "cw"), (-1, -1, "cw"))
"""Signs of x and y (to the left) of PX4's rotors, front right first."""


def in_px4_order(**changes: Any) -> Vehicle:
    mounts = tuple(Mount((x * ARM, y * ARM, 0.02), spin=spin) for x, y, spin in PX4_X)
    return quadcopter(**({"mounts": mounts, "body": Body(AREAS)} | changes))


@pytest.fixture(scope="module")
def aircraft() -> Aircraft:
    return aircraft_of(in_px4_order(air=propmap.Air(1.1)))


@pytest.fixture(scope="module")
def files(aircraft: Aircraft, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("autopilot")
    for target in ("px4", "ardupilot"):
        export_autopilot(aircraft, target, folder)
    return {path.name: path.read_text() for path in folder.iterdir()}


def by_qgroundcontrol(text: str) -> dict[str, float]:
    """As ParameterManager::readParametersFromStream does: five columns between tabs."""
    read: dict[str, float] = {}
    for line in text.splitlines():
        if line.startswith("#"):
            continue
        vehicle, component, name, value, kind = line.split("\t")
        assert name not in read and re.fullmatch(r"[A-Z0-9_]{1,16}", name)  # as MAVLink has them
        assert (vehicle, component) == ("1", "1")
        assert kind in ("6", "9") and (kind == "9" or value == str(int(value)))
        read[name] = float(value)
    return read


def by_ap_param(text: str) -> dict[str, float]:
    """As AP_Param::load_defaults_file does: pieces of 98 characters, the second word a number."""
    read: dict[str, float] = {}
    for line in text.splitlines():
        for piece in (line[k : k + 98] for k in range(0, len(line), 98)):
            if not piece.startswith("#"):
                name, value = re.split(r"[, =\t]+", piece)[:2]
                read[name] = float(value)
    return read


def ekf2(p: dict[str, float], rho: float, velocity: np.ndarray) -> np.ndarray:
    """Ekf::fuseDrag: specific force along x and y [m/s^2] at a velocity (3,) in the body frame."""
    inverse = np.array([1.0 / p["EKF2_BCOEF_X"], 1.0 / p["EKF2_BCOEF_Y"]])
    plane = velocity[:2]
    joined = np.linalg.norm(inverse * plane) / np.linalg.norm(plane)
    rotors = p["EKF2_MCOEF"] * np.sqrt(rho / 1.225)
    return -0.5 * joined * rho * plane * np.linalg.norm(velocity) - plane * rotors


def ekf3(p: dict[str, float], rho: float, velocity: np.ndarray) -> np.ndarray:
    """NavEKF3_core::FuseDragForces, the same."""
    ratio = rho / 1.225
    forces = []
    for v, axis in zip(velocity[:2].tolist(), "XY", strict=True):
        sign = -1.0 if v > 0.0 else 1.0
        bluff = 0.5 / p[f"EK3_DRAG_BCOEF_{axis}"] * rho * v**2 * sign
        forces.append(bluff - v * p["EK3_DRAG_MCOEF"] * ratio)
    return np.array(forces)


FILTERS = {
    "px4": ("quadcopter_px4.params", by_qgroundcontrol, ekf2),
    "ardupilot": ("quadcopter_ardupilot.param", by_ap_param, ekf3),
}


@pytest.mark.parametrize("target", FILTERS)
def test_the_filter_expects_the_force_of_level_flight(
    aircraft: Aircraft, files: dict[str, str], target: str
) -> None:
    """Between the speeds of the fit, and sideways as a vehicle whose body is turned."""
    file, read, equation = FILTERS[target]
    parameters, vehicle = read(files[file]), aircraft.vehicle
    speeds = np.array([2.0, 4.0, 8.0, 12.0, 14.0])
    turned = replace(vehicle, body=Body((AREAS[1], AREAS[0], AREAS[2])))
    for way, flown, axis in (("forward", vehicle, 0), ("sideways", turned, 1)):
        states = aircraft_of(flown).steady(speeds, margin=False)
        note = files[f"README-{target}.md"]
        told = re.search(rf"{way} at most [^;]*?and at most ([\d.]+) N at all speeds", note)
        assert told
        worst = float(told[1])
        assert worst < 0.1 * vehicle.mass
        for pitch, v in zip(states.pitch.tolist(), speeds.tolist(), strict=True):
            velocity = np.zeros(3)
            velocity[axis], velocity[2] = v * np.cos(pitch), v * np.sin(pitch)
            predicted = equation(parameters, vehicle.air.density, velocity)
            measured = np.zeros(2)
            measured[axis] = -G * np.sin(pitch)
            # As near as the note says of the fitted speeds, and a tenth more between them.
            assert vehicle.mass * np.abs(predicted - measured).max() < 1.1 * worst


def test_rotors_are_where_the_firmware_has_them(aircraft: Aircraft, files: dict[str, str]) -> None:
    """x forward, y right, z down; torque over thrust as the reaction on the vehicle."""
    p = by_qgroundcontrol(files["quadcopter_px4.params"])
    assert p["CA_ROTOR_COUNT"] == 4
    hover = aircraft.steady([0.0])
    arm = hover.torque[0] / hover.thrust[0]
    # ActuatorEffectivenessRotors: moment = ct r x a - ct km a; thrust 1 of each rotor in turn.
    for k, mount in enumerate(aircraft.vehicle.mounts):
        place = np.array([p[f"CA_ROTOR{k}_P{axis}"] for axis in "XYZ"])
        axis = np.array([p[f"CA_ROTOR{k}_A{letter}"] for letter in "XYZ"])
        moment = np.cross(place, axis) - p[f"CA_ROTOR{k}_KM"] * axis
        x, y, _ = mount.position
        # Lifting the front raises the nose (+y right), lifting the left rolls right (+x).
        assert moment[0] == pytest.approx(y) and moment[1] == pytest.approx(x)
        # A rotor that turns counter-clockwise turns the vehicle clockwise, +z down.
        sign = 1.0 if mount.spin == "ccw" else -1.0
        assert moment[2] == pytest.approx(sign * arm[k], rel=1e-3)


def test_the_thrust_curve_is_that_of_motor_and_battery(
    aircraft: Aircraft, files: dict[str, str]
) -> None:
    """Rotor speeds at some signals, found anew from the motor's equations."""
    motor, esc, pack = POWERTRAIN.motor, POWERTRAIN.controller, POWERTRAIN.battery
    assert motor and esc and pack
    kv, resistance = motor.speed_constant, motor.resistance + esc.resistance
    still = aircraft.loads.loads(600.0, 0.0, 0.0)
    k_t, k_q = float(still.thrust) / 600.0**2, float(still.torque) / 600.0**2

    def unbalanced(omega: float, signal: float) -> float:
        current = kv * k_q * omega**2 + 0.6
        needed = omega / kv + current * resistance
        power = 4.0 * current * needed + pack.auxiliary_power
        full = float(pack.open_circuit_voltage(np.array(1.0)))
        drawn = (full - np.sqrt(full**2 - 4.0 * pack.resistance * power)) / (2.0 * pack.resistance)
        return float(needed - signal * (full - pack.resistance * drawn))

    def thrust(signal: float) -> float:
        return k_t * brentq(unbalanced, 1.0, 1500.0, args=(signal,)) ** 2

    px4 = by_qgroundcontrol(files["quadcopter_px4.params"])
    ardupilot = by_ap_param(files["quadcopter_ardupilot.param"])
    full = thrust(1.0)
    # Constant coefficients here, those at each Reynolds number there.
    assert px4["CA_ROTOR0_CT"] == pytest.approx(full, rel=0.02)
    f, e = px4["THR_MDL_FAC"], ardupilot["MOT_THST_EXPO"]
    low, most = thrust(0.15), thrust(0.95)
    for x in (0.25, 0.5, 0.75):
        assert f * x**2 + (1.0 - f) * x == pytest.approx(thrust(x) / full, abs=0.05)
        share = (thrust(0.15 + 0.8 * x) - low) / (most - low)
        assert e * x**2 + (1.0 - e) * x == pytest.approx(share, abs=0.04)


def test_what_is_not_known_is_left_out_and_said(tmp_path: Path) -> None:
    craft = aircraft_of(in_px4_order(powertrain=Powertrain()))
    for target in ("px4", "ardupilot"):
        export_autopilot(craft, target, tmp_path, speeds=SPEEDS)
    text = {path.name: path.read_text() for path in tmp_path.iterdir()}
    assert "quadcopter_px4_sih.params" not in text
    px4, ardupilot = text["quadcopter_px4.params"], text["quadcopter_ardupilot.param"]
    assert "THR_MDL_FAC" not in px4 and "_CT" not in px4 and "CA_ROTOR0_KM" in px4
    assert "MOT_" not in ardupilot
    told = "THR_MDL_FAC: the vehicle file has no [motor] and no [battery]."
    assert told in text["README-px4.md"] and "the value is 1" in text["README-px4.md"]
    assert "the value is 0.73 between MOT_SPIN_MIN 0.15" in text["README-ardupilot.md"]


def test_the_simulator_leans_as_the_model_does(aircraft: Aircraft, files: dict[str, str]) -> None:
    """Sih::generate_force_and_torques: linear drag, so that tan(lean) = SIH_KDV V / (m g)."""
    p = by_qgroundcontrol(files["quadcopter_px4_sih.params"])
    assert p["SIH_L_ROLL"] == p["SIH_L_PITCH"] == ARM and p["THR_MDL_FAC"] == 0.0
    weight = p["SIH_MASS"] * G
    within = re.search(r"\*\*SIH_KDV\*\*.*within ([\d.]+) N", files["README-px4.md"])
    assert within
    states = aircraft.steady([3.0, 8.0, 13.0], margin=False)
    needed = weight * np.tan(states.pitch)
    assert np.abs(needed - p["SIH_KDV"] * states.speed).max() < 1.1 * float(within[1])
    # Hover takes the share of the full signal that the thrust margin says.
    hover = aircraft.steady([0.0])
    assert p["SIH_T_MAX"] > hover.thrust[0].max()
    assert p["SIH_Q_MAX"] / p["SIH_T_MAX"] == pytest.approx(
        (hover.torque / hover.thrust).mean(), rel=0.05
    )
    # Its motors have an order of their own.
    other = aircraft_of(in_px4_order(mounts=aircraft.vehicle.mounts[::-1]))
    told = autopilot_parameters(other, "px4", SPEEDS)
    assert [part.suffix for part in told.sets] == ["px4.params"]
    assert "front right" in told.left_out[-1].why


def test_deviations_follow_from_the_constants() -> None:
    """As much as trims with a constant changed say: one of drag, and one of lift, with which the
    rotors turn slower for the same weight."""
    vehicle = in_px4_order(powertrain=Powertrain())
    spreads = {"c_d0": 0.01, "zero_lift_angle": 0.03}
    matrix = np.diag(np.square(list(spreads.values())))
    covariance = SectionCovariance(tuple(spreads), matrix)
    base = propmap.airfoil("paper-apc")
    known = SectionUncertainty(covariance, another_tunnel=False)
    law = base.with_parameters(uncertainty=known)

    def craft(airfoil: propmap.Airfoil) -> Aircraft:
        corrections = propmap.model_corrections("recommended")
        model = propmap.Model(vehicle.propeller, airfoil, vehicle.air, corrections)
        return Aircraft(vehicle, propmap.Rotor(model))

    speeds = np.array([4.0, 10.0])
    flights = inplane_forces(craft(law), "x", speeds)
    for row, (name, spread) in enumerate(spreads.items()):
        moved = base.with_parameters(**{name: getattr(base, name) + 0.2 * spread})
        by_trim = (inplane_forces(craft(moved), "x", speeds).force - flights.force) / 0.2
        assert np.abs(flights.errors[row]) == pytest.approx(np.abs(by_trim), rel=0.1)
    # The rest is the model's own: a tenth of the rotor drag, its thrust as if it were known.
    assert flights.errors.shape[0] == 5
    found = autopilot_parameters(craft(law), "px4", speeds)
    nothing = autopilot_parameters(craft(base), "px4", speeds)
    stds = {kind.title: kind.std for kind in found.sets[0].kinds}
    assert stds["EKF2_MCOEF"] and 0.05 < stds["EKF2_MCOEF"] / 0.1 < 2.0
    assert all(kind.std is None for kind in nothing.sets[0].kinds)


def test_a_map_serves_in_place_of_a_rotor() -> None:
    """One that says nothing of its errors and ends below full throttle."""
    table = LoadTable(invented_content(of=in_px4_order()))
    still = table.loads(600.0, 0.0, 0.0)
    vehicle = in_px4_order(mass=4.0 * float(still.thrust) / G)
    told = autopilot_parameters(Aircraft(vehicle, table), "px4", SPEEDS)
    values = told.sets[0].values
    assert values["CA_ROTOR0_KM"] == pytest.approx(float(still.torque / still.thrust), rel=1e-6)
    assert values["EKF2_MCOEF"] > 0.01
    assert all(kind.std is None for kind in told.sets[0].kinds)
    assert "the table ends at 9549 rpm, and full throttle is" in told.left_out[0].why


def tilted(angle: float, which: slice = slice(None)) -> tuple[Mount, ...]:
    mounts = list(in_px4_order().mounts)
    for k in range(4)[which]:
        mounts[k] = replace(mounts[k], axis=(np.sin(angle), 0.0, np.cos(angle)))
    return tuple(mounts)


PLACES = in_px4_order().mounts
WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "one rotor": ({"mounts": PLACES[:1]}, "has 1 rotor;"),
    "wakes": ({"wakes": Wakes()}, "[wakes] is given"),
    "a wing": ({"wing": Wing(0.2)}, "has a wing"),
    "one above the other": (
        {"mounts": (*PLACES, replace(PLACES[0], position=(ARM, -ARM, -0.05), spin="cw"))},
        "rotors 1 and 5 are above each other",
    ),
    "a pusher": ({"mounts": (*PLACES, Mount((-0.3, 0.0, 0.0), (1.0, 0.0, 0.0)))}, "not upward"),
    "all leaning forward": ({"mounts": tilted(0.1)}, "the rotors' thrust has a component"),
    "one spin for all": (
        {"mounts": tuple(replace(mount, spin="cw") for mount in PLACES)},
        "cannot hover without a moment",
    ),
    "too heavy": ({"mass": 12.0}, "does not hover"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_vehicle_that_the_filters_do_not_know_is_refused(case: str, tmp_path: Path) -> None:
    changes, message = WRONG[case]
    with pytest.raises(InputError, match=re.escape(message)) as caught:
        export_autopilot(aircraft_of(in_px4_order(**changes)), "px4", tmp_path / "to")
    assert "\n" not in str(caught.value) and caught.value.remedy
    assert not (tmp_path / "to").exists()


def test_tilts_that_cancel_are_part_of_the_coefficients() -> None:
    """Front and back rotors leaning towards each other, as on many airframes."""
    front, back = tilted(-0.1), tilted(0.1)
    mounts = (front[0], back[1], front[2], back[3])
    told = autopilot_parameters(aircraft_of(in_px4_order(mounts=mounts)), "px4", SPEEDS)
    assert any("tilted" in remark for remark in told.remarks)
    values = told.sets[0].values
    assert values["CA_ROTOR0_AX"] == pytest.approx(-np.sin(0.1))
    assert values["CA_ROTOR0_AZ"] == pytest.approx(-np.cos(0.1))


def test_speeds_that_are_not_flown_are_named(tmp_path: Path) -> None:
    craft = aircraft_of(in_px4_order(), maximum_rotor_speed=680.0)
    export_autopilot(craft, "px4", tmp_path, speeds=np.array([4.0, 8.0, 30.0]))
    assert (
        "No level flight at 30 m/s: beyond the largest rotor speed."
        in (tmp_path / "README-px4.md").read_text()
    )
    with pytest.raises(InputError, match="give two or more possible speeds"):
        autopilot_parameters(craft, "px4", np.array([30.0, 40.0]))
    with pytest.raises(InputError, match="fewer than two speeds"):
        autopilot_parameters(craft, "px4", np.array([0.0, 5.0]))
    with pytest.raises(InputError, match="no target 'betaflight'; choose one of px4, ardupilot"):
        autopilot_parameters(craft, "betaflight")


# --- PX4's propeller with an advance ratio: airplanes, tailsitters, pushers ----------------------

PUSHER = in_px4_order(
    mounts=(Mount((-0.3, 0.0, 0.0), (1.0, 0.0, 0.0), "cw"),),
    air=propmap.Air(1.1, 1.8e-5),
    wing=Wing(0.2),
)
ANY = (-np.inf, np.inf)
RANGES = {
    **{f"SIH_F_C{x}0": (0.0, np.inf) for x in "TP"},
    **{f"SIH_F_C{x}1": ANY for x in "TP"},
    **{f"SIH_F_C{x}2": (-np.inf, 0.0) for x in "TP"},
    "SIH_F_DIA_INCH": (0.1, np.inf),
    "SIH_F_RPM_MAX": (0.1, np.inf),
    "THR_MDL_FAC": (0.0, 1.0),
}
"""As PX4's sih_params.yaml and motor_params.yaml have them."""


def by_thruster(p: dict[str, float], throttle: float, along: float) -> tuple[float, float]:
    """Thrust and torque as Thruster::compute_thrust_from_throttle and _torque_ have them."""
    diameter, turns = p["SIH_F_DIA_INCH"] * 0.0254, p["SIH_F_RPM_MAX"] * np.sqrt(throttle) / 60.0
    ratio = along / turns / diameter
    powers = np.array([1.0, ratio, ratio**2])
    ct, cp = (max(powers @ [p[f"SIH_F_C{x}{k}"] for k in range(3)], 0.0) for x in "TP")
    force = 1.225 * turns**2 * diameter**4
    return ct * force, cp / 2.0 / np.pi * force * diameter


@pytest.mark.parametrize("vehicle", [PUSHER, replace(PUSHER, wing=None)], ids=["wing", "forward"])
def test_the_simulator_s_propeller_pulls_as_the_rotor_does(
    vehicle: Vehicle, tmp_path: Path
) -> None:
    """In air of 1.225 kg/m^3, within the error that the note states, between its points."""
    craft = aircraft_of(vehicle)
    export_autopilot(craft, "px4", tmp_path)
    names = {"README-px4.md", "quadcopter_px4_sih.params"}
    assert {path.name for path in tmp_path.iterdir()} == names
    note = (tmp_path / "README-px4.md").read_text()
    p = by_qgroundcontrol((tmp_path / "quadcopter_px4_sih.params").read_text())
    assert set(p) == set(RANGES)
    assert all(low <= p[name] <= high for name, (low, high) in RANGES.items())
    assert "kg/m^3 at any height. The vehicle file has 1.1." in note
    stated = r"C_[TP] quadratic.* from 0 to ([\d.]+),.*within ([\d.]+),"
    (limit, thrust_error), (_, power_error) = np.array(re.findall(stated, note), float)
    assert 0.9 < limit < 1.1 and thrust_error < 0.012 and power_error < 0.012
    # The voltage that is left under load turns the motor as fast as the file says.
    omega = p["SIH_F_RPM_MAX"] * RPM
    full = float(craft.loads.loads(omega, 0.0, 0.0).torque)
    state = POWERTRAIN.driven(np.array([[full]]), np.array([[omega]]), 1.0)
    assert state.controller_voltage[0, 0] == pytest.approx(state.battery_voltage[0], rel=1e-3)
    rng, diameter = np.random.default_rng(26720), 2.0 * vehicle.propeller.radius
    for throttle, ratio in rng.uniform([0.25, 0.0], [1.0, 0.9 * limit], (50, 2)):
        turns = p["SIH_F_RPM_MAX"] * np.sqrt(throttle) / 60.0
        along = ratio * turns * diameter
        loads = craft.loads.loads(2.0 * np.pi * turns, along, 0.0)
        thrust, torque = by_thruster(p, throttle, along)
        force = 1.225 * turns**2 * diameter**4
        # Between the note's figures, which are rounded to 1e-4.
        apart = (thrust - loads.thrust * 1.225 / 1.1) / force
        assert abs(apart) < thrust_error + 1e-3
        apart = 2.0 * np.pi * (torque - loads.torque * 1.225 / 1.1) / (force * diameter)
        assert abs(apart) < power_error + 1e-3


def test_a_rising_parabola_becomes_a_falling_line() -> None:
    """PX4 takes no constant of C_T above zero for J^2."""
    content = invented_content(of=PUSHER)
    content.coefficients[:, 0] += 0.17 * (content.advance[:, None] * np.cos(content.beta)) ** 2
    slow = Powertrain(Motor(400.0 * RPM, 0.1, (0.3,)), None, Battery(4, 18000.0))
    craft = Aircraft(replace(PUSHER, powertrain=slow), LoadTable(content))
    (found,) = autopilot_parameters(craft, "px4").sets
    assert found.values["SIH_F_CT2"] == 0.0 and found.values["SIH_F_CT1"] < 0.0


def test_a_tailsitter_s_curve_that_is_no_quadratic_is_said() -> None:
    vehicle = read_vehicle(Path(__file__).parents[2] / "examples/aircraft/tailsitter.toml").vehicle
    rotor = propmap.Rotor(propmap.catalogue_model("apc-8x6e", air=vehicle.air))
    told = autopilot_parameters(Aircraft(vehicle, rotor), "px4")
    assert any("C_P is not quadratic in J" in remark for remark in told.remarks)
    assert "SIH_L_ROLL" in {left.name for left in told.left_out}
    # Beside what PX4's airframe 10043 has for UIUC's APC 8x6: 0.131 + 0.004 J - 0.146 J^2.
    values = told.sets[0].values
    ratio = np.linspace(0.2, 0.8, 20)
    ours = values["SIH_F_CT0"] + values["SIH_F_CT1"] * ratio + values["SIH_F_CT2"] * ratio**2
    assert np.abs(ours - (0.131 + 0.004 * ratio - 0.146 * ratio**2)).max() < 0.02


def test_a_propeller_without_full_throttle_or_thrust_is_refused() -> None:
    with pytest.raises(InputError, match=r"no \[motor\] and no \[battery\].*full throttle"):
        autopilot_parameters(aircraft_of(replace(PUSHER, powertrain=Powertrain())), "px4")
    with pytest.raises(
        InputError, match="but from a vehicle with 3 or more rotors; choose one of px4"
    ):
        autopilot_parameters(aircraft_of(PUSHER), "ardupilot")
    backwards = replace(PUSHER.propeller, twist=-PUSHER.propeller.twist)
    with pytest.raises(InputError, match="slow axial flow; check the propeller"):
        autopilot_parameters(aircraft_of(replace(PUSHER, propeller=backwards)), "px4")
