"""Fly RotorPy's quadrotor with the full rotor model and inflow lag."""

import numpy as np
from rotorpy.vehicles.hummingbird_params import quad_params
from rotorpy.vehicles.multirotor import Multirotor
from scipy.spatial.transform import Rotation

import propmap

law, corrections = propmap.airfoil("paper-apc"), (propmap.correction("pitt-peters"),)
model = propmap.Model(propmap.propeller("apc-8x6e"), law, corrections=corrections)
rotor = propmap.Rotor(model)


def airspeed(state):
    """Return the velocity of the vehicle through the air, in the vehicle frame [m/s]."""
    return Rotation.from_quat(state["q"]).inv().apply(state["v"] - state["wind"])


class Quadrotor(Multirotor):
    """A quadrotor with the inflow of each rotor as a state, constant during a step of RotorPy."""

    def __init__(self, parameters, **options):
        super().__init__(parameters, **options)
        # rotor_dir is the direction of the torque on the body, opposite to the spin.
        spins = ["cw" if direction > 0 else "ccw" for direction in self.rotor_dir]
        self.dynamic = propmap.DynamicInflow(rotor, spin=spins)
        start = self.initial_state
        hubs = self.hub_velocities(start["w"], airspeed(start))
        self.inflow = self.dynamic.steady(start["rotor_speeds"], hubs)

    def hub_velocities(self, body_rates, velocity):
        """Return the velocity of each hub, including the rotation of the vehicle [m/s]."""
        return velocity + np.cross(body_rates, self.rotor_geometry)

    def step(self, state, control, t_step):
        """Step the inflow, then the vehicle as RotorPy does."""
        hubs = self.hub_velocities(state["w"], airspeed(state))
        self.inflow = self.dynamic.step(self.inflow, t_step, state["rotor_speeds"], hubs)
        return super().step(state, control, t_step)

    def compute_body_wrench(self, body_rates, rotor_speeds, body_airspeed_vector):
        """Return force and moment of all rotors about the center of mass."""
        hubs = self.hub_velocities(body_rates, body_airspeed_vector)
        found = self.dynamic.wrench(self.inflow, rotor_speeds, hubs)
        arms = np.cross(self.rotor_geometry, found.force)
        return found.force.sum(axis=0), (found.moment + arms).sum(axis=0)


weight = quad_params["mass"] * 9.81
speeds = np.linspace(300.0, 900.0, 61)  # rad/s
hover = np.interp(weight / 4.0, rotor.loads(speeds, 0.0, 0.0).thrust, speeds)
state = {name: np.zeros(3) for name in ("x", "v", "w", "wind")}
state |= {"q": np.array([0.0, 0.0, 0.0, 1.0]), "rotor_speeds": np.full(4, hover)}
# The small time constant of the motor makes the inflow lag visible.
motor = {"rotor_speed_min": 300.0, "rotor_speed_max": 900.0, "tau_m": 0.002}
vehicle = Quadrotor(quad_params | motor, initial_state=state, integrator_kwargs={"method": "RK23"})
for k in range(1, 11):
    state = vehicle.step(state, {"cmd_motor_speeds": np.full(4, 1.15 * hover)}, 2e-3)
    at = (state["rotor_speeds"], airspeed(state))
    lagging = vehicle.compute_body_wrench(state["w"], *at)[0][2] / weight
    steady = rotor.loads_at_velocity(*at).thrust.sum() / weight
    print(f"{2 * k:2d} ms: thrust over weight {lagging:.4f}, without inflow lag {steady:.4f}")
