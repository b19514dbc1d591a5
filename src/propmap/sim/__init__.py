"""Vehicles in rigid-body simulators: ``propmap.sim.mujoco`` and ``propmap.sim.mjx``."""
