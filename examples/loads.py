"""Loads of a rotor in climb, oblique and edgewise flight."""

import numpy as np

import propmap

recommended = propmap.corrections_of("recommended")  # () for the paper's model
blade, section = propmap.propeller("apc-8x6e"), propmap.airfoil("apc-8x6e-2019")
rotor = propmap.Rotor(propmap.Model(blade, section, corrections=recommended))
omega, beta = 6000 * np.pi / 30, np.radians([0, 45, 90])  # rad/s; climb, oblique, edgewise
loads = rotor.loads(omega, 10.0, beta)
print(loads.thrust, loads.drag, loads.torque, loads.status)
print(rotor.wrench(omega, [8.0, 0.0, 2.0], spin="ccw").force)
