"""Every export's force and moment on the hub are those of ``Rotor.wrench``, for both spins."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.export import export_table
from propmap.table import LoadTable

from .compiled import FLAGS
from .conftest import RADIUS, Module
from .needed import package, program
from .test_jsbsim import (
    AIRCRAFT,
    KG_M3_PER_SLUG_FT3,
    METERS_PER_FOOT,
    MOTOR,
    NEWTONS_PER_POUND,
)

EXAMPLE = Path(__file__).parents[2] / "examples" / "c" / "inflow.c"

Both = tuple[propmap.Rotor, LoadTable]

SPINS = {"ccw": 1, "cw": -1}
OMEGA = 600.0
VELOCITIES = np.array([[4.0, 2.0, 1.0], [-3.0, 3.5, 0.5], [1.0, -4.5, 2.0], [-5.0, -0.5, 0.3]])
"""Towards every quarter of the disk, within the envelope."""

CALLER = """
#include "{name}.h"
void wrench(int n, const double *a, double *to)
{{
    int i, k;
    for (i = 0; i < n; ++i, a += 6, to += 15) {{
        const {name}_wrench_t w = {name}_wrench(a[0], a[1], a[2], a[3], (int)a[4]);
        const {name}_wrench_t v = {name}_wrench_in_inflow(a[5], a[0], a[1], a[2], a[3], (int)a[4]);
        const {name}_inflow_t steady = {name}_inflow(a[0], a[1], a[2], a[3]);
        for (k = 0; k < 3; ++k) {{
            to[k] = w.force[k];
            to[3 + k] = w.moment[k];
            to[6 + k] = v.force[k];
            to[9 + k] = v.moment[k];
        }}
        to[12] = steady.steady;
        to[13] = steady.time_constant;
        to[14] = {name}_inflow_step(a[5], 1e-3, a[0], a[1], a[2], a[3]);
    }}
}}
"""


def expected(rotor: propmap.Rotor, velocity: np.ndarray, spin: str) -> np.ndarray:
    """Force and moment (n, 6), with all six loads at work."""
    found = rotor.wrench(OMEGA, velocity, spin)
    loads = rotor.loads_at_velocity(OMEGA, velocity)
    assert (loads.pitch_moment > 1e-4).all() and (abs(loads.side_force) > 1e-3).all()
    return np.concatenate([found.force, found.moment], axis=-1)


def share(got: np.ndarray, want: np.ndarray) -> np.ndarray:
    """Errors over thrust and thrust times radius."""
    scale = want[..., 2:3] * np.array([1.0, 1.0, 1.0, RADIUS, RADIUS, RADIUS])
    return np.asarray(abs(got - want) / scale)


def in_c(table: LoadTable, folder: Path, asked: np.ndarray) -> np.ndarray:
    """What the header gives at omega, velocity, spin and inflow (n, 6): (n, 15)."""
    (header, _) = export_table(table, "c", folder)
    (folder / "caller.c").write_text(CALLER.format(name=header.stem))
    command = [program("gcc"), *FLAGS, "-fPIC", "-shared", "caller.c", "-o", "caller.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    given, found = np.ascontiguousarray(asked), np.empty((len(asked), 15))
    library = ctypes.CDLL(str(folder / "caller.so"))
    library.wrench(len(asked), *(ctypes.c_void_p(a.ctypes.data) for a in (given, found)))
    return found


@pytest.mark.parametrize("spin", SPINS)
def test_the_c_header(oblique: Both, tmp_path: Path, spin: str) -> None:
    rotor, table = oblique
    rows = [[OMEGA, *velocity, SPINS[spin], 0.0] for velocity in VELOCITIES]
    found = in_c(table, tmp_path / "c", np.array(rows))[:, :6]
    assert share(found, expected(rotor, VELOCITIES, spin)).max() < 0.003  # the table's tolerance


def test_the_inflow_in_c_follows_that_of_the_model(oblique: Both, tmp_path: Path) -> None:
    """In a table each annulus has settled, with its stall, so that thrust seems to depend less on
    the inflow: the change of thrust is up to 40 % too small."""
    rotor, table = oblique
    dynamic = propmap.DynamicInflow(rotor)
    velocity = np.vstack([VELOCITIES, [[0.0, 0.0, 0.0], [0.0, 0.0, 5.0]]])
    steady = dynamic.steady(OMEGA, velocity)
    for missing in (1.0, -1.5):
        rows = np.column_stack([0.0 * steady[:, :1] + OMEGA, velocity, 1.0 + 0.0 * steady[:, :1]])
        first = in_c(table, tmp_path / f"first{missing}", np.column_stack([rows, steady[:, 0]]))
        np.testing.assert_allclose(first[:, 12], steady[:, 0], rtol=0.06)
        times = dynamic.time_constants(OMEGA, velocity)[:, 0]
        np.testing.assert_allclose(first[:, 13], times, rtol=0.15)
        begin = first[:, 12] - missing
        found = in_c(table, tmp_path / f"then{missing}", np.column_stack([rows, begin]))
        there = steady - np.array([missing, 0.0, 0.0])
        want = dynamic.step(there, 1e-3, OMEGA, velocity)[:, 0] - steady[:, 0]
        np.testing.assert_allclose(found[:, 14] - first[:, 12], want, atol=0.05 * abs(missing))
        thrust = dynamic.loads(there, OMEGA, velocity).thrust
        change = thrust - rotor.loads_at_velocity(OMEGA, velocity).thrust
        assert (np.sign(change) == np.sign(missing)).all()
        ratio = (found[:, 8] - found[:, 2]) / change
        assert (ratio > 0.6).all() and (ratio < 1.05).all()
        # The steady inflow changes nothing.
        own = in_c(table, tmp_path / f"own{missing}", np.column_stack([rows, first[:, 12]]))
        np.testing.assert_allclose(own[:, 6:12], own[:, :6], rtol=1e-9, atol=1e-12)


def test_the_inflow_in_c_decays_for_any_step(oblique: Both, tmp_path: Path) -> None:
    """By its closed form: the deviation falls, from any state, and never changes its sign."""
    _, table = oblique
    random = np.random.default_rng(3)
    velocity = np.abs(random.uniform(-3.0, 3.0, (200, 3)))
    rows = np.column_stack([random.uniform(450.0, 750.0, 200), velocity, np.ones(200)])
    state = random.uniform(-10.0, 20.0, 200)
    found = in_c(table, tmp_path / "c", np.column_stack([rows, state]))
    before, after = state - found[:, 12], found[:, 14] - found[:, 12]
    assert (before * after > 0.0).all() and (abs(after) < abs(before)).all()
    # Near the steady state, the exponential of the time constant.
    near = in_c(table, tmp_path / "near", np.column_stack([rows, found[:, 12] + 1e-4]))
    want = 1e-4 * np.exp(-1e-3 / found[:, 13])
    np.testing.assert_allclose(near[:, 14] - near[:, 12], want, rtol=1e-3)
    # Those parts of its rate that are known: without blades 3 pi/4 times 2 v over R.
    hover = np.column_stack([600.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    v, time = in_c(table, tmp_path / "hover", hover)[0, 12:14]
    thrust = float(table.loads(600.0, 0.0, 0.0).thrust)
    radius, density = table.content.radius, table.content.density
    assert v == pytest.approx(np.sqrt(thrust / (2.0 * density * np.pi * radius**2)), rel=1e-9)
    assert 0.5 < time * 1.5 * np.pi * v / radius < 1.0


@pytest.mark.parametrize("spin", SPINS)
def test_the_multinomial(oblique: Both, module: Module, tmp_path: Path, spin: str) -> None:
    rotor, table = oblique
    written = module(table, "multinomial")
    at = (OMEGA, *VELOCITIES.T)
    found = np.stack([*written.force(*at, SPINS[spin]), *written.moment(*at, SPINS[spin])], axis=-1)
    want = expected(rotor, VELOCITIES, spin)
    # A quadratic in the velocity; the loads across come within a quarter of themselves.
    error = share(found, want)
    assert error[:, [2, 5]].max() < 0.03 and error[:, [0, 1, 3, 4]].max() < 0.004
    (tmp_path / "multinomial" / "main.c").write_text(f"""
