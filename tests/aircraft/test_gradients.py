"""Derivatives of power against changed aircraft that are trimmed again, and deviations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.aircraft.sensitivity import derivatives, spread
from propmap.aircraft.trim import Aircraft
from propmap.errors import InputError
from propmap.model.propeller import Propeller
from propmap.vehicle.vehicle import Body, Wakes

from .conftest import aircraft_of, quadcopter

SPEEDS = np.array([0.0, 4.0, 9.0, 15.0])
LAW = propmap.airfoil("apc-8x6e-2019").with_parameters(uncertainty=None)
BLADE = propmap.propeller("apc-8x6e")


def craft_of(
    law: propmap.Airfoil = LAW, propeller: Propeller = BLADE, **changes: object
) -> Aircraft:
    vehicle = quadcopter(propeller=propeller, **changes)
    model = propmap.Model(propeller, law, vehicle.air, propmap.model_corrections("recommended"))
    return Aircraft(vehicle, propmap.Rotor(model))


def section(name: str) -> Callable[[float], Aircraft]:
    return lambda h: craft_of(LAW.with_parameters(**{name: getattr(LAW, name) + h}))


CHANGED: dict[str, tuple[Callable[[float], Aircraft], float, float]] = {
    "mass": (lambda h: craft_of(mass=1.2 + h), 0.01, 3e-3),
    "drag_area_x": (lambda h: craft_of(body=Body((0.015 + h, 0.015, 0.03))), 1e-3, 3e-3),
    "chord_scale": (
        lambda h: craft_of(propeller=replace(BLADE, chord=BLADE.chord * (1.0 + h))),
        0.01,
        0.015,
    ),
    "twist_offset": (
        lambda h: craft_of(propeller=replace(BLADE, twist=BLADE.twist + h)),
        0.002,
        0.015,
    ),
    "diameter_scale": (lambda h: craft_of(propeller=BLADE.scaled(1.0 + h)), 0.01, 0.005),
    "c_d": (section("c_d"), 0.02, 0.015),
    "c_l1": (section("c_l1"), 0.05, 0.015),
    "zero_lift_angle": (section("zero_lift_angle"), 0.002, 0.015),
}
"""Changed aircraft, the step of the differences, and how far the derivatives may be off."""


def test_derivatives_are_differences_of_changed_aircraft() -> None:
    craft = craft_of()
    level = craft.steady(SPEEDS, margin=False)
    found = derivatives(craft, level, ("speed", *CHANGED))
    ahead, behind = (craft.steady(np.abs(SPEEDS + h), margin=False).power for h in (0.05, -0.05))
    wanted, within = {"speed": (ahead - behind) / 0.1}, {"speed": 5e-3}
    used = found["mass"].used
    for name, (changed, step, within[name]) in CHANGED.items():
        more, less = (changed(h).steady(SPEEDS, margin=False) for h in (step, -step))
        wanted[name] = (more.power - less.power) / (2.0 * step)
        for limit, share in used.items() if name == "mass" else ():
            by = (more.used[limit] - less.used[limit]) / (2.0 * step)
            assert share == pytest.approx(by, rel=5e-3, abs=1e-6), limit
    for name, by in wanted.items():
        assert found[name].power == pytest.approx(by, abs=within[name] * np.abs(by).max()), name


def test_bands_of_power_are_those_of_the_rotors_torque_in_hover() -> None:
    """In hover all rotors carry the weight, whatever is wrong: dP = P (dQ/Q - 3/2 dT/T)."""
    model = propmap.catalogue_model("apc-8x6e")
    vehicle = quadcopter(propeller=model.propeller)
    craft = Aircraft(vehicle, propmap.Rotor(replace(model, air=vehicle.air)))
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


def test_nothing_known_and_names_that_are_not_there(aircraft: Aircraft) -> None:
    vehicle = quadcopter()
    model = propmap.Model(vehicle.propeller, propmap.airfoil("paper-apc"), vehicle.air)
    bare = Aircraft(vehicle, propmap.Rotor(model))
    assert spread(bare, bare.steady(np.zeros(1))) is None
    with pytest.raises(InputError, match="no derivative for 'kv'"):
        derivatives(aircraft, aircraft.steady(np.zeros(1)), ("kv",))
    wakes = aircraft_of(quadcopter(wakes=Wakes()))
    with pytest.raises(InputError, match="rotors with wakes"):
        derivatives(wakes, aircraft.steady(np.zeros(1)), ("diameter_scale",))
    grounded = aircraft_of(quadcopter(mass=60.0)).steady(np.zeros(1))
    assert np.isnan(derivatives(aircraft, grounded, ("mass",))["mass"].power).all()
