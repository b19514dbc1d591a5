"""A vehicle's rotors in JAX and MJX: the numbers of ``VehicleForces``, and derivatives of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest

import propmap
from propmap import InputError, VehicleForces
from propmap.sim.mjx import JaxForces, MjxRotors
from propmap.table import STATUSES
from propmap.vehicle.vehicle import Wakes, Wing
from tests.export.test_vehicle_export import ASKEW, VEHICLES, table_of

LEAN = ASKEW[3].axis
VEHICLE = replace(
    VEHICLES["askew, with a wing and lift"], wing=Wing(0.05, 0.1, 4.5, 1.0, 0.25, 0.6)
)
TABLE = table_of(VEHICLE)
TABLE.content.cells[:, 20:] = 1  # vortex rings in descent
CHEAPLY = {"xla_backend_optimization_level": 0}
"""Most of the time of these tests goes into compiling."""

WRENCH = jax.jit(JaxForces.wrench, static_argnames="clamp", compiler_options=CHEAPLY)


def states(count: int, seed: int = 0) -> tuple[np.ndarray, ...]:
    """Rotor speeds, velocities, rates and winds inside the table."""
    rng = np.random.default_rng(seed)
    omegas, rates = rng.uniform(300.0, 900.0, (count, 4)), rng.normal(0.0, 1.0, (count, 3))
    return omegas, rng.normal(0.0, 2.0, (count, 3)), rates, rng.normal(0.0, 1.0, (count, 3))


def special_states() -> tuple[np.ndarray, ...]:
    """Velocities and rates at which some direction is not defined."""
    along = [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], LEAN, [1.0, 0.0, 0.0]
    velocity = 3.0 * np.array([*along, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    rates = np.zeros((6, 3))
    rates[-1] = [0.5, -0.3, 2.0]
    return np.tile([500.0, 600.0, 550.0, 700.0], (6, 1)), velocity, rates, 0.0 * rates


BEYOND = 4


def beyond_the_table() -> tuple[np.ndarray, ...]:
    """Slow and reversed rotors, a fast one among others, and flight that is too fast."""
    omegas = np.array([[150.0] * 4, [-5.0] * 4, [500.0, 500.0, 500.0, 1200.0], [500.0] * 4])
    velocity = np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 40.0]])
    return omegas, velocity, np.zeros((BEYOND, 3)), np.zeros((BEYOND, 3))


@pytest.mark.parametrize(("x64", "tolerance"), [(True, 1e-9), (False, 3e-5)])
def test_it_is_the_wrench_of_numpy(x64: bool, tolerance: float) -> None:
    parts = zip(states(200), special_states(), beyond_the_table(), strict=True)
    given = [np.concatenate(part) for part in parts]
    # Slow rotors have no loads either; for ``VehicleForces`` a negative speed is an error.
    expected = VehicleForces(VEHICLE, TABLE).wrench(np.abs(given[0]), *given[1:])
    with jax.enable_x64(x64):
        forces = JaxForces.from_vehicle(VEHICLE, TABLE)
        found = WRENCH(forces, *given)
        assert found.force.dtype == (jnp.float64 if x64 else jnp.float32)
    size = np.abs(expected.rotor_force[:-BEYOND]).max()
    assert np.isnan(expected.force[-BEYOND:]).all() and np.isfinite(expected.force[:-BEYOND]).all()
    np.testing.assert_allclose(found.force, expected.force, atol=tolerance * size, rtol=0.0)
    np.testing.assert_allclose(found.moment, expected.moment, atol=tolerance * size, rtol=0.0)
    words = np.array(STATUSES)[found.code]
    np.testing.assert_array_equal(words, expected.status)
    assert set(words.tolist()) == {"ok", "vortex_ring", "outside"}
    if x64:
        return
    held = WRENCH(forces, *given, clamp=True)
    np.testing.assert_array_equal(held.code, found.code)
    assert np.isfinite(held.force).all()
    np.testing.assert_allclose(held.force[:-BEYOND], found.force[:-BEYOND], rtol=1e-5, atol=1e-5)
    given[0][-4:] = np.clip(given[0][-4:], 200.0, 1000.0)  # the ends of the table
    at_end = VehicleForces(VEHICLE, TABLE).wrench(*given).force
    for row in (-4, -3, -2):
        np.testing.assert_allclose(held.force[row], at_end[row], rtol=0.0, atol=tolerance * size)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -500.0])
def test_bad_numbers_have_no_loads(bad: float) -> None:
    """In each speed, velocity, rate and wind; NaN also clamped."""
    forces, good = JaxForces.from_vehicle(VEHICLE, TABLE), states(1)
    for part, array in enumerate(good):
        for k in range(array.shape[1]):
            given = [np.array(x[0]) for x in good]
            given[part][k] = bad
            for clamp in (False, True) if np.isnan(bad) else (False,):
                found = WRENCH(forces, *given, clamp=clamp)
                assert STATUSES[int(found.code)] == "outside"
                assert not np.isfinite([found.force, found.moment]).any()


def differentiated() -> Callable[..., tuple[Any, ...]]:
    """Values and derivatives of a number of which all of force and moment is a part."""
    forces = JaxForces.from_vehicle(VEHICLE, TABLE)
    weights = jnp.array([1.0, -2.0, 0.7, 5.0, 8.0, -6.0])

    def of(omegas: Any, velocity: Any, rates: Any) -> jax.Array:
        found = forces.wrench(omegas, velocity, rates)
        return jnp.concatenate([found.force, found.moment]) @ weights

    many = jax.vmap(jax.value_and_grad(of, argnums=(0, 1, 2)))
    return jax.jit(many, compiler_options=CHEAPLY)


def test_derivatives_are_those_of_differences() -> None:
    """Central ones, over a step beside which 1 mm/s, up to which loads are linear, is little."""
    omegas, velocity, rates, _ = (
        np.concatenate(pair) for pair in zip(states(8, 3), special_states(), strict=True)
    )
    with jax.enable_x64(True):
        many = differentiated()
        _, slopes = many(omegas, velocity, rates)
        given = [omegas, velocity, rates]
        for part, step in enumerate((1e-3, 1e-4, 1e-4)):
            for column in range(given[part].shape[1]):
                ends = []
                for sign in (1.0, -1.0):
                    moved = list(given)
                    moved[part] = moved[part].copy()
                    moved[part][:, column] += sign * step
                    ends.append(np.asarray(many(*moved)[0]))
                difference = (ends[0] - ends[1]) / (2.0 * step)
                # Drag areas have |v| v and the hub's in-plane speed a kink of the second order.
                np.testing.assert_allclose(slopes[part][:, column], difference, 1e-3, 2e-3)


def test_derivatives_are_finite_in_single_precision() -> None:
    many = differentiated()
    omegas, velocity, rates, _ = (jnp.asarray(x, jnp.float32) for x in special_states())
    _, slopes = many(omegas, velocity, rates)
    assert all(np.isfinite(slope).all() and np.abs(slope).min() > 0.0 for slope in slopes)


# --- On a body of MJX ----------------------------------------------------------------------------

MJCF = """<mujoco><option timestep="0.002" gravity="0 0 -9.81"/><worldbody>
<body name="quad" pos="0 0 1"><freejoint/>
<inertial pos="{place}" mass="1.0" diaginertia="0.006 0.007 0.011"/>
<body name="nose" pos="0.1 0 0"><inertial pos="0 0 0" mass="{nose}" diaginertia="1e-5 1e-5 1e-5"/>
</body></body><body name="post"><geom size="0.1"/></body></worldbody></mujoco>"""


def model_of(place: str = "-0.02 0 0", nose: float = 0.2, air: float = 0.0) -> mujoco.MjModel:
    model = mujoco.MjModel.from_xml_string(MJCF.format(place=place, nose=nose))
    model.opt.density = air
    return model


def rotors_on(model: mujoco.MjModel, **changes: Any) -> MjxRotors:
    given = {"vehicle": VEHICLE, "table": TABLE, "body": "quad", "time_constant": 0.05} | changes
    return MjxRotors.from_vehicle(model=model, **given)


def test_the_applied_wrench_accelerates_as_newton_and_euler_have_it() -> None:
    """Turned, moving and turning, with the center of mass off the origin of either body."""
    from mujoco import mjx

    wind, omegas = np.array([1.0, -0.5, 0.2]), np.array([520.0, 560.0, 610.0, 590.0])
    model, heavy = model_of("0.05 -0.03 0.02"), replace(VEHICLE, rotor_inertia=5e-5)
    data = mujoco.MjData(model)
    data.qpos[3:7] = np.array([0.9, 0.2, -0.3, 0.25]) / np.linalg.norm([0.9, 0.2, -0.3, 0.25])
    data.qvel[:] = [1.0, 0.5, -0.4, 0.6, -0.3, 0.8]
    mujoco.mj_forward(model, data)
    at = model.body("quad").id
    turn = data.xmat[at].reshape(3, 3)
    # By MuJoCo's own momentum of the whole: its rate is force, and moment about the center of mass.
    mujoco.mj_subtreeVel(model, data)
    before = data.subtree_linvel[at].copy(), data.subtree_angmom[at].copy()
    expected = VehicleForces(VEHICLE, TABLE).wrench(
        omegas, turn.T @ before[0], data.qvel[3:6], turn.T @ wind
    )
    rates = data.qvel[3:6].copy()
    apply = jax.jit(MjxRotors.apply, compiler_options=CHEAPLY)
    with jax.enable_x64(True):
        rotors = rotors_on(model, vehicle=heavy)
        given = mjx.put_data(model, data), omegas, omegas + 10.0, wind
        state, after, code = apply(rotors, *given)
    # MuJoCo's own dynamics, which MJX has too.
    data.xfrc_applied[:] = state.xfrc_applied
    mujoco.mj_forward(model, data)
    acceleration = data.qacc.copy()
    assert STATUSES[int(code)] == expected.status
    np.testing.assert_allclose(after, omegas + 10.0 * (1.0 - np.exp(-0.002 / 0.05)), rtol=1e-12)
    step = 1e-6
    mujoco.mj_integratePos(model, data.qpos, data.qvel, step)
    data.qvel += step * acceleration
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    force = 1.2 * ((data.subtree_linvel[at] - before[0]) / step + [0.0, 0.0, 9.81])
    moment = (data.subtree_angmom[at] - before[1]) / step
    np.testing.assert_allclose(force, turn @ expected.force, atol=1e-4)
    # What the rotors gain of angular momentum, and what turning it takes, the body loses.
    axes = np.array([(1.0 if m.spin == "ccw" else -1.0) * np.array(m.axis) for m in VEHICLE.mounts])
    change = (np.asarray(after) - omegas) / 0.002
    gained = 5e-5 * (change @ axes + np.cross(rates, omegas @ axes))
    np.testing.assert_allclose(moment, turn @ (expected.moment - gained), atol=1e-4)
    assert np.abs(gained).min() > 1e-3


@pytest.mark.slow
def test_many_fly_at_once_and_are_differentiated() -> None:
    """Climb after some steps, by the commands of each of a few vehicles."""
    from mujoco import mjx

    model = model_of("-0.02 0 0")
    rotors, device = rotors_on(model), mjx.put_model(model)
    start = mjx.put_data(model, mujoco.MjData(model))

    def climb(command: jax.Array) -> jax.Array:
        def step(carried: Any, _: None) -> tuple[Any, None]:
            data, omegas = carried
            data, omegas, _ = rotors.apply(data, omegas, jnp.full(4, command))
            return (mjx.step(device, data), omegas), None

        first = (start, jnp.full(4, 500.0))
        (data, _), _ = jax.lax.scan(step, first, None, length=20)
        return data.qvel[2]

    commands = jnp.array([480.0, 560.0, 600.0])
    many = jax.jit(jax.vmap(jax.value_and_grad(climb)), compiler_options=CHEAPLY)
    speeds, slopes = many(commands)
    # Between two commands the slope is nearly linear.
    by_slopes = 0.5 * (slopes[1:] + slopes[:-1]) * np.diff(commands)
    assert (by_slopes > 1e-3).all()
    np.testing.assert_allclose(np.diff(speeds), by_slopes, rtol=0.01)


OTHER = propmap.propeller("apc-8x6e")
WRONG: dict[str, tuple[Callable[[], Any], str]] = {
    "no table": (lambda: JaxForces.from_vehicle(VEHICLE, 3), "table is int; give a LoadTable"),  # type: ignore[arg-type]
    "wakes": (lambda: JaxForces.from_vehicle(replace(VEHICLE, wakes=Wakes()), TABLE), "has wakes"),
    "another propeller": (
        lambda: JaxForces.from_vehicle(replace(VEHICLE, propeller=OTHER), TABLE),
        "the table is for 'invented'",
    ),
    "three speeds": (
        lambda: JaxForces.from_vehicle(VEHICLE, TABLE).wrench([500.0] * 3, [0.0] * 3),
        "omega has shape (3,); its last axis must have 4 values",
    ),
    "a number for a velocity": (
        lambda: JaxForces.from_vehicle(VEHICLE, TABLE).wrench([500.0] * 4, 3.0),
        "velocity has shape ()",
    ),
    "a complex wind": (
        lambda: JaxForces.from_vehicle(VEHICLE, TABLE).wrench(
            [500.0] * 4, [0.0] * 3, wind=[1j] * 3
        ),
        "wind is complex; give real numbers",
    ),
    "a velocity of two components": (
        lambda: JaxForces.from_vehicle(VEHICLE, TABLE).table.loads_at_velocity(500.0, [1.0, 2.0]),
        "velocity has shape (2,); its last axis must have 3 values",
    ),
    "one command": (
        lambda: rotors_on(model_of()).apply(None, [500.0] * 4, [500.0]),
        "commands has shape (1,); its last axis must have 4 values",
    ),
    "no such body": (
        lambda: rotors_on(model_of(), body="drone"),
        "the model has no body 'drone'; choose one of quad, nose, post",
    ),
    "not free": (lambda: rotors_on(model_of(), body="post"), "'post' is not free"),
    "grams": (
        lambda: rotors_on(model_of(nose=1200.0)),
        "'quad' has 1201 kg, the vehicle 1.2; give both the same mass",
    ),
    "air of its own": (lambda: rotors_on(model_of(air=1.2)), "density or viscosity is not 0"),
    "negative lag": (lambda: rotors_on(model_of(), time_constant=-0.1), "time_constant is -0.1 s"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_is_refused_in_a_line(case: str) -> None:
    call, message = WRONG[case]
    with pytest.raises(InputError) as caught:
        call()
    assert message in str(caught.value) and "\n" not in str(caught.value)
