"""Thrust of a rotor whose blades are nowhere stalled, by small angles: a good guess, at once.

Each annulus has its Glauert inflow (10) for the lift of small angles of attack, without drag, tip
loss or stall.  Outside of descent such a thrust gives the inflow of ordinary flight within one per
cent; in descent, where momentum theory has several solutions or none, it takes the largest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from propmap.engine.forecast import Forecast
from propmap.physics.rotor import RotorArrays
from propmap.typing import Floats

STEPS = 8
"""Of Newton's method, from above the largest solution."""


def attached_thrust(
    rotor: RotorArrays,
    omega: Floats,
    v_axial: Floats,
    v_inplane: Floats,
    others: Sequence[RotorArrays] = (),
) -> tuple[Floats, Floats]:
    """Thrust of attached blades, and by how much that of slightly different rotors is more.

    Parameters
    ----------
    rotor : RotorArrays
        The rotor, of NumPy arrays.
    omega, v_axial, v_inplane : ndarray, shape (N,)
        [rad/s], [m/s]; v_inplane >= 0.
    others : sequence of P RotorArrays
        The same rotor with other section constants.

    Returns
    -------
    tuple of ndarray, shape (N,) and (P, N)
        Thrust [N], and the differences [N] to first order in those of the lift.
    """
    forecast = Forecast.of(rotor)
    radius, pull = forecast.radius[:, None], forecast.solidity_slope[:, None]
    pitch = forecast.pitch(omega)
    turning, edgewise = omega * radius, v_inplane**2
    # The mean over azimuth of U_T^2 (theta - phi): U_T = Omega y + V_in sin(psi).
    lifting = turning**2 + 0.5 * edgewise
    push = lifting * pitch - turning * v_axial
    v = np.sqrt(np.maximum(pull * push, 0.0)) + 1.5 * np.maximum(-v_axial, 0.0)
    for _ in range(STEPS):
        wake, slope = _wake(v, v_axial, edgewise)
        v = v - (v * wake - pull * (push - turning * v)) / (slope + pull * turning)
    wake, slope = _wake(v, v_axial, edgewise)
    weight = 4.0 * np.pi * float(rotor.medium.density) * radius
    thrust = np.asarray(np.trapezoid(weight * v * wake, forecast.radius, axis=0))
    yielding = weight * slope / (slope + pull * turning)
    more = np.zeros((len(others), omega.size))
    for row, other in enumerate(others):
        there = Forecast.of(other)
        steeper = there.solidity_slope[:, None] - pull
        driven = pull * lifting * (there.pitch(omega) - pitch) + steeper * (push - turning * v)
        more[row] = np.trapezoid(yielding * driven, forecast.radius, axis=0)
    return thrust, more


def _wake(v: Floats, v_axial: Floats, edgewise: Floats) -> tuple[Floats, Floats]:
    """W of eq. (10) at the inflow ``v`` [m/s], and the derivative of v W by v."""
    through = v_axial + v
    wake = np.sqrt(edgewise + through**2 + 1e-9)
    return wake, np.maximum(wake + v * through / wake, 1e-3)
