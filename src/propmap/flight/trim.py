"""Steady level circles of a vehicle whose section law is known: the paper's experiment."""

from __future__ import annotations

import math

import numpy as np

from propmap.arrays.types import Floats
from propmap.errors import InputError
from propmap.fit.flight import ForceModel
from propmap.fit.parameters import EVERY, PAPER_FOUR, SECTION
from propmap.flight.leaning import in_leaning_frame
from propmap.model.airfoil import Airfoil
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.vehicle import Vehicle

PAPER_RADIUS = 1.7
"""[m], the length of the tether."""

TIP_SPEED = 60.0
"""[m/s] of the rotors from which the search begins."""

CHANGE = 1e-5
"""Of an unknown, for a difference quotient; the forces are computed to about 1e-12."""

LONGEST_STEPS = (0.3, 0.2, 0.2)
"""Of the logarithm of the rotor speed, of pitch and of roll [rad]."""

STEEPEST = 1.4
"""[rad] of pitch and roll."""

ITERATIONS = 30
EXACT, ACCEPTED = 1e-9, 1e-4
"""Force left over, as a share of the weight, at which the search ends, and which is accepted
where the forces jump: the number of azimuths that they are computed with depends on the speed."""


def true_values(vehicle: Vehicle, airfoil: Airfoil) -> dict[str, float]:
    """All parameters of a fit by name, as they are; terms that a fit would add are zero."""
    values = {name: parameter.start for name, parameter in EVERY.items()}
    values |= {name: getattr(airfoil, name) for name in SECTION}
    if vehicle.wing is not None:
        values |= {f"wing_{name}": getattr(vehicle.wing, name) for name in _WING}
    return values


_WING = ("c_l1", "c_l2", "alpha_0")


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

    speeds : (n,) [m/s] >= 0.  radius : of the circles [m]; infinity for straight flight.
    tether : a horizontal one carries the centripetal force, as in the paper; otherwise the
    vehicle banks.  disturbance : (n,), vertical force that the rotors carry besides the weight,
    as a share of it: what an identification, which does not know of it, sees as an error.
    All rotors turn at one speed; moments are not balanced, which takes small differences of
    rotor speed.  The forces are those that identification uses.  ``specific_force`` holds the
    tether's pull.  Raises ``InputError`` for speeds that cannot be flown.
    """
    flown = np.asarray(speeds, dtype=np.float64)
    if flown.ndim != 1 or flown.size == 0 or not (np.isfinite(flown) & (flown >= 0.0)).all():
        raise InputError("speeds must be one or more numbers", "give 0 or more m/s")
    if not radius > 0.0:
        raise InputError(f"the circle's radius is {radius:g} m", "give metres, above 0")
    problem = _Problem(vehicle, airfoil, flown, radius, tether, disturbance)
    unknowns, left_over = _newton(problem)
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
        carried = np.nan_to_num(self.residual(self.first)[:, 1] + lift, nan=1.0)
        self.first[:, 0] -= 0.5 * np.log(np.clip(carried / lift, 0.05, 20.0))

    def log(self, unknowns: Floats) -> FlightLog:
        """The circles as operating points."""
        pitch = unknowns[:, 1]
        roll = unknowns[:, 2] if self.count == 3 else np.zeros_like(pitch)
        nothing, one = np.zeros_like(pitch), np.ones_like(pitch)

        def seen(forward: Floats, left: Floats, vertical: Floats) -> Floats:
            return in_leaning_frame(np.stack([forward, left, vertical], axis=1), pitch, roll)

        up, turn = seen(nothing, nothing, one), self.speeds / self.radius
        speed = np.exp(unknowns[:, :1])
        return FlightLog(
            source="simulated level circles",
            time=np.arange(pitch.size, dtype=np.float64),
            velocity=seen(self.speeds, nothing, nothing),
            rates=turn[:, None] * up,
            up=up,
            specific_force=seen(nothing, self.speeds * turn, GRAVITY * one),
            rotor_speed=np.repeat(speed, len(self.vehicle.mounts), axis=1),
        )

    def residual(self, unknowns: Floats) -> Floats:
        """Forces forward, up and to the left, less those wanted, over the weight; (n, k)."""
        log = self.log(unknowns)
        # With the derivatives that a fit of the paper's four needs, so as to share its program.
        force = ForceModel(self.vehicle, log, self.airfoil).at(self.values, PAPER_FOUR).force
        forward = np.cross(_left(log.up), log.up)
        parts = np.stack([forward, log.up, _left(log.up)], axis=1)[:, : self.count]
        weight = self.vehicle.mass * GRAVITY
        return np.asarray(np.einsum("nki,ni->nk", parts, force) / weight - self.wanted)

    def linearised(self, unknowns: Floats) -> tuple[Floats, Floats]:
        """Residuals (n, k) and their derivatives (n, k, k)."""
        residual = self.residual(unknowns)
        changed = [
            self.residual(unknowns + CHANGE * direction) - residual
            for direction in np.eye(self.count)
        ]
        return residual, np.stack(changed, axis=-1) / CHANGE


def _left(up: Floats) -> Floats:
    """The horizontal direction to the left in the frame of a vehicle that sees ``up``; (n, 3)."""
    forward = np.array([1.0, 0.0, 0.0])
    across = np.cross(up, forward)
    return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))


def _newton(problem: _Problem) -> tuple[Floats, Floats]:
    """The best unknowns found (n, k), and what they leave over (n,)."""
    now = problem.first
    best, left_over = now.copy(), np.full(now.shape[0], np.inf)
    for _ in range(ITERATIONS):
        residual, slopes = problem.linearised(now)
        size = np.nan_to_num(np.max(np.abs(residual), axis=1), nan=np.inf)
        better = size < left_over
        best[better], left_over[better] = now[better], size[better]
        if (left_over < EXACT).all():
            break
        known = np.isfinite(slopes).all(axis=(1, 2)) & np.isfinite(size)
        inverse = np.linalg.pinv(np.where(known[:, None, None], slopes, 0.0))
        step = -np.einsum("nij,nj->ni", inverse, np.where(known[:, None], residual, 0.0))
        longest = np.array(LONGEST_STEPS[: problem.count])
        ahead = now + np.clip(step, -longest, longest)
        ahead[:, 1:] = np.clip(ahead[:, 1:], -STEEPEST, STEEPEST)
        # Where there are no loads, back towards where there were some.
        now = np.where(known[:, None], ahead, 0.5 * (now + best))
    return best, left_over
