"""Multinomial, Gazebo's motor model, RotorPy's rotor: the fits, the files, what they cost."""

from __future__ import annotations

import re
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.export import export_table
from propmap.export.files import SIMPLE, errors, sample
from propmap.export.simple_models import (
    fit_motor_model,
    fit_multinomial,
    fit_rotor,
    multinomial_loads,
)
from propmap.loads import LOADS
from propmap.table import LoadTable

from .compiled import FLAGS
from .conftest import RADIUS, Module, invented_content
from .needed import package, program

RHO = 1.2


def test_the_multinomial_recovers_what_is_one(invented: LoadTable) -> None:
    fitted = fit_multinomial(sample(invented), RHO)
    force = np.pi * RADIUS**4
    arm = np.array([1.0, 1.0 / RADIUS, 1.0 / RADIUS**2, 1.0 / RADIUS**2])
    # The table interpolates cubics in J and beta: not exactly a polynomial in lambda_c and mu.
    assert np.array(fitted["thrust"]) == pytest.approx(
        force * np.array([0.016, -0.08, -0.05, 0.02]) * arm, rel=1e-3
    )
    assert np.array(fitted["torque"]) == pytest.approx(
        force * RADIUS * np.array([0.0025, -0.002, -0.003, 0.001]) * arm, rel=1e-3
    )
    assert np.array(fitted["drag"]) == pytest.approx(
        force * np.array([0.006, 0.01]) * arm[1:3], rel=1e-3
    )
    assert np.array(fitted["roll_moment"]) == pytest.approx(
        force * RADIUS * np.array([0.004, -0.002]) * arm[1:3], rel=1e-3
    )


def test_the_multinomial_module_gives_the_fitted_loads(table: LoadTable, module: Module) -> None:
    written = module(table, "multinomial")
    samples = sample(table)
    fitted = fit_multinomial(samples, table.content.density)
    loads = multinomial_loads(fitted, samples, table.content.density)
    x, y = 0.6 * samples.inplane, 0.8 * samples.inplane
    force = np.stack(written.force(samples.omega, x, y, samples.axial, 1.0))
    moment = np.stack(written.moment(samples.omega, x, y, samples.axial, 1.0))
    thrust, drag, torque, roll = (loads[n] for n in ("thrust", "drag", "torque", "roll_moment"))
    expected = np.stack([-0.6 * drag, -0.8 * drag, thrust])
    np.testing.assert_allclose(force, expected, rtol=1e-12, atol=1e-15)
    turning = np.stack([-0.6 * roll, -0.8 * roll, -torque])
    np.testing.assert_allclose(moment, turning, rtol=1e-12, atol=1e-15)
    other = np.stack(written.moment(samples.omega, x, y, samples.axial, -1.0))
    np.testing.assert_array_equal(other, -moment)
    np.testing.assert_allclose(
        written.thrust(samples.omega, x, y, samples.axial, 2.0 * written.RHO), 2.0 * force[2]
    )


def test_casadi_evaluates_the_multinomial_and_its_gradient(
    table: LoadTable, module: Module
) -> None:
    casadi = package("casadi")
    written = module(table, "multinomial")
    symbols = casadi.SX.sym("omega_x_y_z", 4)
    outputs = casadi.vertcat(
        *written.force(*casadi.vertsplit(symbols), -1),
        *written.moment(*casadi.vertsplit(symbols), -1),
    )
    both = casadi.Function("both", [symbols], [outputs, casadi.jacobian(outputs, symbols)])
    # At rest across the axis too, where the drag's length would have no derivative.
    for point in (np.array([500.0, 2.0, -1.0, 1.5]), np.array([600.0, 0.0, 0.0, 0.5])):
        value, slopes = (np.asarray(m) for m in both(point))

        def wrench(p: np.ndarray) -> np.ndarray:
            return np.array([*written.force(*p, -1), *written.moment(*p, -1)])

        np.testing.assert_allclose(value[:, 0], wrench(point), rtol=1e-12, atol=1e-15)
        step = 1e-3 * np.eye(4)
        # A central difference is exact for a quadratic.
        central = np.stack([(wrench(point + s) - wrench(point - s)) / 2e-3 for s in step], axis=1)
        np.testing.assert_allclose(slopes, central, rtol=1e-7, atol=1e-10)


