"""Vehicles in simulators of rigid bodies: ``propmap.sim.mujoco``, ``propmap.sim.mjx``."""
