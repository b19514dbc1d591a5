"""Compute aerodynamic force and moment on a quadrotor with wakes of rotors on each other."""

import numpy as np

import propmap
from propmap.vehicle.vehicle import Body, Mount, Wakes

model = propmap.catalogue_model("APC 8x6E")
corners = (("cw", 1, 1), ("ccw", -1, 1), ("cw", -1, -1), ("ccw", 1, -1))
quad = propmap.Vehicle(
    name="quad",
    mass=1.2,  # kg
    propeller=model.propeller,
    mounts=tuple(Mount((0.16 * x, 0.16 * y, 0.02), spin=spin) for spin, x, y in corners),
    body=Body(drag_area=(0.015, 0.015, 0.03)),
    wakes=Wakes(),
)  # or propmap.read_vehicle("vehicle.toml").vehicle
forces = propmap.VehicleForces(quad, propmap.Rotor(model))  # or a LoadTable

speeds = np.array([0.0, 5.0, 10.0])  # m/s
velocity = np.column_stack([speeds, 0.0 * speeds, 0.5 + 0.0 * speeds])  # x forward, y left, z up
found = forces.wrench([640.0] * 4, velocity, rates=[0.0, 0.1, 0.0], wind=[1.0, 0.0, 0.0])
print("force", found.force, "N; moment", found.moment, "N m")
print("power", found.power, "W; status", found.status)
print("wakes add to the axial flow", found.added_flow[-1], "m/s at the four rotors")
