"""Multinomial, RotorPy, JSBSim: fits, files, their errors, and wrenches on the hub."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.export import export_table
from propmap.export.files import SIMPLE, errors, sample
from propmap.export.simple_models import axial_error, coefficients, fit_multinomial
from propmap.loads import LOADS
from propmap.table import LoadTable

from .compiled import printed
from .conftest import (
    OMEGA,
    RADIUS,
    SPINS,
    VELOCITIES,
    Both,
    Module,
    frame,
    hub_wrench,
    invented_content,
    share,
)
from .needed import package

RHO = 1.2


def test_the_multinomial_recovers_what_is_one(invented: LoadTable) -> None:
    fitted = fit_multinomial(sample(invented), RHO)
    force = np.pi * RADIUS**4
    arm = np.array([1.0, 1.0 / RADIUS, 1.0 / RADIUS**2, 1.0 / RADIUS**2])
    known = {
        "thrust": force * np.array([0.016, -0.08, -0.05, 0.02]) * arm,
        "torque": force * RADIUS * np.array([0.0025, -0.002, -0.003, 0.001]) * arm,
        "drag": force * np.array([0.006, 0.01]) * arm[1:3],
        "roll_moment": force * RADIUS * np.array([0.004, -0.002]) * arm[1:3],
    }
    for name, constants in known.items():
        # The table interpolates cubics in J and beta: not exactly a polynomial in lambda_c and mu.
        assert np.array(fitted[name]) == pytest.approx(constants, rel=1e-3), name


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


@pytest.mark.parametrize("target", ["multinomial", "rotorpy", "jsbsim"])
def test_the_note_tells_the_errors(table: LoadTable, tmp_path: Path, target: str) -> None:
    text = export_table(table, target, tmp_path)[-1].read_text()
    rows = re.findall(r"^  (\w+) +([0-9.]+)% +([0-9.]+)%$", text, re.M)
    assert [row[0] for row in rows] == 2 * list(LOADS)
    assert all(float(rms) <= float(worst) for _, rms, worst in rows)
    for stated in (SIMPLE, "apc-8x6e", "paper-apc", "1.225 kg/m^3", "SHA-256", "propmap 1."):
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


def test_maps_without_climb_or_axial_flight_are_refused(tmp_path: Path) -> None:
    content = invented_content(beta=(3.0, np.pi))
    content.cells[:] = 1
    with pytest.raises(InputError, match="no points with axial speed"):
        export_table(LoadTable(content), "gazebo", tmp_path)
    table = LoadTable(invented_content(beta=(0.5, np.pi)))
    with pytest.raises(InputError, match=r"begins at 28\.6.* deg.*--beta 0:"):
        export_table(table, "jsbsim", tmp_path)


# --- JSBSim on a stand ---------------------------------------------------------------------------

NEWTONS_PER_POUND = 4.4482216152605
METERS_PER_FOOT = 0.3048
KG_M3_PER_SLUG_FT3 = 515.378818

AIRCRAFT = """<?xml version="1.0"?>
<fdm_config name="stand" version="2.0">
  <metrics>
    <wingarea unit="M2"> 0.01 </wingarea> <wingspan unit="M"> 0.1 </wingspan>
    <chord unit="M"> 0.1 </chord>
    <location name="AERORP" unit="M"> <x> 0 </x> <y> 0 </y> <z> 0 </z> </location>
  </metrics>
  <mass_balance>
    <ixx unit="KG*M2"> 1 </ixx> <iyy unit="KG*M2"> 1 </iyy> <izz unit="KG*M2"> 1 </izz>
    <emptywt unit="KG"> 1 </emptywt>
    <location name="CG" unit="M"> <x> 0 </x> <y> 0 </y> <z> 0 </z> </location>
  </mass_balance>
  <ground_reactions/>
  <propulsion>
    <engine file="motor">
      <thruster file="apc_8x6e">
        <location unit="M"> <x> 0 </x> <y> 0 </y> <z> 0 </z> </location>
        <orient unit="DEG"> <roll> 0 </roll> <pitch> 0 </pitch> <yaw> 0 </yaw> </orient>
        <sense> {sense} </sense>
      </thruster>
    </engine>
  </propulsion>
  <aerodynamics> <axis name="DRAG"/> <axis name="SIDE"/> <axis name="LIFT"/> </aerodynamics>
  <external_reactions file="apc_8x6e_reactions"/>
