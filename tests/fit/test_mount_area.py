"""What is mounted in the slipstream: identified, filed, used again; stated by a vehicle."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.fit.comparison import compare_tunnel
from propmap.fit.files import FitFile, fit_text, read_fit
from propmap.fit.fit import Fitted, Settings, coverage, fit
from propmap.fit.flight import ForceModel, level_rows
from propmap.fit.parameters import FIRST_GUESS, SECTION, Choice
from propmap.fit.tunnel import TunnelData, model_with, tunnel_rows
from propmap.flight.simulate import expectation, true_values
from propmap.model.corrections import Installed
from propmap.model.envelope import Envelope
from propmap.vehicle.vehicle import Vehicle
from tests.fit.test_flight_fit import MOUNTS, OMEGA, VELOCITIES, log

BLADE, LAW = propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")
MODEL = propmap.Model(BLADE, LAW)
AREA = 0.0014
MOUNTED = MODEL.with_mount(Installed(1.0, AREA))
FIXED = {name: getattr(LAW, name) for name in SECTION if name != "c_d"}
CHOICE = Choice(("c_d", "mount_area"), FIXED)
NOISE = 0.003


@pytest.fixture(scope="module")
def data() -> TunnelData:
    """Loads of the rotor on its mount, with errors of ``NOISE``."""
    speed = np.resize([4.0, 7.0, 10.0, 12.0], 16)
    beta = np.radians(np.repeat([30.0, 55.0, 75.0, 90.0], 4))
    omega = np.resize([520.0, 600.0, 680.0], 16)
    found = propmap.Rotor(MOUNTED).loads(omega, speed, beta)
    random = np.random.default_rng(7)
    names = ("thrust", "drag", "torque")
    loads = {n: getattr(found, n) * (1.0 + NOISE * random.normal(size=16)) for n in names}
    return TunnelData("twin", omega, speed, beta, loads)


@pytest.fixture(scope="module")
def fitted(data: TunnelData) -> Fitted:
    return fit(tunnel_rows(MODEL, data, CHOICE), CHOICE, Settings(starts=2, folds=0))


@pytest.fixture(scope="module")
def file(fitted: Fitted, data: TunnelData, tmp_path_factory: pytest.TempPathFactory) -> FitFile:
    text = fit_text(
        fitted,
        kind="tunnel",
        name="mounted",
        model=MODEL,
        data=["uiuc-8x6e"],
        covered=coverage(data.omega, data.speed, data.beta, BLADE.radius),
        envelope=Envelope.of(*data.flow, BLADE.radius),
        hover=np.zeros(fitted.rows.measured.size),
        remarks=(),
        options={},
    )
    path = tmp_path_factory.mktemp("fit") / "mounted.toml"
    path.write_text(text)
    return read_fit(path)


def test_the_area_is_found_again(fitted: Fitted) -> None:
    assert fitted.values["mount_area"] == pytest.approx(AREA, rel=0.03)
    assert fitted.uncertainty.identified == (True, True)
    width = fitted.uncertainty.high[1] - fitted.uncertainty.low[1]
    # The interval is four standard deviations wide.
    assert abs(fitted.values["mount_area"] - AREA) < width < 0.1 * AREA


def test_the_file_brings_it_along_with_its_covariance(file: FitFile, fitted: Fitted) -> None:
    (mount,) = file.model.corrections
    assert mount == Installed(1.0, fitted.values["mount_area"])
    assert file.covariance is not None and file.covariance.names == ("c_d", "mount_area")
    np.testing.assert_allclose(file.covariance.matrix, fitted.uncertainty.covariance)
    area = file.record.parameters[1]
    assert (area.name, area.unit, area.value) == ("mount_area", "m^2", mount.area_m2)


def test_whoever_uses_the_file_has_the_drag(file: FitFile, data: TunnelData) -> None:
    assert compare_tunnel(file.model, data)["drag_N"].all.relative_rms < 2.0 * NOISE
    bare = compare_tunnel(file.model.with_mount(Installed(1.0, 0.0)), data)["drag_N"].all
    assert bare.relative_rms > 0.2


def test_a_model_keeps_its_mount_where_the_fit_has_no_say() -> None:
    """And the share of the inflow where it has."""
    deep = MODEL.with_mount(Installed(1.0, AREA, wake=1.8))
    section = {name: getattr(LAW, name) for name in SECTION}
    assert model_with(deep, FIRST_GUESS | section).corrections == (Installed(1.0, AREA, wake=1.8),)
    moved = model_with(deep, FIRST_GUESS | section | {"mount_area": 0.003})
    assert moved.corrections == (Installed(1.0, 0.003, wake=1.8),)
    assert model_with(MODEL, FIRST_GUESS | section).corrections == ()


# A vehicle whose rotors are mounted on different things.
DRAGS = (Installed(1.0, 0.001), Installed(1.0, 0.003), Installed(1.0, 0.001), None)
VEHICLE = Vehicle(
    "test",
    1.0,
    BLADE,
    tuple(replace(mount, drag=drag) for mount, drag in zip(MOUNTS, DRAGS, strict=True)),
)
VALUES = FIRST_GUESS | {name: getattr(LAW, name) for name in SECTION}
FLOWN = log(((8.0, 0.0, 1.0), (5.0, 5.0, 1.0)), rates=(0.4, -0.3, 2.0))


def test_each_rotor_of_a_vehicle_has_its_own_mount() -> None:
    total = np.zeros((2, 3))
    for mount in VEHICLE.mounts:
        model = MODEL if mount.drag is None else MODEL.with_mount(mount.drag)
        hub = FLOWN.velocity + np.cross(FLOWN.rates, np.array(mount.position))
        rotor = propmap.Rotor(model)
        total += rotor.wrench(OMEGA, hub, mount.spin).force
    force = ForceModel(VEHICLE, FLOWN, LAW).at(VALUES, ("c_l1",)).force
    np.testing.assert_allclose(force, total, atol=0.02)
    bare = ForceModel(replace(VEHICLE, mounts=MOUNTS), FLOWN, LAW).at(VALUES, ("c_l1",)).force
    assert np.max(np.abs(force - bare)) > 0.1


def test_a_vehicle_s_mount_takes_the_place_of_the_law_s() -> None:
    every = tuple(replace(mount, drag=Installed(1.0, 0.001)) for mount in MOUNTS)
    law = replace(LAW, corrections=("installed:factor=1,area_m2=0.01",))
    forces = [
        ForceModel(replace(VEHICLE, mounts=every), FLOWN, one).at(VALUES, ("c_l1",)).force
        for one in (law, LAW)
    ]
    np.testing.assert_array_equal(*forces)
    own = true_values(replace(VEHICLE, mounts=MOUNTS), law)
    assert own["mount_area"] == 0.01
    assert "mount_area" not in true_values(VEHICLE, law)


def test_an_area_in_flight_is_that_of_every_rotor() -> None:
    """And its derivative is that of the forces, which are linear in it."""
    model = ForceModel(replace(VEHICLE, mounts=MOUNTS), FLOWN, LAW)
    at = {
        area: model.at(VALUES | {"mount_area": area}, ("c_l1", "mount_area"))
        for area in (0.001, 0.003)
    }
    slope = (at[0.003].loads - at[0.001].loads) / 0.002
    np.testing.assert_allclose(at[0.001].slopes[1], slope, rtol=1e-9, atol=1e-9)
    assert slope[0, 0] < -50.0


@pytest.mark.parametrize(
    ("corrections", "area"), [((), 0.0), (("installed:factor=1,area_m2=0.004",), 0.004)]
)
def test_a_planned_flight_knows_the_area_that_is_true(
    corrections: tuple[str, ...], area: float
) -> None:
    law, vehicle = replace(LAW, corrections=corrections), replace(VEHICLE, mounts=MOUNTS)
    found = expectation(vehicle, law, log(VELOCITIES), free=("c_l1", "mount_area"))
    assert found.truth.tolist() == [LAW.c_l1, area]
    assert found.uncertainty.low[1] <= area <= found.uncertainty.high[1]


def test_a_vehicle_that_states_its_mounts_leaves_none_to_find() -> None:
    for choice in (Choice(("mount_area",)), Choice(fixed={"mount_area": 0.001})):
        with pytest.raises(InputError, match=r"mount_area is a param.*remove the \[mount\] table"):
            level_rows(ForceModel(VEHICLE, FLOWN, LAW), choice)


def test_the_fit_file_is_readable_as_a_parameter_set(file: FitFile, tmp_path: Path) -> None:
    path = tmp_path / "again.toml"
    path.write_text(file.airfoil.to_toml())
    again = propmap.Model(BLADE, propmap.airfoil(path))
    assert again.corrections == file.model.corrections
