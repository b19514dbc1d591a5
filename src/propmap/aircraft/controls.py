"""How rotor speeds make thrust and moments: which of these a vehicle's rotors can balance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from propmap.typing import Floats
from propmap.vehicle.rotors import Rotors

WEAKEST = 0.02
"""Moment that a pattern of rotor speeds must make, over that of the strongest: below, as for the
yaw of rotors that all spin alike about one axis, it is left to control surfaces."""


class Controls(NamedTuple):
    """Patterns of squared rotor speeds, and what each is for.

    Attributes
    ----------
    patterns : ndarray, shape (k, c)
        Of k rotors: the first is thrust, with all rotors alike; the others, of length 1 each, make
        moments.
    moments : ndarray, shape (c - 1, 3)
        Unit vectors along which these balance the moment about the centre of mass [-].
    """

    patterns: Floats
    moments: Floats


def controls(rotors: Rotors, arm_of_torque: float) -> Controls:
    """The patterns of a vehicle.

    With more rotors than there are forces and moments, the speeds differ least from each other.

    Parameters
    ----------
    rotors : Rotors
        Where they are.
    arm_of_torque : float
        Torque over thrust of a rotor [m].
    """
    turning = -arm_of_torque * rotors.spin[:, None] * rotors.axis
    effect = (np.cross(rotors.position, rotors.axis) + turning).T
    alike = np.ones((len(rotors), 1))
    along, size, across = np.linalg.svd(effect, full_matrices=False)
    kept = [k for k in range(size.size) if size[k] > WEAKEST * size[0]] if size[0] > 0.0 else []
    # Thrust comes first: moments that only a change of it would balance are not balanced.
    while kept and _dependent(np.hstack([alike, across[kept].T])):
        kept.pop()
    return Controls(np.hstack([alike, across[kept].T]), along[:, kept].T)


def _dependent(patterns: Floats) -> bool:
    size = np.linalg.svd(patterns / np.linalg.norm(patterns, axis=0), compute_uv=False)
    return patterns.shape[1] > patterns.shape[0] or bool(size[-1] < 1e-3)
