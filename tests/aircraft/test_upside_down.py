"""Flight upside down, with rotors that turn backward: the mirror image of upright flight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from propmap.aircraft.assumptions import assumptions
from propmap.aircraft.performance import performance
from propmap.aircraft.sensitivity import spread
from propmap.aircraft.trim import Aircraft
from propmap.errors import InputError
from propmap.export import export_vehicle
from propmap.export.autopilot import export_autopilot
from propmap.loads import LOADS
from propmap.table import LoadTable
from propmap.vehicle.vehicle import Vehicle, Wakes
from propmap.vehicle.vehicle_forces import VehicleForces
from tests.table.conftest import invented_content

UPSIDE_DOWN = np.array([1.0, -1.0, -1.0])  # half a turn about x
KEPT = np.array([1.0 if name in ("drag", "roll_moment") else -1.0 for name in LOADS])


def tables_of(vehicle: Vehicle) -> tuple[LoadTable, LoadTable]:
    """A smooth table for the vehicle, and that of the same rotor upside down, turning backward."""
    content = invented_content()
    blade = {
        "radius_m": vehicle.propeller.radius,
        "geometry_sha256": vehicle.propeller.fingerprint(),
    }
    info = {"propeller": {"name": "plate", **blade}, "air": {"density_kg_m3": vehicle.air.density}}
    speed = np.array([0.0, content.advance[-1] * content.omega[0] * vehicle.propeller.radius])
    spread_of = 0.05 * np.abs(content.coefficients)
    ahead = replace(content, info=info, speed=speed, deviations=spread_of)
    back = replace(
        ahead,
        omega=-content.omega[::-1],
        coefficients=KEPT[:, None, None] * content.coefficients[::-1, :, :, ::-1],
        deviations=spread_of[::-1, :, :, ::-1],
    )
    return LoadTable(ahead), LoadTable(back)


@pytest.mark.parametrize("bank", [0.0, 0.4])
def test_it_is_the_mirror_image_of_upright_flight(vehicle: Vehicle, bank: float) -> None:
    mounts = tuple(
        replace(mount, position=tuple(UPSIDE_DOWN * mount.position)) for mount in vehicle.mounts
    )
    ahead, back = tables_of(vehicle)
    upright, inverted = Aircraft(replace(vehicle, mounts=mounts), ahead), Aircraft(vehicle, back)
    speeds, climb = np.array([2.0, 5.0, 8.0]), 0.0 if bank else 1.0
    one, other = (craft.steady(speeds, climb, bank) for craft in (upright, inverted))
    assert other.status.tolist() == one.status.tolist() == ["ok"] * 3
    np.testing.assert_allclose(other.rotor_speed, -one.rotor_speed, rtol=1e-7)
    np.testing.assert_allclose(other.pitch, one.pitch, atol=1e-7)
    np.testing.assert_allclose(other.roll, one.roll + np.pi, atol=1e-7)
    np.testing.assert_allclose(other.thrust, -one.thrust, rtol=1e-7)
    for name in ("shaft_power", "electrical_power", "throttle", "thrust_margin"):
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=1e-6)
    std, wanted = spread(inverted, other), spread(upright, one)
    assert std is not None and wanted is not None
    np.testing.assert_allclose(std.power, wanted.power, rtol=1e-4)
    still, hover = (craft.with_hover_model().steady(speeds) for craft in (upright, inverted))
    np.testing.assert_allclose(hover.shaft_power, still.shaft_power, rtol=1e-7)
    assert "upside down" in inverted.notes[0] and not any("upside" in n for n in upright.notes)


def test_the_forces_balance_the_weight_and_exports_refuse(
    vehicle: Vehicle, tmp_path: object
) -> None:
    _, back = tables_of(vehicle)
    craft = Aircraft(vehicle, back)
    hover = craft.steady([0.0])
    found = VehicleForces(vehicle, back).wrench(hover.rotor_speed, [0.0, 0.0, 0.0])
    np.testing.assert_allclose(found.force, [[0.0, 0.0, -craft.balance.weight]], atol=1e-6)
    assert found.status == ["reversed"] and (hover.rotor_speed < 0.0).all()
    assert "turning backward" in assumptions(vehicle, back)["rotors"]
    assert performance(craft, craft.steady(np.linspace(0.0, 8.0, 9))).hover is not None
    for export in (
        lambda: export_vehicle(vehicle, back, "gazebo", str(tmp_path)),
        lambda: export_autopilot(craft, "px4", str(tmp_path)),
    ):
        with pytest.raises(InputError, match=r"turns backward, which .* cannot represent; choose"):
            export()
    with pytest.raises(
        InputError, match=r"turn backward, but .* wakes or a wing; ignore the wakes"
    ):
        Aircraft(replace(vehicle, wakes=Wakes()), back)
