"""Fly RotorPy's quadrotor with the exported rotor: hover in a wind of 1 m/s."""

import numpy as np
from apc_8x6e_rotorpy import rotor_params
from rotorpy.controllers.quadrotor_control import SE3Control
from rotorpy.vehicles.hummingbird_params import quad_params
from rotorpy.vehicles.multirotor import Multirotor

vehicle = {**quad_params, **rotor_params}
hover = np.sqrt(vehicle["mass"] * 9.81 / 4 / vehicle["k_eta"])  # rad/s
state = {name: np.zeros(3) for name in ("x", "v", "w")}
state |= {"q": np.array([0.0, 0.0, 0.0, 1.0]), "wind": np.array([1.0, 0.0, 0.0])}
state |= {"rotor_speeds": np.full(4, hover)}
wanted = {name: np.zeros(3) for name in ("x", "x_dot", "x_ddot", "x_dddot", "x_ddddot")}
wanted |= {"yaw": 0.0, "yaw_dot": 0.0, "yaw_ddot": 0.0}
rotor, control = Multirotor(vehicle, initial_state=state), SE3Control(vehicle)
for k in range(300):
    state = rotor.step(state, control.update(0.01 * k, state, wanted), 0.01)
print("after 3 s:", state["x"], "m, rotors at", state["rotor_speeds"], "rad/s")
