"""Vehicles: rotors, airframe, powertrain, wakes, and flight logs."""
