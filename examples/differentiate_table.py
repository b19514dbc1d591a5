"""Differentiate a simulation with a table: find the rotor speed that leads to a climb rate."""

import jax
import jax.numpy as jnp

from propmap.table import JaxTable, LoadTable

table = JaxTable.from_table(LoadTable.load("map.npz"))
WEIGHT, MASS, STEP = 2.0, 2.0 / 9.81, 0.02  # N, kg, s


def speed_after(omega, seconds=0.4):
    """Return the vertical speed [m/s] after a climb from 1 m/s at constant omega [rad/s]."""

    def step(velocity, _):
        loads = table.loads_at_velocity(omega, jnp.array([5.0, 0.0, 0.0]).at[2].set(velocity))
        return velocity + STEP * (loads.thrust - WEIGHT) / MASS, None

    return jax.lax.scan(step, 1.0, None, length=int(seconds / STEP))[0]


newton = jax.jit(jax.value_and_grad(speed_after))
omega = 600.0
for _ in range(4):
    speed, slope = newton(omega)
    print(f"omega {float(omega):7.2f} rad/s: {float(speed):+.4f} m/s at the end")
    omega = omega - (speed - 0.5) / slope  # Newton's step toward 0.5 m/s
