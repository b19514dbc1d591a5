"""Force and moment on a whole vehicle, beside a sum over rotors written with loops and scalars."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import propmap
from propmap import InputError, VehicleForces
from propmap.model.airfoil import SectionCovariance, SectionUncertainty
from propmap.model.corrections import Installed
from propmap.model.envelope import Envelope
from propmap.vehicle.vehicle import Body, Mount, Vehicle, Wakes, Wing

from .wrench_by_hand import by_hand

PROPELLER = propmap.propeller("apc-8x6e")
MODEL = propmap.Model(
    PROPELLER,
    propmap.airfoil("apc-8x6e-2019"),
    corrections=propmap.model_corrections("recommended"),
)
ROTOR = propmap.Rotor(MODEL)
LEAN = (math.sin(0.1), 0.0, math.cos(0.1))
QUAD = Vehicle(
    "quad",
    1.2,
    PROPELLER,
    (
        Mount((0.16, 0.17, 0.02), spin="cw"),
        Mount((-0.16, 0.15, 0.02), LEAN, "ccw", Installed(2e-3)),
        Mount((-0.16, -0.17, 0.03), spin="cw"),
        Mount((0.16, -0.15, 0.02), (0.0, -0.28, 0.96), "ccw"),
    ),
    body=Body((0.015, 0.02, 0.03), 0.01, (0.004, 0.006), 0.02),
    wing=Wing(0.05, 0.1, 4.5, 1.0, 0.25),
)
WAKES = Wakes(1.5, 0.7, 1.2, 0.8)
IN_WAKES = replace(QUAD, mounts=QUAD.mounts[1:], wakes=WAKES)
"""Three rotors, because each pair has a table of its own."""

CORNERS = ((1, 1, "cw"), (-1, 1, "ccw"), (-1, -1, "cw"), (1, -1, "ccw"))
SYMMETRIC = Vehicle(
    "symmetric",
    1.2,
    PROPELLER,
    tuple(Mount((0.16 * x, 0.16 * y, 0.02), spin=spin) for x, y, spin in CORNERS),
)


def states(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    omegas = rng.uniform(450.0, 800.0, (count, 4))
    velocity = rng.normal(0.0, 5.0, (count, 3)) * [1.0, 1.0, 0.4] + [0.0, 0.0, 2.0]
    return omegas, velocity, rng.normal(0.0, 1.5, (count, 3)), rng.normal(0.0, 2.0, (count, 3))


@pytest.mark.parametrize("vehicle", [QUAD, IN_WAKES], ids=["alone", "wakes"])
def test_the_sum_of_all_parts(vehicle: Vehicle) -> None:
    omegas, *given = states(3)
    given.insert(0, omegas[:, : len(vehicle.mounts)])
    if vehicle.wakes is not None:
        given[1][:, 2] = np.abs(given[1][:, 2]) + 6.0
    found = VehicleForces(vehicle, ROTOR).wrench(*given)
    tolerance = 1e-9
    parts = found.rotor_force.sum(axis=1) + found.body_force + found.wing_force
    np.testing.assert_allclose(found.force, parts, rtol=1e-14)
    np.testing.assert_allclose(found.moment, found.rotor_moment.sum(axis=1), rtol=1e-14)
    np.testing.assert_allclose(found.power, np.sum(found.torque * given[0], axis=1), rtol=1e-14)
    assert np.abs(found.body_force).min() > 0.0 and np.abs(found.wing_force[:, 0]).min() > 0.0
    for k, state in enumerate(zip(*given, strict=True)):
        force, moment, power = by_hand(ROTOR, vehicle, *state)
        size = float(np.linalg.norm(force))
        np.testing.assert_allclose(found.force[k], force, atol=tolerance * size)
        np.testing.assert_allclose(found.moment[k], moment, atol=tolerance * 0.2 * size)
        assert found.power[k] == pytest.approx(power, rel=tolerance)


def test_rotors_that_turn_backward_push_down() -> None:
    forces, omega = VehicleForces(SYMMETRIC, ROTOR), np.array([-600.0, -600.0, 600.0, 600.0])
    found = forces.wrench(omega, [0.0, 0.0, 0.0])
    alone = [float(ROTOR.loads(w, 0.0, 0.0).thrust) for w in omega]
    np.testing.assert_allclose(found.thrust, alone)
    assert found.status == "reversed" and found.power > 0.0
    with pytest.raises(InputError, match="omega is negative"):
        VehicleForces(replace(SYMMETRIC, wakes=WAKES), ROTOR).wrench(omega, [0.0, 0.0, 0.0])


def test_a_batch_is_a_loop_of_scalars() -> None:
    forces = VehicleForces(IN_WAKES, ROTOR)
    omegas, velocity, rates, wind = states(5, seed=4)
    omegas = omegas[:, :3]
    found = forces.wrench(omegas[:3, None], velocity, rates, wind[0])
    assert found.force.shape == (3, 5, 3) and found.status.shape == (3, 5)
    for i in range(3):
        for j in range(5):
            one = forces.wrench(omegas[i], velocity[j], rates[j], wind[0])
            for name in vars(one):
                each, among = getattr(one, name), getattr(found, name)[i, j]
                if name in ("status", "rotor_status"):
                    np.testing.assert_array_equal(each, among)
                else:
                    np.testing.assert_allclose(each, among, rtol=1e-9, atol=1e-9, err_msg=name)


class Patchy:
    """Thrust and torque of a rotor that has none to tell about at high speeds."""

    def loads_at_velocity(self, omega: np.ndarray, velocity: np.ndarray) -> Any:
        del velocity
        lost = omega > 900.0
        status = np.where(lost, "not_converged", np.where(omega > 800.0, "vortex_ring", "ok"))
        thrust = np.where(lost, np.nan, 1e-5 * omega**2)
        rest = dict.fromkeys(("drag", "roll_moment", "side_force", "pitch_moment"), 0.0 * thrust)
        return SimpleNamespace(thrust=thrust, torque=0.02 * thrust, status=status, **rest)


def test_the_worst_status_and_no_number_where_loads_are_lost() -> None:
    pair = replace(SYMMETRIC, mounts=SYMMETRIC.mounts[:2], wakes=WAKES)
    forces = VehicleForces(pair, Patchy())
    omegas = [[600.0, 600.0], [600.0, 850.0], [850.0, 950.0]]
    found = forces.wrench(omegas, [0.0, 0.0, 0.0])
    assert found.status.tolist() == ["ok", "vortex_ring", "not_converged"]
    np.testing.assert_array_equal(np.isnan(found.force).any(axis=1), [False, False, True])
    assert np.isnan(found.moment[2]).all() and np.isnan(found.power[2])
    assert found.rotor_status[2, 1] == "not_converged"


def test_a_rotor_beyond_the_data_of_its_constants_is_extrapolated() -> None:
    ends = Envelope((0.0, 100.0), (0.0, 0.1), (0.0, 0.1), (-0.05, 0.05), (5000.0, 7000.0))
    known = SectionUncertainty(SectionCovariance((), np.zeros((0, 0))), envelope=ends)
    law = replace(MODEL.airfoil, uncertainty=known)
    forces = VehicleForces(SYMMETRIC, propmap.Rotor(replace(MODEL, airfoil=law)))
    slow, fast, sinking = [3.0, 0.0, 0.0], [12.0, 0.0, 0.0], [0.0, 0.0, -6.5]
    found = forces.wrench([600.0] * 4, [slow, fast, sinking])
    assert found.status[:2].tolist() == ["ok", "extrapolated"]
    # What momentum theory cannot tell is worse.
    assert found.status[2] == "vortex_ring"
    assert (found.rotor_status[1] == "extrapolated").all()
    one = forces.wrench([[600.0, 600.0, 600.0, 900.0]], slow)
    assert one.rotor_status[0].tolist() == ["ok", "ok", "ok", "extrapolated"]
    assert one.status.tolist() == ["extrapolated"]
    # The loads are those of the same rotor without a word.
    plain = VehicleForces(SYMMETRIC, ROTOR).wrench([600.0] * 4, [slow, fast, sinking])
    np.testing.assert_array_equal(found.force, plain.force)
    assert "extrapolated" not in plain.status


STATE: dict[str, Any] = {"omega": [600.0] * 4, "velocity": [1.0, 0.0, 0.0]}
WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "three speeds": ({"omega": [600.0] * 3}, "omega has shape (3,); its last axis must be the"),
    "complex": ({"omega": [600.0 + 1.0j] * 4}, "give a real number"),
    "masked": (
        {"velocity": np.ma.masked_less([1.0, -9.0, 0.0], 0.0)},
        "velocity has masked points",
    ),
    "negative": ({"omega": [600.0, -600.0, 600.0, 600.0]}, "omega is negative (-600): give a"),
    "no number": ({"omega": [600.0, 600.0, 600.0, math.nan]}, "omega contains a value that is"),
    "lengths": (
        {"omega": np.full((3, 4), 600.0), "velocity": np.zeros((2, 3))},
        "shapes do not fit together: omega (3, 4), velocity (2, 3), rates (3,), wind (3,)",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_bad_states(case: str) -> None:
    changes, message = WRONG[case]
    with pytest.raises(InputError, match=re.escape(message)) as caught:
        VehicleForces(SYMMETRIC, Patchy()).wrench(**(STATE | changes))
    assert "\n" not in str(caught.value)


def test_bad_sources() -> None:
    with pytest.raises(InputError, match="another propeller"):
        VehicleForces(replace(QUAD, propeller=propmap.propeller("apc-9x6e")), ROTOR)
    with pytest.raises(InputError, match="loads is Model; give a Rotor or a LoadTable"):
        VehicleForces(QUAD, MODEL)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"vehicle is str; give propmap.read_vehicle\(path\).ve"):
        VehicleForces("quad.toml", ROTOR)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"\[mount\], which does not apply to a table"):
        VehicleForces(QUAD, Patchy())
    close = (*SYMMETRIC.mounts, replace(SYMMETRIC.mounts[0], spin="ccw"))
    with pytest.raises(InputError, match="rotors 1 and 5 are 0 m apart"):
        VehicleForces(replace(SYMMETRIC, mounts=close, wakes=WAKES), ROTOR)
