"""Steady level circles of a vehicle whose section law is known: the paper's experiment."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.aircraft.trim import solve
from propmap.errors import InputError
from propmap.fit.flight import ForceModel, wing_values
from propmap.fit.parameters import FIRST_GUESS, SECTION, constants_of
from propmap.model.airfoil import Airfoil
from propmap.model.corrections import MountDrag
from propmap.model.model import Model
from propmap.typing import Floats
from propmap.vehicle.log import GRAVITY, FlightLog, in_vehicle_frame
from propmap.vehicle.vehicle import Vehicle

PAPER_RADIUS = 1.7
"""Length of the tether [m]."""

TIP_SPEED = 60.0
"""Tip speed of the rotors [m/s] from which the search begins."""

CHANGE = 1e-5
"""Step of an unknown in a difference quotient; the forces are computed to about 1e-12."""

LONGEST_STEPS = (0.3, 0.2, 0.2)
"""Largest change in one step of the logarithm of the rotor speed, of pitch, of roll [rad]."""

STEEPEST = 1.4
"""Largest pitch and roll [rad]."""

EXACT, ACCEPTED = 1e-9, 1e-4
"""Unbalanced force as a share of the weight: the search ends below the first; up to the second is
accepted, as the forces jump where the number of azimuths, which depends on the speed, changes."""


def true_values(vehicle: Vehicle, airfoil: Airfoil) -> dict[str, float]:
    """All parameters of a fit by name, as they are; what a fit would add to the body is zero.

    Of what the rotors are mounted on, where the vehicle tells it, a fit has no parameter.
    """
    law = constants_of(airfoil)
    section = {name: getattr(law, name) for name in SECTION}
    told = any(mount.drag is not None for mount in vehicle.mounts)
    mounted = Model(vehicle.propeller, law, vehicle.air).correction_of(MountDrag)
    area = None if told or mounted is None else mounted.area(vehicle.propeller.radius)
    mount = {} if area is None else {"mount_area": area}
    return FIRST_GUESS | section | mount | wing_values(vehicle)


def trim(
    vehicle: Vehicle,
    airfoil: Airfoil,
    speeds: Floats,
    *,
    radius: float = PAPER_RADIUS,
    tether: bool = True,
    disturbance: Floats | None = None,
) -> FlightLog:
    """Operating points of level circles to the left, nose first; one per speed.

    All rotors turn at one speed: moments, which take small differences of rotor speed, are not
    balanced.  The forces are those that a fit uses.

    Parameters
    ----------
    vehicle, airfoil : Vehicle, Airfoil
        What flies, and the section law of its blades.
    speeds : ndarray, shape (n,)
        Flight speeds [m/s], >= 0.
    radius : float
        Of the circles [m]; infinity for straight flight.
    tether : bool
        Whether a horizontal tether carries the centripetal force, as in the paper; otherwise the
        vehicle banks.
    disturbance : ndarray, shape (n,), optional
        Vertical force that the rotors carry besides the weight, as a share of it: what a fit,
        which does not know of it, sees as an error.

    Returns
    -------
    FlightLog
        Its ``specific_force`` holds the tether's pull.

    Raises
    ------
    InputError
        For speeds that cannot be flown.
    """
    flown = np.asarray(speeds, dtype=np.float64)
    if flown.ndim != 1 or flown.size == 0 or not (np.isfinite(flown) & (flown >= 0.0)).all():
        raise InputError("speeds must be one or more numbers", "give 0 or more m/s")
    if not radius > 0.0:
        raise InputError(f"the circle's radius is {radius:g} m", "give metres, above 0")
    problem = _Problem(vehicle, airfoil, flown, radius, tether, disturbance)
    functions = problem.linearised, problem.residual, problem.bounded
    unknowns = solve(*functions, problem.first, flown, EXACT)
    left_over = np.abs(problem.residual(unknowns, np.arange(flown.size))).max(axis=1)
    lost = ~(left_over < ACCEPTED)
    if lost.any():
        first = float(flown[lost].min())
        slower = flown[~lost & (flown < first)]
        remedy = f"{slower.max():.4g} m/s can be" if slower.size else "give slower ones"
        if not tether and math.isfinite(radius):
            remedy += ", or fly wider circles"
        raise InputError(
            f"{first:.4g} m/s cannot be flown: no rotor speed and attitude balance the forces",
            f"{remedy}; check mass, propeller and body of the vehicle",
        )
    return problem.log(unknowns)


class _Problem:
    """Force balances of n circles; the unknowns (n, k) are log rotor speed, pitch, roll."""

    def __init__(
        self,
        vehicle: Vehicle,
        airfoil: Airfoil,
        speeds: Floats,
        radius: float,
        tether: bool,
        disturbance: Floats | None,
    ) -> None:
        self.vehicle, self.airfoil, self.speeds, self.radius = vehicle, airfoil, speeds, radius
        self.values = true_values(vehicle, airfoil)
        self.count = 2 if tether else 3
        nothing = np.zeros_like(speeds)
        lift = 1.0 + (nothing if disturbance is None else disturbance)
        aside = speeds**2 / (radius * GRAVITY)
        self.wanted = np.stack([nothing, lift, aside], axis=1)[:, : self.count]
        bank = -np.arctan(aside)
        rate = np.full_like(speeds, np.log(TIP_SPEED / vehicle.propeller.radius))
        self.first = np.stack([rate, nothing, bank], axis=1)[:, : self.count]
        # Thrust goes with the square of the rotor speed.
        everyone = np.arange(speeds.size)
        carried = np.nan_to_num(self.residual(self.first, everyone)[:, 1] + lift, nan=1.0)
        self.first[:, 0] -= 0.5 * np.log(np.clip(carried / lift, 0.05, 20.0))

    def log(self, unknowns: Floats, which: Any = slice(None)) -> FlightLog:
        """The circles, or those of some speeds, as operating points."""
        speeds, pitch = self.speeds[which], unknowns[:, 1]
        roll = unknowns[:, 2] if self.count == 3 else np.zeros_like(pitch)
        up, turn = in_vehicle_frame(0.0, 0.0, 1.0, pitch, roll), speeds / self.radius
        pull = in_vehicle_frame(0.0, speeds * turn, GRAVITY, pitch, roll)
        rotor_speed = np.exp(unknowns[:, :1])
        return FlightLog(
            source="simulated level circles",
            time=np.arange(pitch.size, dtype=np.float64),
            velocity=in_vehicle_frame(speeds, 0.0, 0.0, pitch, roll),
            rates=turn[:, None] * up,
            up=up,
            specific_force=pull,
            rotor_speed=np.repeat(rotor_speed, len(self.vehicle.mounts), axis=1),
        )

    def residual(self, unknowns: Floats, which: NDArray[np.intp]) -> Floats:
        """Forces forward, up and to the left, less those wanted, over the weight; (m, k)."""
        log = self.log(unknowns, which)
        force = ForceModel(self.vehicle, log, self.airfoil).at(self.values, ()).force
        forward = np.cross(_left(log.up), log.up)
        parts = np.stack([forward, log.up, _left(log.up)], axis=1)[:, : self.count]
        weight = self.vehicle.mass * GRAVITY
        return np.asarray(np.einsum("nki,ni->nk", parts, force) / weight - self.wanted[which])

    def linearised(self, unknowns: Floats, which: NDArray[np.intp]) -> tuple[Floats, Floats]:
        """Residuals (m, k) and their derivatives (m, k, k)."""
        residual = self.residual(unknowns, which)
        changed = [
            self.residual(unknowns + CHANGE * direction, which) - residual
            for direction in np.eye(self.count)
        ]
        return residual, np.stack(changed, axis=-1) / CHANGE

    def bounded(self, unknowns: Floats, step: Floats) -> Floats:
        """The step, at most the longest and to the steepest attitude."""
        longest = np.array(LONGEST_STEPS[: self.count])
        step = np.clip(step, -longest, longest)
        angles = unknowns[:, 1:]
        step[:, 1:] = np.clip(angles + step[:, 1:], -STEEPEST, STEEPEST) - angles
        return step


def _left(up: Floats) -> Floats:
    """The horizontal direction to the left in the frame of a vehicle that sees ``up``; (n, 3)."""
    forward = np.array([1.0, 0.0, 0.0])
    across = np.cross(up, forward)
    return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))
