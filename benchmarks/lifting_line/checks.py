"""What the lifting line has to give where the answer is known."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.special import hankel2

import propmap
from benchmarks.lifting_line.circulation import Sections, solve
from benchmarks.lifting_line.rotor import consistent, momentum_inflow
from benchmarks.lifting_line.vortices import Floats, Lattice, influence, panel_velocity
from benchmarks.lifting_line.wake import (
    Flight,
    Resolution,
    cosine_edges,
    cosine_middles,
    radial,
    rigid_wake,
)

THIN_AIRFOIL = propmap.Airfoil(c_l1=2.0 * np.pi, c_l2=0.0, c_d=0.0, alpha_0=1.5)
"""2 pi per radian, without stall."""


class Compared(NamedTuple):
    """A number found, and the one known."""

    found: float
    known: float


def _wing_wake(span: Floats, chord: Floats, step: float, phases: int, steps: int) -> Lattice:
    """A plane wake that a stream along x at 1 m/s carries away from a wing along y."""
    age = np.concatenate([[0.0], np.arange(steps) + 0.5])
    edges = np.zeros((phases, age.size, span.size, 3))
    edges[..., 0] = (age * step)[:, None]
    edges[..., 1] = span
    return Lattice(edges, 1e-6 * np.ones((steps, span.size)), 0.25 * chord)


def _wing_sections(
    span: Floats, chord: Floats, normal: Floats, twist: float, wake: Lattice
) -> Sections:
    middle = np.stack([0.0 * chord, span, 0.0 * chord], axis=-1)
    at = np.broadcast_to(middle, (*normal.shape, 3))
    by = influence(at, wake, 1)
    everywhere = np.ones_like(normal)
    return Sections(
        chord=everywhere * chord,
        twist=everywhere * twist,
        tangential=everywhere,
        normal=normal,
        by_tangential=by[..., 0].reshape(normal.size, normal.size),
        by_normal=-by[..., 2].reshape(normal.size, normal.size),
        reynolds_per_speed=1e5 * everywhere,
    )


def elliptic_wing(stations: int = 24, aspect_ratio: float = 8.0) -> Compared:
    """C_L per angle of attack of an elliptic wing, 2 pi / (1 + 2 / A) by Prandtl [1/rad]."""
    alpha, edges = 0.05, cosine_edges(-1.0, 1.0, stations)
    middle = cosine_middles(-1.0, 1.0, stations)
    chord = 8.0 / (np.pi * aspect_ratio) * np.sqrt(1.0 - middle**2)
    wake = _wing_wake(edges, chord, 100.0, 1, 20)
    sections = _wing_sections(middle, chord, np.zeros((1, stations)), alpha, wake)
    circulation, _ = solve(sections, THIN_AIRFOIL, np.full((1, stations), 1e-3))
    area = 4.0 / aspect_ratio
    lift = 2.0 * float((circulation * np.diff(edges)).sum()) / area
    return Compared(lift / alpha, 2.0 * np.pi / (1.0 + 2.0 / aspect_ratio))


def heaving_section(reduced_frequency: float, phases: int = 72) -> tuple[Compared, Compared]:
    """Lift of a heaving section over that without a wake, by Theodorsen C(k) [-].

    Gives the real and the imaginary part; k is of half the chord.  T. Theodorsen, "General Theory
    of Aerodynamic Instability and the Mechanism of Flutter", NACA TR 496, 1935.
    """
    chord, span = np.array([1.0]), np.array([-1e4, 1e4])
    step = np.pi * chord[0] / reduced_frequency / phases
    wake = _wing_wake(span, chord, step, phases, 40 * phases)
    phase = 2.0 * np.pi * np.arange(phases) / phases
    normal = -1e-3 * np.cos(phase)[:, None]
    sections = _wing_sections(np.zeros(1), chord, normal, 0.0, wake)
    circulation, _ = solve(sections, THIN_AIRFOIL, normal + 1e-6)
    found = 2.0 * np.mean(circulation[:, 0] * np.exp(-1j * phase)) / (1e-3 * np.pi)
    h0, h1 = hankel2(0, reduced_frequency), hankel2(1, reduced_frequency)
    known = h1 / (h1 + 1j * h0)
    return Compared(found.real, known.real), Compared(found.imag, known.imag)


def skewed_cylinder(skew: float, resolution: Resolution) -> tuple[Compared, Compared]:
    """Mean v_0 [m/s] of the inflow near the axis in a wake of constant circulation, and its slope.

    The vortex cylinder of Coleman, Feingold and Stempin: averaged over the turn, a wake of constant
    circulation has v_0 = N Gamma Omega / (4 pi W), W being the speed at which it goes away, and
    from there to the rear a slope of tan(chi/2) v_0 / R near the axis, chi being its ``skew`` to
    the axis [rad].  (With the axis's root vortex, which induces nothing along the axis of the rotor
    where it is straight.)  The slope is given over v_0 y / R [-].
    """
    blade = propmap.propeller("apc-8x6e")
    station = np.linspace(0.01, 1.0, 20) * blade.radius
    whole = propmap.Propeller("whole", 2, station, 0.01 + 0.0 * station, 0.2 + 0.0 * station)
    speed, omega = 10.0, 600.0
    flight = Flight(omega, speed * np.cos(skew), speed * np.sin(skew))
    wake = rigid_wake(whole, flight, 0.0, 1.6e-5, resolution)
    azimuth = 2.0 * np.pi * (np.arange(48) + 0.5) / 48
    share = 0.2
    points = share * blade.radius * radial(azimuth)
    induced = np.zeros_like(points)
    for phase in range(resolution.phases):
        induced += 2.0 * panel_velocity(points, wake, phase).sum(axis=(1, 2)) / resolution.phases
    inflow = -induced[:, 2]
    mean = float(inflow.mean())
    slope = 2.0 * float((inflow * np.cos(azimuth)).mean()) / (share * mean)
    known = Compared(mean, omega / (2.0 * np.pi * speed))
    return known, Compared(slope, float(np.tan(0.5 * skew)))


class Hover(NamedTuple):
    """A hovering rotor in the rigid wake of its own thrust."""

    thrust: float  # [N]
    power_factor: float
    """Power that goes into the inflow, over that of momentum theory at the same thrust [-]."""


def hover(model: propmap.Model, omega: float, resolution: Resolution) -> Hover:
    """The rotor of a ``model`` in hover at ``omega`` [rad/s], at this ``resolution``."""
    flight = Flight(omega, 0.0, 0.0)
    rotor, solution = consistent(model, flight, resolution)
    flow, thrust = solution.flow, rotor.loads(solution.flow).thrust
    half = 0.5 * model.air.density * rotor.sections.chord * flow.speed * rotor.width
    lift = model.propeller.blades * half * flow.lift * flow.tangential
    power = float((lift * flow.normal).sum(axis=1).mean())
    return Hover(thrust, power / (thrust * momentum_inflow(model, flight, thrust)))
