"""Whether equation (11) has roots below the largest, for blades whose stall is not followed."""

from __future__ import annotations

import numpy as np

from propmap.arrays.loops import scan
from propmap.arrays.namespace import Array, xp
from propmap.physics.velocities import AzimuthNodes, azimuth_nodes
from propmap.solve.hump import Angle, angles_about_stall, inflow_at_angle, stall_side
from propmap.solve.problem import AnnulusProblem, residual

_PAST_STALL = np.array([0.0, 0.04, 0.1, 0.2])
"""Angles from the stall angle [rad] at which the residual is sampled."""

EVERY = 3
"""The residual is sampled at every third station."""

AZIMUTHS = 32
"""Azimuth nodes over a full turn, at most.  With 24 nodes, one in five hundred fast points with a
single root is said to have several; with 8 nodes, one in twenty."""


def several_roots(solved: tuple[AnnulusProblem, Array], azimuth: AzimuthNodes) -> Array:
    """Whether (11) has more than one root at a station; bool (B,).

    Below a single root the residual is positive.  Further roots come in pairs, past stall, so that
    a negative residual below the largest root means three roots.  It is sampled at four angles of
    every third station and at few azimuths; the largest root does not depend on this diagnosis.

    Parameters
    ----------
    solved : tuple of AnnulusProblem and Array
        Equation (11) at the stations, and its largest root [m/s], (S, B).
    azimuth : AzimuthNodes
        Azimuths to average over.
    """
    some = azimuth if 2 * len(azimuth.sines) <= AZIMUTHS else azimuth_nodes(AZIMUTHS)
    problem, root = solved[0].stations(slice(None, None, EVERY)), solved[1][::EVERY]
    side = stall_side(problem.stations(slice(-2, -1)))
    margin = 1e-4 * (problem.at.turning + problem.at.v_inplane)

    def look(several: Array, angle: Angle) -> Array:
        v = inflow_at_angle(problem, angle)
        below = v < root - margin
        return several | (below & (residual(problem, xp.where(below, v, 0.0), some) < 0.0))

    none = xp.zeros(root.shape, bool)
    several = scan(look, none, angles_about_stall(problem, side, _PAST_STALL))
    return xp.any(several, axis=0)
