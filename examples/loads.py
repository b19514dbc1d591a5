"""Compute the loads of a rotor in climb, oblique and edgewise flight, with 95 % bands."""

import numpy as np

import propmap

rotor = propmap.Rotor(propmap.catalogue_model("APC 8x6E"))  # or "HQ 5x4.3x3", or your geometry file
omega, beta = 6000 * np.pi / 30, np.radians([0, 45, 90])  # rad/s; climb, oblique, edgewise
loads = rotor.loads(omega, 10.0, beta)
low, high = loads.interval(0.95)
print(loads.thrust, low.thrust, high.thrust)  # [N]
print(loads.drag, loads.torque, loads.std.torque, loads.status)
print(rotor.wrench(omega, [8.0, 0.0, 2.0], spin="ccw").force)