</fdm_config>
"""

MOTOR = """<?xml version="1.0"?>
<electric_engine name="motor"> <power unit="WATTS"> {watts} </power> </electric_engine>
"""


WATTS = 40.0


def on_stand(table: LoadTable, folder: Path, sense: int) -> Any:
    """JSBSim with a running rotor on a stand that does not move."""
    jsbsim = package("jsbsim")
    export_table(table, "jsbsim", folder / "engine")
    (folder / "engine" / "motor.xml").write_text(MOTOR.format(watts=WATTS))
    stand = folder / "aircraft" / "stand"
    stand.mkdir(parents=True)
    (folder / "engine" / "apc_8x6e_reactions.xml").rename(stand / "apc_8x6e_reactions.xml")
    (stand / "stand.xml").write_text(AIRCRAFT.format(sense=sense))
    jsbsim.FGJSBBase().debug_lvl = 0
    simulation = jsbsim.FGFDMExec(str(folder))
    simulation.load_model("stand")
    simulation["propmap/apc_8x6e-sense"] = sense
    for name in ("rate/rotational", "rate/translational", "position/rotational",
                 "position/translational"):  # fmt: skip
        simulation[f"simulation/integrator/{name}"] = 0
    simulation["ic/h-sl-ft"] = 100.0
    simulation.run_ic()
    simulation["propulsion/engine/set-running"] = 1
    simulation["fcs/throttle-cmd-norm"] = 0.5
    simulation.set_dt(0.002)
    for _ in range(5000):
        simulation.run()
    return simulation


def test_coefficients_are_those_of_the_map(invented: LoadTable) -> None:
    advance, thrust, power = coefficients(invented)
    assert (np.diff(advance) > 0.0).all() and advance[0] < 0.0
    climb = advance / np.pi
    # T/(rho n^2 D^4) = C (2 pi)^2 pi/16, P/(rho n^3 D^5) = C (2 pi)^3 pi/32.
    c_thrust = 0.016 - 0.08 * climb - 0.05 * climb**2
    c_torque = 0.0025 - 0.002 * climb - 0.003 * climb**2
    np.testing.assert_allclose(thrust, c_thrust * np.pi**3 / 4.0, atol=1e-5)
    np.testing.assert_allclose(power, c_torque * np.pi**4 / 4.0, atol=1e-5)


def test_descent_ends_where_the_map_does() -> None:
    content = invented_content()
    content.coefficients[:, :, 12:14, -3:] = np.nan
    advance, thrust, _ = coefficients(LoadTable(content))
    assert np.isfinite(thrust).all()
    assert -np.pi * 0.12 < advance[0] < -np.pi * 0.08
    climbing = invented_content(beta=(0.0, 2.0))
    assert coefficients(LoadTable(climbing))[0][0] == 0.0


# --- The wrench on the hub, for both spins -------------------------------------------------------


@pytest.mark.parametrize("spin", SPINS)
def test_the_wrench_of_the_multinomial(
    oblique: Both, module: Module, tmp_path: Path, spin: str
) -> None:
    rotor, table = oblique
    written = module(table, "multinomial")
    at = (OMEGA, *VELOCITIES.T)
    found = np.stack([*written.force(*at, SPINS[spin]), *written.moment(*at, SPINS[spin])], axis=-1)
    want = hub_wrench(rotor, spin)
    # A quadratic in the velocity; the loads across come within a quarter of themselves.
    error = share(found, want)
    assert error[:, [2, 5]].max() < 0.03 and error[:, [0, 1, 3, 4]].max() < 0.004
    loads = ("thrust(1.1, 500, 2, 1, 3)", "torque(1.1, 500, 2, 1, 3)")
    slopes = ("drag_slope(1.1, 500, 3)", "roll_slope(1.1, 500, 3)")
    prefix = "apc_8x6e_multinomial_"
    values = ", ".join(["f[0]", "f[1]", "f[2]", "m[0]", "m[1]", "m[2]"])
    text = printed(
        tmp_path / "multinomial",
        f"""
