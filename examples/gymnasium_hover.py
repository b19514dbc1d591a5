"""A Gymnasium environment: keep a quadrotor at a place in gusts, with the loads of propmap."""

import gymnasium
import mujoco
import numpy as np
from gymnasium.utils.env_checker import check_env

import propmap
from propmap.sim.mujoco import MujocoRotors, attach
from propmap.vehicle.vehicle import Body, Mount

MJCF = """<mujoco><option timestep="0.002"/><worldbody><body name="quad"><freejoint/>
<inertial pos="0 0 0" mass="1.2" diaginertia="0.011 0.011 0.02"/></body></worldbody></mujoco>"""
HOVER, RANGE = (
    675.0,
    200.0,
)  # rotor speed for action 0, and its increase at action 1 [rad/s]
STEPS = 10  # of the simulation per step of the environment
FAR = 5.0  # distance at which an episode ends [m]


class Hover(gymnasium.Env):
    """A quadrotor in gusts.

    The action contains a command from -1 to 1 per rotor.  The observation contains the position
    [m], the quaternion, the velocity [m/s] and the body rates [rad/s].
    """

    action_space = gymnasium.spaces.Box(-1.0, 1.0, (4,), np.float32)
    observation_space = gymnasium.spaces.Box(-1e3, 1e3, (13,), np.float64)

    def __init__(self):
        rotor = propmap.Rotor(propmap.catalogue_model("APC 8x6E"))
        corners = (("cw", 1, 1), ("ccw", -1, 1), ("cw", -1, -1), ("ccw", 1, -1))
        mounts = tuple(Mount((0.16 * x, 0.16 * y, 0.0), spin=spin) for spin, x, y in corners)
        blade, body = rotor.model.propeller, Body((0.015, 0.015, 0.03))
        spec = mujoco.MjSpec.from_string(MJCF)
        vehicle, _ = attach(spec, propmap.Vehicle("quad", 1.2, blade, mounts, body=body), "quad")
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.forces = MujocoRotors(self.model, vehicle, rotor)

    def reset(self, *, seed=None, options=None):
        """Start near the place, with the rotor speeds of hover."""
        super().reset(seed=seed, options=options)
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:3] = self.np_random.uniform(-0.5, 0.5, 3)
        self.data.act[:] = HOVER
        self.model.opt.wind[:] = 0.0
        return self.observation(), {}

    def step(self, action):
        """Fly for 20 ms; the reward is larger if the quadrotor is close, level and slow."""
        self.data.ctrl[:] = HOVER + RANGE * np.clip(action, -1.0, 1.0)
        self.model.opt.wind[:] = 0.99 * self.model.opt.wind + self.np_random.normal(0.0, 0.3, 3)
        mujoco.set_mjcb_passive(self.forces)  # global, so every environment must set its own
        mujoco.mj_step(self.model, self.data, STEPS)
        mujoco.set_mjcb_passive(None)
        seen = self.observation()
        distance, tilt = np.linalg.norm(seen[:3]), np.linalg.norm(seen[4:6])
        reward = 1.0 - distance - tilt - 0.1 * np.linalg.norm(seen[7:10])
        return seen, float(reward), bool(distance > FAR), False, {"status": self.forces.status}

    def observation(self):
        """Return position, quaternion, velocity and body rates."""
        return np.concatenate([self.data.qpos, self.data.qvel])


env = Hover()
check_env(env, skip_render_check=True)
env.action_space.seed(0)
env.reset(seed=0)
for k in range(1, 11):
    seen, reward, ended, _, info = env.step(env.action_space.sample())
    print(f"{0.02 * k:.2f} s: position {seen[:3].round(3)} m, reward {reward:.3f}")
