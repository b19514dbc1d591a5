"""Programs for blades with any number of stations compute the same loads."""

from __future__ import annotations

import numpy as np
import pytest

import propmap
from propmap.engine.rotor_arrays import rotor_arrays
from propmap.loads import LOADS
from propmap.physics.geometry import blade_shape, with_stations
from propmap.rotor import MOST_STATIONS

OMEGA = np.array([400.0, 700.0, 700.0, 600.0])
SPEED = np.array([0.0, 5.0, 20.0, 8.0])
BETA = np.array([0.0, 0.3, 1.5, 2.0])


@pytest.mark.parametrize("name", ["apc-8x6e", "uiuc-apcsf-10x4.7"])
def test_the_loads_are_the_same_to_the_last_digit(name: str) -> None:
    law, corrections = propmap.airfoil("paper-apc"), propmap.corrections_of("recommended")
    model = propmap.Model(propmap.propeller(name), law, corrections=corrections)
    own = propmap.Rotor(model, compiled=False).for_all_sizes()
    shared = propmap.Rotor(model, compiled=False).for_all_blades()
    assert shared.arrays.blade.station.size == MOST_STATIONS
    expected, found = own.loads(OMEGA, SPEED, BETA), shared.loads(OMEGA, SPEED, BETA)
    for load in LOADS:
        np.testing.assert_array_equal(getattr(found, load), getattr(expected, load))


def test_a_blade_keeps_its_shape_up_to_the_tip() -> None:
    arrays = rotor_arrays(
        propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))
    )
    longer = with_stations(arrays.blade, 50)
    radius = np.linspace(float(arrays.blade.station[0]), float(arrays.blade.tip), 200)
    for a, b in zip(blade_shape(arrays.blade, radius), blade_shape(longer, radius), strict=True):
        np.testing.assert_array_equal(a, b)
    assert with_stations(arrays.blade, 3) is arrays.blade


def test_a_rotor_of_another_model_has_the_same_settings() -> None:
    law = propmap.airfoil("paper-apc")
    models = [propmap.Model(propmap.propeller(n), law) for n in ("apc-8x6e", "apc-9x6e")]
    rotor = propmap.Rotor(models[0], accuracy="fine", compiled=False).for_all_blades()
    other = rotor.with_model(models[1])
    assert (other.accuracy, other.compiled, other.model) == ("fine", False, models[1])
    assert other.arrays.blade.station.size == MOST_STATIONS