def test_the_multinomial_in_c(table: LoadTable, module: Module, tmp_path: Path) -> None:
    gcc = program("gcc")
    written = module(table, "multinomial")
    p = "apc_8x6e_multinomial_"
    (tmp_path / "multinomial" / "main.c").write_text(f"""
#include "apc_8x6e_multinomial.h"
#include <stdio.h>
int main(void)
{{
    printf("%.17g %.17g %.17g %.17g\\n", {p}thrust(1.1, 500, 2, 1, 3), {p}torque(1.1, 500, 2, 1, 3),
           {p}drag_slope(1.1, 500, 3), {p}roll_slope(1.1, 500, 3));
    return 0;
}}
""")
    folder = tmp_path / "multinomial"
    subprocess.run([gcc, *FLAGS, "main.c", "-o", "main"], cwd=folder, check=True)
    found = subprocess.run([folder / "main"], capture_output=True, text=True, check=True).stdout
    expected = [
        written.thrust(500.0, 2.0, 1.0, 3.0, 1.1),
        written.torque(500.0, 2.0, 1.0, 3.0, 1.1),
        written.drag_slope(500.0, 3.0, 1.1),
        written.roll_slope(500.0, 3.0, 1.1),
    ]
    np.testing.assert_allclose([float(word) for word in found.split()], expected, rtol=1e-13)


def test_the_sdf_gives_the_motor_model(table: LoadTable, tmp_path: Path) -> None:
    path, _ = export_table(table, "gazebo", tmp_path)
    elements = ET.fromstring(f"<plugin>{path.read_text()}</plugin>")
    value = {element.tag: float(element.text or "") for element in elements}
    samples = sample(table)
    omega, inplane = samples.omega, samples.inplane
    # The plugin's own formulas.
    thrust = value["motorConstant"] * omega * abs(omega)
    drag = abs(omega) * value["rotorDragCoefficient"] * inplane
    torque = thrust * value["momentConstant"]
    roll = abs(omega) * value["rollingMomentCoefficient"] * inplane
    found = {"thrust": thrust, "drag": drag, "torque": torque, "roll_moment": roll}
    fitted = fit_motor_model(table, samples).loads(omega, inplane)
    assert set(fitted) == set(found)
    for name, values in fitted.items():
        np.testing.assert_allclose(found[name], values, rtol=1e-8)
    assert value["maxRotVelocity"] == pytest.approx(table.envelope["omega"][1])
    still = table.loads(600.0, 0.0, 0.0)
    # In hover; the Reynolds number moves the torque.
    assert value["motorConstant"] * 600.0**2 == pytest.approx(still.thrust, rel=0.01)
    assert value["momentConstant"] * still.thrust == pytest.approx(still.torque, rel=0.03)
    edgewise = table.loads(600.0, 3.0, np.pi / 2)
    assert value["rotorDragCoefficient"] * 1800.0 == pytest.approx(edgewise.drag, rel=0.1)
    assert value["rollingMomentCoefficient"] * 1800.0 == pytest.approx(
        edgewise.roll_moment, rel=0.1
    )


def test_rotorpy_gives_the_loads_of_the_fit(table: LoadTable, module: Module) -> None:
    multirotor = package("rotorpy.vehicles.multirotor")
    parameters = module(table, "rotorpy").rotor_params
    vehicle = multirotor.Multirotor({**_frame(), **parameters})
    fitted = fit_rotor(table, sample(table))
    for velocity in ([0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, 1.0, 1.5], [1.0, -2.0, 0.5]):
        force, moment = vehicle.compute_body_wrench(
            np.zeros(3), np.full(4, 600.0), np.array(velocity)
        )
        x, y, z = velocity
        inplane = np.hypot(x, y)
        loads = fitted.loads(*np.array([[600.0], [z], [inplane]]))
        thrust, drag = float(loads["thrust"][0]), float(loads["drag"][0])
        unit = np.array([x, y]) / max(inplane, 1e-9)
        np.testing.assert_allclose(force, 4.0 * np.array([*(-drag * unit), thrust]), atol=1e-12)
        assert moment[2] == pytest.approx(0.0, abs=1e-12)
        assert thrust == pytest.approx(_table_thrust(table, velocity), rel=0.1)


