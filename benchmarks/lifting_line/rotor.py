"""Loads of a rotor whose blades are lifting lines, averaged over a turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

import propmap
from benchmarks.lifting_line.circulation import Flow, Sections, flow_at, solve
from benchmarks.lifting_line.vortices import Floats, Lattice, influence
from benchmarks.lifting_line.wake import (
    Flight,
    Resolution,
    cosine_edges,
    cosine_middles,
    radial,
    rigid_wake,
)

MOST_ROUNDS = 12

LATER_STALL = (2.0, 1.5, 1.25, 1.1)
"""Stall angles over the law's own with which attached flow is looked for [-]."""


class RotorLoads(NamedTuple):
    """Loads averaged over a turn [N], [N m], with the package's signs."""

    thrust: float
    drag: float
    torque: float
    roll_moment: float
    side_force: float
    pitch_moment: float


@dataclass(frozen=True)
class LiftingRotor:
    """A rotor at an operating point, with the velocities that its wake induces."""

    model: propmap.Model  # its inflow is not used
    flight: Flight
    radius: Floats  # of the stations [m], (M,)
    width: Floats
    azimuth: Floats  # of the phases [rad], (n,)
    sections: Sections

    def solved(self, start: Floats | None = None) -> Solution:
        """Solve for the periodic circulation from ``start`` (n, M) [m^2/s] or attached flow."""
        sections, law = self.sections, self.law
        if start is None:
            # Several solutions are possible where sections stall.  The one next to attached flow
            # is looked for, as in the package: stall comes late at first.
            start = np.full(sections.tangential.shape, 1e-3)
            for later in LATER_STALL:
                start, _ = solve(sections, law.with_parameters(alpha_0=later * law.alpha_0), start)
        circulation, left = solve(sections, law, start)
        return Solution(circulation, flow_at(sections, law, circulation), left)

    @property
    def law(self) -> Any:
        """Lift and drag of the sections."""
        return self.model.airfoil

    def loads(self, flow: Flow) -> RotorLoads:
        """Sum up loads of the blades in a ``flow``."""
        half = 0.5 * self.model.air.density * self.sections.chord * flow.speed * self.width
        normal = half * (flow.lift * flow.tangential - flow.drag * flow.normal)
        tangential = half * (flow.lift * flow.normal + flow.drag * flow.tangential)
        sine, cosine = np.sin(self.azimuth)[:, None], np.cos(self.azimuth)[:, None]

        def total(term: Floats) -> float:
            return float(self.model.propeller.blades * term.sum(axis=1).mean())

        return RotorLoads(
            thrust=total(normal),
            drag=total(tangential * sine),
            torque=total(tangential * self.radius),
            roll_moment=total(normal * self.radius * sine),
            side_force=total(tangential * cosine),
            pitch_moment=-total(normal * self.radius * cosine),
        )


class Solution(NamedTuple):
    """A periodic circulation [m^2/s], its flow, and the error left over the largest circulation."""

    circulation: Floats
    flow: Flow
    left: float


def kinematic_viscosity(model: propmap.Model) -> float:
    """Kinematic viscosity of the air [m^2/s]."""
    return model.air.viscosity / model.air.density


def lifting_rotor(
    model: propmap.Model, flight: Flight, wake: Lattice, resolution: Resolution
) -> LiftingRotor:
    """Put the rotor in the ``wake`` of its first blade, which has this ``resolution``."""
    blade, n = model.propeller, resolution.phases
    radius = cosine_middles(blade.root, blade.radius, resolution.stations)
    width = np.diff(cosine_edges(blade.root, blade.radius, resolution.stations))
    azimuth = 2.0 * np.pi * np.arange(n) / n
    outward = radial(azimuth)
    forward = np.cross([0.0, 0.0, 1.0], outward)
    by_circulation = influence(radius[:, None] * outward[:, None], wake, blade.blades)
    by_tangential = -np.einsum("npmjx,nx->npmj", by_circulation, forward)
    by_normal = -by_circulation[..., 2]
    everywhere = np.ones((n, 1))
    chord = PchipInterpolator(blade.station, blade.chord)(radius)
    twist = PchipInterpolator(blade.station, blade.twist)(radius)
    size = n * resolution.stations
    sections = Sections(
        chord=everywhere * chord,
        twist=everywhere * twist,
        tangential=flight.omega * radius - (forward @ flight.stream)[:, None],
        normal=everywhere * (-flight.stream[2] + 0.0 * radius),
        by_tangential=by_tangential.reshape(size, size),
        by_normal=by_normal.reshape(size, size),
        reynolds_per_speed=everywhere * chord / kinematic_viscosity(model),
    )
    return LiftingRotor(model, flight, radius, width, azimuth, sections)


def momentum_inflow(model: propmap.Model, flight: Flight, thrust: float) -> float:
    """Glauert's uniform inflow [m/s] of a rotor of that ``thrust`` [N] in a ``flight``."""
    squared = thrust / (2.0 * model.air.density * np.pi * model.propeller.radius**2)
    inflow = np.sqrt(squared)
    for _ in range(200):
        mass_flow = np.hypot(flight.v_inplane, flight.v_axial + inflow)
        inflow = 0.5 * (inflow + squared / mass_flow)
    return float(inflow)


def in_rigid_wake(
    model: propmap.Model, flight: Flight, thrust: float, resolution: Resolution
) -> LiftingRotor:
    """Put the rotor in a wake that the free stream and the inflow of ``thrust`` [N] carry off."""
    inflow = momentum_inflow(model, flight, thrust)
    viscosity = kinematic_viscosity(model)
    wake = rigid_wake(model.propeller, flight, inflow, viscosity, resolution)
    return lifting_rotor(model, flight, wake, resolution)


def consistent(
    model: propmap.Model, flight: Flight, resolution: Resolution
) -> tuple[LiftingRotor, Solution]:
    """Put the rotor in the rigid wake of its own thrust, and solve for its circulation."""
    # To begin with, a thrust coefficient of 0.01 by rho A (Omega R)^2, about that of a hover.
    tip_speed = flight.omega * model.propeller.radius
    thrust = 0.01 * model.air.density * np.pi * model.propeller.radius**2 * tip_speed**2
    start = None
    for _ in range(MOST_ROUNDS):
        rotor = in_rigid_wake(model, flight, thrust, resolution)
        solution = rotor.solved(start)
        start = solution.circulation
        found = rotor.loads(solution.flow).thrust
        if abs(found - thrust) < 1e-3 * abs(found):
            break
        thrust = found
    return rotor, solution
