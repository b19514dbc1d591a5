"""Where the wake of a rotor's blade lies: carried away by the free stream and a mean inflow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.lifting_line.vortices import Floats, Lattice
from propmap.model.propeller import Propeller

FIRST_CORE = 0.01
"""Radius of a trailing vortex's core at the blade, over the rotor's radius [-]; a twentieth of the
chord of a small propeller."""

LAMB, SQUIRE = 1.25643, 2e-4
"""Growth of a laminar core, and its increase by turbulence per circulation and viscosity [-]."""


@dataclass(frozen=True)
class Resolution:
    """How finely blade and wake are divided, and how thick the vortices are."""

    stations: int = 20  # of a blade, closer at its ends
    phases: int = 36  # steps of a turn; a multiple of the number of blades
    turns: int = 10  # of the wake that are kept
    first_core: float = FIRST_CORE


@dataclass(frozen=True)
class Flight:
    """An operating point."""

    omega: float  # [rad/s]
    v_axial: float  # V cos(beta) [m/s]
    v_inplane: float  # V sin(beta) [m/s]

    @property
    def stream(self) -> Floats:
        """The air's velocity past the hub [m/s], shape (3,)."""
        return np.array([-self.v_inplane, 0.0, -self.v_axial])


def cosine_edges(low: float, high: float, count: int) -> Floats:
    """``count`` + 1 radii [m] from ``low`` to ``high``, closer at both ends."""
    return low + 0.5 * (high - low) * (1.0 - np.cos(np.linspace(0.0, np.pi, count + 1)))


def cosine_middles(low: float, high: float, count: int) -> Floats:
    """The ``count`` radii [m] between those of ``cosine_edges`` of ``low`` to ``high``."""
    angle = (np.arange(count) + 0.5) * np.pi / count
    return low + 0.5 * (high - low) * (1.0 - np.cos(angle))


def radial(azimuth: Floats) -> Floats:
    """Unit vectors from hub to tip, shape (..., 3), at ``azimuth`` [rad], 0 at the rear.

    The frame has x along the in-plane velocity and z along the thrust; the rotor turns
    counter-clockwise seen from above.
    """
    return np.stack([-np.cos(azimuth), -np.sin(azimuth), 0.0 * azimuth], axis=-1)


def ages(resolution: Resolution) -> Floats:
    """Ages of the lattice's edges, in steps [-]: 0, 1/2, 3/2 and so on.

    What was shed k steps ago then lies about its own place.
    """
    count = resolution.turns * resolution.phases
    return np.concatenate([[0.0], np.arange(count) + 0.5])


def rigid_wake(
    propeller: Propeller, flight: Flight, inflow: float, viscosity: float, resolution: Resolution
) -> Lattice:
    """Lay the wake of one blade, carried away by the free stream and a uniform ``inflow`` [m/s].

    Its cores grow by the kinematic ``viscosity`` [m^2/s].
    """
    step = 2.0 * np.pi / resolution.phases
    age = ages(resolution)
    azimuth = step * (np.arange(resolution.phases)[:, None] - age)
    radius = cosine_edges(propeller.root, propeller.radius, resolution.stations)
    drift = flight.stream - np.array([0.0, 0.0, inflow])
    time = age * step / flight.omega
    edges = radius[:, None] * radial(azimuth)[:, :, None, :] + time[:, None, None] * drift
    return Lattice(edges, *cores(propeller, flight, viscosity, resolution))


def cores(
    propeller: Propeller, flight: Flight, viscosity: float, resolution: Resolution
) -> tuple[Floats, Floats]:
    """Radii of the cores [m], of what trails (K - 1, M + 1) and of what is shed (M,).

    Trailing vortices diffuse as those of Lamb and Oseen, faster by Squire's eddy viscosity.

    What is shed has a core of a quarter of the chord.  Thin-airfoil theory has the sheet begin at
    the trailing edge and asks for its downwash at three quarters of the chord, c/4 in front of it.
    Here it begins where the downwash is asked for, and h / (h^2 + (c/4)^2), summed along the sheet,
    comes to the same as 1 / (h + c/4).
    """
    chord = np.interp(
        cosine_middles(propeller.root, propeller.radius, resolution.stations),
        propeller.station,
        propeller.chord,
    )
    # Squire's term takes a circulation, which need not be exact: that of C_L = 0.5 at 3/4 radius.
    at = 0.75 * propeller.radius
    circulation = 0.25 * flight.omega * at * np.interp(at, propeller.station, propeller.chord)
    eddy = 1.0 + SQUIRE * circulation / viscosity
    age = ages(resolution)
    time = 0.5 * (age[1:] + age[:-1]) * 2.0 * np.pi / resolution.phases / flight.omega
    square = (resolution.first_core * propeller.radius) ** 2 + 4.0 * LAMB * eddy * viscosity * time
    trailing = np.sqrt(square)[:, None] * np.ones(resolution.stations + 1)
    return trailing, 0.25 * chord
