"""Section constants that have the loads of another blade.

A blade whose chord is larger by one factor everywhere has the forces of section constants larger by
it, and a blade that is twisted further by one angle everywhere those of angles smaller by it.  So
what is not known of a blade is kept as a change of its constants.
"""

from __future__ import annotations

import numpy as np

from propmap.catalogue.identified import PARAMETERS
from propmap.model.model import Propeller
from propmap.typing import Floats

INNERMOST = 0.3
"""Share of the radius from which blades are compared."""

_FORCES = np.array([name in ("c_l1", "c_d", "c_d0") for name in PARAMETERS], float)
# The coordinate of the drag angle is from the chord line, as the zero-lift angle is.
_ANGLES = np.array([name in ("zero_lift_angle", "drag_angle") for name in PARAMETERS], float)


def equivalent(blade: Propeller, other: Propeller) -> Floats:
    """What the constants of a ``blade`` become on the ``other``, for about the same loads.

    Parameters
    ----------
    blade, other : Propeller
        Of the same radius.

    Returns
    -------
    ndarray, shape (7,)
        To be added to the coordinates of ``prior.PopulationPrior``: the logarithm of the mean ratio
        of the chords in those of forces, and less the mean difference of the twists [rad] in those
        of angles.  Means are weighed by the square of the radius and the other's chord.
    """
    share = other.station / other.radius
    share = share[share >= INNERMOST]
    own, its = (
        [np.interp(share, b.station / b.radius, values) for values in (b.chord, b.twist)]
        for b in (blade, other)
    )
    weight = share**2 * its[0]
    ratio = (weight * own[0] / its[0]).sum() / weight.sum()
    turned = (weight * (own[1] - its[1])).sum() / weight.sum()
    return np.log(ratio) * _FORCES - turned * _ANGLES
