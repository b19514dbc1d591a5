"""Velocity of the air at a blade section, eqs. (1) and (2), angle of attack, azimuth nodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import numpy as np

from propmap.arrays.elementary import arctangent
from propmap.arrays.loops import mean_over
from propmap.arrays.materialize import materialize
from propmap.arrays.namespace import Array, xp

SPEED_FLOOR = 1e-9
"""[m/s] added in quadrature to every speed that is divided by.

It keeps gradients finite where a section stands still in the air (Omega = V = 0, or the edge of
the reverse-flow circle) and changes no load by more than a rounding error."""


def tangential_velocity(omega: Array, radius: Array, v_inplane: Array, sine: Array) -> Array:
    """Air velocity at a section in the disk plane, against the rotation, eq. (1).

    Parameters
    ----------
    omega : Array
        Rotational speed [rad/s].
    radius : Array
        Radius y of the section [m].
    v_inplane : Array
        V sin(beta) [m/s].
    sine : Array
        sin(psi) [-], 1 on the advancing side.

    Returns
    -------
    Array
        U_T [m/s], of the arguments' broadcast shape; positive from the leading edge.
    """
    return omega * radius + v_inplane * sine  # Eq. (1)


def normal_velocity(v_axial: Array, inflow: Array) -> Array:
    """Air velocity through the disk, eq. (2).

    Parameters
    ----------
    v_axial : Array
        V cos(beta) [m/s].
    inflow : Array
        Inflow v_i(y) [m/s].

    Returns
    -------
    Array
        U_P [m/s], of the arguments' broadcast shape; positive against the thrust.
    """
    return v_axial + inflow  # Eq. (2)


def floored_norm(a: Array, b: Array) -> Array:
    """sqrt(a^2 + b^2) [m/s] with ``SPEED_FLOOR`` added in quadrature."""
    return xp.sqrt(floored_square(a, b))


def floored_square(a: Array, b: Array) -> Array:
    """a^2 + b^2 [m^2/s^2] with the square of ``SPEED_FLOOR`` added."""
    return a * a + b * b + SPEED_FLOOR**2


def angle_of(along: Array, across: Array, size: Array) -> Array:
    """The angle whose cosine is ``along / size`` and sine ``across / size``.

    It is ``atan2(across, along)``, which for alpha is the paper's theta - phi wrapped to (-pi, pi].
    By the half angle, tan(a/2) = sin(a) / (1 + cos(a)), only |t| <= 1 needs an arctangent.

    Parameters
    ----------
    along, across : Array
        Components of one vector, in any unit.
    size : Array
        Its length, > 0.

    Returns
    -------
    Array
        Angle [rad] in [-pi, pi].
    """
    # A product with the reciprocal: XLA would give the quotient of two arrays a kernel of its own.
    half = arctangent(across * (1.0 / (size + xp.abs(along))))
    behind = xp.where(across < 0.0, -np.pi, np.pi) - 2.0 * half
    return xp.where(along < 0.0, behind, 2.0 * half)


@jax.tree_util.register_pytree_node_class
@dataclass(frozen=True)
class AzimuthNodes:
    """Azimuths over which loads are averaged; a pytree.

    Attributes
    ----------
    sines : Array
        sin(psi) [-] of the nodes, shape (n,), or (n, B) with a column for each operating point.
    count : int or Array
        How many rows of ``sines`` are used: a static integer, or integers (B,).
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

    @property
    def axial(self) -> bool:
        """Whether there is a single azimuth, as suffices where loads do not vary with it."""
        return isinstance(self.count, int) and self.count == 1

    def mean(self, term: Callable[[Array], Any], together: int | None = None) -> Any:
        """The mean over azimuth of ``term(sin(psi))``, an array or a tree of arrays.

        ``together`` is as in ``arrays.loops.mean_over``.
        """
        sines = xp.asarray(self.sines)
        if self.axial:
            return materialize(lambda: term(sines[0]), sines[0])
        return mean_over(term, sines, self.count, together)


def azimuth_nodes(azimuths: int) -> AzimuthNodes:
    """Equally spaced azimuths of a full turn, with each distinct value of sin(psi) once.

    The mean over them is the periodic trapezoidal rule, which converges spectrally.  Loads depend
    on psi through sin(psi) alone, and the nodes lie symmetrically about the advancing and the
    retreating side: they come in pairs of equal loads, of which one is computed.

    Parameters
    ----------
    azimuths : int
        Even number of nodes over 2 pi, or 1 for axial flow.
    """
    if azimuths == 1:
        return AzimuthNodes(np.zeros(1), 1)
    half = azimuths // 2
    return AzimuthNodes(np.sin(-0.5 * np.pi + np.pi * (np.arange(half) + 0.5) / half), half)
