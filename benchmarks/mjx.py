"""How fast 4,096 quadrotors fly at once in MJX, on the table and on the hover model.

``python -m benchmarks.mjx``.  One step of each at random states within 12 m/s, in single precision,
jitted and vmapped, on whatever JAX computes on.  Times are of the wall, the least of several
repeats, since XLA takes all cores.  Writes results/mjx.json.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

import propmap
from benchmarks.results_file import machine, write_results
from benchmarks.table import RPM, least_seconds
from propmap.hover import HoverModel
from propmap.sim.mjx import JaxWrench, MjxRotors
from propmap.table import build_table
from propmap.vehicle.vehicle import Body, Mount, Vehicle
from propmap.vehicle.vehicle_forces import VehicleForces

VEHICLES, REPEATS, SPEED = 4096, 300, 12.0
MJCF = """<mujoco><option timestep="0.002"/><worldbody><body name="quad"><freejoint/>
<inertial pos="0 0 0" mass="1.2" diaginertia="0.008 0.008 0.014"/></body></worldbody></mujoco>"""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class HoverForces:
    """Thrust and torque in proportion to the square of the rotor speeds, in place of a table's."""

    thrust: Any
    torque: Any
    place: Any
    spin: Any

    def wrench(self, omegas: Any, *_: Any, **__: Any) -> JaxWrench:
        """Force and moment on the vehicle."""
        square = omegas**2
        lift = self.thrust * square
        yaw = -self.torque * jnp.sum(self.spin * square, axis=-1)
        roll, pitch = lift @ self.place[:, 1], -(lift @ self.place[:, 0])
        none = jnp.zeros_like(yaw)
        force = jnp.stack([none, none, lift.sum(axis=-1)], axis=-1)
        return JaxWrench(force, jnp.stack([roll, pitch, yaw], axis=-1), none)


def quadrotor(propeller: propmap.Propeller) -> Vehicle:
    """A quadrotor of 1.2 kg in X."""
    corners = (("cw", 1, 1), ("ccw", -1, 1), ("cw", -1, -1), ("ccw", 1, -1))
    mounts = tuple(Mount((0.16 * x, 0.16 * y, 0.02), spin=spin) for spin, x, y in corners)
    return Vehicle("quad", 1.2, propeller, mounts, body=Body((0.015, 0.015, 0.03)))


def seconds_of(call: Callable[[], Any]) -> float:
    """Least time of a ``call`` until its arrays are there [s]."""
    wait: Any = jax.block_until_ready
    return least_seconds(lambda: wait(call()), REPEATS, time.perf_counter)


def measure() -> dict[str, Any]:
    """All figures."""
    place = machine() | {"jax": jax.__version__, "device": jax.devices()[0].device_kind}
    rotor = propmap.Rotor(propmap.catalogue_model("APC 8x6E"))
    vehicle = quadrotor(rotor.model.propeller)
    table = build_table(
        rotor,
        omega=(4500.0 * RPM, 10000.0 * RPM),
        speed=(0.0, 20.0),
        beta=(0.0, np.pi),
        tolerance=0.025,
    )
    model = mujoco.MjModel.from_xml_string(MJCF)
    on_table = MjxRotors.from_vehicle(vehicle, table, model, "quad", time_constant=0.03)
    still = HoverModel.from_rotor(rotor)
    spin = jnp.array([1.0 if mount.spin == "ccw" else -1.0 for mount in vehicle.mounts])
    hover: Any = HoverForces(still.k_thrust, still.k_torque, jnp.array(vehicle.hub_positions), spin)

    rng = np.random.default_rng(4096)
    omegas = rng.uniform(480.0, 900.0, (VEHICLES, 4)).astype(np.float32)
    direction = rng.normal(size=(VEHICLES, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    velocity = (direction * rng.uniform(0.0, SPEED, (VEHICLES, 1))).astype(np.float32)
    rates = rng.normal(0.0, 1.0, (VEHICLES, 3)).astype(np.float32)
    device = mjx.put_model(model)
    one = mjx.make_data(model)
    attitude = rng.normal(size=(VEHICLES, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    qpos = jnp.asarray(np.hstack([0.0 * direction, attitude]), jnp.float32)
    qvel = jnp.asarray(np.hstack([velocity, rates]), jnp.float32)
    data = jax.vmap(lambda q, v: one.replace(qpos=q, qvel=v))(qpos, qvel)

    def stepped(rotors: MjxRotors, data: Any, omegas: Any) -> Any:
        data, omegas, code = rotors.apply(data, omegas, jnp.full(4, 560.0))
        return mjx.step(device, data).qvel, omegas, code

    def pushed(forces: Any, omegas: Any, velocity: Any, rates: Any) -> Any:
        return forces.wrench(omegas, velocity, rates)

    def upward(forces: Any, omegas: Any, velocity: Any, rates: Any) -> Any:
        return forces.wrench(omegas, velocity, rates).force[..., 2]

    step = jax.jit(jax.vmap(stepped, in_axes=(None, 0, 0)))
    force = jax.jit(jax.vmap(pushed, in_axes=(None, 0, 0, 0)))
    slope = jax.jit(
        jax.vmap(jax.value_and_grad(upward, argnums=(1, 2, 3)), in_axes=(None, 0, 0, 0))
    )
    bare = jax.jit(jax.vmap(lambda data: mjx.step(device, data).qvel))
    state = tuple(map(jnp.asarray, (omegas, velocity, rates)))
    calls: dict[str, Any] = {
        "step_of_mjx_alone": lambda: bare(data),
        "step_on_hover_model": lambda: step(replace(on_table, forces=hover), data, state[0]),
        "step_on_table": lambda: step(on_table, data, state[0]),
        "wrench_of_hover_model": lambda: force(hover, *state),
        "wrench_of_table": lambda: force(on_table.forces, *state),
        "wrench_of_table_and_gradient": lambda: slope(on_table.forces, *state),
    }
    seconds = {name: seconds_of(call) for name, call in calls.items()}
    found, expected = calls["wrench_of_table"](), VehicleForces(vehicle, table).wrench(*state)
    apart = np.abs(np.asarray(found.force) - expected.force).max() / np.abs(expected.force).max()
    return {
        "machine": place,
        "vehicles": VEHICLES,
        "milliseconds": {name: 1e3 * value for name, value in seconds.items()},
        "vehicles_per_second": {name: VEHICLES / value for name, value in seconds.items()},
        "largest_difference_from_numpy": float(apart),
        "codes": np.bincount(np.asarray(found.code)).tolist(),
        "table_largest_error": max(table.certificate["max_error"].values()),
    }


def main() -> None:
    """Measure, print and write."""
    found = measure()
    print(f"{found['vehicles']} vehicles at once, {found['machine']['device']}")
    for name, value in found["milliseconds"].items():
        rate = found["vehicles_per_second"][name]
        print(f"{name.replace('_', ' ')}: {value:.2f} ms, {rate / 1e6:.2f} million per second")
    print(
        f"largest difference from NumPy: {found['largest_difference_from_numpy']:.1e} of the force"
    )
    print(write_results("mjx.json", found))


if __name__ == "__main__":
    main()
