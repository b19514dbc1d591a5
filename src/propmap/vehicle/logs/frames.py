"""From the frames of a log to FLU (forward, left, up) and ENU (east, north, up), by name."""

from __future__ import annotations

import numpy as np

from propmap.arrays.types import Floats

HALF = np.sqrt(0.5)

TO_FLU = {"flu": (1.0, 1.0, 1.0), "frd": (1.0, -1.0, -1.0)}
"""Signs of the axes; FRD is FLU turned half a turn about x."""

FROM_BODY = {"flu": (1.0, 0.0, 0.0, 0.0), "frd": (0.0, 1.0, 0.0, 0.0)}
TO_ENU = {"enu": (1.0, 0.0, 0.0, 0.0), "ned": (0.0, HALF, HALF, 0.0)}
"""The same as quaternions w, x, y, z; NED is ENU turned half a turn about north-east."""


def body_to_flu(vectors: Floats, frame: str) -> Floats:
    """Vectors (n, 3) along the axes of the body frame "flu" or "frd", along those of FLU."""
    return vectors * np.array(TO_FLU[frame])


def world_to_enu(vectors: Floats, frame: str) -> Floats:
    """Vectors (n, 3) along the axes of the world frame "enu" or "ned", along those of ENU."""
    return vectors if frame == "enu" else vectors[:, [1, 0, 2]] * np.array([1.0, 1.0, -1.0])


def attitude_to_flu_enu(quaternions: Floats, body_frame: str, world_frame: str) -> Floats:
    """Quaternions (n, 4) from body to world, in the named frames, as those from FLU to ENU."""
    return _product(
        _product(np.array(TO_ENU[world_frame]), quaternions), np.array(FROM_BODY[body_frame])
    )


def quaternion_of_angles(roll: Floats, pitch: Floats, yaw: Floats) -> Floats:
    """Quaternions (n, 4) of angles [rad], (n,): yaw about z, then pitch about y, roll about x.

    The axes are those of the frames that the angles are given in: in FLU a positive pitch is
    nose down, in FRD it is nose up.
    """
    x, y, z = (np.zeros((roll.size, 4)) for _ in range(3))
    for axis, (turn, angle) in enumerate(((x, roll), (y, pitch), (z, yaw)), start=1):
        turn[:, 0], turn[:, axis] = np.cos(angle / 2.0), np.sin(angle / 2.0)
    return _product(_product(z, y), x)


def continuous(quaternions: Floats) -> Floats:
    """Unit quaternions (n, 4) with the signs that make neighbours close."""
    unit = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    same = np.sum(unit[1:] * unit[:-1], axis=1) >= 0.0
    return unit * np.concatenate([[1.0], np.cumprod(np.where(same, 1.0, -1.0))])[:, None]


def world_to_body(quaternions: Floats, vectors: Floats) -> Floats:
    """World vectors (n, 3) along the body axes of unit quaternions (n, 4) from body to world."""
    w, axis = quaternions[:, :1], -quaternions[:, 1:]
    twice = 2.0 * np.cross(axis, vectors)
    return vectors + w * twice + np.cross(axis, twice)


def _product(p: Floats, q: Floats) -> Floats:
    """The quaternion that turns by ``q`` and then by ``p``; (..., 4)."""
    a, u = p[..., :1], p[..., 1:]
    b, v = q[..., :1], q[..., 1:]
    scalar = a * b - np.sum(u * v, axis=-1, keepdims=True)
    return np.concatenate([scalar, a * v + b * u + np.cross(u, v)], axis=-1)
