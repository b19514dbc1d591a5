"""Where some of the blade is likely to stall, and what the rotor carries at rest.

Both decide how many nodes an operating point gets, before and after it is evaluated.  A wrong
forecast costs time or is found out from the result, never accuracy.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.namespace import by_numpy
from propmap.arrays.types import Floats
from propmap.engine.accuracy import STALL_WIDTH
from propmap.physics.velocities import azimuth_nodes
from propmap.solve.problem import Case, RotorArrays
from propmap.solve.rotor_loads import disk_loads

Singles = NDArray[np.float32]

TOGETHER = 1024
"""Points whose stall is forecast at once: more, and NumPy waits for memory."""

STALL_MARGIN = (2.9, 12.0)
"""Distance from the stall angle, in units of the stall's width, within which stall is expected: in
axial flow, and by how much it grows with the advance ratio, since the forecast errs more in fast
flow.  Of 18 000 random points of the three sets of Table I fewer than one in a thousand stalls
unforeseen."""

TIP_SPEED = 100.0
"""[m/s] at which the loads at rest are taken; they hardly depend on it but for the square."""

LEAST_LIFT, LEAST_TORQUE = 0.1, 0.01
"""Loads at rest are taken for no less than those of this mean lift coefficient, and of this mean
coefficient of the force against the rotation [-]; a blade stalled at rest carries little."""


class Forecast(NamedTuple):
    """What is forecast from; S stations.

    Attributes
    ----------
    radius, pitch : ndarray, shape (S,)
        y [m], and angle of the zero-lift line to the disk plane [rad].
    solidity_slope : ndarray, shape (S,)
        N_b c dC_L/dalpha / (8 pi y) of attached flow [-].
    stall_angle, stall_width : float
        From zero lift, of the section law [rad].
    """

    radius: Floats
    pitch: Floats
    solidity_slope: Floats
    stall_angle: float
    stall_width: float

    @classmethod
    def of(cls, arrays: RotorArrays) -> Forecast:
        """For a rotor, as arrays of NumPy."""
        blade, law = arrays.blade, arrays.law
        with by_numpy():
            bounds = law.bounds()
        radius = np.linspace(float(blade.root), float(blade.tip), 12)
        chord = np.interp(radius, blade.station, blade.chord)
        twist = np.interp(radius, blade.station, blade.twist)
        slope = chord * float(blade.blades * bounds.attached_slope) / (8.0 * np.pi * radius)
        pitch = twist - float(law.zero_lift_angle)
        return cls(radius, pitch, slope, float(bounds.least_stall_angle), float(bounds.stall_width))

    def may_stall(self, omega: Floats, v_axial: Floats, v_inplane: Floats) -> NDArray[np.bool_]:
        """Where some of the blade may stall, (N,), from attached lift alone; all descent may."""
        width = max(self.stall_width, STALL_WIDTH)  # the forecast's own error does not shrink
        found = np.empty(omega.size, bool)
        for start in range(0, omega.size, TOGETHER):
            part = slice(start, start + TOGETHER)
            flow = (omega[part], v_axial[part], v_inplane[part])
            advance = flow[2] / np.maximum(flow[0] * self.radius[-1], 1e-9)
            margin = (STALL_MARGIN[0] + STALL_MARGIN[1] * advance) * width
            limit = np.clip(self.stall_angle - margin, 0.0, np.pi)
            # Half as many bits take half of the time.
            blade = (self.radius, self.solidity_slope, self.pitch)
            asked = (values.astype(np.float32) for values in (limit, *blade, *flow))
            found[part] = _exceeds(*asked) | (flow[1] < 0.0)
        return found


def _exceeds(
    limit: Singles,
    radius: Singles,
    solidity_slope: Singles,
    pitch: Singles,
    omega: Singles,
    v_axial: Singles,
    v_inplane: Singles,
) -> NDArray[np.bool_]:
    """Whether somewhere along the blade the angle of attack from zero lift, of either sign, is
    larger than ``limit`` (N,) [rad], between 0 and pi."""
    r, k, theta = radius[:, None], solidity_slope[:, None], pitch[:, None]
    turning = omega * r
    edgewise = v_inplane**2
    speed = np.sqrt(turning**2 + 0.5 * edgewise)
    pull = k * speed
    push = pull * (speed * theta - v_axial)
    least_wake = 0.5 * np.sqrt(np.maximum(k * theta, 0.0)) * turning
    through = np.zeros_like(turning) + v_axial
    for _ in range(4):
        # k U_T (U_T theta - through) = v_i W: blade elements and momentum, small angles.
        wake = np.maximum(np.sqrt(edgewise + through**2) + 1e-9, least_wake)
        through = v_axial + push / (wake + pull)
    # The cosine of an angle from 0 to pi falls with it: no arctangent, which is half of the time.
    along = np.cos(theta) * turning + np.sin(theta) * through
    past = along <= np.cos(limit) * np.sqrt(turning**2 + through**2)
    return np.asarray(past.any(axis=0))


def static_loads(arrays: RotorArrays) -> tuple[float, float]:
    """Thrust [N s^2] and torque [N m s^2] at rest over Omega^2, roughly, and not too small."""
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
