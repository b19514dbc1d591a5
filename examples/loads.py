"""Loads of a rotor in climb, oblique and edgewise flight."""

import numpy as np

import propmap

rotor = propmap.Rotor(propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")))
omega = 6000 * np.pi / 30  # rad/s
beta = np.radians([0, 45, 90])  # climb, oblique, edgewise
loads = rotor.loads(omega, 10.0, beta)
print(loads.thrust, loads.drag, loads.torque, loads.status)
wrench = rotor.wrench(omega, [8.0, 0.0, 2.0], spin="ccw")
print(wrench.force, wrench.moment)
