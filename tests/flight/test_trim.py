"""Trimmed circles balance the forces, and a fit finds the truth that they were made with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.fit.fit import Settings, fit
from propmap.fit.flight import ForceModel, level_rows
from propmap.fit.parameters import Choice
from propmap.flight.simulate import PAPER_RADIUS, trim, true_values
from propmap.hover import HoverModel
from propmap.units import GRAVITY
from propmap.vehicle.log import FlightLog, pitch_and_roll
from propmap.vehicle.vehicle import Body, Vehicle, Wing

from .conftest import SPEEDS


def _force(vehicle: Vehicle, airfoil: propmap.Airfoil, log: FlightLog) -> np.ndarray:
    values = true_values(vehicle, airfoil)
    return ForceModel(vehicle, log, airfoil).at(values, ()).force


def test_circles(points: FlightLog) -> None:
    assert points.speed == pytest.approx(SPEEDS)
    assert np.abs(points.climb_rate).max() < 1e-12
    turn = np.sum(points.rates * points.up, axis=1)
    assert turn == pytest.approx(SPEEDS / PAPER_RADIUS)
    pitch, roll = pitch_and_roll(points.up)
    assert (np.diff(pitch) > 0.0).all() and pitch[0] > 0.0
    assert roll == pytest.approx(0.0)
    # To the left, where the tether pulls, and up.
    assert points.specific_force[:, 1] == pytest.approx(SPEEDS**2 / PAPER_RADIUS)
    assert np.sum(points.specific_force * points.up, axis=1) == pytest.approx(GRAVITY)
    assert (np.ptp(points.rotor_speed, axis=1) == 0.0).all()


def test_hover_is_the_hover_model(vehicle: Vehicle, airfoil: propmap.Airfoil) -> None:
    still = trim(vehicle, airfoil, np.array([0.0]))
    rotor = propmap.Rotor(propmap.Model(vehicle.propeller, airfoil, vehicle.air))
    model = HoverModel.from_rotor(rotor, float(still.rotor_speed[0, 0]))
    needed = np.sqrt(vehicle.mass * GRAVITY / (4.0 * model.k_thrust))
    # Thrust agrees to 0.1 %, as above, the speed to half of that.
    assert still.rotor_speed == pytest.approx(needed, rel=5e-4)
    assert still.up == pytest.approx(np.array([[0.0, 0.0, 1.0]]), abs=1e-9)


def test_banked_circles(vehicle: Vehicle, airfoil: propmap.Airfoil) -> None:
    radius, speeds = 40.0, np.array([4.0, 9.0, 14.0])
    banked = trim(vehicle, airfoil, speeds, radius=radius, tether=False)
    force = _force(vehicle, airfoil, banked) / vehicle.mass
    assert force == pytest.approx(banked.specific_force, abs=1e-6 * GRAVITY)
    assert np.linalg.norm(force, axis=1) == pytest.approx(
        np.hypot(GRAVITY, speeds**2 / radius), rel=1e-6
    )
    # A circle to the left, left side down.
    assert (pitch_and_roll(banked.up)[1] < 0.0).all()


def test_body_and_wing_are_carried(vehicle: Vehicle, airfoil: propmap.Airfoil) -> None:
    speeds = np.array([6.0, 12.0])
    plain = trim(vehicle, airfoil, speeds)
    draggy = replace(vehicle, body=Body((0.02, 0.0, 0.0)))
    assert (pitch_and_roll(trim(draggy, airfoil, speeds).up)[0] > pitch_and_roll(plain.up)[0]).all()
    winged = replace(vehicle, wing=Wing(0.03, incidence=0.3))
    log = trim(winged, airfoil, speeds)
    assert (log.rotor_speed < plain.rotor_speed).all()
    vertical = np.sum(_force(winged, airfoil, log) * log.up, axis=1)
    assert vertical == pytest.approx(winged.mass * GRAVITY, rel=1e-6)


def test_a_disturbance_is_what_a_fit_sees(vehicle: Vehicle, airfoil: propmap.Airfoil) -> None:
    share = np.array([0.02, -0.03])
    log = trim(vehicle, airfoil, np.array([3.0, 8.0]), disturbance=share)
    weight = vehicle.mass * GRAVITY
    vertical = np.sum(_force(vehicle, airfoil, log) * log.up, axis=1)
    assert vertical / weight - 1.0 == pytest.approx(share, abs=1e-6)
    assert np.sum(log.specific_force * log.up, axis=1) == pytest.approx(GRAVITY)
    # The rest balances: no force is left along the path.
    along = np.sum(_force(vehicle, airfoil, log) * log.velocity, axis=1) / log.speed
    assert np.abs(along).max() < 1e-6 * weight


def test_what_cannot_be_flown_is_named(vehicle: Vehicle, airfoil: propmap.Airfoil) -> None:
    with pytest.raises(InputError, match=r"^60 m/s cannot be flown.*; 5 m/s is possible"):
        trim(vehicle, airfoil, np.array([5.0, 60.0]))
    with pytest.raises(InputError, match="wider circles"):
        trim(vehicle, airfoil, np.array([5.0, 14.0]), radius=0.5, tether=False)
    with pytest.raises(InputError, match="speeds"):
        trim(vehicle, airfoil, np.array([5.0, -1.0]))
    with pytest.raises(InputError, match="radius"):
        trim(vehicle, airfoil, np.array([5.0]), radius=0.0)


def test_a_fit_finds_the_truth(
    vehicle: Vehicle, airfoil: propmap.Airfoil, points: FlightLog
) -> None:
    choice = Choice()
    rows = level_rows(ForceModel(vehicle, points, airfoil), choice)
    found = fit(rows, choice, Settings(starts=1, folds=0))
    assert np.abs(found.minimum.residual).max() < 1e-6
    for name, share in (("c_l1", 1e-3), ("c_d", 1e-3), ("alpha_0", 1e-3)):
        assert found.values[name] == pytest.approx(getattr(airfoil, name), rel=share), name
