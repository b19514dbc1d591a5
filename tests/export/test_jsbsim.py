"""JSBSim's propeller: its coefficients, its units, and what JSBSim makes of it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.export import export_table
from propmap.export.simple_models import axial_error, coefficients
from propmap.table import LoadTable

from .conftest import RADIUS, invented_content
from .needed import package

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
        <sense> 1 </sense>
      </thruster>
    </engine>
  </propulsion>
  <aerodynamics> <axis name="DRAG"/> <axis name="SIDE"/> <axis name="LIFT"/> </aerodynamics>
</fdm_config>
"""

MOTOR = """<?xml version="1.0"?>
<electric_engine name="motor"> <power unit="WATTS"> {watts} </power> </electric_engine>
"""


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


def test_the_file_says_units_and_blades(invented: LoadTable, tmp_path: Path) -> None:
    path, *_ = export_table(invented, "jsbsim", tmp_path)
    root = ET.parse(path).getroot()
    diameter = root.find("diameter")
    assert diameter is not None and diameter.get("unit") == "IN"
    assert float(diameter.text or "") * 0.0254 == pytest.approx(2.0 * RADIUS)
    assert root.findtext("numblades", "").strip() == "3"
    assert [table.get("name") for table in root.iter("table")] == ["C_THRUST", "C_POWER"]
    ixx = root.find("ixx")
    assert ixx is not None and ixx.get("unit") == "KG*M2"


def test_a_table_without_axial_flight_is_refused(tmp_path: Path) -> None:
    table = LoadTable(invented_content(beta=(0.5, np.pi)))
    with pytest.raises(InputError, match=r"begins at 28\.6.* deg.*--beta 0:"):
        export_table(table, "jsbsim", tmp_path)


@pytest.mark.parametrize(("watts", "speed"), [(20.0, 0.0), (20.0, 3.0), (25.0, 5.5)])
def test_jsbsim_returns_the_axial_thrust_of_the_map(
    table: LoadTable, tmp_path: Path, watts: float, speed: float
) -> None:
    jsbsim = package("jsbsim")
    export_table(table, "jsbsim", tmp_path / "engine")
    (tmp_path / "engine" / "motor.xml").write_text(MOTOR.format(watts=watts))
    (tmp_path / "aircraft" / "stand").mkdir(parents=True)
    (tmp_path / "aircraft" / "stand" / "stand.xml").write_text(AIRCRAFT)
    jsbsim.FGJSBBase().debug_lvl = 0
    simulation = jsbsim.FGFDMExec(str(tmp_path))
    simulation.load_model("stand")
    # On a stand in the air stream: it does not move, and the wind is its speed.
    for name in ("rate/rotational", "rate/translational", "position/rotational",
                 "position/translational"):  # fmt: skip
        simulation[f"simulation/integrator/{name}"] = 0
    simulation["ic/h-sl-ft"] = 100.0
    simulation["ic/u-fps"] = speed / METERS_PER_FOOT
    simulation.run_ic()
    simulation["propulsion/engine/set-running"] = 1
    simulation["fcs/throttle-cmd-norm"] = 1.0
    simulation.set_dt(0.002)
    for _ in range(5000):
        simulation.run()
    assert simulation["velocities/u-aero-fps"] * METERS_PER_FOOT == pytest.approx(speed, abs=0.01)
    omega = simulation["propulsion/engine/propeller-rpm"] * np.pi / 30.0
    low, high = table.envelope["omega"]
    assert low < omega < high
    thrust = simulation["propulsion/engine/thrust-lbs"] * NEWTONS_PER_POUND
    density = simulation["atmosphere/rho-slugs_ft3"] * KG_M3_PER_SLUG_FT3
    expected = table.loads(omega, speed, 0.0)
    static = float(table.loads(omega, 0.0, 0.0).thrust)
    found = thrust * table.content.density / density
    assert abs(found - expected.thrust) / static < 0.01
    assert max(axial_error(table)) < 0.05
    # The motor's power, which the propeller takes up in the steady state.
    assert expected.power * density / table.content.density == pytest.approx(watts, rel=0.05)