#include "apc_8x6e_multinomial.h"
#include <stdio.h>
int main(void)
{{
    double f[3], m[3];
    apc_8x6e_multinomial_wrench({written.RHO}, 600, 4, 2, 1, {SPINS[spin]}, f, m);
    printf("%.17g %.17g %.17g %.17g %.17g %.17g\\n", f[0], f[1], f[2], m[0], m[1], m[2]);
    return 0;
}}
""")
    folder = tmp_path / "multinomial"
    command = [program("gcc"), *FLAGS, "main.c", "-o", "main"]
    subprocess.run(command, cwd=folder, check=True)
    text = subprocess.run([folder / "main"], capture_output=True, text=True, check=True).stdout
    np.testing.assert_allclose([float(word) for word in text.split()], found[0], rtol=1e-12)


@pytest.mark.parametrize("spin", SPINS)
def test_rotorpy(oblique: Both, module: Module, spin: str) -> None:
    """With the mix-in, all six; without it, RotorPy has neither side force nor rolling moment."""
    multirotor = package("rotorpy.vehicles.multirotor")
    rotor, table = oblique
    written = module(table, "rotorpy")

    class Vehicle(written.HubWrench, multirotor.Multirotor):  # type: ignore[name-defined,misc]
        pass

    places = 0.2 * np.array(
        [[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, -1.0, 0.0], [-1.0, 1.0, 0.0]]
    )
    spins = np.array([1, -1, 1, -1])
    parameters = {
        **dict.fromkeys(("mass", "Ixx", "Iyy", "Izz"), 0.01),
        **dict.fromkeys(("Ixy", "Ixz", "Iyz", "c_Dx", "c_Dy", "c_Dz"), 0.0),
        "num_rotors": 4,
        "rotor_pos": {f"r{k}": place for k, place in enumerate(places, 1)},
        "rotor_directions": -spins,  # of the torque on the body
        "tau_m": 0.02,
        **written.rotor_params,
    }
    vehicle, plain = Vehicle(parameters), multirotor.Multirotor(parameters)
    turning = np.array([0.5, -0.3, 2.0])
    # Two rotors of one spin at opposite places, which leave no moment of their forces' arms.
    speeds = np.where(spins == SPINS[spin], OMEGA, 0.0)
    for velocity, target in zip(VELOCITIES, expected(rotor, VELOCITIES, spin), strict=True):
        lift = parameters["k_h"] * (velocity[0] ** 2 + velocity[1] ** 2)  # at any speed of a rotor
        for one, is_all in ((vehicle, True), (plain, False)):
            found = np.concatenate(one.compute_body_wrench(np.zeros(3), speeds, velocity)) / 2.0
            found[2] -= lift
            error = share(found, target)
            assert error[[2, 5]].max() < 0.06
            assert (error[[0, 1, 3, 4]].max() < 0.012) == is_all
    # A vehicle that turns: each hub has a velocity of its own, and its forces an arm.
    velocity, want = VELOCITIES[0], np.zeros(6)
    for place, sign in zip(places, spins, strict=True):
        hub = velocity + np.cross(turning, place)
        wrench = rotor.wrench(OMEGA, hub, "ccw" if sign > 0 else "cw")
        want[:3] += wrench.force
        want[3:] += wrench.moment + np.cross(place, wrench.force)
    found = np.concatenate(vehicle.compute_body_wrench(turning, np.full(4, OMEGA), velocity))
    np.testing.assert_allclose(found[:2], want[:2], atol=0.004 * want[2])
    np.testing.assert_allclose(found[3:], want[3:], atol=0.006 * want[2] * 0.2)


@pytest.mark.parametrize("spin", SPINS)
def test_gazebo_has_four_of_six(oblique: Both, tmp_path: Path, spin: str) -> None:
    """By the plugin's formulas; what is missing are the side force and the pitching moment."""
    rotor, table = oblique
    path, note = export_table(table, "gazebo", tmp_path)
    elements = ET.fromstring(f"<plugin>{path.read_text()}</plugin>")
    value = {element.tag: float(element.text or "") for element in elements}
    sign = SPINS[spin]  # turningDirection
    across = VELOCITIES * [1.0, 1.0, 0.0]
    thrust = value["motorConstant"] * OMEGA**2
    force = -OMEGA * value["rotorDragCoefficient"] * across + [0.0, 0.0, thrust]
    # PX4's plugin turns the rolling moment with the direction; the note says what others need.
    moment = -sign * OMEGA * value["rollingMomentCoefficient"] * across
    moment = moment - [0.0, 0.0, sign * value["momentConstant"] * thrust]
    want = expected(rotor, VELOCITIES, spin)
    loads = rotor.loads_at_velocity(OMEGA, VELOCITIES)
    z, length = np.array([0.0, 0.0, 1.0]), np.hypot(*VELOCITIES.T[:2])
    left = np.cross(z, across / length[:, None])
    lost = np.concatenate(
        [sign * loads.side_force[:, None] * left, -loads.pitch_moment[:, None] * left], axis=-1
    )
    error = share(np.concatenate([force, moment], axis=-1), want - lost)
    assert error[:, [0, 1, 3, 4]].max() < 0.006 and error[:, 2].max() < 0.3
    assert "no side force and no pitching moment" in " ".join(note.read_text().split())


