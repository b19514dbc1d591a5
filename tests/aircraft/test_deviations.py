"""How power follows a change, and how sure it is, beside aircraft that were changed and trimmed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.aircraft.sensitivity import derivatives, power_gradient, spread
from propmap.aircraft.trim import Aircraft, SteadyStates
from propmap.errors import InputError
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.vehicle import Body, Wakes

from .conftest import aircraft_of, quadcopter, rotor_of

EXAMPLES = Path(__file__).parents[2] / "examples"
SPEEDS = np.array([0.0, 7.0, 15.0])


@pytest.fixture(scope="module")
def level(aircraft: Aircraft) -> SteadyStates:
    return aircraft.steady(SPEEDS)


def power_of(speeds: np.ndarray = SPEEDS, **changes: object) -> np.ndarray:
    """States of the quadcopter with ``changes``, one of which may be ``twist`` [rad] or ``c_d``."""
    twist, c_d = changes.pop("twist", 0.0), changes.pop("c_d", None)
    vehicle = quadcopter(**changes)
    blade = vehicle.propeller
    vehicle = replace(vehicle, propeller=replace(blade, twist=blade.twist + twist))
    rotor = rotor_of(vehicle)
    if c_d is not None:
        law = rotor.model.airfoil.with_parameters(c_d=c_d)  # type: ignore[union-attr]
        rotor = rotor.with_model(rotor.model.with_airfoil(law))
    return np.asarray(Aircraft(vehicle, rotor).steady(speeds).electrical_power)


def test_power_follows_as_that_of_changed_aircraft(aircraft: Aircraft, level: SteadyStates) -> None:
    found = power_gradient(aircraft, level, ("speed", "mass", "drag_area_x", "c_d", "twist_offset"))
    own = float(aircraft.rotors.sources[0][0].model.airfoil.c_d)  # type: ignore[attr-defined]
    areas = ((0.015 + h, 0.015, 0.03) for h in (1e-3, -1e-3))
    pairs = {
        "speed": (power_of(SPEEDS + 0.05), power_of(np.abs(SPEEDS - 0.05)), 0.1),
        "mass": (power_of(mass=1.21), power_of(mass=1.19), 0.02),
        "drag_area_x": (*(power_of(body=Body(area)) for area in areas), 2e-3),
        "c_d": (power_of(c_d=own + 0.02), power_of(c_d=own - 0.02), 0.04),
        "twist_offset": (power_of(twist=2e-3), power_of(twist=-2e-3), 4e-3),
    }
    for name, (more, less, apart) in pairs.items():
        wanted = (more - less) / apart
        scale = np.abs(wanted).max()
        np.testing.assert_allclose(found[name], wanted, rtol=0.03, atol=0.02 * scale, err_msg=name)


def test_pitch_leans_further_with_drag(aircraft: Aircraft, level: SteadyStates) -> None:
    by = derivatives(aircraft, level, ("drag_area_x",))["drag_area_x"]
    assert by.pitch[0] == pytest.approx(0.0, abs=1e-9) and (by.pitch[1:] > 0.0).all()


def known_blade() -> Aircraft:
    """The quadcopter with constants that carry what is known of them."""
    model = propmap.catalogue_model("apc-8x6e")
    vehicle = quadcopter(propeller=model.propeller)
    rotor = propmap.Rotor(replace(model, air=vehicle.air))
    return Aircraft(vehicle, rotor)


def test_bands_of_power_are_those_of_the_rotors_torque_in_hover() -> None:
    """In hover all rotors carry the weight, whatever is wrong: dP = P (dQ/Q - 3/2 dT/T)."""
    craft = known_blade()
    states = craft.steady(np.zeros(1))
    sure = spread(craft, states)
    assert sure is not None
    rotor = craft.rotors.sources[0][0]
    loads = rotor.loads_at_velocity(states.rotor_speed[0, :1], np.zeros((1, 3)))
    # Whatever thrust and torque have in common, the band is between its extremes.
    thrust = float(loads.std.thrust[0] / loads.thrust[0])
    torque = float(loads.std.torque[0] / loads.torque[0])
    share = float(sure.shaft_power[0] / states.shaft_power[0])
    assert abs(torque - 1.5 * thrust) - 1e-3 <= share <= torque + 1.5 * thrust + 1e-3


def test_bands_have_no_jumps() -> None:
    """A step of the differences that is smaller than the loads' jumps shows as a spike."""
    vehicle = read_vehicle(EXAMPLES / "aircraft" / "delivery.toml").vehicle
    model = propmap.catalogue_model("uiuc-apcsf-11x4.7")
    model = propmap.Model(vehicle.propeller, model.airfoil, vehicle.air, model.corrections)
    craft = Aircraft(vehicle, propmap.Rotor(model))
    sure = spread(craft, craft.steady(np.array([14.0, 15.0, 16.0])))
    assert sure is not None
    before, here, after = sure.shaft_power
    assert here == pytest.approx(0.5 * (before + after), rel=0.05)


def test_nothing_known_and_names_that_are_not_there(
    aircraft: Aircraft, level: SteadyStates
) -> None:
    vehicle = quadcopter()
    model = propmap.Model(vehicle.propeller, propmap.airfoil("paper-apc"), vehicle.air)
    bare = Aircraft(vehicle, propmap.Rotor(model))
    assert spread(bare, bare.steady(SPEEDS[:1])) is None
    with pytest.raises(InputError, match="no derivative by 'kv'"):
        power_gradient(aircraft, level, ("kv",))
    wakes = aircraft_of(quadcopter(wakes=Wakes()))
    with pytest.raises(InputError, match="rotors with wakes"):
        power_gradient(wakes, wakes.steady(SPEEDS[:1], margin=False), ("diameter_scale",))
    grounded = aircraft_of(quadcopter(mass=60.0)).steady(SPEEDS)
    assert np.isnan(power_gradient(aircraft, grounded, ("mass",))["mass"]).all()
