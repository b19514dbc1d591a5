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
    with pytest.raises(InputError, match="no points with lambda_c"):
        export_table(LoadTable(content), "gazebo", tmp_path)
    table = LoadTable(invented_content(beta=(0.5, np.pi)))
    with pytest.raises(InputError, match=r"begins at 28\.6.* deg.*--beta 0:"):
        export_table(table, "jsbsim", tmp_path)


# -------------------------------------------------------------------------------------------------
# JSBSim on a stand.

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


def on_stand(
    table: LoadTable, folder: Path, velocity: np.ndarray, *, watts: float, sense: int = 1
) -> Any:
    """JSBSim's steady state of a rotor on a stand that stands still in a wind of ``velocity``."""
    jsbsim = package("jsbsim")
    export_table(table, "jsbsim", folder / "engine")
    (folder / "engine" / "motor.xml").write_text(MOTOR.format(watts=watts))
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
    # The rotor's x, y and z are the body's y, z and x.
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


# -------------------------------------------------------------------------------------------------
# The wrench on the hub, for both spins.


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


@pytest.mark.parametrize(
    ("spin", "velocity", "watts"),
    [
        ("ccw", (3.0, -2.0, 1.0), 20.0),
        ("cw", (3.0, -2.0, 1.0), 20.0),
        ("ccw", (0.0, 0.0, 0.0), 20.0),
        ("ccw", (0.0, 0.0, 5.5), 25.0),
    ],
)
def test_the_wrench_in_jsbsim(
    oblique: Both, tmp_path: Path, spin: str, velocity: tuple[float, ...], watts: float
) -> None:
    rotor, table = oblique
    axial, through = velocity[0] == 0.0, np.array(velocity)
    simulation = on_stand(table, tmp_path, through, watts=watts, sense=SPINS[spin])
    omega = simulation["propulsion/engine/propeller-rpm"] * np.pi / 30.0
    low, high = table.envelope["omega"]
    assert low < omega < high
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
    error = share(found, np.concatenate([wrench.force, wrench.moment]))
    assert error[[0, 1, 3, 4]].max() < 0.004
    assert error[2] < (0.01 if axial else 0.1) and error[5] < 0.03
    assert np.sign(found[5]) == -SPINS[spin]
    if axial:
        assert max(axial_error(table)) < 0.05
        # The motor's power, which the propeller takes up in the steady state.
        assert abs(found[5]) * omega * density == pytest.approx(watts, rel=0.05)
