"""The velocity about a rotor's wake: a semi-infinite skewed cylinder of vortex rings.

The rings are parallel to the disk and lie along the direction in which the air carries the wake
away.  The Biot-Savart integral along that direction has a closed form; what is left is one integral
around a ring, here by equally spaced azimuths, which converge geometrically away from the wake's
surface.  With x in radii, a = x - e_r, d the unit direction of the wake, c = |a| and b = a . d,

    w = 1/(4 pi) Int [e_t x a / (c (c - b)) - e_t x d / (c - b)] . z dpsi

is the velocity along z per density of circulation along the wake.  At the disk's centre it is 1/2
for every skew, which is why a wake of density 2 v carries the inflow v of Glauert's momentum (10).

References
----------
W. Castles, J. H. De Leeuw, "The Normal Component of the Induced Velocity in the Vicinity of a
Lifting Rotor and Some Examples of Its Application", NACA Report 1184, 1954.
E. Branlard, M. Gaunaa, "Cylindrical Vortex Wake Model: Skewed Cylinder, Application to Yawed or
Tilted Rotors", Wind Energy 19, 2016, doi 10.1002/we.1838.
"""

from __future__ import annotations

import numpy as np

from propmap.typing import Floats

AZIMUTHS = 32
"""Of the integral around a ring.  With ``CORE`` the error is below 1 % of the inflow outside the
wake's surface and some per cent on it."""

CORE = 0.05
"""Radius of the core of the vortex sheet, over the rotor's radius [-]: it spreads the jump of the
velocity across the wake's surface, so that the velocity is smooth where a wake sweeps over a
rotor."""


def axial_velocity(
    place: Floats, direction: Floats, *, core: float = CORE, azimuths: int = AZIMUTHS
) -> Floats:
    """Downward velocity per density of circulation along the wake of a rotor.

    Parameters
    ----------
    place : ndarray, shape (..., 3)
        Where, in radii from the rotor's centre, in a frame with z along its thrust [-].
    direction : ndarray, shape (..., 3)
        Unit vector along which the air carries the wake away [-].
    core : float
        Radius of the sheet's core, in radii of the rotor [-].
    azimuths : int
        Nodes around a ring.

    Returns
    -------
    ndarray, shape (...)
        Velocity against z [-], positive inside the wake of a rotor that thrusts along z, where it
        goes to 1 far below a rotor in axial flow.
    """
    psi = 2.0 * np.pi * (np.arange(azimuths) + 0.5) / azimuths
    cosine, sine = np.cos(psi), np.sin(psi)
    x, y, z = (place[..., k, None] for k in range(3))
    along_x, along_y, along_z = (direction[..., k, None] for k in range(3))
    from_x, from_y = x - cosine, y - sine
    distance = np.sqrt(from_x**2 + from_y**2 + z**2 + core**2)
    beside = distance - (from_x * along_x + from_y * along_y + z * along_z)
    # The z components of e_t x a and e_t x d, with e_t = (-sin(psi), cos(psi), 0).
    ring = -sine * from_y - cosine * from_x
    wake = -sine * along_y - cosine * along_x
    # Rings that push air down turn the other way: the sign of both terms is that of -z.
    total: Floats = np.mean((ring / distance - wake) / beside, axis=-1)
    return 0.5 * total
