"""Flattening of a blade that turns: the centrifugal force on its mass twists it to the disk plane.

A section's mass lies along its chord.  Turning at Omega pulls it outwards from the axis and so into
the disk plane: the propeller moment -Omega^2 I sin(theta) cos(theta) per length.  A blade of
length R that is held at its hub gives way to a moment that is the same all along it by

    delta(y) = delta_tip s (2 - s),   s = y / R,   delta_tip ~ Omega^2 .

Between blades of one material and shape delta_tip goes as the square of the tip speed, whatever
their size, and with (c/t)^2, the square of chord over thickness.  For c/t = 10 and a pitch of 17
degrees it is 0.5 (rho_b (Omega R)^2 / G) (c/2t)^2 sin(theta) cos(theta), at a tip speed of 100 m/s
about 0.05 rad for polycarbonate and 0.02 rad for nylon with glass fibres.

References
----------
J. C. Houbolt, G. W. Brooks, "Differential Equations of Motion for Combined Flapwise Bending,
Chordwise Bending, and Torsion of Twisted Nonuniform Rotor Blades", NACA Report 1346, 1958.
"""

from __future__ import annotations

from propmap.arrays.namespace import Array

TIP_SPEED = 100.0
"""At which the tip's angle is stated [m/s]: an ordinary one of small propellers."""


def untwisting(tip_angle: Array, tip: Array, radius: Array, omega: Array) -> Array:
    """By how much the twist is less than at rest [rad].

    Parameters
    ----------
    tip_angle : Array
        What the tip's twist loses at a tip speed of 100 m/s [rad].
    tip : Array
        R [m].
    radius, omega : Array
        y [m] and Omega [rad/s]; they broadcast to the shape of the result.
    """
    share, tip_speed = radius / tip, omega * tip
    lost: Array = tip_angle * (tip_speed / TIP_SPEED) ** 2 * share * (2.0 - share)
    return lost
