"""Circulation along the blade over a turn: Kutta and Joukowski's law in the wake's own velocity."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from benchmarks.lifting_line.vortices import Floats
from propmap.model.airfoil import Airfoil

TOLERANCE = 1e-6
"""Largest error of the circulation, over the largest circulation [-]."""

MOST_STEPS = 300

DIFFERENCE = 1e-5
"""Step of the angle of attack [rad], for the slope of the lift."""

STALLED_SHARE = 0.3
"""Share of Newton's step that is taken where a section is stalled [-]."""


class Sections(NamedTuple):
    """The blade's sections at all phases; shape (n, M) where none is given."""

    chord: Floats  # [m]
    twist: Floats  # angle of the chord line to the disk [rad]
    tangential: (
        Floats  # air's velocity without the wake's in the rotor's plane, from the leading edge
    )
    normal: Floats  # against the thrust [m/s]
    by_tangential: Floats  # what the wake adds per circulation [1/m], shape (n M, n M)
    by_normal: Floats
    reynolds_per_speed: Floats  # Re over the speed of the air [s/m]


class Flow(NamedTuple):
    """Air and coefficients at the sections, all (n, M): velocities [m/s], slopes [1/rad]."""

    tangential: Floats
    normal: Floats
    speed: Floats
    lift: Floats
    drag: Floats
    lift_slope: Floats


def flow_at(sections: Sections, law: Airfoil, circulation: Floats) -> Flow:
    """Compute the flow that belongs to a ``circulation`` (n, M) [m^2/s]."""
    shape, flat = circulation.shape, circulation.ravel()
    tangential = (sections.by_tangential @ flat).reshape(shape)
    normal = (sections.by_normal @ flat).reshape(shape)
    return _flow(sections, law, tangential, normal)


def averaged_flow(sections: Sections, law: Airfoil, flow: Flow) -> Flow:
    """Compute the flow if the wake induced the same all around, its mean at each radius."""
    tangential = (flow.tangential - sections.tangential).mean(axis=0)
    normal = (flow.normal - sections.normal).mean(axis=0)
    return _flow(sections, law, tangential, normal)


def _flow(
    sections: Sections, law: Airfoil, induced_tangential: Floats, induced_normal: Floats
) -> Flow:
    tangential = sections.tangential + induced_tangential
    normal = sections.normal + induced_normal
    speed = np.hypot(tangential, normal)
    alpha = sections.twist - np.arctan2(normal, tangential)
    reynolds = sections.reynolds_per_speed * speed
    lift, drag = law.coefficients(alpha, reynolds)
    ahead, behind = (law.coefficients(alpha + h, reynolds)[0] for h in (DIFFERENCE, -DIFFERENCE))
    return Flow(tangential, normal, speed, lift, drag, (ahead - behind) / (2.0 * DIFFERENCE))


def solve(sections: Sections, law: Airfoil, start: Floats) -> tuple[Floats, float]:
    """Find the circulation (n, M) [m^2/s] at which Gamma = 1/2 c U C_L everywhere.

    Newton's steps.  Where some section's lift falls with the angle of attack that slope is taken as
    zero, and the steps are short: stalled sections beside each other have many solutions, and long
    steps end at those that alternate along the blade.  An attached blade as ``start`` finds an
    attached one.  Also gives the largest error over the largest circulation [-].
    """
    circulation = start.copy()
    left = np.inf
    for _ in range(MOST_STEPS):
        flow = flow_at(sections, law, circulation)
        error = 0.5 * sections.chord * flow.speed * flow.lift - circulation
        left = float(np.abs(error).max() / np.abs(circulation).max())
        if left < TOLERANCE:
            break
        share = STALLED_SHARE if (flow.lift_slope < 0.0).any() else 1.0
        circulation = circulation + share * _newton_step(sections, flow, error)
    return circulation, left


def _newton_step(sections: Sections, flow: Flow, error: Floats) -> Floats:
    slope = np.maximum(flow.lift_slope, 0.0)
    half = 0.5 * sections.chord / flow.speed
    by_normal = half * (flow.lift * flow.normal - slope * flow.tangential)
    by_tangential = half * (flow.lift * flow.tangential + slope * flow.normal)
    matrix = np.eye(error.size)
    matrix -= by_normal.ravel()[:, None] * sections.by_normal
    matrix -= by_tangential.ravel()[:, None] * sections.by_tangential
    step: Any = np.linalg.solve(matrix, error.ravel())
    return step.reshape(error.shape)
