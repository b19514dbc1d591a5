"""Section velocities, eqs. (1) and (2), and the azimuth nodes they are evaluated at."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax
import numpy as np

from propmap.arrays.namespace import Array, xp

SPEED_FLOOR = 1e-9
"""[m/s] added in quadrature to every speed that is divided by.

It keeps the gradient finite where a section stands still in the air (Omega = V = 0, or the
edge of the reverse-flow circle) and changes no load by more than a rounding error."""


@jax.tree_util.register_pytree_node_class
@dataclass(frozen=True)
class AzimuthNodes:
    """Azimuth nodes, a pytree: the first ``count`` rows of sines [-] are used.

    For one number of nodes sines is (n,) and count a Python integer: static, which reverse-mode
    differentiation needs.  For a number of its own per operating point sines is (n, B) and count
    an integer array (B,).
    """

    sines: Array | np.ndarray
    count: Array | int

    def tree_flatten(self) -> tuple[tuple[Any, ...], int | None]:
        """Children and static part, for JAX."""
        if isinstance(self.count, int):
            return (self.sines,), self.count
        return (self.sines, self.count), None

    @classmethod
    def tree_unflatten(cls, static: int | None, children: tuple[Any, ...]) -> AzimuthNodes:
        """The inverse of ``tree_flatten``."""
        return cls(*children) if static is None else cls(children[0], static)


def azimuth_nodes(azimuths: int) -> AzimuthNodes:
    """The nodes of a full turn, each distinct value of sin(psi) once.

    azimuths : even number of nodes over 2 pi, or 1 for axial flow.

    The loads depend on the azimuth psi only through sin(psi), so the equally spaced nodes
    of a full turn, placed symmetrically about the advancing and the retreating side, come
    in pairs of equal value: half of them carry the whole spectrally accurate trapezoid.
    """
    if azimuths == 1:
        return AzimuthNodes(np.zeros(1), 1)
    half = azimuths // 2
    return AzimuthNodes(np.sin(-0.5 * np.pi + np.pi * (np.arange(half) + 0.5) / half), half)


def tangential_velocity(omega: Array, radius: Array, v_inplane: Array, sine: Array) -> Array:
    """Air velocity along the chordwise direction of rotation [m/s], eq. (1).

    omega [rad/s], radius [m], v_inplane = V sin(beta) [m/s], sine = sin(psi) [-];
    broadcast against each other.  Positive from the leading edge.
    """
    return omega * radius + v_inplane * sine  # Eq. (1)


def normal_velocity(v_axial: Array, inflow: Array) -> Array:
    """Air velocity through the disk [m/s], eq. (2), positive against the thrust.

    v_axial = V cos(beta) [m/s], inflow = v_i(y) [m/s]; broadcast against each other.
    """
    return v_axial + inflow  # Eq. (2)


def floored_norm(a: Array, b: Array) -> Array:
    """sqrt(a^2 + b^2) [m/s] with ``SPEED_FLOOR`` added in quadrature."""
    return xp.sqrt(floored_square(a, b))


def floored_square(a: Array, b: Array) -> Array:
    """a^2 + b^2 [m^2/s^2] with the square of ``SPEED_FLOOR`` added."""
    return a * a + b * b + SPEED_FLOOR**2
