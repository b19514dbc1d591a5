"""Rotors in the slipstreams of those above them: limits of the theory, and a measured pair."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks import coaxial
from propmap import Model, Rotor, VehicleForces, airfoil, read_vehicle
from propmap.errors import InputError
from propmap.vehicle.vehicle import SLIPSTREAMS, Mount, Vehicle, Wakes
from propmap.vehicle.wakes import (
    above_each_other,
    hub_flow_at,
    wake_flow,
)

RADIUS = coaxial.PROPELLER.radius
THRUST = np.array([[30.0, 20.0]])


def pair(height: float, aside: float = 0.0, wakes: Wakes = SLIPSTREAMS) -> Vehicle:
    """The upper rotor first; both in radii."""
    made = coaxial.pair(height * RADIUS)
    moved = replace(made.mounts[1], position=(0.0, aside * RADIUS, 0.0))
    return replace(made, mounts=(made.mounts[0], moved), wakes=wakes)


def added(vehicle: Vehicle, velocity: object = (0.0, 0.0, 0.0)) -> np.ndarray:
    """Over the inflow of the upper rotor."""
    moving = np.atleast_2d(np.array(velocity, float))
    flow = hub_flow_at(vehicle, np.ones((len(moving), 2)), moving, 0.0 * moving)
    thrust = np.repeat(THRUST, len(moving), axis=0)
    assert vehicle.wakes is not None
    found = wake_flow(vehicle, vehicle.wakes, flow, thrust)
    return found.added / found.inflow[:, :1]


def test_in_hover_the_lower_meets_the_inflow_of_the_upper_at_any_depth() -> None:
    """As much air goes through the contracted slipstream as through the upper disk."""
    for height in (0.1, 1.0, 10.0):
        np.testing.assert_allclose(added(pair(height)), [[0.0, 1.0]], atol=1e-9)


def test_equal_thrusts_between_the_limits_of_momentum_theory() -> None:
    """Leishman and Syal, J. Am. Helicopter Soc. 53, 2008: one plane, and far below.

    Two equal thrusts in one plane are one rotor of twice the disk loading: sqrt(2).  With the
    lower rotor in the contracted wake, half the disk at twice the inflow, momentum and energy give
    s^2 + s - 4 = 0 for the flow s through the lower rotor over the inflow of the upper.
    """
    far_below = 0.5 * (1.0 + 0.5 * (np.sqrt(17.0) - 1.0))
    assert far_below == pytest.approx(1.281, abs=5e-4)
    for height in coaxial.HEIGHTS:
        # v (v + 1) = 1: the golden section.
        assert coaxial.ideal_power(height) == pytest.approx(0.25 * (3.0 + np.sqrt(5.0)), rel=1e-6)
        assert far_below < coaxial.ideal_power(height) < 1.03 * far_below < np.sqrt(2.0)


@pytest.mark.parametrize(("aside", "speed"), [(0.4, 8.0), (1.6, 0.0), (1.0, 3.0)])
def test_partly_overlapped_disks_by_counting_points(aside: float, speed: float) -> None:
    made, depth = pair(0.5, aside), 0.5
    moving = np.array([[speed, 0.0, 0.0]])
    flow = hub_flow_at(made, np.ones((1, 2)), moving, 0.0 * moving)
    inflow = wake_flow(made, SLIPSTREAMS, flow, THRUST).inflow[0, 0]
    tangent = speed / inflow
    path = depth * np.hypot(1.0, tangent)
    grown = 1.0 + path / np.hypot(1.0, path)
    # Continuity, of level flight: the upper disk's speed over that in the slipstream.
    radius2 = np.hypot(speed, inflow) / np.hypot(speed, grown * inflow)
    x, y = np.meshgrid(*2 * [np.linspace(-1.0, 1.0, 1201)])
    own = x**2 + y**2 <= 1.0
    covered = (x + depth * tangent) ** 2 + (y + aside) ** 2 <= radius2
    share = (own & covered).sum() / own.sum()
    found = added(made, (speed, 0.0, 0.0))[0]
    assert found[0] == 0.0
    assert found[1] == pytest.approx(grown * share, abs=4e-3)


def test_gains_count_for_cylinders_alone() -> None:
    other = pair(0.3, wakes=Wakes(3.0, 2.0, 0.5))
    np.testing.assert_allclose(added(other), added(pair(0.3)), rtol=1e-12)
    still = np.zeros((1, 3))
    found = wake_flow(other, Wakes(), hub_flow_at(other, np.ones((1, 2)), still, still), THRUST)
    assert all(not found.by_gain[name].any() for name in ("ahead", "beside", "downwash"))


def test_derivatives_against_differences() -> None:
    made, h = pair(0.4, 0.5), 1e-4
    moving = np.random.default_rng(1).normal([0.0, 0.0, 4.0], 3.0, (30, 3))
    flow = hub_flow_at(made, np.ones((30, 2)), moving, 0.0 * moving)
    thrust = np.repeat(THRUST, 30, axis=0)
    found = wake_flow(made, SLIPSTREAMS, flow, thrust)
    step = np.array([h, 0.0])
    more, less = (wake_flow(made, SLIPSTREAMS, flow, thrust + d).added for d in (step, -step))
    slope = (more - less) / (2.0 * h)
    np.testing.assert_allclose(found.by_thrust[:, :, 0], slope, atol=1e-3 * np.abs(slope).max())


def test_who_is_above_whom() -> None:
    together = np.array([[False, True], [True, False]])
    for made, expected in (
        (pair(0.3), together),
        (pair(5.0, 1.9), together),
        (pair(0.3, 2.0), ~together & together),  # side by side
        (pair(0.02, 1.0), ~together & together),  # in one plane
    ):
        np.testing.assert_array_equal(above_each_other(made), expected)
    across = replace(pair(0.5).mounts[1], axis=(1.0, 0.0, 0.0))
    assert not above_each_other(replace(pair(0.5), mounts=(pair(0.5).mounts[0], across))).any()
    with pytest.raises(InputError, match="apart"):
        VehicleForces(pair(0.01), Rotor(Model(coaxial.PROPELLER, airfoil("paper-apc"))))


def test_the_measured_pair_at_all_speeds() -> None:
    """Within 5 % in total thrust and power and 8 % in the split; nothing is fitted to the pair."""
    thrust, power = coaxial.computed(coaxial.pair(coaxial.APART))
    upper, lower = coaxial.MEASURED[:, 1:3], coaxial.MEASURED[:, 4:]
    measured = np.stack([upper, lower], axis=1)
    np.testing.assert_allclose(thrust.sum(axis=1), measured[..., 0].sum(axis=1), rtol=0.05)
    np.testing.assert_allclose(power.sum(axis=1), measured[..., 1].sum(axis=1), rtol=0.05)
    share = measured[:, 0, 0] / measured[..., 0].sum(axis=1)
    np.testing.assert_allclose(thrust[:, 0] / thrust.sum(axis=1), share, rtol=0.08)
    np.testing.assert_allclose(thrust, measured[..., 0], rtol=0.09)
    # Without the slipstream it is another machine.
    alone, _ = coaxial.computed(replace(coaxial.pair(coaxial.APART), wakes=None))
    assert np.all(alone.sum(axis=1) > 1.2 * measured[..., 0].sum(axis=1))


def vehicle_from(folder: Path, rotors: list[tuple[object, ...]]) -> Vehicle:
    head = 'schema = 1\nname = "coax"\nframe = "flu"\nmass = 16.36\npropeller = "apc-8x6e"\n'
    table = "[[rotors]]\nposition = [{}, {}, {}]\nspin = '{}'\n"
    text = head + "".join(table.format(*rotor) for rotor in rotors)
    (folder / "vehicle.toml").write_text(text, encoding="utf-8")
    return read_vehicle(folder / "vehicle.toml").vehicle


def test_four_pairs_of_a_file_are_four_times_the_pair(tmp_path: Path) -> None:
    spins = ("cw", "ccw")
    rotors: list[tuple[object, ...]] = [
        (x, y, 0.1 * (0.5 - level), spins[(k + level) % 2])
        for k, (x, y) in enumerate([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])
        for level in (0, 1)
    ]
    made = vehicle_from(tmp_path, rotors)
    assert made.wakes == SLIPSTREAMS
    rotor = Rotor(Model(made.propeller, airfoil("paper-apc")))
    first = replace(made, mounts=made.mounts[:2])
    one = VehicleForces(first, rotor).wrench([600.0, 550.0], (0.0, 0.0, 0.0))
    found = VehicleForces(made, rotor).wrench([600.0, 550.0] * 4, (0.0, 0.0, 0.0))
    np.testing.assert_allclose(found.thrust, np.tile(one.thrust, 4), rtol=1e-9)
    # The upper rotor of each pair works in still air.
    np.testing.assert_allclose(found.added_flow[::2], 0.0, atol=1e-12)
    assert (found.added_flow[1::2] > 1.0).all()


def test_rotors_side_by_side_have_no_wakes_unless_asked(tmp_path: Path) -> None:
    rotors: list[tuple[object, ...]] = [(0.2, 0.2, 0.0, "cw"), (-0.2, 0.2, 0.1, "ccw")]
    assert vehicle_from(tmp_path, rotors).wakes is None


def test_a_rotor_behind_another_on_one_axis_is_in_its_slipstream() -> None:
    """Push and pull: what is above along the thrust is ahead."""
    forward = (1.0, 0.0, 0.0)
    mounts = (Mount((0.5, 0.0, 0.0), forward), Mount((-0.5, 0.0, 0.0), forward, "cw"))
    found = added(replace(pair(0.5), mounts=mounts), (3.0, 0.0, 0.0))
    assert found[0, 0] == 0.0 and found[0, 1] == pytest.approx(1.0, abs=1e-6)
