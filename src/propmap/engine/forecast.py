"""Where some of the blade may stall, and the loads at rest.

The forecast decides how many nodes an operating point gets at first; the loads at rest, whether it
is evaluated again.  A wrong forecast costs time, not accuracy: it is noticed from the result.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.namespace import by_numpy
from propmap.engine.accuracy import STALL_WIDTH
from propmap.physics.blade_untwist import untwisting
from propmap.physics.rotor import RotorArrays
from propmap.physics.sections.law import SectionLaw
from propmap.physics.velocities import azimuth_nodes
from propmap.solve.problem import Case
from propmap.solve.rotor_loads import disk_loads
from propmap.typing import Floats

Singles = NDArray[np.float32]

TOGETHER = 1024
"""Points whose stall is forecast at once; the arrays of more would not fit in the cache."""

STALL_MARGIN = (2.9, 12.0)
"""Distance from the stall angle within which stall is expected, in units of the stall's width: its
value in axial flow, and its increase with the advance ratio, as the forecast is less accurate in
fast flow.  Of 18 000 random points of the three sets of Table I fewer than one in a thousand stalls
unforeseen."""

TIP_SPEED = 100.0
"""[m/s] at which the loads at rest are computed; they are nearly proportional to its square."""

LEAST_LIFT, LEAST_TORQUE = 0.1, 0.01
"""Lower limits of the loads at rest, as mean coefficients [-] of lift and of the force against the
rotation: a blade stalled at rest has small loads."""


class Forecast(NamedTuple):
    """Forecast of stall from geometry and attached lift; S stations.

    Attributes
    ----------
    law : SectionLaw
        Lift of the sections.
    radius, twist : ndarray, shape (S,)
        y [m], and angle of the chord line to the disk plane at rest [rad].
    untwist_per_square : ndarray, shape (S,)
        What that angle loses over Omega^2 [rad s^2]; see ``BladeUntwist``.
    reynolds_per_omega : ndarray, shape (S,)
        rho y c / mu [s].
    solidity_slope : ndarray, shape (S,)
        N_b c dC_L/dalpha / (8 pi y) of attached flow [-].
    stall_angle, stall_width : float
        Least stall angle from zero lift, and width of stall [rad].
    """

    law: SectionLaw
    radius: Floats
    twist: Floats
    untwist_per_square: Floats
    reynolds_per_omega: Floats
    solidity_slope: Floats
    stall_angle: float
    stall_width: float

    @classmethod
    def of(cls, arrays: RotorArrays) -> Forecast:
        """The forecast for a rotor given as NumPy arrays."""
        blade, law, air = arrays.blade, arrays.law, arrays.medium
        with by_numpy():
            bounds = law.bounds()
        radius = np.linspace(float(blade.root), float(blade.tip), 12)
        chord = np.interp(radius, blade.station, blade.chord)
        twist = np.interp(radius, blade.station, blade.twist)
        rigid: Any = np.float64(0.0)
        bent: Any = (blade.untwist if blade.untwist is not None else rigid, blade.tip, radius, 1.0)
        untwist = np.asarray(untwisting(*bent))
        slope = chord * float(blade.blades * bounds.attached_slope) / (8.0 * np.pi * radius)
        reynolds = float(air.density / air.viscosity) * radius * chord
        stall = float(bounds.least_stall_angle), float(bounds.stall_width)
        return cls(law, radius, twist, untwist, reynolds, slope, *stall)

    def may_stall(self, omega: Floats, v_axial: Floats, v_inplane: Floats) -> NDArray[np.bool_]:
        """Where some of the blade may stall, (N,), from attached lift alone; always in descent."""
        width = max(self.stall_width, STALL_WIDTH)  # the forecast has errors at any width
        found = np.empty(omega.size, bool)
        for start in range(0, omega.size, TOGETHER):
            part = slice(start, start + TOGETHER)
            flow = (omega[part], v_axial[part], v_inplane[part])
            advance = flow[2] / np.maximum(flow[0] * self.radius[-1], 1e-9)
            margin = (STALL_MARGIN[0] + STALL_MARGIN[1] * advance) * width
            limit = np.clip(self.stall_angle - margin, 0.0, np.pi)
            # float32 takes half of the time.
            blade = (self.radius[:, None], self.solidity_slope[:, None], self.pitch(flow[0]))
            asked = (values.astype(np.float32) for values in (limit, *blade, *flow))
            found[part] = _exceeds(*asked) | (flow[1] < 0.0)
        return found

    def pitch(self, omega: Floats) -> Floats:
        """Angle of the zero-lift line to the disk plane [rad], (S, N), at omega (N,) [rad/s]."""
        reynolds: Any = self.reynolds_per_omega[:, None] * omega
        with by_numpy():
            zero_lift = self.law.zero_lift_at(reynolds)
        twist = self.twist[:, None] - self.untwist_per_square[:, None] * omega**2
        return np.asarray(twist - zero_lift)


def _exceeds(
    limit: Singles,
    radius: Singles,
    solidity_slope: Singles,
    pitch: Singles,
    omega: Singles,
    v_axial: Singles,
    v_inplane: Singles,
) -> NDArray[np.bool_]:
    """Whether somewhere along the blade the angle of attack from zero lift exceeds ``limit`` (N,)
    in absolute value; ``limit`` is between 0 and pi [rad].  The blade's arrays are (S, 1), or
    (S, N)."""
    r, k, theta = radius, solidity_slope, pitch
    turning = omega * r
    edgewise = v_inplane**2
    speed = np.sqrt(turning**2 + 0.5 * edgewise)
    pull = k * speed
    push = pull * (speed * theta - v_axial)
    least_wake = 0.5 * np.sqrt(np.maximum(k * theta, 0.0)) * turning
    through = np.zeros_like(turning) + v_axial
    for _ in range(4):
        # Eq. (11) for small angles: k U_T (U_T theta - through) = v_i W.
        wake = np.maximum(np.sqrt(edgewise + through**2) + 1e-9, least_wake)
        through = v_axial + push / (wake + pull)
    # Compare cosines, which fall from 0 to pi: an arctangent would take as long as all the rest.
    along = np.cos(theta) * turning + np.sin(theta) * through
    past = along <= np.cos(limit) * np.sqrt(turning**2 + through**2)
    return np.asarray(past.any(axis=0))


def static_loads(arrays: RotorArrays) -> tuple[float, float]:
    """Thrust [N s^2] and torque [N m s^2] at rest over Omega^2, approximate, with lower limits."""
    blade, density = arrays.blade, float(arrays.medium.density)
    omega, still = np.array([TIP_SPEED / float(blade.tip)]), np.zeros(1)
    with by_numpy():
        case: Case = Case(arrays, omega, still, still, None)  # type: ignore[arg-type]
        at_rest = disk_loads(case, (24,), azimuth_nodes(1)).loads
    station, chord = np.asarray(blade.station), np.asarray(blade.chord)
    force = 0.5 * density * float(blade.blades) * np.trapezoid(chord * station**2, station)
    thrust, torque = (
        abs(float(load[0])) / float(omega[0]) ** 2 for load in (at_rest[0], at_rest[2])
    )
    return max(thrust, LEAST_LIFT * force), max(torque, LEAST_TORQUE * force * float(blade.tip))
