"""Learn the gains of a controller for forward flight in MJX by gradient descent."""

import jax
import jax.numpy as jnp
import mujoco
from mujoco import mjx

import propmap
from propmap.sim.mjx import MjxRotors
from propmap.table import LoadTable
from propmap.vehicle.vehicle import Body, Mount

MJCF = """<mujoco><option timestep="0.01"/><worldbody><body name="quad"><freejoint/>
<inertial pos="0 0 0" mass="0.8" diaginertia="0.006 0.006 0.01"/></body></worldbody></mujoco>"""
model = mujoco.MjModel.from_xml_string(MJCF)
corners = (("cw", 1, 1), ("ccw", -1, 1), ("cw", -1, -1), ("ccw", 1, -1))
mounts = tuple(Mount((0.16 * x, 0.16 * y, 0.0), spin=spin) for spin, x, y in corners)
body = Body((0.015, 0.015, 0.03))
quad = propmap.Vehicle("quad", 0.8, propmap.propeller("apc-8x6e"), mounts, body=body)
rotors = MjxRotors.from_vehicle(quad, LoadTable.load("map.npz"), model, "quad", time_constant=0.03)
device, start, rear = mjx.put_model(model), mjx.make_data(model), jnp.array([-1.0, 1.0, 1.0, -1.0])


def fly(logs, wanted=4.0):
    """Return the mean squared error over the first two seconds, and the final velocity [m/s]."""
    lean_gain, stiffness, damping, climb_gain = jnp.exp(logs)

    def step(state, _):
        data, omegas = state
        speed, climb, turning = data.qvel[0], data.qvel[2], data.qvel[4]
        lean = 2.0 * jnp.arctan2(data.qpos[5], data.qpos[3])
        push = stiffness * (lean_gain * (wanted - speed) - lean) - damping * turning
        commands = 540.0 - climb_gain * climb + push * rear  # rad/s
        data, omegas, _ = rotors.apply(data, omegas, commands)
        return (mjx.step(device, data), omegas), (wanted - speed) ** 2 + 4.0 * climb**2

    (data, _), costs = jax.lax.scan(step, (start, jnp.full(4, 540.0)), None, length=200)
    return costs.mean(), data.qvel[:3]


slope = jax.jit(jax.value_and_grad(fly, has_aux=True))
logs = jnp.log(jnp.array([0.05, 60.0, 15.0, 20.0]))
for k in range(21):
    (cost, velocity), gradient = slope(logs)
    if k % 5 == 0:
        print(f"step {k:2}: cost {cost:.3f}; in the end {velocity[0]:.2f} m/s forward")
    logs = logs - 0.15 * gradient / jnp.linalg.norm(gradient)
print("gains", jnp.exp(logs).round(3))
