"""Balance of moments: a rigid body with rotors, its motion made by SciPy and explained again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.fit.flight import ForceModel, balance_rows
from propmap.fit.moments import FACTORS, measured_moment, moment_of_all
from propmap.fit.parameters import FIRST_GUESS, SECTION, TURNING, Choice
from propmap.vehicle.log import hub_flow
from tests.fit.flight_twin import LAW, VEHICLE, manoeuvre

LAW_VALUES = {name: getattr(LAW, name) for name in SECTION}
BODY = replace(VEHICLE, rotor_inertia=2e-5)


def test_free_rotation_needs_no_moment() -> None:
    """Euler's equations of a top with a spinning rotor, integrated by SciPy."""
    from scipy.integrate import solve_ivp

    log = manoeuvre(0, 200)
    inertia = np.array([4e-3, 5e-3, 8e-3])
    momentum = BODY.rotor_inertia * np.array([0.0, 0.0, 3.0 * 500.0])

    def turning(_: float, rates: np.ndarray) -> np.ndarray:
        return -np.cross(rates, inertia * rates + momentum) / inertia

    time = np.linspace(0.0, 1.0, len(log))
    rates = solve_ivp(turning, (0.0, 1.0), [3.0, -2.0, 1.0], t_eval=time, rtol=1e-10, atol=1e-12).y
    slopes = np.array([turning(0.0, one) for one in rates.T])
    # Three of four rotors turn the same way more than the other: momentum of 3 x 500 rad/s.
    spin = np.array([1.0 if mount.spin == "ccw" else -1.0 for mount in BODY.mounts])
    speeds = np.full((len(log), len(spin)), 500.0)
    speeds += spin * (3.0 * 500.0 - spin.sum() * 500.0) / len(spin)
    free = replace(
        log,
        rates=rates.T,
        angular_acceleration=slopes,
        rotor_speed=speeds,
        rotor_acceleration=np.zeros_like(speeds),
    )
    none = np.zeros((0, len(log), 6))
    still = np.zeros((len(log), 6))
    reaction, _ = moment_of_all(BODY, free, hub_flow(BODY, free), still, none, {}, ())
    np.testing.assert_allclose(measured_moment(BODY, free), reaction, atol=1e-9)
    assert np.abs(reaction).max() > 1e-2


def test_a_shifted_center_and_a_spun_up_rotor() -> None:
    log = replace(manoeuvre(0, 5), rotor_acceleration=np.full((5, 4), 1000.0))
    flow, up = hub_flow(BODY, log), np.tile([0.0, 0.0, 8.0, 0.0, 0.0, 0.0], (5, 1))
    names = ("center_x", "center_y", "rotor_inertia")
    zero = np.zeros((3, 5, 6))
    values = {"center_x": 0.01, "center_y": -0.02}
    base, _ = moment_of_all(BODY, log, flow, up, zero, {}, names)
    moved, slopes = moment_of_all(BODY, log, flow, up, zero, values, names)
    # Lift behind the center of mass turns the nose down: about y, to the left, it is positive.
    np.testing.assert_allclose(moved - base, np.tile([0.02 * 8.0, 0.01 * 8.0, 0.0], (5, 1)))
    np.testing.assert_allclose(slopes[0], np.tile([0.0, 8.0, 0.0], (5, 1)))
    np.testing.assert_allclose(base, BODY.rotor_inertia * slopes[2])
    scaled, by_scale = moment_of_all(
        BODY, log, flow, up, zero[:2], values | {"moment_scale_xy": 0.3}, tuple(FACTORS)
    )
    np.testing.assert_allclose(scaled, moved * [0.3, 0.3, 1.0])
    np.testing.assert_allclose(by_scale.sum(axis=0), moved)


HOVER = replace(
    manoeuvre(0, 1),
    velocity=np.zeros((1, 3)),
    rates=np.zeros((1, 3)),
    rotor_speed=np.full((1, 4), 560.0),
    rotor_acceleration=np.zeros((1, 4)),
)


def test_a_rotor_that_spins_up_turns_the_vehicle_against_its_spin() -> None:
    for k, mount in enumerate(BODY.mounts):
        faster = replace(HOVER, rotor_acceleration=1000.0 * np.eye(4)[[k]])
        moment = ForceModel(BODY, faster, LAW).at(FIRST_GUESS | LAW_VALUES, ()).moment
        # "ccw" from above is positive about z, which points up.
        sign = -1.0 if mount.spin == "ccw" else 1.0
        # Nothing else turns a symmetric vehicle in hover.
        np.testing.assert_allclose(moment[0], [0.0, 0.0, sign * 1000.0 * 2e-5], atol=1e-12)


def test_turning_changes_no_forces_and_needs_the_inertia() -> None:
    log, bare = manoeuvre(0, 20), replace(BODY, inertia=None)
    values = FIRST_GUESS | LAW_VALUES
    turned = values | {name: 0.5 * one.upper for name, one in TURNING.items()}
    forces = [ForceModel(bare, log, LAW).at(one, ()).force for one in (values, turned)]
    np.testing.assert_allclose(*forces, rtol=1e-12)
    fixed = {n: v for n, v in LAW_VALUES.items() if n != "c_l1"}
    rows = balance_rows(ForceModel(BODY, log, LAW), Choice(("c_l1", "center_x"), fixed))
    assert rows.names[3:] == ("moment_x", "moment_y", "moment_z")
    assert rows.units[3] == "N m" and rows.measured.size == 6 * len(log)
    rows = balance_rows(ForceModel(bare, log, LAW), Choice(("c_l1",), fixed))
    assert rows.names == ("force_x", "force_y", "force_z")
    with pytest.raises(InputError, match="add inertia"):
        balance_rows(ForceModel(bare, log, LAW), Choice(("c_l1", "center_x"), fixed))
