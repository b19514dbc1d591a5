"""Control allocation: thrust and moments that the rotor speeds of a vehicle command."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from propmap.typing import Floats
from propmap.vehicle.vehicle_forces import FORWARD

AXES = ("thrust", "roll", "pitch", "yaw")

APART = 0.2
"""Smallest independent share of a commanded axis.  The share is the norm of the row's component
normal to the other commanded rows, relative to the row's norm.  With this share, the axis requires
changes of thrust five times as large as an independent axis.  With equal spins of diagonal pairs,
yaw has a share of 0.95 if the front arms are twice as wide as the rear arms.  With equal spins
along each side, yaw has a share of 0.11 if the front arms are wider by a quarter."""
NOTHING = 1e-3  # norms of rows, or of their normal components, below this value count as zero


@dataclass(frozen=True, eq=False)
class Allocation:
    """Effect of the thrusts of k rotors on a vehicle, and the axes that the rotor speeds command.

    Attributes
    ----------
    matrix : ndarray, shape (6, k)
        Effect of a unit thrust of each rotor: thrust, moments about x, y and z divided by the
        longest arm, and the forces along the other two axes [-].
    commanded : list of int
        Rows of ``matrix`` that the rotor speeds command independently; their number is the rank.
    notes : list of str
        One sentence that lists the axes among thrust, roll, pitch and yaw that the rotor speeds
        do not command; empty if the rotor speeds command all four.
    """

    matrix: Floats
    commanded: list[int]
    notes: list[str]

    @classmethod
    def of(cls, position: Floats, axis: Floats, torque: Floats) -> Allocation:
        """Return the allocation of k rotors with hubs at ``position`` (k, 3) [m] relative to the
        center of mass.  The thrust acts along the unit vectors ``axis`` (k, 3); ``torque`` (k,) is
        torque over thrust [m], positive for ccw."""
        moment = np.cross(position, axis) - torque[:, None] * axis
        arm = max(np.linalg.norm(position, axis=1).max(), np.abs(torque).max()) or 1.0
        upward = abs(axis[:, 2].mean()) >= FORWARD
        thrust, *others = axis.T[[2, 0, 1] if upward else [0, 1, 2]]
        rows = np.vstack([thrust, moment.T / arm, others])
        least = np.maximum(APART * np.linalg.norm(rows, axis=1), NOTHING)
        commanded: list[int] = []
        # Select the row with the largest normal component, forces normal to the thrust last.
        for group in (range(len(AXES)), range(len(AXES), len(rows))):
            for _ in group:
                shares = rows @ np.linalg.pinv(rows[commanded])
                left = np.linalg.norm(rows - shares @ rows[commanded], axis=1)
                found = [k for k in group if left[k] > least[k]]
                commanded += [max(found, key=left.__getitem__)] if found else []
        axes = [k for k in commanded if k < len(AXES)]
        lost = [_dependence(rows, k, axes, least[k]) for k in range(len(AXES)) if k not in axes]
        remedy = "use control surfaces or servos, or check position, axis and spin of the rotors"
        note = f"rotor speeds alone cannot command {', nor '.join(lost)}; {remedy}"
        return cls(rows, commanded, [note] if lost else [])

    @property
    def condition(self) -> float:
        """Condition number of thrust and moments [-]; infinite unless all axes are commanded."""
        return math.inf if self.notes else float(np.linalg.cond(self.matrix[: len(AXES)]))

    @property
    def yaw_over_roll(self) -> float:
        """Ratio of the largest yaw moment to the largest roll moment, if each thrust changes by the
        same amount [-]; NaN without a roll moment."""
        roll, _, yaw = np.abs(self.matrix[1 : len(AXES)]).sum(axis=1).tolist()
        return yaw / roll if roll > NOTHING else math.nan


def _dependence(rows: Floats, k: int, axes: list[int], least: float) -> str:
    """Name axis ``k``, and the ``axes`` whose part of its row has a norm above ``least``."""
    shares, known = rows[k] @ np.linalg.pinv(rows[axes]), rows[axes]
    parts = np.abs(shares) * np.linalg.norm(known, axis=1)
    others = [AXES[j] for j, part in zip(axes, parts, strict=True) if part > least]
    if not others:
        return f"{AXES[k]} at all"
    left = np.linalg.norm(rows[k] - shares @ known) / np.linalg.norm(rows[k])
    return f"{AXES[k]} without {' and '.join(others)} ({left:.0%} of {AXES[k]} is independent)"
