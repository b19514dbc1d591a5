"""Velocity induced by the vortex lattice behind a blade, per circulation of its panels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Lattice(NamedTuple):
    """Trailing vortex sheet of one blade at n phases of its period.

    The sheet has K edges in age and M + 1 along the blade.  Between edges k and k + 1 lies what was
    shed about k steps ago; a step is a period over n.  The first edge is the bound vortex.
    """

    edges: Floats  # (n, K, M + 1, 3) [m]
    trailing_core: Floats  # radius of the cores of what trails [m], (K - 1, M + 1)
    shed_core: Floats  # radius of the cores of what is shed [m], (M,)


def segment_velocity(points: Floats, start: Floats, end: Floats, core: Floats) -> Floats:
    """Velocity induced by straight vortex segments per circulation [1/m], (..., 3).

    Biot and Savart's law with the distance h from the segment's line as h^2 + core^2 in the
    denominator: J. Katz, A. Plotkin, "Low-Speed Aerodynamics", 2nd ed., Cambridge 2001, eq. (2.72);
    M. P. Scully, "Computation of Helicopter Rotor Wake Geometry and Its Influence on Rotor Harmonic
    Airloads", MIT ASRL TR 178-1, 1975, for the core.  Shapes broadcast, ``core`` without the last
    axis.
    """
    first, second = _components(points - start), _components(points - end)
    along = _components(end - start)
    cross = (
        first[1] * second[2] - first[2] * second[1],
        first[2] * second[0] - first[0] * second[2],
        first[0] * second[1] - first[1] * second[0],
    )
    r1, r2 = _length(first), _length(second)
    length_squared = sum(a * a for a in along)
    ends = sum(a * (b / r1 - c / r2) for a, b, c in zip(along, first, second, strict=True))
    denominator = sum(a * a for a in cross) + core**2 * length_squared
    factor = ends / (4.0 * np.pi * denominator)
    return np.stack([factor * a for a in cross], axis=-1)


def _components(vector: Floats) -> tuple[Floats, ...]:
    return vector[..., 0], vector[..., 1], vector[..., 2]


def _length(vector: tuple[Floats, ...]) -> Floats:
    # The floor keeps a segment's own end, where the cross product is zero, from a division by it.
    return np.sqrt(sum(a * a for a in vector) + 1e-24)


def panel_velocity(points: Floats, lattice: Lattice, phase: int) -> Floats:
    """Velocity at points (P, 3) by each panel at a phase, per circulation [1/m], (P, K - 1, M, 3).

    A panel is a ring: outwards along its younger edge, back inwards along the older one.
    """
    at, edges = points[:, None, None], lattice.edges[phase]
    trailing = segment_velocity(at, edges[:-1], edges[1:], lattice.trailing_core)
    shed = segment_velocity(at, edges[:, :-1], edges[:, 1:], lattice.shed_core)
    return trailing[:, :, 1:] - trailing[:, :, :-1] + shed[:, :-1] - shed[:, 1:]


def influence(points: Floats, lattice: Lattice, blades: int) -> Floats:
    """Velocity at points that move with the phase, per circulation of each station at each phase.

    All blades do the same one after another, so that blade b at phase i is where the first one is
    at phase i + b n / blades; n must be a multiple of ``blades``.  Points are (n, P, 3), velocities
    (n, P, n, M, 3) [1/m]: by phase and point, then phase and station of the vortex.
    """
    n, count = points.shape[:2]
    panels, stations = lattice.edges.shape[1] - 1, lattice.edges.shape[2] - 1
    found = np.zeros((n, count, n, stations, 3))
    for phase in range(n):
        for blade in range(blades):
            own = (phase + blade * n // blades) % n
            velocity = panel_velocity(points[phase], lattice, own)
            for age in range(min(n, panels)):
                found[phase, :, (own - age) % n] += velocity[:, age::n].sum(axis=1)
    return found