@pytest.mark.parametrize("spin", SPINS)
def test_jsbsim(oblique: Both, tmp_path: Path, spin: str) -> None:
    jsbsim = package("jsbsim")
    rotor, table = oblique
    export_table(table, "jsbsim", tmp_path / "engine")
    (tmp_path / "engine" / "motor.xml").write_text(MOTOR.format(watts=20.0))
    stand = tmp_path / "aircraft" / "stand"
    stand.mkdir(parents=True)
    (tmp_path / "engine" / "apc_8x6e_reactions.xml").rename(stand / "apc_8x6e_reactions.xml")
    text = AIRCRAFT.replace("<sense> 1 </sense>", f"<sense> {SPINS[spin]} </sense>")
    text = text.replace(
        "</fdm_config>", '<external_reactions file="apc_8x6e_reactions"/></fdm_config>'
    )
    (stand / "stand.xml").write_text(text)
    jsbsim.FGJSBBase().debug_lvl = 0
    simulation = jsbsim.FGFDMExec(str(tmp_path))
    simulation.load_model("stand")
    simulation["propmap/apc_8x6e-sense"] = SPINS[spin]
    for name in ("rate/rotational", "rate/translational", "position/rotational",
                 "position/translational"):  # fmt: skip
        simulation[f"simulation/integrator/{name}"] = 0
    simulation["ic/h-sl-ft"] = 100.0
    # The rotor's x, y and z are the body's y, z and x.
    velocity = np.array([3.0, -2.0, 1.0])
    for name, speed in zip("vwu", velocity, strict=True):
        simulation[f"ic/{name}-fps"] = speed / METERS_PER_FOOT
    simulation.run_ic()
    simulation["propulsion/engine/set-running"] = 1
    simulation["fcs/throttle-cmd-norm"] = 1.0
    simulation.set_dt(0.002)
    for _ in range(5000):
        simulation.run()
    aero = [simulation[f"velocities/{name}-aero-fps"] * METERS_PER_FOOT for name in "vwu"]
    assert aero == pytest.approx(velocity, abs=0.01)
    omega = simulation["propulsion/engine/propeller-rpm"] * np.pi / 30.0
    density = simulation["atmosphere/rho-slugs_ft3"] * KG_M3_PER_SLUG_FT3 / table.content.density
    force, moment = (
        np.array([sum(simulation[f"{kind}-{part}-{unit}"] for part in ("prop", "external"))
                  for kind in axes])
        for axes, unit in (
            (("forces/fby", "forces/fbz", "forces/fbx"), "lbs"),
            (("moments/m", "moments/n", "moments/l"), "lbsft"),
        )
    )  # fmt: skip
    found = np.concatenate([force, moment * METERS_PER_FOOT]) * NEWTONS_PER_POUND / density
    wrench = rotor.wrench(omega, velocity, spin)
    want = np.concatenate([wrench.force, wrench.moment])
    error = share(found, want)
    assert error[[0, 1, 3, 4]].max() < 0.004
    assert error[2] < 0.1 and error[5] < 0.03  # of axial flow
    assert np.sign(found[5]) == -SPINS[spin]


def test_the_example_of_the_inflow_in_c(oblique: Both, tmp_path: Path) -> None:
    _, table = oblique
    export_table(table, "c", tmp_path)
    shutil.copy(EXAMPLE, tmp_path)
    command = [program("gcc"), *FLAGS, EXAMPLE.name, "-o", "inflow", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    text = subprocess.run([tmp_path / "inflow"], capture_output=True, text=True, check=True).stdout
    time_constant = float(re.findall(r"time constant (\S+) ms", text)[0])
    inflow, thrust = np.array(re.findall(r"inflow (\S+) m/s, thrust (\S+) N", text), float).T
    # The last line is the steady one, which the others near from one side.
    assert (np.diff(inflow[:-1]) > 0.0).all() and (np.diff(thrust[:-1]) < 0.0).all()
    assert thrust[0] > 1.05 * thrust[-1]
    left = (inflow[-1] - inflow[:-1]) / (inflow[-1] - inflow[0])
    assert left[10] == pytest.approx(np.exp(-10.0 / time_constant), abs=0.02)
