"""Loads of a coaxial pair in hover, compared with a test stand: `make bench ONLY=coaxial`.

Writes results/coaxial.json: thrust and shaft power of both rotors at the measured rotor speeds, and
the ideal power of two coaxial rotors.  No constants are fitted to the pair.  `propmap fit tunnel`
identified the section constants from 30 measurements of one isolated rotor.

Geometry, and measured loads of a pair 0.115 m apart: T-Motor 28 in, examples of pyBEMT (K. E. T.
Giljarhus, J. Open Source Software 5, 2020, doi 10.21105/joss.02480; MIT License).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.results_file import write_results
from propmap import Airfoil, Model, Propeller, Rotor
from propmap.typing import Floats
from propmap.units import RPM
from propmap.vehicle.vehicle import SLIPSTREAMS, Mount, Vehicle
from propmap.vehicle.vehicle_forces import VehicleForces
from propmap.vehicle.wakes import hub_flow_at, wake_flow

PROPELLER = Propeller(
    "tmotor-28",
    2,
    np.array([0.07112, 0.10668, 0.14224, 0.1778, 0.21336, 0.24892, 0.28448, 0.32004, 0.3556]),
    np.array([0.056, 0.07, 0.07, 0.065, 0.058, 0.05, 0.043, 0.034, 0.02]),
    np.radians([19.6, 17.9, 14.4, 11.6, 9.7, 8.4, 7.2, 6.7, 6.2]),
)
CONSTANTS = Airfoil(
    c_l1=6.43833,
    c_l2=2.0,
    c_d=1.93621,
    alpha_0=0.227351,
    zero_lift_angle=-0.0305736,
    c_d0=0.0161037,
    c_p=1.328,
    sharpness=50.0,
    reynolds_camber=-0.0231977,
    drag_angle=0.0530997,
    corrections=("pitt-peters",),
)
APART = 0.115  # distance of the measured rotors [m]
MEASURED = np.array(
    [
        (1037, 5.44, 22.38, 1024, 3.51, 19.31),
        (1118, 6.42, 28.35, 1106, 4.11, 24.59),
        (1204, 7.54, 35.7, 1192, 4.87, 31.01),
        (1374, 10.1, 53.7, 1361, 6.42, 46.19),
        (1532, 12.9, 76.03, 1522, 8.0, 63.81),
        (1693, 16.1, 103.6, 1688, 9.91, 86.37),
        (1850, 19.8, 137.0, 1849, 11.9, 112.8),
        (1923, 21.4, 154.4, 1922, 12.8, 127.2),
        (2001, 23.2, 173.6, 1999, 13.9, 142.9),
        (2073, 25.1, 194.2, 2077, 15.0, 159.0),
        (2145, 27.3, 216.7, 2152, 16.1, 176.2),
        (2289, 30.8, 261.0, 2295, 18.8, 216.7),
        (2433, 34.7, 310.9, 2437, 21.7, 262.1),
        (2568, 38.9, 366.7, 2575, 24.4, 310.4),
        (2695, 42.7, 422.6, 2704, 27.3, 360.9),
        (2819, 47.0, 485.7, 2836, 29.9, 414.4),
        (2941, 50.3, 543.5, 2947, 33.6, 478.6),
        (2987, 53.1, 581.0, 3011, 33.9, 496.0),
        (3102, 56.7, 644.1, 3125, 37.4, 562.7),
    ]
)
"""Columns: speed [1/min], thrust [N] and shaft power [W] of the upper rotor, then of the lower."""

HEIGHTS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 15.0)  # distances for the ideal power [radii]


def pair(height: float) -> Vehicle:
    """Return two rotors on one axis, ``height`` [m] apart, the upper rotor first."""
    mounts = (Mount((0.0, 0.0, height)), Mount((0.0, 0.0, 0.0), spin="cw"))
    return Vehicle("pair", 4.0, PROPELLER, mounts, wakes=SLIPSTREAMS)


def computed(vehicle: Vehicle) -> tuple[Floats, Floats]:
    """Return thrust [N] and shaft power [W] of both rotors at the measured speeds, (n, 2) each."""
    omega = MEASURED[:, [0, 3]] * RPM
    rotor = Rotor(Model(PROPELLER, CONSTANTS, vehicle.air))
    found = VehicleForces(vehicle, rotor).wrench(omega, (0.0, 0.0, 0.0))
    return found.thrust, found.torque * omega


def ideal_power(height: float) -> float:
    """Return the induced power of a pair in hover, divided by that of two isolated rotors.

    Both rotors have equal thrust and are ``height`` radii apart.
    """
    vehicle = pair(height * PROPELLER.radius)
    still, none, thrust = np.zeros((1, 2)), np.zeros((1, 3)), np.ones((1, 2))
    flow = hub_flow_at(vehicle, still, none, none)
    alone = wake_flow(vehicle, SLIPSTREAMS, flow, thrust)
    own = wake_flow(vehicle, SLIPSTREAMS, flow.perturbed(alone.added), thrust).inflow
    return float(np.sum(alone.added + own) / np.sum(alone.inflow))


def main() -> None:
    """Compute the loads, print them and write the results."""
    thrust, power = computed(pair(APART))
    rows: list[dict[str, Any]] = []
    for k, measured in enumerate(MEASURED.tolist()):
        rows.append({"rpm": measured[0], "measured": measured, "thrust": thrust[k].tolist()})
        rows[-1]["power"] = power[k].tolist()
        print(rows[-1])
    heights = [{"height": h, "power": ideal_power(h)} for h in HEIGHTS]
    print(heights, write_results("coaxial.json", {"rows": rows, "ideal": heights}))


if __name__ == "__main__":
    main()
