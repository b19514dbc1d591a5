"""What is mounted in the slipstream: identified, filed, used again; stated by a vehicle."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.fit.comparison import compare_tunnel
from propmap.fit.files import fit_text, read_fit
from propmap.fit.fit import Settings, coverage, fit
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
FIXED = {name: getattr(LAW, name) for name in SECTION if name != "c_d"}
CHOICE = Choice(("c_d", "mount_area"), FIXED)
NOISE = 0.003


def test_the_area_is_found_filed_and_used_again(tmp_path: Path) -> None:
    speed = np.resize([4.0, 7.0, 10.0, 12.0], 16)
    beta = np.radians(np.repeat([30.0, 55.0, 75.0, 90.0], 4))
    omega = np.resize([520.0, 600.0, 680.0], 16)
    true = propmap.Rotor(MODEL.with_mount(Installed(1.0, AREA))).loads(omega, speed, beta)
    random = np.random.default_rng(7)
    names = ("thrust", "drag", "torque")
    loads = {n: getattr(true, n) * (1.0 + NOISE * random.normal(size=16)) for n in names}
    data = TunnelData("twin", omega, speed, beta, loads)
    fitted = fit(tunnel_rows(MODEL, data, CHOICE), CHOICE, Settings(starts=1, folds=0))
    sure = fitted.uncertainty
    assert fitted.values["mount_area"] == pytest.approx(AREA, rel=0.03)
    assert sure.identified == (True, True)
    # The interval is four standard deviations wide.
    assert abs(fitted.values["mount_area"] - AREA) < sure.high[1] - sure.low[1] < 0.1 * AREA

    path = tmp_path / "mounted.toml"
    text = fit_text(
        fitted,
        kind="tunnel",
        name="mounted",
        model=MODEL,
        data=["uiuc-8x6e"],
        covered=coverage(omega, speed, beta, BLADE.radius),
        envelope=Envelope.of(*data.flow, BLADE.radius),
        hover=np.zeros(fitted.rows.measured.size),
        remarks=(),
        options={},
    )
    path.write_text(text)
    file = read_fit(path)
    (mount,) = file.model.corrections
    assert mount == Installed(1.0, fitted.values["mount_area"])
    assert file.covariance is not None and file.covariance.names == ("c_d", "mount_area")
    np.testing.assert_allclose(file.covariance.matrix, sure.covariance)
    area = file.record.parameters[1]
    assert (area.name, area.unit, area.value) == ("mount_area", "m^2", mount.area_m2)
    path.write_text(file.airfoil.to_toml())
    assert propmap.Model(BLADE, propmap.airfoil(path)).corrections == file.model.corrections

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
    for choice in (Choice(("mount_area",)), Choice(fixed={"mount_area": 0.001})):
        with pytest.raises(InputError, match=r"mount_area is a param.*remove the \[mount\] table"):
            level_rows(ForceModel(VEHICLE, FLOWN, LAW), choice)


def test_a_planned_flight_knows_the_area_that_is_true() -> None:
    law = replace(LAW, corrections=("installed:factor=1,area_m2=0.004",))
    bare = replace(VEHICLE, mounts=MOUNTS)
    found = expectation(bare, law, log(VELOCITIES), free=("c_l1", "mount_area"))
    assert found.truth.tolist() == [LAW.c_l1, 0.004]
    assert found.uncertainty.low[1] <= 0.004 <= found.uncertainty.high[1]