def test_rotorpy_flies_the_exported_vehicle(table: LoadTable, module: Module) -> None:
    multirotor = package("rotorpy.vehicles.multirotor")
    control = package("rotorpy.controllers.quadrotor_control")
    parameters = {**_frame(), **module(table, "rotorpy").rotor_params}
    hover = float(np.sqrt(parameters["mass"] * 9.81 / 4.0 / parameters["k_eta"]))
    low, high = table.envelope["omega"]
    assert low < hover < high
    state = {
        "x": np.array([0.3, -0.2, 0.1]),
        "v": np.zeros(3),
        "q": np.array([0.0, 0.0, 0.0, 1.0]),
        "w": np.zeros(3),
        "wind": np.array([1.0, 0.0, 0.0]),
        "rotor_speeds": np.full(4, hover),
    }
    vehicle = multirotor.Multirotor(parameters, initial_state=state)
    controller = control.SE3Control(parameters)
    wanted = {name: np.zeros(3) for name in ("x", "x_dot", "x_ddot", "x_dddot", "x_ddddot")}
    wanted |= {"yaw": 0.0, "yaw_dot": 0.0, "yaw_ddot": 0.0}
    for k in range(600):
        state = vehicle.step(state, controller.update(0.01 * k, state, wanted), 0.01)
    # It holds its place against the wind, up to the lean that the drag asks for.
    assert np.linalg.norm(state["x"]) < 0.2
    assert np.linalg.norm(state["v"]) < 0.02
    assert state["rotor_speeds"] == pytest.approx(np.full(4, hover), rel=0.03)
    force, _ = vehicle.compute_body_wrench(
        np.zeros(3), state["rotor_speeds"], np.array([-1.0, 0.0, 0.0])
    )
    assert force[0] > 0.0


@pytest.mark.parametrize("target", ["multinomial", "gazebo", "rotorpy", "jsbsim"])
def test_the_note_tells_the_errors(table: LoadTable, tmp_path: Path, target: str) -> None:
    paths = export_table(table, target, tmp_path)
    text = paths[-1].read_text()
    assert paths[-1].name == f"README-{target}.txt"
    assert SIMPLE in text and "the table's whole envelope" in text
    rows = re.findall(r"^  (\w+) +([0-9.]+)% +([0-9.]+)%$", text, re.M)
    assert [row[0] for row in rows] == 2 * list(LOADS)
    assert all(float(rms) <= float(worst) for _, rms, worst in rows)
    for stated in ("apc-8x6e", "paper-apc", "1.225 kg/m^3", "SHA-256", "propmap 1."):
        assert stated in text


def test_errors_are_shares_of_static_loads(invented: LoadTable) -> None:
    samples = sample(invented)
    wrong = dict.fromkeys(LOADS, 0.0) | {"thrust": 0.01, "drag": -0.02, "torque": 0.03}
    off = {n: samples.loads[n] + share * samples.static[n] for n, share in wrong.items()}
    for found in errors(samples, off):
        sizes = np.abs(list(wrong.values()))
        assert found.rms == pytest.approx(sizes)
        assert found.worst == pytest.approx(sizes)
    still = invented.loads(samples.omega, 0.0, 0.0)
    assert samples.static["roll_moment"] == pytest.approx(np.asarray(still.thrust) * RADIUS)


@pytest.mark.parametrize("target", ["multinomial", "gazebo", "rotorpy", "jsbsim"])
def test_a_table_without_hover_is_refused(tmp_path: Path, target: str) -> None:
    fast = LoadTable(invented_content(speed=2.0))
    # The advance axis still begins at zero; the envelope does not.
    with pytest.raises(InputError, match=r"begins at 2 m/s.*--speed 0:"):
        export_table(fast, target, tmp_path / "to")
    assert list(tmp_path.iterdir()) == []


def test_a_map_of_vortex_rings_is_refused(tmp_path: Path) -> None:
    content = invented_content(beta=(3.0, np.pi))
    content.cells[:] = 1
    with pytest.raises(InputError, match="no points with lambda_c"):
        export_table(LoadTable(content), "gazebo", tmp_path)


def _table_thrust(table: LoadTable, velocity: list[float]) -> float:
    return float(table.loads_at_velocity(600.0, velocity).thrust)


def _frame() -> dict[str, object]:
    """What RotorPy wants to know of a vehicle besides its rotors."""
    arm = 0.15
    corners = [(1, 1), (1, -1), (-1, -1), (-1, 1)]
    return {
        "mass": 0.9,
        "Ixx": 4e-3,
        "Iyy": 4e-3,
        "Izz": 7e-3,
        "Ixy": 0.0,
        "Ixz": 0.0,
        "Iyz": 0.0,
        "num_rotors": 4,
        "rotor_pos": {f"r{k}": arm * np.array([*c, 0.0]) for k, c in enumerate(corners, 1)},
        "rotor_directions": np.array([1, -1, 1, -1]),
        "c_Dx": 0.0,
        "c_Dy": 0.0,
        "c_Dz": 0.0,
        "tau_m": 0.02,
    }
