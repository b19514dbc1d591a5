"""Measure the speed of tables and of many quadrotors in JAX, in single and double precision.

Run ``make bench ONLY=accelerator``.  JAX selects the accelerator; if there is none, the benchmark
measures the processor.  Each time is the least wall time of several calls of a compiled function.
The table is that of ``benchmarks.table``.  The benchmark writes results/accelerator.json.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.mjx import quadrotor
from benchmarks.results_file import machine, write_results
from benchmarks.table import RPM, built, least_seconds, random_points
from propmap.loads import LOADS, error_scales
from propmap.sim.mjx import JaxForces
from propmap.table import JaxTable

POINTS, VEHICLES = 1_000_000, 262_144
ON_PROCESSOR = 16  # a processor computes this many times fewer points and vehicles
STEPS, REPEATS = 10, 3
STEP = 0.002  # [s]
INERTIA = np.array([0.008, 0.008, 0.014])  # of the quadrotor [kg m^2]
GRAVITY = 9.81  # [m/s^2]


def seconds_of(call: Callable[..., Any], *arguments: Any) -> float:
    """Return the least time of a compiled ``call`` until its arrays are computed [s]."""
    compiled = jax.jit(call)
    wait: Any = jax.block_until_ready
    return least_seconds(lambda: wait(compiled(*arguments)), REPEATS, time.perf_counter)


def loads(table: JaxTable, omega: Any, speed: Any, beta: Any) -> Any:
    """Return all loads of a table at n points, (L, n)."""
    found = table.loads(omega, speed, beta)
    return jnp.stack([getattr(found, name) for name in LOADS])


def slopes(table: JaxTable, *point: Any) -> Any:
    """Return all loads at the points, with their derivatives along the three coordinates."""

    def along(k: int) -> Any:
        tangents = [jnp.full_like(x, float(i == k)) for i, x in enumerate(point)]
        return jax.jvp(lambda *p: loads(table, *p), point, tuple(tangents))

    return [along(k) for k in range(3)]


def flown(forces: JaxForces, omega: Any, state: Any) -> Any:
    """Return the state of free quadrotors after ten steps at constant rotor speeds.

    The state is the velocity [m/s] and the angular velocity [rad/s] in the vehicle frame, and the
    direction of gravity in this frame, (n, 3) each.
    """
    mass = forces.vehicle.mass

    def step(state: Any, _: None) -> tuple[Any, None]:
        velocity, rates, down = state
        air = forces.wrench(omega, velocity, rates, clamp=True)
        inertia = jnp.asarray(INERTIA, velocity.dtype)
        pull = air.force / mass + GRAVITY * down - jnp.cross(rates, velocity)
        turn = (air.moment - jnp.cross(rates, inertia * rates)) / inertia
        down = down - STEP * jnp.cross(rates, down)
        down = down / jnp.linalg.norm(down, axis=-1, keepdims=True)
        return (velocity + STEP * pull, rates + STEP * turn, down), None

    return jax.lax.scan(step, state, length=STEPS)[0]


def climbed(forces: JaxForces, omega: Any, state: Any) -> Any:
    """Return the sum of the upward velocities after ten steps; it depends on every input."""
    velocity, _, down = flown(forces, omega, state)
    return -jnp.sum(velocity * down)


def measure() -> dict[str, Any]:
    """Return all results."""
    device = jax.devices()[0]
    place = machine() | {"jax": jax.__version__, "device": device.device_kind}
    table, rotor, _ = built(0.005, "standard")
    fewer = ON_PROCESSOR if device.platform == "cpu" else 1
    count, vehicles = POINTS // fewer, VEHICLES // fewer
    vehicle, points = quadrotor(rotor.model.propeller), random_points(count)
    rng = np.random.default_rng(1)
    omega = rng.uniform(4500.0, 8000.0, (vehicles, 4)) * RPM
    down = rng.normal(0.0, 0.3, (vehicles, 3)) - [0.0, 0.0, 1.0]
    down /= np.linalg.norm(down, axis=1, keepdims=True)
    start = rng.normal(0.0, 3.0, (vehicles, 3)), rng.normal(0.0, 0.3, (vehicles, 3)), down
    found: dict[str, Any] = {}
    values: dict[str, Any] = {}
    for name in ("single", "double"):
        with jax.enable_x64(name == "double"):
            forces = JaxForces.from_vehicle(vehicle, table)
            some, flight = jax.tree.map(jnp.asarray, (points, (omega, start)))
            gradient = jax.value_and_grad(climbed, argnums=(1, 2))
            seconds = {
                "loads": seconds_of(loads, forces.table, *some) / count,
                "loads_with_derivatives": seconds_of(slopes, forces.table, *some) / count,
                "steps": seconds_of(flown, forces, *flight) / vehicles / STEPS,
                "steps_with_gradient": seconds_of(gradient, forces, *flight) / vehicles / STEPS,
            }
            found[name] = {what: 1.0 / one for what, one in seconds.items()}
            values[name] = np.asarray(loads(forces.table, *some), dtype=np.float64)
    still = table.loads(points[0], 0.0, 0.0)
    scales = error_scales(still._asdict(), rotor.model.propeller.radius)
    apart = np.abs(values["single"] - values["double"]) / np.array(list(scales.values()))
    return {
        "machine": place,
        "platform": device.platform,
        "points": count,
        "vehicles": vehicles,
        "steps": STEPS,
        "per_second": found,
        "single_minus_double": dict(zip(LOADS, np.max(apart, axis=1).tolist(), strict=True)),
    }


def main() -> None:
    """Measure, print and write."""
    found = measure()
    if found["platform"] == "cpu":
        print("JAX found no accelerator; the benchmark measured the processor")
    print(found["machine"]["device"], f"JAX {jax.__version__}")
    for name in ("single", "double"):
        for what, rate in found["per_second"][name].items():
            print(f"{name} precision, {what.replace('_', ' ')}: {rate:.3g} per second")
    worst = max(found["single_minus_double"].values())
    print(f"largest difference between the precisions: {worst:.1e} of the static load")
    print(write_results("accelerator.json", found))


if __name__ == "__main__":
    main()