#include "apc_8x6e_multinomial.h"
#include <stdio.h>
int main(void)
{{
    double f[3], m[3];
    {prefix}wrench({written.RHO}, 600, 4, 2, 1, {SPINS[spin]}, f, m);
    printf("{"%.17g " * 10}", {values}, {", ".join(prefix + one for one in (*loads, *slopes))});
    return 0;
}}
""",
    )
    others = [
        written.thrust(500.0, 2.0, 1.0, 3.0, 1.1),
        written.torque(500.0, 2.0, 1.0, 3.0, 1.1),
        written.drag_slope(500.0, 3.0, 1.1),
        written.roll_slope(500.0, 3.0, 1.1),
    ]
    in_c = [float(word) for word in text.split()]
    np.testing.assert_allclose(in_c, [*found[0], *others], rtol=1e-12)


@pytest.mark.parametrize("spin", SPINS)
def test_the_wrench_in_rotorpy(oblique: Both, module: Module, spin: str) -> None:
    """With the mix-in, all six; without it, RotorPy has neither side force nor rolling moment."""
    multirotor = package("rotorpy.vehicles.multirotor")
    rotor, table = oblique
    written = module(table, "rotorpy")

    class Vehicle(written.HubWrench, multirotor.Multirotor):  # type: ignore[name-defined,misc]
        pass

    parameters = {**frame(1.0), **written.rotor_params}
    places, spins = [*parameters["rotor_pos"].values()], -parameters["rotor_directions"]
    vehicle, plain = Vehicle(parameters), multirotor.Multirotor(parameters)
    turning = np.array([0.5, -0.3, 2.0])
    # Two rotors of one spin at opposite places, which leave no moment of their forces' arms.
    speeds = np.where(spins == SPINS[spin], OMEGA, 0.0)
    for velocity, target in zip(VELOCITIES, hub_wrench(rotor, spin), strict=True):
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
def test_five_hundred_wrenches_in_jsbsim(oblique: Both, tmp_path: Path, spin: str) -> None:
    """While throttle and wind change: thrust and power as in axial flow, the others in full."""
    _, table = oblique
    simulation, rows = on_stand(table, tmp_path, SPINS[spin]), []
    loads = {"forces/fb": "lbs", "moments/": "lbsft"}
    for k, turn in enumerate(np.linspace(0.0, 1.0, 5000)):
        across = 2.5 * np.sin(14.0 * turn), 2.0 * np.sin(9.0 * turn + 1.0)
        simulation["fcs/throttle-cmd-norm"] = 0.55 + 0.4 * np.sin(17.0 * turn)
        wind = -np.array([*across, 2.2 - 2.2 * np.cos(23.0 * turn)]) / METERS_PER_FOOT
        # The rotor's x, y and z are the body's y, z and x.
        for name, speed in zip(("east", "down", "north"), wind, strict=True):
            simulation[f"atmosphere/wind-{name}-fps"] = speed
        simulation.run()
        if k % 10:
            continue
        wrench = [
            simulation[f"{kind}{axis}-prop-{unit}"] + simulation[f"{kind}{axis}-external-{unit}"]
            for (kind, unit), axes in zip(loads.items(), ("yzx", "mnl"), strict=True)
            for axis in axes
        ]
        air = [simulation[f"velocities/{name}-aero-fps"] for name in "vwu"]
        names = ("propeller-rpm", "propeller-power-ftlbps")
        engine = [simulation[f"propulsion/engine/{name}"] for name in names]
        given = simulation["fcs/throttle-cmd-norm"], simulation["atmosphere/rho-slugs_ft3"]
        rows.append([*wrench, *air, *engine, *given])
    found = np.array(rows) * ([NEWTONS_PER_POUND] * 3 + [NEWTONS_PER_POUND * METERS_PER_FOOT] * 3
        + [METERS_PER_FOOT] * 3 + [np.pi / 30.0, NEWTONS_PER_POUND * METERS_PER_FOOT]
        + [WATTS, KG_M3_PER_SLUG_FT3])  # fmt: skip
    velocity, (omega, power, motor, density) = found[:, 6:9], found[:, 9:].T
    assert len(found) == 500 and np.ptp(omega) > 250.0 and np.ptp(velocity, axis=0).min() > 3.9
    # The motor turns the stand, also while the propeller gains speed, which is up to 0.1 % a step.
    np.testing.assert_allclose(-SPINS[spin] * found[:, 5] * omega, motor, rtol=2e-3)
    relative = density / table.content.density
    static, axial = table.loads(omega, 0.0, 0.0), table.loads(omega, velocity[:, 2], 0.0)
    errors = axial_error(table)
    off = abs(found[:, 2] / relative - axial.thrust) / static.thrust
    assert off.max() < errors[0] + 0.005
    assert (abs(power / relative - axial.power) / static.power).max() < errors[1] + 0.005
    full = table.loads_at_velocity(omega, velocity)
    ahead = velocity[:, :2] / np.linalg.norm(velocity[:, :2], axis=1, keepdims=True)
    left, sign = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1), SPINS[spin]
    force = -full.drag[:, None] * ahead + sign * full.side_force[:, None] * left
    moment = -sign * full.roll_moment[:, None] * ahead - full.pitch_moment[:, None] * left
    for got, want, size in ((found[:, :2], force, 1.0), (found[:, 3:5], moment, RADIUS)):
        off = abs(got / relative[:, None] - want).max(axis=1) / (size * static.thrust)
        assert off.max() < 0.002 and (abs(want).max(axis=1) / (size * static.thrust)).max() > 0.02
