"""Parameters of PX4's simulator in hardware (SIH): linear rotors and linear drag."""

from __future__ import annotations

import numpy as np

from propmap.export.parameter_set import Explained, Flights
from propmap.export.px4_allocation import in_frd
from propmap.export.static_loads import StaticLoads
from propmap.export.thrust_curve import ThrustCurve
from propmap.vehicle.flight_log import GRAVITY
from propmap.vehicle.vehicle import Vehicle

SIH = "PX4-Autopilot src/modules/simulation/simulator_sih/sih.cpp, generate_force_and_torques"

SIH_QUAD = ((1, 1, "ccw"), (-1, -1, "ccw"), (1, -1, "cw"), (-1, 1, "cw"))
"""Signs of x and y (to the right) and spins of the simulator's rotors."""


def simulator(
    vehicle: Vehicle, flights: Flights, still: StaticLoads, curve: ThrustCurve | None
) -> tuple[list[Explained], str]:
    """Parameters of the simulator in hardware, or why there are none.

    Parameters
    ----------
    vehicle : Vehicle
        What is simulated.
    flights : tuple of 2 InplaneForces
        Its level flights along x and y.
    still : StaticLoads
        Of its rotors.
    curve : ThrustCurve or None
        Their thrust by the signal.
    """
    if curve is None:
        return [], "they need the thrust at the full signal, see THR_MDL_FAC"
    places = [in_frd(mount.position) for mount in vehicle.mounts]
    arms = np.abs(np.array(places))[:, :2]
    pattern = tuple(
        (int(np.sign(place[0])), int(np.sign(place[1])), mount.spin)
        for place, mount in zip(places, vehicle.mounts, strict=True)
    )
    alike = np.ptp(arms, axis=0) <= 0.01 * arms.max()
    if pattern != SIH_QUAD or not alike.all():
        return [], (
            "the simulator flies a quadrotor in X with equal arms, rotors 1 to 4 front right, back "
            "left, front left, back right, the first two counter-clockwise; this vehicle is another"
        )
    weight = vehicle.mass * GRAVITY
    speed = np.concatenate([flight.speed for flight in flights])
    needed = np.concatenate([weight * np.tan(flight.pitch) for flight in flights])
    drag = float(np.sum(speed * needed) / np.sum(speed**2))
    worst = float(np.abs(drag * speed - needed).max())
    changes = np.concatenate([flight.errors for flight in flights], axis=1) * vehicle.mass
    spread = float(np.linalg.norm(changes @ speed) / np.sum(speed**2)) if changes.size else None
    share = still.std_of(1.0 / still.thrust, 0.0)
    whole = still.std_of(0.0, 1.0 / still.torque)
    linear = "The simulator's thrust and torque are linear in the signal, hence THR_MDL_FAC is 0."
    full = curve.full_signal(vehicle.powertrain.motor)
    return [
        Explained(
            "SIH_VEHICLE_TYPE", {"SIH_VEHICLE_TYPE": 0}, "-", None, "0, a quadrotor.", SIH, "Exact."
        ),
        Explained(
            "SIH_MASS",
            {"SIH_MASS": float(vehicle.mass)},
            "kg",
            None,
            "Take-off mass.",
            SIH,
            "Exact: it is the vehicle file's. Moments of inertia are not written: set SIH_IXX etc.",
        ),
        Explained(
            "SIH_T_MAX",
            {"SIH_T_MAX": round(curve.full_thrust, 4)},
            "N",
            None if share is None else share * curve.full_thrust,
            f"Thrust of a rotor = SIH_T_MAX u. {linear}",
            SIH,
            full,
        ),
        Explained(
            "SIH_Q_MAX",
            {"SIH_Q_MAX": round(curve.full_torque, 6)},
            "N m",
            None if whole is None else whole * curve.full_torque,
            "Torque of a rotor = SIH_Q_MAX u.",
            SIH,
            full,
        ),
        Explained(
            "SIH_L_ROLL, SIH_L_PITCH",
            {"SIH_L_ROLL": float(arms[:, 1].mean()), "SIH_L_PITCH": float(arms[:, 0].mean())},
            "m",
            None,
            "Distances of the rotors from the planes of symmetry.",
            SIH,
            "Exact.",
        ),
        Explained(
            "SIH_KDV",
            {"SIH_KDV": round(drag, 5)},
            "N s/m",
            spread,
            "Force on the vehicle = -SIH_KDV V, in all directions.",
            SIH,
            f"Fitted to what the lean in the level flights below takes: within {worst:.2g} N.",
        ),
        Explained(
            "THR_MDL_FAC",
            {"THR_MDL_FAC": 0.0},
            "-",
            None,
            linear,
            SIH,
            "Of the simulator alone: the real vehicle has another.",
        ),
    ], ""
