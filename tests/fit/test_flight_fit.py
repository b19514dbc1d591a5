"""Force balances of a vehicle: signs, geometry, body, wing, derivatives, and real flights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.cli.fit_flight import flight_priors, free_by_default, with_flight_priors
from propmap.errors import InputError
from propmap.fit.comparison import compare_forces, flight_forces
from propmap.fit.fit import range_warnings
from propmap.fit.flight import ForceModel, balance_rows, body_force, level_rows, wing_values
from propmap.fit.parameters import FIRST_GUESS, SECTION, WAKES, Choice
from propmap.units import GRAVITY
from propmap.vehicle.log import FlightLog, hub_flow
from propmap.vehicle.vehicle import Body, Vehicle, Wing

from .flight_twin import ARM
from .flight_twin import VEHICLE as TWIN

PROPELLER = propmap.propeller("apc-8x6e")
LAW = propmap.airfoil("paper-apc")
LAW_VALUES = {name: getattr(LAW, name) for name in SECTION}
VALUES = FIRST_GUESS | LAW_VALUES
TWO = Choice(("c_l1", "alpha_0"))

MOUNTS = TWIN.mounts
OMEGA = 600.0


def vehicle(**changes: object) -> Vehicle:
    made = Vehicle("test", 1.0, PROPELLER, MOUNTS)
    return replace(made, **changes)  # type: ignore[arg-type]


def log(
    velocity: object = ((0.0, 0.0, 0.0),),
    rates: object = (0.0, 0.0, 0.0),
    up: object = (0.0, 0.0, 1.0),
    rotors: int = 4,
) -> FlightLog:
    """Samples, one second apart, of one attitude; up is what an accelerometer at rest reads."""
    v = np.array(velocity, float)
    one = np.ones((len(v), 1))
    return FlightLog(
        "test",
        np.arange(len(v), dtype=float),
        v,
        one * np.array(rates, float),
        one * np.array(up, float),
        GRAVITY * one * np.array(up, float),
        np.full((len(v), rotors), OMEGA),
    )


def model(log: FlightLog, **changes: object) -> ForceModel:
    return ForceModel(vehicle(**changes), log, LAW)


@pytest.fixture(scope="module")
def static_thrust() -> float:
    """Thrust of one rotor at ``OMEGA`` [N]."""
    return float(propmap.Rotor(propmap.Model(PROPELLER, LAW)).loads(OMEGA, 0.0, 0.0).thrust)


CLOSE = 2e-3  # Twice the accuracy of the loads.


def test_hovering_with_thrust_as_weight_leaves_nothing(static_thrust: float) -> None:
    still = model(log(((0, 0, 0), (0, 0, 0))), mass=4.0 * static_thrust / GRAVITY)
    for rows in (level_rows(still, TWO), balance_rows(still, TWO)):
        value, _ = rows.model(VALUES, TWO.free)
        np.testing.assert_allclose((value - rows.measured) / rows.scale, 0.0, atol=CLOSE)
        np.testing.assert_allclose(rows.scale, 4.0 * static_thrust)
    rows = level_rows(still, TWO)
    assert rows.names == ("vertical_force",) and rows.group is None


# Climbing.
VELOCITIES = ((8.0, 0.0, 1.0), (0.0, -8.0, 1.0), (-4.0, 3.0, 1.0), (5.0, 5.0, 1.0))


@pytest.fixture(scope="module")
def moving() -> ForceModel:
    return model(log(VELOCITIES, rates=(0.4, -0.3, 2.0)))


def test_forces_are_the_sum_of_the_rotors_wrenches(moving: ForceModel) -> None:
    """Against ``Rotor.wrench``, hub by hub: omega x r and the direction of the drag."""
    rotor = propmap.Rotor(propmap.Model(PROPELLER, LAW))
    total = np.zeros((4, 3))
    for mount in MOUNTS:
        hub = moving.log.velocity + np.cross(moving.log.rates, np.array(mount.position))
        total += rotor.wrench(OMEGA, hub, mount.spin).force
    np.testing.assert_allclose(moving.at(VALUES, TWO.free).force, total, atol=CLOSE * 10)


def test_hubs_move_with_the_turning_vehicle() -> None:
    flow = hub_flow(vehicle(), log(((0.0, 0.0, 0.0),), rates=(0.0, 0.0, 3.0)))
    np.testing.assert_allclose(flow.inplane, 3.0 * ARM * np.sqrt(2.0) * np.ones((1, 4)))
    np.testing.assert_allclose(flow.axial, 0.0)
    # Turning to the left, the hub ahead on the left moves backwards on the left: (-1, 1).
    np.testing.assert_allclose(flow.downstream[0, 0], np.array([1, -1, 0]) / np.sqrt(2.0))
    rolling = hub_flow(vehicle(), log(((0.0, 0.0, 0.0),), rates=(2.0, 0.0, 0.0)))
    # Rolling to the right lifts the left side.
    np.testing.assert_allclose(rolling.axial, [[2 * ARM, -2 * ARM, 2 * ARM, -2 * ARM]])


def body(
    velocity: object, changes: Mapping[str, float] | None = None, **vehicle_changes: object
) -> np.ndarray:
    values = VALUES | dict(changes or {})
    return body_force(vehicle(**vehicle_changes), log(velocity), values, ())[0]


def test_body_drag_per_axis() -> None:
    density = propmap.Air().density
    areas = {"drag_area_x": 0.01, "drag_area_y": 0.02, "drag_area_z": 0.03}
    found = body(((4, 0, 0), (0, -4, 0), (0, 0, 4), (3, 4, -5)), areas)
    per = 0.5 * density * np.array([0.01, 0.02, 0.03])
    np.testing.assert_allclose(found[0], [-16 * per[0], 0, 0], atol=1e-12)
    np.testing.assert_allclose(found[1], [0, 16 * per[1], 0], atol=1e-12)
    np.testing.assert_allclose(found[2], [0, 0, -16 * per[2]], atol=1e-12)
    np.testing.assert_allclose(found[3], [-9 * per[0], -16 * per[1], 25 * per[2]])
    # What the vehicle file gives adds up.
    both = body(((4, 0, 0),), areas, body=Body(drag_area=(0.02, 0.0, 0.0)))
    np.testing.assert_allclose(both[0], 3.0 * found[0])


def test_a_plate_s_force_goes_with_the_sine_of_the_angle() -> None:
    angle = np.radians([0.0, 20.0, -45.0, 90.0])
    bearing = np.array([0.0, 0.3, 2.0, 0.0])
    ahead = np.cos(angle)[:, None] * np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
    velocity = 8.0 * np.column_stack([ahead, np.sin(angle)])
    found = body(velocity, {"plate_area": 0.03})
    most = body(((0.0, 0.0, 8.0),), {"drag_area_z": 0.03})[0, 2]
    np.testing.assert_allclose(found[:, :2], 0.0)
    np.testing.assert_allclose(found[:, 2], most * np.sin(angle), atol=1e-12)
    np.testing.assert_allclose(body(velocity, body=Body(plate_area=0.03)), found)


def test_body_lift_is_across_the_flow() -> None:
    """1/2 rho V^2 A sin(a) cos(a), upwards where the air comes from below."""
    sinking = body(((6.0, 0.0, -2.0),), {"lift_area": 0.05})[0]
    angle, speed2 = np.arctan2(2.0, 6.0), 40.0
    expected = 0.5 * propmap.Air().density * speed2 * 0.05 * np.sin(angle) * np.cos(angle)
    assert np.linalg.norm(sinking) == pytest.approx(expected)
    assert sinking @ [6.0, 0.0, -2.0] == pytest.approx(0.0, abs=1e-12)
    assert sinking[2] > 0.0
    by_file = body(((6.0, 0.0, -2.0),), body=Body(lift_area=0.05))[0]
    np.testing.assert_allclose(by_file, sinking)


def test_a_wing_s_lift_is_equation_3() -> None:
    angle = np.radians([-60.0, -12.0, 3.0, 12.0, 18.0, 40.0])
    speed, area, incidence = 9.0, 0.12, 0.15
    velocity = np.stack([np.cos(angle), 0.0 * angle, -np.sin(angle)], axis=1) * speed
    wing = Wing(area, incidence, c_l1=4.5, c_l2=1.1, alpha_0=0.28)
    found = body(velocity, wing_values(vehicle(wing=wing)), wing=Wing(area, incidence))
    law = propmap.Airfoil(c_l1=4.5, c_l2=1.1, c_d=0.01, c_d0=0.0, alpha_0=0.28)
    c_l = law.coefficients(angle + incidence, 1e5)[0]
    across = np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=1)
    expected = 0.5 * propmap.Air().density * speed**2 * area * c_l[:, None] * across
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-5)
    assert wing_values(vehicle()) == {}


def test_balance_rows_are_three_per_sample(moving: ForceModel) -> None:
    rows = balance_rows(moving, TWO, segment=2.0)
    assert rows.names == ("force_x", "force_y", "force_z")
    np.testing.assert_array_equal(rows.load, np.tile([0, 1, 2], 4))
    np.testing.assert_array_equal(rows.point, np.repeat([0, 1, 2, 3], 3))
    np.testing.assert_array_equal(rows.group, np.repeat([0, 0, 1, 1], 3))
    np.testing.assert_allclose(rows.measured.reshape(4, 3)[:, 2], GRAVITY)
    np.testing.assert_allclose(rows.speed, np.repeat(moving.log.speed, 3))
    value, slope = rows.model(VALUES, TWO.free)
    balance = moving.at(VALUES, TWO.free)
    np.testing.assert_array_equal(value, balance.force.ravel())
    np.testing.assert_array_equal(slope[5], balance.slopes[:, 1, 2])


def test_the_comparison_sees_what_the_rows_see(moving: ForceModel) -> None:
    more = {"drag_area_x": 0.02, "wake_ahead": 1.8}
    forces = flight_forces(moving.vehicle, moving.log, LAW, more)
    found = compare_forces(moving.vehicle, moving.log, forces)
    assert tuple(found) == ("force_x_N", "force_y_N", "force_z_N")
    off = moving.at(VALUES | more, TWO.free).force - moving.log.specific_force * moving.vehicle.mass
    for k, name in enumerate(found):
        rms = float(np.sqrt(np.mean(off[:, k] ** 2)))
        assert found[name].all.rms == pytest.approx(rms, abs=0.02), name
        assert found[name].all.rows == 4
    # The hover model has no force in the plane of the rotors.
    measured = moving.log.specific_force[:, 0]
    assert found["force_x_N"].all.hover_rms == pytest.approx(np.sqrt(np.mean(measured**2)))


def test_refusals() -> None:
    still = log(((0, 0, 0), (0, 0, 0)))
    unmeasured = replace(still, specific_force=np.full((2, 3), np.nan))
    with pytest.raises(InputError, match=r"some samples have no specific force .* --method level"):
        balance_rows(model(unmeasured), TWO)
    with pytest.raises(InputError, match="no specific force to compare with"):
        compare_forces(vehicle(), unmeasured, flight_forces(vehicle(), unmeasured, LAW, {}))
    # A table of operating points has none, and needs none.
    assert level_rows(model(unmeasured), TWO).measured.size == 2
    for rows in (level_rows, balance_rows):
        with pytest.raises(InputError, match="wing_c_l1 is free but the vehicle has no wing"):
            rows(model(still), Choice(("c_l1", "wing_c_l1")))
    with pytest.raises(InputError, match=r"6 rotor speeds for 4 rotors; .*\[\[rotors\]\]"):
        model(log(rotors=6))
    winged = model(still, wing=Wing(0.1))
    assert level_rows(winged, Choice(("wing_c_l1",))).measured.size == 2


def test_what_the_range_of_speeds_cannot_tell() -> None:
    def told(*speeds: float) -> list[str]:
        return range_warnings(level_rows(model(log([(v, 0.0, 0.0) for v in speeds])), TWO))

    assert told(0.0, 5.0, 9.0) == []
    (hover,), (one,) = told(0.0, 0.3, 0.5), told(7.0, 7.5, 8.0)
    assert "all data are from hover" in hover
    assert "all data are from one speed, 7.0 to 8.0 m/s" in one


def test_wakes_and_body_are_free_by_default_in_fast_flights() -> None:
    """Below half of the inflow of hover, the wakes hardly reach other rotors, and the force of the
    body is as small as errors of the thrust."""
    disk = vehicle().air.density * np.pi * PROPELLER.radius**2
    inflow = np.sqrt(GRAVITY / 4.0 / (2.0 * disk))
    slow, fast, of_one = (
        log(((0.0, 0.0, 0.0), (k * inflow, 0.0, 0.0))) for k in (0.49, 0.51, 1.02)
    )
    one = vehicle(mounts=MOUNTS[:1])
    body = {"plate_area", "download_area_x", "download_area_y"}
    assert not (body | set(WAKES)) & set(free_by_default(vehicle(), slow, level=False))
    assert body | set(WAKES) <= set(free_by_default(vehicle(), fast, level=False))
    alone = set(free_by_default(one, of_one, level=False))
    assert body <= alone and not set(WAKES) & alone


def test_a_wing_takes_the_place_of_the_plate_in_fits() -> None:
    flown, rotors = log(((5.0, 0.0, 1.0),)), vehicle()
    free = free_by_default(rotors, flown, level=False)
    winged = free_by_default(replace(rotors, wing=Wing(0.1)), flown, level=False)
    assert "plate_area" in free and "drag_area_z" not in free
    assert "drag_area_z" in winged and "plate_area" not in winged
    # A search would hardly leave a bound that it starts at.
    known = flight_priors(rotors, flown, hover=False)
    choice = with_flight_priors(Choice(free), known)
    assert choice.first[free.index("plate_area")] == known["plate_area"].deviation > 0.0
