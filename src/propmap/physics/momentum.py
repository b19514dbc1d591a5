"""Momentum theory of an annulus, eqs. (8)-(10) and (12), and its windmill branch.

On (8): the paper negates its right-hand side when the wake is above the disk.  That is right for a
mass flow with a sign.  The mass flow of (10) has none, and the air's velocity changes by 2 v_i
against the thrust whichever way the air crosses the disk.  So the thrust has the sign of v_i in
climb as in windmill descent, and nothing is negated here.
"""

from __future__ import annotations

import numpy as np

from propmap.arrays.namespace import Array, xp
from propmap.physics.velocities import SPEED_FLOOR, floored_norm


def annulus_thrust_slope(
    radius: Array, v_axial: Array, v_inplane: Array, inflow: Array
) -> tuple[Array, Array]:
    """Thrust of an annulus by Glauert's mass flow, eq. (10); eq. (9) is its axial case.

    Parameters
    ----------
    radius : Array
        y [m].
    v_axial, v_inplane : Array
        V cos(beta) and V sin(beta) [m/s].
    inflow : Array
        v_i [m/s]; all broadcast.

    Returns
    -------
    tuple of Array
        Thrust per radius and density [m^3/s^2] (rho times it is dT/dy [N/m]), and its derivative by
        v_i [m^2/s].
    """
    through = v_axial + inflow
    speed = floored_norm(v_inplane, through)
    per_radius = 4.0 * np.pi * radius
    # Eq. (10)
    return per_radius * inflow * speed, per_radius * (speed + inflow * through / speed)


def windmill_annulus_thrust_slope(
    radius: Array, v_axial: Array, v_inplane: Array, inflow: Array
) -> tuple[Array, Array]:
    """Eq. (10) made to rise with v_i everywhere, for the windmill branch of descent.

    In descent within 19.5 deg of the axis, (10) has two turning points.  It rises with v_i up to
    the first, where the far wake stands still (V cos(beta) + 2 v_i = 0 in axial flow); beyond it
    momentum theory does not hold.  It falls to the second, where the air at the disk stands still,
    and rises again.  Up to the first turning point this function is (10) unchanged.  From there on
    the falling stretch is mirrored, so that the thrust goes on rising.  In axial flow the mirrored
    curve is the parabola 4 pi y (v_i - first)^2 above the turning point.  In oblique flow the
    mirrored (10) is averaged with that parabola, whose weight is 1 - 8 tan^2 of the angle: 1 in
    axial flow, 0 at 19.5 deg.  With a = v_i / |V cos(beta)| the parabola is
    C_T = 1 + 4 (a - 1/2)^2, which like Buhl's empirical curve ends at C_T = 2 for a = 1.

    Parameters
    ----------
    radius, v_axial, v_inplane, inflow : Array
        As in ``annulus_thrust_slope``, with v_axial < 0; the results are as there.

    References
    ----------
    M. L. Buhl, NREL/TP-500-36834, 2005.
    """
    first, second = _turning_points(v_axial, v_inplane)
    at_first, _ = annulus_thrust_slope(radius, v_axial, v_inplane, first)
    at_second, _ = annulus_thrust_slope(radius, v_axial, v_inplane, second)
    here, slope = annulus_thrust_slope(radius, v_axial, v_inplane, inflow)
    within = inflow <= second
    past = xp.where(within, 2.0 * at_first - here, here + 2.0 * (at_first - at_second))
    past_slope = xp.where(within, -slope, slope)
    # In oblique flow (10) is flat at ``second``.  Mirrored, this flat place would give (11) further
    # roots; the parabola has none.
    parabola = at_first + 4.0 * np.pi * radius * (inflow - first) ** 2
    parabola_slope = 8.0 * np.pi * radius * (inflow - first)
    axial = 4.0 * (second - first) ** 2 / xp.maximum(v_axial**2, SPEED_FLOOR**2)
    past = axial * parabola + (1.0 - axial) * past
    past_slope = axial * parabola_slope + (1.0 - axial) * past_slope
    valid = inflow <= first
    return xp.where(valid, here, past), xp.where(valid, slope, past_slope)


def past_momentum_theory(v_axial: Array, v_inplane: Array, inflow: Array) -> Array:
    """Whether v_i [m/s] is beyond the first turning point of (10) in steep descent."""
    first, second = _turning_points(v_axial, v_inplane)
    return (inflow > first) & (second > first)


def _turning_points(v_axial: Array, v_inplane: Array) -> tuple[Array, Array]:
    """The two v_i [m/s] between which (10) falls with v_i; equal where it does not fall."""
    square = v_axial**2 - 8.0 * v_inplane**2
    steep = square > 0.0
    root = xp.where(steep, xp.sqrt(xp.where(steep, square, 1.0)), 0.0)
    return 0.25 * (v_axial - root) - v_axial, 0.25 * (v_axial + root) - v_axial


def static_inflow(static_thrust: Array, density: Array, tip_radius: Array) -> Array:
    """Uniform inflow of the rotor in hover, eq. (12).

    Parameters
    ----------
    static_thrust : Array
        Thrust at rest in the air at the same Omega [N].
    density : Array
        rho [kg/m^3].
    tip_radius : Array
        R [m].

    Returns
    -------
    Array
        v_i0 [m/s]; zero where the static thrust is not positive.
    """
    square = static_thrust / (2.0 * density * np.pi * tip_radius**2)
    positive = square > 0.0
    return xp.where(positive, xp.sqrt(xp.where(positive, square, 1.0)), 0.0)  # Eq. (12)
