"""Control allocation: thrust and moments that a vehicle commands by its rotor speeds."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from propmap.typing import Floats
from propmap.vehicle.vehicle_forces import FORWARD

AXES = ("thrust", "roll", "pitch", "yaw")

APART = 0.2
"""Least independent share of a commanded axis, which then needs five times the changes of thrust.
Yaw by diagonal pairs keeps 0.95 with front arms twice as wide as the rear arms.  Yaw by equal spins
along the sides keeps 0.11 with front arms wider by a quarter."""
NOTHING = 1e-3  # moment over thrust and arm that is too small to command an axis


@dataclass(frozen=True, eq=False)
class Allocation:
    """Effect of the thrusts of k rotors on a vehicle, and the axes that rotor speeds command.

    Attributes
    ----------
    matrix : ndarray, shape (6, k)
        Effect of a unit thrust of each rotor: thrust, moments about x, y and z divided by the
        longest arm, and the forces along the other two axes [-].
    commanded : list of int
        Rows that the rotor speeds command independently; the length is the rank.
    notes : list of str
        A sentence on thrust, roll, pitch or yaw, unless all four are commanded.
    """

    matrix: Floats
    commanded: list[int]
    notes: list[str]

    @classmethod
    def of(cls, position: Floats, axis: Floats, torque: Floats) -> Allocation:
        """Return the allocation of hubs at the ``position`` (k, 3) relative to the center of mass
        [m], for thrust along the unit vectors ``axis`` (k, 3), with ``torque`` (k,) over thrust
        [m], positive for ccw."""
        moment = np.cross(position, axis) - torque[:, None] * axis
        arm = max(np.linalg.norm(position, axis=1).max(), np.abs(torque).max()) or 1.0
        upward = abs(axis[:, 2].mean()) >= FORWARD
        thrust, *others = axis.T[[2, 0, 1] if upward else [0, 1, 2]]
        rows = np.vstack([thrust, moment.T / arm, others])
        least = np.maximum(APART * np.linalg.norm(rows, axis=1), NOTHING)
        commanded: list[int] = []
        # The strongest rows first, and forces across the thrust after all axes.
        for group in (range(len(AXES)), range(len(AXES), len(rows))):
            for _ in group:
                shares = rows @ np.linalg.pinv(rows[commanded])
                left = np.linalg.norm(rows - shares @ rows[commanded], axis=1)
                found = [k for k in group if left[k] > least[k]]
                commanded += [max(found, key=left.__getitem__)] if found else []
        axes = [k for k in commanded if k < len(AXES)]
        lost = [_dependence(rows, k, axes, least[k]) for k in range(len(AXES)) if k not in axes]
        remedy = "without control surfaces or servos, check position, axis and spin of the rotors"
        note = f"rotor speeds alone cannot command {', nor '.join(lost)}; {remedy}"
        return cls(rows, commanded, [note] if lost else [])

    @property
    def condition(self) -> float:
        """Condition number of thrust and moments [-]; infinite if an axis is not commanded."""
        return math.inf if self.notes else float(np.linalg.cond(self.matrix[: len(AXES)]))

    @property
    def yaw_over_roll(self) -> float:
        """Largest yaw moment over largest roll moment, for equal changes of all thrusts [-]; NaN
        without a roll moment."""
        roll, _, yaw = np.abs(self.matrix[1 : len(AXES)]).sum(axis=1).tolist()
        return yaw / roll if roll > NOTHING else math.nan


def _dependence(rows: Floats, k: int, axes: list[int], least: float) -> str:
    """Return axis ``k`` with the commanded ``axes`` that contribute more than ``least``."""
    shares, known = rows[k] @ np.linalg.pinv(rows[axes]), rows[axes]
    parts = np.abs(shares) * np.linalg.norm(known, axis=1)
    others = [AXES[j] for j, part in zip(axes, parts, strict=True) if part > least]
    if not others:
        return f"{AXES[k]} at all"
    left = np.linalg.norm(rows[k] - shares @ known) / np.linalg.norm(rows[k])
    why = f"{left:.0%} of it is independent" if left > NOTHING else "proportional"
    return f"{AXES[k]} without {' and '.join(others)} ({why})"
