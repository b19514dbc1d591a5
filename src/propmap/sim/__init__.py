"""Vehicles in simulators of rigid bodies."""
