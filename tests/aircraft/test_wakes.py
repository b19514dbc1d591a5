"""Steady states and derivatives of rotors in each other's wakes."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.aircraft.ranking import Candidate, Ranking, Task
from propmap.vehicle.vehicle import Mount, Vehicle, Wakes
from propmap.vehicle.vehicle_forces import Rotors

from .conftest import aircraft_of, quadcopter, unbalanced

GAINS = Wakes(2.0, 0.8, 1.0, 0.9)
SPEEDS = np.array([0.0, 6.0, 14.0])


@pytest.fixture(scope="module")
def in_wakes() -> Vehicle:
    return quadcopter(wakes=GAINS)


def test_rear_rotors_in_downwash_turn_faster(vehicle: Vehicle, in_wakes: Vehicle) -> None:
    level = aircraft_of(in_wakes).steady(SPEEDS)
    assert level.status.tolist() == ["ok"] * 3
    assert level.residual.max() < 1e-8
    for k, speed in enumerate(SPEEDS.tolist()):
        assert np.abs(unbalanced(in_wakes, level, k, (speed, 0.0, 0.0))).max() < 1e-8
    alone = aircraft_of(vehicle).steady(SPEEDS)
    change = level.rotor_speed - alone.rotor_speed
    assert (change[1:, [1, 2]] > 3.0).all()  # rear, in downwash
    assert (change[1:, [0, 3]] < -3.0).all()  # front, in upwash
    front_left, _, _, front_right = level.rotor_speed.T
    assert front_left == pytest.approx(front_right, rel=1e-9)
    # Propellers are ranked in their wakes.
    candidate = Candidate("apc-8x6e", vehicle.propeller, propmap.airfoil("apc-8x6e-2019"))
    power = [
        Ranking(one, Task("cruise", 12.0, None), ()).aircraft(candidate).steady(12.0).shaft_power[0]
        for one in (vehicle, in_wakes)
    ]
    assert abs(power[1] / power[0] - 1.0) > 1e-3


def test_a_lower_rotor_turns_faster_for_its_share(vehicle: Vehicle) -> None:
    """Two of one thrust on one axis: the lower one climbs through the upper one's wake."""
    pair = (Mount((0.0, 0.0, 0.1), spin="cw"), Mount((0.0, 0.0, -0.1), spin="ccw"))
    made = replace(vehicle, mounts=pair, mass=0.6, wakes=Wakes())
    states = aircraft_of(made).steady(0.0)
    alone = aircraft_of(replace(made, wakes=None)).steady(0.0)
    assert states.status.tolist() == ["ok"]
    # The torques of both spins balance, so the lower one, through which air falls, thrusts less.
    assert states.torque[0, 0] == pytest.approx(states.torque[0, 1], rel=1e-7)
    assert states.thrust[0, 1] < 0.9 * states.thrust[0, 0]
    assert 1.1 < states.shaft_power[0] / alone.shaft_power[0] < 1.6


class Smooth:
    """Loads that change evenly with the flow, so that difference quotients of them are good.

    They are quadratic in a ``factor``; ``slope`` tells whether its derivative is wanted instead.
    """

    def __init__(self, factor: float = 1.0, *, slope: bool = False) -> None:
        self.factor, self.slope = factor, slope

    def loads_at_velocity(self, omega: np.ndarray, velocity: np.ndarray) -> Any:
        across, along = np.hypot(velocity[:, 0], velocity[:, 1]), velocity[:, 2]
        lift = 8e-6 * omega**2 - 5e-4 * omega * along + 2e-3 * across**2
        thrust, inplane = self.factor**2 * lift, omega * across * (1.0 - 0.02 * along)
        torque = 0.02 * thrust + 1e-5 * omega * along
        rest = {"drag": 2e-5, "roll_moment": 1e-6, "side_force": 3e-6, "pitch_moment": 2e-6}
        loads = {name: size * self.factor * inplane for name, size in rest.items()}
        if self.slope:
            loads = {name: size * inplane for name, size in rest.items()}
            thrust = 2.0 * self.factor * lift
            torque = 0.02 * thrust
        return SimpleNamespace(
            thrust=thrust, torque=torque, status=np.full(omega.shape, "ok"), **loads
        )


def turbulent(in_wakes: Vehicle) -> tuple[Vehicle, np.ndarray, np.ndarray]:
    """Return three rotors, one below another, where wakes act most, with speeds and flows."""
    below = replace(in_wakes.mounts[0], position=(0.17, 0.15, -0.1), spin="ccw")
    rng = np.random.default_rng(0)
    omega = rng.uniform(550.0, 750.0, (3, 3))
    velocity = np.array(rng.normal(0.0, 2.0, (3, 3, 3))) + np.array([3.0, 0.0, 2.0])
    return replace(in_wakes, mounts=(*in_wakes.mounts[:2], below)), omega, velocity


def test_slopes_by_the_speeds_of_other_rotors(in_wakes: Vehicle) -> None:
    vehicle, omega, velocity = turbulent(in_wakes)
    rotors = Rotors.of(vehicle, Smooth())
    wrenches, force, moment = rotors.around(omega, velocity[None], 1e-5)

    def total(speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found = rotors.wrenches(speeds, velocity)
        turning = rotors.moment(found.force, found.moment)
        return found.force.sum(axis=1), turning.sum(axis=1)

    plain = rotors.wrenches(omega, velocity)
    np.testing.assert_allclose(wrenches.force[0], plain.force, rtol=1e-12)
    each = np.abs(force).max(), np.abs(moment).max()
    for k in range(3):
        step = 0.01 * np.eye(3)[k]
        up, down = total(omega + step), total(omega - step)
        for slope, size, high, low in zip((force, moment), each, up, down, strict=True):
            # The slopes of the wakes by the thrusts are good to half a per cent of the wakes.
            np.testing.assert_allclose(slope[:, k], (high - low) / 0.02, atol=1e-3 * size)
    alone = Rotors.of(replace(vehicle, wakes=None), Smooth())
    own = alone.around(omega, velocity[None], 1e-5)[1]
    assert np.abs(force - own).max() > 0.05 * each[0]  # far beyond the tolerance


@pytest.mark.parametrize("wakes", [None, GAINS], ids=["alone", "wakes"])
def test_what_changes_of_the_loads_do(in_wakes: Vehicle, wakes: Wakes | None) -> None:
    vehicle, omega, velocity = turbulent(replace(in_wakes, wakes=wakes))
    everyone, h = np.arange(3), 1e-4
    up, down, here = (Rotors.of(vehicle, Smooth(1.0 + d)) for d in (h, -h, 0.0))
    found = here.changed([(Smooth(slope=True), everyone)], omega, velocity)
    high, low = (rotors.wrenches(omega, velocity) for rotors in (up, down))
    for name in ("force", "moment", "thrust", "torque"):
        slope = (getattr(high, name) - getattr(low, name)) / (2.0 * h)
        size = np.abs(slope).max()
        np.testing.assert_allclose(getattr(found, name), slope, atol=1e-3 * size, err_msg=name)
    # Were the wakes to stay as they are, it would be otherwise.
    if wakes is not None:
        flow = velocity + here.wrenches(omega, velocity).added_flow[..., None] * here.axis
        kept = Rotors.of(replace(vehicle, wakes=None), Smooth(slope=True)).wrenches(omega, flow)
        assert np.abs(kept.thrust - found.thrust).max() > 0.02 * np.abs(found.thrust).max()
