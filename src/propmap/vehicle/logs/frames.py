"""From the frames of a log to FLU (forward, left, up) and ENU (east, north, up), by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from propmap.typing import Floats

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


def body_to_flu(vectors: Floats, frame: str) -> Floats:
    """Vectors (n, 3) along the axes of the body frame "flu" or "frd", along those of FLU."""
    return vectors if frame == "flu" else vectors * np.array([1.0, -1.0, -1.0])


def world_to_enu(vectors: Floats, frame: str) -> Floats:
    """Vectors (n, 3) along the axes of the world frame "enu" or "ned", along those of ENU."""
    return vectors if frame == "enu" else vectors[:, [1, 0, 2]] * np.array([1.0, 1.0, -1.0])


def attitude_to_flu_enu(quaternions: Floats, body_frame: str, world_frame: str) -> Rotation:
    """Rotations from FLU to ENU, of quaternions w, x, y, z (n, 4) between the named frames."""
    from scipy.spatial.transform import Rotation

    attitude = Rotation.from_quat(quaternions, scalar_first=True)
    if body_frame == "frd":  # FLU turned half a turn about x
        attitude = attitude * Rotation.from_quat([0.0, 1.0, 0.0, 0.0], scalar_first=True)
    if world_frame == "ned":  # ENU turned half a turn about north-east
        attitude = Rotation.from_quat([0.0, 1.0, 1.0, 0.0], scalar_first=True) * attitude
    return attitude


def quaternion_of_angles(roll: Floats, pitch: Floats, yaw: Floats) -> Floats:
    """Quaternions (n, 4) of angles [rad], (n,): yaw about z, then pitch about y, roll about x.

    The axes are those of the frames that the angles are given in: in FLU a positive pitch is
    nose down, in FRD it is nose up.
    """
    from scipy.spatial.transform import Rotation

    angles = np.stack([yaw, pitch, roll], axis=1)
    return np.asarray(Rotation.from_euler("ZYX", angles).as_quat(scalar_first=True))


def continuous(quaternions: Floats) -> Floats:
    """Unit quaternions (n, 4) with the signs that make neighbours close."""
    unit = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    same = np.sum(unit[1:] * unit[:-1], axis=1) >= 0.0
    return unit * np.concatenate([[1.0], np.cumprod(np.where(same, 1.0, -1.0))])[:, None]
