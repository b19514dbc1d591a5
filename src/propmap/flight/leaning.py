"""A leaning vehicle: vectors in its frame, and how far it leans."""

from __future__ import annotations

import numpy as np

from propmap.arrays.types import Floats


def in_leaning_frame(vectors: Floats, pitch: Floats, roll: Floats) -> Floats:
    """Vectors (n, 3) along forward, left, vertical, in the frame of the leaning vehicle.

    pitch : (n,) [rad], about the left, positive where the top leans forward.  roll : (n,) [rad],
    about the vehicle's x axis, after the pitch, positive right side down.
    """
    x, y, z = vectors.T
    # Pitch turns about y to the left, z towards x; roll then about x, y towards z.
    forward, below = x * np.cos(pitch) - z * np.sin(pitch), x * np.sin(pitch) + z * np.cos(pitch)
    left, top = y * np.cos(roll) + below * np.sin(roll), below * np.cos(roll) - y * np.sin(roll)
    return np.stack([forward, left, top], axis=1)


def lean(up: Floats) -> tuple[Floats, Floats]:
    """Pitch and roll [rad] as above, (n,), of a vehicle that sees ``up`` (n, 3)."""
    return -np.arcsin(np.clip(up[:, 0], -1.0, 1.0)), np.arctan2(up[:, 1], up[:, 2])
