"""Momentum theory of an annulus, eqs. (8)-(10), in every wake state.

Eq. (9) is the axial case of (10).  On (8): the paper says that its right-hand side is
negated when the wake is above the disk.  That belongs to a signed mass flow.  The force on
the rotor is minus the change of momentum of the air; the air's velocity changes by 2 v_i
against the thrust whichever way it crosses the disk, and the mass flow counts how much air
does so, without a sign.  With the unsigned mass flow of (10) the thrust therefore keeps the
sign of v_i in climb and in windmill descent alike, and nothing is negated.
"""

from __future__ import annotations

import numpy as np

from propmap.arrays.namespace import Array, xp
from propmap.physics.velocities import SPEED_FLOOR, floored_norm


def annulus_thrust(radius: Array, v_axial: Array, v_inplane: Array, inflow: Array) -> Array:
    """Thrust per radius and density [m^3/s^2] by Glauert's mass flow, eq. (10).

    radius [m], v_axial = V cos(beta), v_inplane = V sin(beta), inflow = v_i [m/s];
    broadcast.  Multiply by rho for dT/dy [N/m].
    """
    mass_flow_speed = floored_norm(v_inplane, v_axial + inflow)
    return 4.0 * np.pi * radius * inflow * mass_flow_speed  # Eq. (10)


def annulus_thrust_slope(
    radius: Array, v_axial: Array, v_inplane: Array, inflow: Array
) -> tuple[Array, Array]:
    """``annulus_thrust`` [m^3/s^2] and its derivative by the inflow [m^2/s].

    radius, v_axial, v_inplane, inflow : as in ``annulus_thrust``.
    """
    through = v_axial + inflow
    speed = floored_norm(v_inplane, through)
    per_radius = 4.0 * np.pi * radius
    return per_radius * inflow * speed, per_radius * (speed + inflow * through / speed)


def windmill_annulus_thrust_slope(
    radius: Array, v_axial: Array, v_inplane: Array, inflow: Array
) -> tuple[Array, Array]:
    """Eq. (10) made monotone in v_i for the windmill branch of descent [m^3/s^2]; and its slope.

    In descent steeper than 19.5 deg from the axis, (10) rises with v_i up to the load at
    which the far wake stands still (V cos(beta) + 2 v_i = 0 in axial flow), falls to where
    the disk itself is becalmed, and rises again: momentum theory does not hold beyond the
    first turning point.  Here the falling stretch is mirrored so that the thrust goes on
    rising.  Up to the turning point this is (10) unchanged.  Beyond it, in axial flow, the
    mirrored curve is the parabola 4 pi y (v_i - first)^2 above the turning point; in oblique
    flow the two are averaged, from the parabola alone in axial flow to (10) alone at 19.5 deg,
    in proportion to 1 - 8 tan^2 of the angle.  In terms of
    C_T = 1 + 4 (a - 1/2)^2 with a = v_i / |V cos(beta)|, which ends at C_T = 2 for a = 1
    as does the empirical turbulent-wake curve of Buhl, NREL/TP-500-36834, 2005.  Shallower
    than 19.5 deg there is no falling stretch and nothing is changed.

    radius, v_axial, v_inplane, inflow : as in ``annulus_thrust``, with v_axial < 0.
    """
    first, second = _turning_points(v_axial, v_inplane)
    at_first = annulus_thrust(radius, v_axial, v_inplane, first)
    at_second = annulus_thrust(radius, v_axial, v_inplane, second)
    here, slope = annulus_thrust_slope(radius, v_axial, v_inplane, inflow)
    within = inflow <= second
    past = xp.where(within, 2.0 * at_first - here, here + 2.0 * (at_first - at_second))
    past_slope = xp.where(within, -slope, slope)
    # Oblique flow leaves (10) flat where the disk is becalmed, at ``second``; mirrored, that would
    # make a second hump in (11) and branches of its own.  The parabola has no such place.
    parabola = at_first + 4.0 * np.pi * radius * (inflow - first) ** 2
    parabola_slope = 8.0 * np.pi * radius * (inflow - first)
    axial = 4.0 * (second - first) ** 2 / xp.maximum(v_axial**2, SPEED_FLOOR**2)
    past = axial * parabola + (1.0 - axial) * past
    past_slope = axial * parabola_slope + (1.0 - axial) * past_slope
    valid = inflow <= first
    return xp.where(valid, here, past), xp.where(valid, slope, past_slope)


def is_mirrored(v_axial: Array, v_inplane: Array, inflow: Array) -> Array:
    """Whether v_i [m/s] is past the limit of momentum theory in steep descent."""
    first, second = _turning_points(v_axial, v_inplane)
    return (inflow > first) & (second > first)


def _turning_points(v_axial: Array, v_inplane: Array) -> tuple[Array, Array]:
    """The v_i [m/s] between which (10) falls; equal where it does not."""
    square = v_axial**2 - 8.0 * v_inplane**2
    steep = square > 0.0
    root = xp.where(steep, xp.sqrt(xp.where(steep, square, 1.0)), 0.0)
    return 0.25 * (v_axial - root) - v_axial, 0.25 * (v_axial + root) - v_axial


def static_inflow(static_thrust: Array, density: Array, tip_radius: Array) -> Array:
    """Uniform inflow of the rotor in hover [m/s], eq. (12).

    static_thrust [N] at the same Omega, density [kg/m^3], tip_radius R [m]; broadcast.
    Zero where the static thrust is not positive.
    """
    square = static_thrust / (2.0 * density * np.pi * tip_radius**2)
    positive = square > 0.0
    return xp.where(positive, xp.sqrt(xp.where(positive, square, 1.0)), 0.0)  # Eq. (12)
