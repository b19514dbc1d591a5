"""The arguments of a table's queries: numbers or arrays that broadcast, in any quadrant."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from propmap.errors import InputError, quoted
from propmap.typing import Floats


def broadcast(**named: ArrayLike) -> list[Floats]:
    """The arguments as arrays of one shape; raises ``InputError`` where they are no numbers."""
    arrays = []
    for name, value in named.items():
        try:
            arrays.append(np.asarray(value, dtype=np.float64))
        except (TypeError, ValueError):
            raise InputError(
                f"{name} is {quoted(value)}: give a number or an array of numbers"
            ) from None
    try:
        return list(np.broadcast_arrays(*arrays))
    except ValueError:
        shapes = ", ".join(f"{n} {a.shape}" for n, a in zip(named, arrays, strict=True))
        raise InputError(f"shapes do not fit together: {shapes}; they must broadcast") from None


def split_velocity(omega: ArrayLike, velocity: ArrayLike) -> tuple[Floats, Floats, Floats, Floats]:
    """omega and the velocity's x, y, z, arrays of one shape."""
    (vector,) = broadcast(velocity=velocity)
    if vector.ndim == 0 or vector.shape[-1] != 3:
        raise InputError(f"velocity has shape {vector.shape}: its last axis must hold x, y, z")
    w, x, y, z = broadcast(omega=omega, vx=vector[..., 0], vy=vector[..., 1], vz=vector[..., 2])
    return w, x, y, z


def fold(beta: Floats) -> tuple[Floats, Floats]:
    """beta brought to 0...pi by the loads' mirror symmetry, and the sign of its change."""
    if ((beta >= 0.0) & (beta <= np.pi)).all():
        return beta, np.ones_like(beta)
    with np.errstate(invalid="ignore"):
        turned = np.remainder(beta + np.pi, 2.0 * np.pi) - np.pi
        within = (beta >= 0.0) & (beta <= np.pi)
    return np.where(within, beta, np.abs(turned)), np.where(within | (turned >= 0.0), 1.0, -1.0)
