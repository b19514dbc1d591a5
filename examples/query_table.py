"""Query a table for loads, derivatives, and the rotational speed for a thrust."""

import numpy as np

from propmap.loads import LOADS
from propmap.table import LoadTable

table = LoadTable.load("map.npz")
print(table)
print(f"certified to {max(table.certificate['max_error'].values()):.2%} of the static loads")

omega = 6000 * np.pi / 30  # rad/s
loads = table.loads(omega, speed=8.0, beta=np.radians([0.0, 45.0, 90.0]))
for name, load in LOADS.items():
    print(f"{name:12s}", getattr(loads, name), load.unit)
print("status", loads.status)

# Derivatives of the thrust with respect to omega and velocity, for a controller or an estimator.
slopes = table.gradient_at_velocity(omega, [6.0, 0.0, 1.0])
print("d thrust / d(omega, x, y, z)", slopes.thrust)

# Rotational speed for a thrust of 2.5 N in edgewise flight at 8 m/s.
needed = table.omega_for("thrust", 2.5, speed=8.0, beta=np.pi / 2)
print(f"omega for 2.5 N: {needed.omega:.1f} rad/s")

# Outside the envelope the loads are NaN.
far = table.loads(omega, 100.0, 0.0)
print("at 100 m/s:", far.thrust, far.status)
