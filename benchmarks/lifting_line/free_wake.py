"""A wake that goes where the velocities carry it that it induces itself, periodic over a turn."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import propmap
from benchmarks.lifting_line.rotor import (
    LiftingRotor,
    Solution,
    kinematic_viscosity,
    lifting_rotor,
    momentum_inflow,
)
from benchmarks.lifting_line.vortices import Floats, Lattice, segment_velocity
from benchmarks.lifting_line.wake import Flight, Resolution, cosine_edges, radial, rigid_wake

RELAXATION = 0.5
"""Share of the way to the new places that the wake goes at each round [-]."""

SMOOTHING = 0.05
"""Least radius of the cores, over R [-], in the velocities that carry the wake: what rolls up more
finely does not come to rest, and is not resolved."""

CHUNK = 48
"""Points whose velocities are computed together."""


class FreeWake(NamedTuple):
    """A rotor in a wake that is carried away by its own velocities."""

    rotor: LiftingRotor
    solution: Solution
    moved: list[float]
    """Root mean square by which the wake's places moved at each round, over R [-]."""


def free_wake(
    model: propmap.Model,
    flight: Flight,
    thrust: float,
    resolution: Resolution,
    free_turns: int,
    rounds: int,
) -> FreeWake:
    """Solve the rotor in a wake whose first turns are free, and which is moved ``rounds`` times.

    It starts with the uniform inflow of a ``thrust`` [N], which its later turns keep.
    """
    inflow = momentum_inflow(model, flight, thrust)
    blade, viscosity = model.propeller, kinematic_viscosity(model)
    wake = rigid_wake(blade, flight, inflow, viscosity, resolution)
    free, moved = free_turns * resolution.phases, []
    circulation: Floats | None = None
    for _ in range(rounds):
        rotor = lifting_rotor(model, flight, wake, resolution)
        solution = rotor.solved(start=circulation)
        circulation = solution.circulation
        core = np.maximum(wake.trailing_core, SMOOTHING * blade.radius)
        smooth = wake._replace(trailing_core=core)
        induced = _node_velocity(smooth, circulation, blade.blades, free)
        places = _carried(blade, flight, inflow, resolution, induced)
        step = RELAXATION * (places - wake.edges)
        moved.append(float(np.sqrt((step[:, :free] ** 2).sum(axis=-1).mean()) / blade.radius))
        wake = wake._replace(edges=wake.edges + step)
    rotor = lifting_rotor(model, flight, wake, resolution)
    return FreeWake(rotor, rotor.solved(start=circulation), moved)


def _carried(
    blade: propmap.Propeller,
    flight: Flight,
    inflow: float,
    resolution: Resolution,
    induced: Floats,
) -> Floats:
    """Places of the edges by the trapezoidal rule along the paths of what was shed."""
    n = resolution.phases
    step = 2.0 * float(np.pi) / n
    time = step / flight.omega
    radius = cosine_edges(blade.root, blade.radius, resolution.stations)
    uniform = flight.stream - np.array([0.0, 0.0, inflow])
    places = np.empty((n, resolution.turns * n + 1, radius.size, 3))
    azimuth: Floats = step * np.arange(n, dtype=np.float64)
    places[:, 0] = radius[:, None] * radial(azimuth)[:, None, :]
    # The first edge in age is half a step old.
    shed = radius[:, None] * radial(azimuth - 0.5 * step)[:, None, :]
    places[:, 1] = shed + 0.5 * time * (flight.stream + induced[:, 1])
    for k in range(2, places.shape[1]):
        # At the phase before, what is now at edge k was at edge k - 1.
        before = np.roll(places[:, k - 1], 1, axis=0)
        velocity = uniform
        if k < induced.shape[1]:
            velocity = flight.stream + 0.5 * (np.roll(induced[:, k - 1], 1, axis=0) + induced[:, k])
        places[:, k] = before + time * velocity
    return places


def _node_velocity(wake: Lattice, circulation: Floats, blades: int, free: int) -> Floats:
    """Induced velocity [m/s] at the first edges in age, shape (n, free, M + 1, 3)."""
    n, _, nodes, _ = wake.edges.shape
    found = np.zeros((n, free, nodes, 3))
    for phase in range(n):
        parts = []
        for blade in range(blades):
            own = (phase + blade * n // blades) % n
            parts.append(_segments(wake, circulation, own))
        start, end, core, strength = (np.concatenate(a) for a in zip(*parts, strict=True))
        points = wake.edges[phase, :free].reshape(-1, 3)
        for low in range(0, len(points), CHUNK):
            at = points[low : low + CHUNK, None]
            velocity = segment_velocity(at, start, end, core)
            some = np.einsum("psx,s->px", velocity, strength)
            found[phase].reshape(-1, 3)[low : low + CHUNK] = some
    return found


def _segments(
    wake: Lattice, circulation: Floats, phase: int
) -> tuple[Floats, Floats, Floats, Floats]:
    """Ends [m], cores [m] and strengths [m^2/s] of all segments of a blade at a phase."""
    edges = wake.edges[phase]
    ages = np.arange(edges.shape[0] - 1)
    panels = circulation[(phase - ages) % circulation.shape[0]]
    trailing = -np.diff(np.pad(panels, ((0, 0), (1, 1))), axis=1)
    shed = np.diff(np.pad(panels, ((1, 1), (0, 0))), axis=0)
    shed_core = np.broadcast_to(wake.shed_core, shed.shape)
    return (
        np.concatenate([edges[:-1].reshape(-1, 3), edges[:, :-1].reshape(-1, 3)]),
        np.concatenate([edges[1:].reshape(-1, 3), edges[:, 1:].reshape(-1, 3)]),
        np.concatenate([wake.trailing_core.ravel(), shed_core.ravel()]),
        np.concatenate([trailing.ravel(), shed.ravel()]),
    )
