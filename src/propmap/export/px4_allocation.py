"""Parameters of PX4's control allocation: where the rotors are, and what they make."""

from __future__ import annotations

import numpy as np

from propmap.errors import InputError
from propmap.export.parameter_set import Explained, Flights
from propmap.export.static_loads import StaticLoads
from propmap.export.thrust_curve import ThrustCurve
from propmap.vehicle.vehicle import Vector, Vehicle

MOST_ROTORS, LARGEST_THRUST = 12, 100.0
"""That control allocation takes: rotors, and CA_ROTORn_CT [N]."""

ALLOCATOR = "PX4-Autopilot src/modules/control_allocator"
ROTORS = f"{ALLOCATOR}/VehicleActuatorEffectiveness/ActuatorEffectivenessRotors.cpp"
NORMALISED = "Control allocation is normalised: what all rotors have in common plays no part"


def in_frd(vector: Vector) -> Vector:
    """A ``vector`` with x forward, y left, z up as one with y right, z down."""
    x, y, z = vector
    return x, 0.0 - y, 0.0 - z


def geometry(vehicle: Vehicle) -> list[Explained]:
    """Number, places and axes of the rotors of a ``vehicle``.

    Raises
    ------
    InputError
        For more rotors than PX4 takes.
    """
    count = len(vehicle.mounts)
    if count > MOST_ROTORS:
        raise InputError(
            f"the vehicle has {count} rotors, and PX4's control allocation takes {MOST_ROTORS}",
            "choose another autopilot",
        )
    places, axes = {}, {}
    for k, mount in enumerate(vehicle.mounts):
        for letter, place, axis in zip(
            "XYZ", in_frd(mount.position), in_frd(mount.axis), strict=True
        ):
            places[f"CA_ROTOR{k}_P{letter}"] = float(place)
            axes[f"CA_ROTOR{k}_A{letter}"] = float(axis)
    exact = "Exact: it is the vehicle file's."
    told = "Position of the hub from the centre of mass, x forward, y right, z down."
    return [
        Explained("CA_ROTOR_COUNT", {"CA_ROTOR_COUNT": count}, "-", None, "Rotors.", ROTORS, exact),
        Explained("CA_ROTORn_PX, _PY, _PZ", places, "m", None, told, ROTORS, exact),
        Explained(
            "CA_ROTORn_AX, _AY, _AZ",
            axes,
            "-",
            None,
            "Direction of the thrust, in the same frame.",
            ROTORS,
            exact,
        ),
    ]


def moment_ratio(vehicle: Vehicle, still: StaticLoads, flights: Flights) -> Explained:
    """Torque over thrust.

    Parameters
    ----------
    vehicle : Vehicle
        Whose rotors they are.
    still : StaticLoads
        In hover.
    flights : tuple of 2 InplaneForces
        Level flights along x and y.
    """
    arm = flights[0].hover_arm
    arms = np.concatenate([flight.arm for flight in flights]) / arm
    return Explained(
        title="CA_ROTORn_KM",
        values={
            f"CA_ROTOR{k}_KM": round(arm if mount.spin == "ccw" else -arm, 7)
            for k, mount in enumerate(vehicle.mounts)
        },
        unit="m",
        std=still.std_of(-arm / still.thrust, 1.0 / still.thrust),
        meaning=(
            "Torque = CA_ROTORn_KM times thrust; positive for a rotor that turns counter-clockwise "
            "seen from above, whose reaction turns the vehicle clockwise."
        ),
        source=f"{ROTORS}, computeEffectivenessMatrix, and module.yaml",
        holds=(
            "That of hover. In the level flights below the ratio is "
            f"{arms.min():.2f} to {arms.max():.2f} times as large."
        ),
    )


def thrust_coefficient(vehicle: Vehicle, still: StaticLoads, curve: ThrustCurve) -> Explained:
    """Thrust at the full signal.

    Parameters
    ----------
    vehicle : Vehicle
        Whose rotors they are.
    still : StaticLoads
        In hover.
    curve : ThrustCurve
        Thrust by the signal, at most ``LARGEST_THRUST``.
    """
    share = still.std_of(1.0 / still.thrust, 0.0)
    return Explained(
        title="CA_ROTORn_CT",
        values={f"CA_ROTOR{k}_CT": round(curve.full_thrust, 4) for k in range(len(vehicle.mounts))},
        unit="N",
        std=None if share is None else share * curve.full_thrust,
        meaning=(
            "Thrust = CA_ROTORn_CT u^2 with the signal u, hence the thrust at u = 1, at rest. "
            f"{NORMALISED}."
        ),
        source=(
            f"{ALLOCATOR}/module.yaml, and for the normalisation src/lib/control_allocation/"
            "control_allocation/ControlAllocationPseudoInverse.cpp"
        ),
        holds=curve.full_signal(vehicle.powertrain.motor),
    )
