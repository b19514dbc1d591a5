"""Derivatives of power beside aircraft that were changed and trimmed again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.aircraft.sensitivity import derivatives, has_slopes, power_gradient
from propmap.aircraft.trim import Aircraft, SteadyStates
from propmap.model.propeller import Propeller
from propmap.vehicle.vehicle import Body

from .conftest import quadcopter

SPEEDS = np.array([0.0, 4.0, 9.0, 15.0])
LAW = propmap.airfoil("apc-8x6e-2019").with_parameters(uncertainty=None)
BLADE = propmap.propeller("apc-8x6e")


def craft_of(
    law: propmap.Airfoil = LAW, propeller: Propeller = BLADE, **changes: object
) -> Aircraft:
    vehicle = quadcopter(propeller=propeller, **changes)
    model = propmap.Model(propeller, law, vehicle.air, propmap.model_corrections("recommended"))
    return Aircraft(vehicle, propmap.Rotor(model))


@pytest.fixture(scope="module")
def craft() -> Aircraft:
    return craft_of()


@pytest.fixture(scope="module")
def level(craft: Aircraft) -> SteadyStates:
    return craft.steady(SPEEDS, margin=False)


@pytest.fixture(scope="module")
def gradient(craft: Aircraft, level: SteadyStates) -> dict[str, np.ndarray]:
    return power_gradient(craft, level, ("speed", "mass", "drag_area_x", *SHAPES, *CONSTANTS))


def slope(changed: Callable[[float], Aircraft], step: float) -> np.ndarray:
    """Differences of the power, by two aircraft that differ."""
    more, less = (changed(h).steady(SPEEDS, margin=False).power for h in (step, -step))
    return np.asarray((more - less) / (2.0 * step))


SHAPES: dict[str, tuple[Callable[[float], Propeller], float, float]] = {
    "chord_scale": (lambda h: replace(BLADE, chord=BLADE.chord * (1.0 + h)), 0.01, 0.015),
    "twist_offset": (lambda h: replace(BLADE, twist=BLADE.twist + h), 0.002, 0.015),
    "diameter_scale": (lambda h: BLADE.scaled(1.0 + h), 0.01, 0.005),
}
"""Changed blades, the step of the differences, and how far these may be off."""

CONSTANTS = {"c_d": 0.02, "c_l1": 0.05, "zero_lift_angle": 0.002}


def test_by_speed_mass_and_drag(gradient: dict[str, np.ndarray]) -> None:
    """The flow's derivatives have the loads' own nodes: 0.3 %, that of these differences."""
    assert has_slopes(craft_of().rotors.sources[0][0])
    ahead, behind = (
        craft_of().steady(np.abs(SPEEDS + h), margin=False).power for h in (0.05, -0.05)
    )
    wanted = {
        "speed": (ahead - behind) / 0.1,
        "mass": slope(lambda h: craft_of(mass=1.2 + h), 0.01),
        "drag_area_x": slope(lambda h: craft_of(body=Body((0.015 + h, 0.015, 0.03))), 1e-3),
    }
    for name, by in wanted.items():
        scale = np.abs(by).max()
        np.testing.assert_allclose(gradient[name], by, rtol=0.0, atol=3e-3 * scale, err_msg=name)


@pytest.mark.parametrize("name", SHAPES)
def test_by_the_blade(name: str, gradient: dict[str, np.ndarray]) -> None:
    changed, step, within = SHAPES[name]
    wanted = slope(lambda h: craft_of(propeller=changed(h)), step)
    assert gradient[name] == pytest.approx(wanted, abs=within * float(np.abs(wanted).max()))


@pytest.mark.parametrize("name", CONSTANTS)
def test_by_constants_of_the_section(name: str, gradient: dict[str, np.ndarray]) -> None:
    def changed(h: float) -> Aircraft:
        return craft_of(LAW.with_parameters(**{name: getattr(LAW, name) + h}))

    wanted = slope(changed, CONSTANTS[name])
    assert gradient[name] == pytest.approx(wanted, abs=0.015 * float(np.abs(wanted).max()))


def test_power_is_least_where_its_derivative_vanishes(craft: Aircraft) -> None:
    """Newton's search on dP/dV, whose root lies beside no cheaper speed."""
    speed = 11.0
    for _ in range(4):
        here = craft.steady([speed - 0.2, speed + 0.2], margin=False)
        low, high = power_gradient(craft, here, ("speed",))["speed"]
        speed -= 0.5 * (low + high) * 0.4 / (high - low)
    power = craft.steady([speed - 0.5, speed, speed + 0.5], margin=False).power
    assert power[1] < power[0] and power[1] < power[2]


def test_the_share_of_a_limit_follows(craft: Aircraft, level: SteadyStates) -> None:
    by = derivatives(craft, level, ("mass",))["mass"].used
    for name, share in by.items():
        more, less = (craft_of(mass=1.2 + h).steady(SPEEDS, margin=False) for h in (0.01, -0.01))
        wanted = (more.used[name] - less.used[name]) / 0.02
        assert share == pytest.approx(wanted, rel=5e-3, abs=1e-6), name
