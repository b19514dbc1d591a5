"""Design studies: blades as asked for, samples that cover, loads of the rotor of each design."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import propmap
from propmap.errors import InputError
from propmap.rotor import Rotor
from propmap.study.files import read_study
from propmap.study.run import Study, changed_blade, pitch_of
from propmap.sweep.run import InMemory, Store

EXAMPLE = Path(__file__).parents[2] / "examples" / "study" / "around_8x6.toml"

POINTS = {
    "rpm": np.array([5000.0]),
    "speed_mps": np.array([0.0, 8.0]),
    "beta_deg": np.array([70.0]),
}


@pytest.fixture(scope="module")
def rotor() -> Rotor:
    model = propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))
    return Rotor(model)


def test_a_blade_of_twice_the_size_has_the_angles_of_the_first(rotor: Rotor) -> None:
    blade = rotor.model.propeller
    twice = changed_blade(blade, diameter=2.0 * blade.diameter)
    np.testing.assert_allclose(twice.chord, 2.0 * blade.chord)
    np.testing.assert_allclose(twice.twist, blade.twist)
    assert pitch_of(twice) == pytest.approx(2.0 * pitch_of(blade))
    # Geometrically alike at equal tip speed: forces grow with the square, but for Reynolds' number.
    small, large = (
        rotor.with_model(replace(rotor.model, propeller=p)).loads(w, 0.0, 0.0).thrust
        for p, w in ((blade, 600.0), (twice, 300.0))
    )
    assert large == pytest.approx(4.0 * small, rel=0.02)


def test_pitch_is_that_asked_for_and_other_stations_follow(rotor: Rotor) -> None:
    blade = rotor.model.propeller
    found = changed_blade(blade, pitch=0.2)
    assert pitch_of(found) == pytest.approx(0.2)
    before, after = (one.station * np.tan(one.twist) for one in (blade, found))
    np.testing.assert_allclose(after / before, 0.2 / pitch_of(blade), rtol=1e-3)
    flat = changed_blade(blade, twist_scale=0.0)
    assert np.ptp(flat.twist) == pytest.approx(0.0, abs=1e-12)
    assert pitch_of(flat) == pytest.approx(pitch_of(blade))
    np.testing.assert_allclose(changed_blade(blade, chord_scale=1.5).chord, 1.5 * blade.chord)


def test_a_latin_hypercube_has_every_stripe_once(rotor: Rotor) -> None:
    varied = {"diameter": np.array([0.18, 0.24]), "blades": np.array([2.0, 3.0])}
    study = Study(rotor, varied, POINTS, designs=20, seed=4)
    stripe = np.floor((study.rows["diameter"] - 0.18) / 0.06 * 20).astype(int)
    assert sorted(stripe) == list(range(20))
    assert sorted(study.rows["blades"]) == [2.0] * 10 + [3.0] * 10
    again = Study(rotor, varied, POINTS, designs=20, seed=4)
    np.testing.assert_array_equal(study.rows["diameter"], again.rows["diameter"])


@pytest.mark.parametrize("where", ["memory", "store"])
def test_loads_are_those_of_each_design(rotor: Rotor, tmp_path: Path, where: str) -> None:
    values = {"pitch": [0.12, 0.16], "blades": [2.0, 3.0], "rpm": [4000.0, 5000.0]}
    varied = {name: np.array(two) for name, two in values.items()}
    shared = {name: POINTS[name] for name in ("speed_mps", "beta_deg")}
    study = Study(rotor, varied, shared, points_per_task=6)
    layout = study.layout()
    assert layout.chunk[0] < study.count
    path = tmp_path / "study.zarr"
    store: Any = InMemory(layout) if where == "memory" else Store.create(path, layout)
    study.run(store, layout)
    found = store.dataset() if where == "memory" else xarray.open_zarr(path)
    assert found["thrust"].dims == ("design", "speed", "beta")
    assert found["pitch"].attrs["units"] == "m"
    assert found["thrust"].attrs["units"] == "N"
    for k in range(study.count):
        one = found.isel(design=k)
        blade = changed_blade(
            rotor.model.propeller, pitch=float(one["pitch"]), blades=int(one["blades"])
        )
        alone = rotor.with_model(replace(rotor.model, propeller=blade))
        expected = alone.loads(float(one["rpm"]) * np.pi / 30.0, [0.0, 8.0], np.radians(70.0))
        np.testing.assert_allclose(one["thrust"].values[:, 0], expected.thrust, rtol=1e-12)
        np.testing.assert_allclose(one["torque"].values[:, 0], expected.torque, rtol=1e-12)


GOOD = EXAMPLE.read_text()

FAULTS = [
    ('method = "latin-hypercube"', 'method = "sobol"', "method is 'sobol'"),
    ('method = "latin-hypercube"', 'method = "full-factorial"', "designs is given"),
    ("diameter_in = [7.0, 9.0]", "diameter_in = [7.0, 8.0, 9.0]", "a Latin hypercube two values"),
    ("diameter_in = [7.0, 9.0]", "diametre_in = [7.0, 9.0]", "did you mean diameter_in"),
    ("pitch_in = [4.0, 7.0]", "diameter_m = [0.1, 0.2]", "given twice"),
    ("chord_scale = [0.8, 1.2]", "chord_scale = [0.8, 90.0]", "the design with"),
    ("blades = [2, 3]", "blades = [2.5, 3]", "whole numbers"),
    ("rpm = [6000.0]", "", "rpm is given nowhere"),
    ("speed_mps = [0.0, 10.0, 20.0]", "speed_mps = [-1.0]", "negative"),
    ("designs = 60", "designs = 1", "designs is 1"),
    ("diameter_in = [7.0, 9.0]", "diameter_in = [9.0, 7.0]", "do not increase"),
]


@pytest.mark.parametrize(("old", "new", "told"), FAULTS)
def test_faults_of_a_file_are_one_line(
    rotor: Rotor, tmp_path: Path, old: str, new: str, told: str
) -> None:
    assert old in GOOD
    file = tmp_path / "study.toml"
    file.write_text(GOOD.replace(old, new))
    with pytest.raises(InputError) as refused:
        read_study(file).study(rotor)
    assert told in str(refused.value)
    assert "\n" not in str(refused.value)
