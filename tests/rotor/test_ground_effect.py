"""The ground below a rotor and a ceiling above it: factors on thrust, by the distance."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import propmap as pm
from propmap.loads import LOADS
from propmap.operating_points import FAR, along_and_across, resolved, split_velocity
from tools.ground_effect import constants, read_rows

OMEGA = 600.0
ROWS = Path(__file__).resolve().parents[3] / "shared/data/static/ground_ceiling_wall.csv"


@pytest.fixture(scope="module", params=("paper", "recommended"))
def rotor(request: pytest.FixtureRequest) -> pm.Rotor:
    corrections = pm.model_corrections(request.param)
    blade, law = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")
    return pm.Rotor(pm.Model(blade, law, corrections=corrections))


def factor(rotor: pm.Rotor, height: float, speed: np.ndarray, inflow: np.ndarray) -> np.ndarray:
    """Factor on the thrust as docs/theory.md states it; ``speed`` is that in the disk plane."""
    near = 0.424 * np.exp(-height / (0.686 * rotor.model.propeller.radius))
    return np.asarray(1.0 + near / (1.0 + (speed / inflow) ** 2))


def test_factor_in_hover_and_in_forward_flight(rotor: pm.Rotor) -> None:
    radius = rotor.model.propeller.radius
    still = rotor.loads(OMEGA, 0.0, 0.0)
    for height in (0.3 * radius, radius, 2.0 * radius, 27.4 * radius, 27.5 * radius):
        near = rotor.loads(OMEGA, 0.0, 0.0, height=height)
        wanted = factor(rotor, height, np.zeros(()), still.mean_inflow)
        np.testing.assert_allclose(near.thrust / still.thrust, wanted, rtol=1e-12)
    for distance in (0.3 * radius, radius, 64.3 * radius, 64.5 * radius):
        near = rotor.loads(OMEGA, 0.0, 0.0, ceiling=distance)
        wanted = 1.0 + 0.148 * np.exp(-distance / (1.61 * radius))
        np.testing.assert_allclose(near.thrust / still.thrust, wanted, rtol=1e-12)
    speed, height = np.array([0.5, 2.0, 5.0, 12.0]), 0.12
    far = rotor.loads(OMEGA, speed, 1.3)
    near = rotor.loads(OMEGA, speed, 1.3, height=height)
    expected = factor(rotor, height, speed * np.sin(1.3), far.mean_inflow)
    np.testing.assert_allclose(near.thrust / far.thrust, expected, rtol=1e-12)
    assert (np.diff(expected) < 0.0).all()
    above = rotor.loads(OMEGA, speed, 1.3, ceiling=0.12).thrust / far.thrust - 1.0
    np.testing.assert_allclose(above / above[0], (expected - 1.0) / (expected[0] - 1.0), rtol=1e-9)
    both = rotor.loads(OMEGA, speed, 1.3, height=height, ceiling=0.12).thrust
    np.testing.assert_allclose(both / near.thrust, 1.0 + above, rtol=1e-12)
    for name in (*LOADS, "power", "mean_inflow"):
        same = getattr(near, name) == getattr(far, name)
        assert (same == (name != "thrust")).all(), name


@pytest.mark.skipif(not ROWS.exists(), reason="needs the reference data")
@pytest.mark.parametrize(("effect", "name"), [("ground", "height"), ("ceiling", "ceiling")])
def test_factors_are_those_of_measured_static_thrust(
    rotor: pm.Rotor, effect: str, name: str
) -> None:
    radius, ratios = rotor.model.propeller.radius, read_rows(ROWS, effect)
    fitted = {"ground": (0.424, 0.686), "ceiling": (0.148, 1.61)}[effect]
    assert constants(ratios) == pytest.approx(fitted, abs=0.003)
    still = rotor.loads(OMEGA, 0.0, 0.0)
    apart = []
    for (_, distance), measured in ratios.items():
        further: Any = {name: distance * radius}
        near = rotor.loads(OMEGA, 0.0, 0.0, **further)
        apart.append(float(near.thrust / still.thrust / np.median(measured)) - 1.0)
    assert len(apart) == 8 and np.abs(apart).max() < 0.03


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
    point = {"omega": 600.0, "v_axial": 1.0, "v_inplane": 3.0, "height": 0.12, "ceiling": 0.1}
    names = list(point)
    found = rotor.gradients(names, **point).slopes[0]

    def thrust(name: str, by: float) -> float:
        moved = point | {name: point[name] + by}
        return float(rotor.gradients((), **moved).loads[0])

    for k, name in enumerate(names):
        step = 1e-5 * point[name]
        difference = (thrust(name, step) - thrust(name, -step)) / (2.0 * step)
        assert found[k] == pytest.approx(difference, rel=2e-5), name


@pytest.mark.parametrize("height", [0.03, -1.0, [0.2, 0.02], np.nan])
def test_heights_of_which_nothing_is_known_are_refused(rotor: pm.Rotor, height: object) -> None:
    with pytest.raises(pm.InputError, match="height"):
        rotor.loads(OMEGA, 3.0, 1.0, height=height)  # type: ignore[arg-type]
    with pytest.raises(pm.InputError, match="ceiling"):
        rotor.loads(OMEGA, 3.0, 1.0, ceiling=height)  # type: ignore[arg-type]


def test_bands_grow_with_the_thrust() -> None:
    known = pm.Rotor(pm.catalogue_model("APC 8x6E"))
    far, near = known.loads(OMEGA, 0.0, 0.0), known.loads(OMEGA, 0.0, 0.0, height=0.08)
    ratio = near.thrust / far.thrust
    for source in ("parameters", "tunnel"):
        here, there = near.std_by_source[source], far.std_by_source[source]
        assert here.thrust / there.thrust == pytest.approx(ratio, rel=1e-9)
