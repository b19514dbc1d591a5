"""An aircraft on a load table flies as on the rotor, within the table's tolerance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.aircraft.performance import performance
from propmap.aircraft.sensitivity import derivatives
from propmap.aircraft.trim import Aircraft
from propmap.errors import InputError
from propmap.model.corrections import Installed
from propmap.table import LoadTable, build_table
from propmap.vehicle.vehicle import Vehicle

from .conftest import rotor_of

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def table(vehicle: Vehicle) -> LoadTable:
    model = rotor_of(vehicle).model
    # How well the constants are known would be tabulated too, which takes time.
    law = model.airfoil.with_parameters(uncertainty=None)
    return build_table(
        propmap.Rotor(model.with_airfoil(law)),
        omega=(450.0, 800.0),
        speed=(0.0, 14.0),
        beta=(0.0, 1.7),
        tolerance=0.03,
        certificate_points=256,
    )


def test_the_same_states(vehicle: Vehicle, table: LoadTable) -> None:
    speeds = np.array([0.0, 5.0, 12.0])
    by_rotor = Aircraft(vehicle, rotor_of(vehicle)).steady(speeds, margin=False)
    by_table = Aircraft(vehicle, table).steady(speeds, margin=False)
    assert by_table.status.tolist() == ["ok"] * 3
    assert by_table.shaft_power == pytest.approx(by_rotor.shaft_power, rel=0.03)
    assert by_table.pitch == pytest.approx(by_rotor.pitch, abs=0.01)
    assert by_table.residual.max() < 1e-8
    outside = Aircraft(vehicle, table).steady([20.0], margin=False)
    assert outside.status.tolist() == ["outside_table"] and np.isnan(outside.shaft_power[0])


def test_no_minimum_is_reported_at_the_last_speed_of_a_table(
    vehicle: Vehicle, table: LoadTable
) -> None:
    beyond, within = (
        performance(craft, craft.steady([0.0, 6.0], margin=False))
        for craft in (Aircraft(vehicle, rotor_of(vehicle)), Aircraft(vehicle, table))
    )
    assert beyond.best_range is not None and beyond.best_range.speed > 14.0
    assert within.best_range is None and within.hover is not None


def test_power_s_derivatives_are_those_of_the_table(vehicle: Vehicle, table: LoadTable) -> None:
    """Beside trims on the same table; its own derivatives make no other error than its loads."""
    speeds = np.array([0.0, 5.0, 11.0])
    craft = Aircraft(vehicle, table)
    found = derivatives(craft, craft.steady(speeds, margin=False), ("speed", "mass"))
    more, less = (craft.steady(np.abs(speeds + h), margin=False).power for h in (0.01, -0.01))
    scale = np.abs(found["speed"].power).max()
    assert found["speed"].power == pytest.approx((more - less) / 0.02, abs=5e-3 * scale)
    more, less = (
        Aircraft(replace(vehicle, mass=1.2 + h), table).steady(speeds, margin=False).power
        for h in (2e-3, -2e-3)
    )
    assert found["mass"].power == pytest.approx((more - less) / 4e-3, rel=5e-3)


def test_a_table_of_something_else(vehicle: Vehicle, table: LoadTable) -> None:
    thin = replace(vehicle, air=propmap.Air(1.0, 1.8e-5))
    with pytest.raises(InputError, match=r"for 1\.225 kg.*build a table with --rho"):
        Aircraft(thin, table)
    other = replace(vehicle, propeller=propmap.propeller("apc-9x6e"))
    with pytest.raises(InputError, match="the table is for"):
        Aircraft(other, table)
    mounted = tuple(replace(m, drag=Installed(1e-3)) for m in vehicle.mounts)
    with pytest.raises(InputError, match=r"\[mount\]"):
        Aircraft(replace(vehicle, mounts=mounted), table)
