"""The ground below a rotor: Cheeseman and Bennett's factor on thrust, by the height of the disk."""

from __future__ import annotations

import numpy as np
import pytest

import propmap as pm
from propmap.loads import LOADS
from propmap.operating_points import FAR, along_and_across, resolved, split_velocity

OMEGA = 600.0


@pytest.fixture(scope="module", params=("paper", "recommended"))
def rotor(request: pytest.FixtureRequest) -> pm.Rotor:
    corrections = pm.model_corrections(request.param)
    blade, law = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")
    return pm.Rotor(pm.Model(blade, law, corrections=corrections))


def test_factor_in_hover_and_in_forward_flight_is_that_of_the_publication(rotor: pm.Rotor) -> None:
    heights = rotor.model.propeller.radius * np.array([0.5, 1.0, 2.0])
    still, near = rotor.loads(OMEGA, 0.0, 0.0), rotor.loads(OMEGA, 0.0, 0.0, height=heights)
    wanted = [4.0 / 3.0, 16.0 / 15.0, 64.0 / 63.0]
    np.testing.assert_allclose(near.thrust / still.thrust, wanted, rtol=1e-12)
    speed, height = np.array([0.5, 2.0, 5.0, 12.0]), 0.12
    far = rotor.loads(OMEGA, speed, 1.3)
    near = rotor.loads(OMEGA, speed, 1.3, height=height)
    image = (rotor.model.propeller.radius / (4.0 * height)) ** 2
    expected = 1.0 / (1.0 - image / (1.0 + (speed * np.sin(1.3) / far.mean_inflow) ** 2))
    np.testing.assert_allclose(near.thrust / far.thrust, expected, rtol=1e-12)
    assert (np.diff(expected) < 0.0).all()
    for name in (*LOADS, "power", "mean_inflow"):
        same = getattr(near, name) == getattr(far, name)
        assert (same == (name != "thrust")).all(), name


def test_all_ways_of_asking_agree(rotor: pm.Rotor) -> None:
    height = np.array([0.06, 0.1, 0.5])
    along, across = 7.0 * np.cos(1.1), 7.0 * np.sin(1.1)
    expected = rotor.loads(OMEGA, 7.0, 1.1, height=height).thrust
    velocity = [across, 0.0, along]
    np.testing.assert_array_equal(
        rotor.loads_at_velocity(OMEGA, velocity, height=height).thrust, expected
    )
    np.testing.assert_array_equal(
        rotor.wrench(OMEGA, velocity, height=height).force[:, 2], expected
    )
    found = rotor.gradients(["height"], OMEGA, along, across, height=height)
    np.testing.assert_array_equal(found.loads[0], expected)
    # There is no ground unless it is given.
    assert resolved(OMEGA, 3.0, 1.0).height is FAR
    assert along_and_across(OMEGA, 3.0, 1.0).height is FAR
    assert split_velocity(OMEGA, [1.0, 2.0, 3.0])[0].height is FAR
    assert rotor.loads(OMEGA, 3.0, 1.0, height=None).thrust == rotor.loads(OMEGA, 3.0, 1.0).thrust
    assert rotor.gradients(["height"], OMEGA, 1.0, 3.0).slopes[0, 0] == 0.0


def test_derivatives_near_the_ground_are_central_differences(rotor: pm.Rotor) -> None:
    point = {"omega": 600.0, "v_axial": 1.0, "v_inplane": 3.0, "height": 0.12}
    names = list(point)
    found = rotor.gradients(names, **point).slopes[0]

    def thrust(name: str, by: float) -> float:
        moved = point | {name: point[name] + by}
        return float(rotor.gradients((), **moved).loads[0])

    for k, name in enumerate(names):
        step = 1e-5 * point[name]
        difference = (thrust(name, step) - thrust(name, -step)) / (2.0 * step)
        assert found[k] == pytest.approx(difference, rel=2e-5), name


@pytest.mark.parametrize("height", [0.05, -1.0, [0.2, 0.03], np.nan])
def test_heights_of_which_nothing_is_known_are_refused(rotor: pm.Rotor, height: object) -> None:
    with pytest.raises(pm.InputError, match="height"):
        rotor.loads(OMEGA, 3.0, 1.0, height=height)  # type: ignore[arg-type]


def test_bands_grow_with_the_thrust() -> None:
    known = pm.Rotor(pm.catalogue_model("APC 8x6E"))
    far, near = known.loads(OMEGA, 0.0, 0.0), known.loads(OMEGA, 0.0, 0.0, height=0.08)
    ratio = near.thrust / far.thrust
    for source in ("parameters", "tunnel"):
        here, there = near.std_by_source[source], far.std_by_source[source]
        assert here.thrust / there.thrust == pytest.approx(ratio, rel=1e-9)
