"""Add rotors to an MJCF model, design an LQR for hover, and fly it in MuJoCo."""

import mujoco
import numpy as np
from scipy.linalg import solve_discrete_are
from scipy.optimize import brentq

import propmap
from propmap.sim.mujoco import MujocoRotors, attach
from propmap.vehicle.vehicle import Mount, Vehicle

MJCF = """<mujoco><option timestep="0.002"/><worldbody><body name="quad"><freejoint/>
<inertial pos="0 0 0" mass="1.2" diaginertia="0.011 0.011 0.02"/></body></worldbody></mujoco>"""
rotor = propmap.Rotor(propmap.catalogue_model("apc-8x6e"))
places = ((0.16, -0.16, "ccw"), (-0.16, 0.16, "ccw"), (0.16, 0.16, "cw"), (-0.16, -0.16, "cw"))
mounts = tuple(Mount((x, y, 0.02), spin=spin) for x, y, spin in places)
spec = mujoco.MjSpec.from_string(MJCF)
vehicle, changes = attach(spec, Vehicle("quad", 1.2, rotor.model.propeller, mounts), "quad")
print("\n".join(changes))
model = spec.compile()
data = mujoco.MjData(model)
mujoco.set_mjcb_passive(MujocoRotors(model, vehicle, rotor))


def climb(omega):
    """Return the vertical acceleration at rest with steady inflow [m/s^2]."""
    data.act[:] = omega
    mujoco.mj_forward(model, data)
    return data.qacc[2]


def state():
    """Return pose, motion and rotor speeds relative to hover (16,)."""
    pose = np.empty(6)
    mujoco.mj_differentiatePos(model, pose, 1.0, model.qpos0, data.qpos)
    return np.concatenate([pose, data.qvel, data.act - hover])


def after(change):
    """Return the state one step after a ``change`` (20,) of state and commands in hover."""
    mujoco.mj_resetData(model, data)
    mujoco.mj_integratePos(model, data.qpos, change[:6], 1.0)
    data.qvel[:], data.act[:], data.ctrl[:] = (
        change[6:12],
        hover + change[12:16],
        hover + change[16:],
    )
    mujoco.mj_step(model, data)
    return state()


hover = brentq(climb, 300.0, 900.0)
slopes = np.array([after(x) - after(-x) for x in 1e-4 * np.eye(20)]).T / 2e-4
a, b = slopes[:, :16], slopes[:, 16:]
q, r = np.diag([10.0] * 3 + [1.0] * 9 + [0.0] * 4), 1e-4 * np.eye(4)
p = solve_discrete_are(a, b, q, r)
gain = np.linalg.solve(r + b.T @ p @ b, b.T @ p @ a)
for name, matrix in (("hover", a), ("hover with LQR", a - b @ gain)):
    found = np.log(np.linalg.eigvals(matrix).astype(complex)) / model.opt.timestep
    print(f"eigenvalues [1/s], {name}:", np.sort_complex(found.round(2)))
inflow = propmap.DynamicInflow(rotor).linearize(hover, (0.0, 0.0, 0.0))
print("eigenvalues [1/s], inflow:", np.sort(np.linalg.eigvals(inflow.a).real.round(1)))

mujoco.mj_resetData(model, data)
data.qpos[:3], data.act[:] = (1.0, -1.0, 0.5), hover
for k in range(3001):
    if k % 500 == 0:
        print(f"{data.time:.0f} s: {np.linalg.norm(data.qpos[:3]):.4f} m from the target")
    data.ctrl[:] = hover - gain @ state()
    mujoco.mj_step(model, data)
mujoco.set_mjcb_passive(None)
