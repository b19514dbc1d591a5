"""Whether equation (11) has further roots below the largest, where stall is not followed."""

from __future__ import annotations

import numpy as np

from propmap.arrays.loops import scan
from propmap.arrays.namespace import Array, xp
from propmap.physics.velocities import AzimuthNodes, azimuth_nodes
from propmap.solve.hump import Angle, angles_about_stall, inflow_at_angle, stall_side
from propmap.solve.problem import AnnulusProblem, residual

_PAST_STALL = np.array([0.0, 0.04, 0.1, 0.2])
"""[rad] from the stall angle at which the residual is sampled."""

EVERY = 3
"""Every how many stations."""

AZIMUTHS = 32
"""Azimuth nodes over a full turn, at most.  With 24 of them, one fast point in five hundred is told
to have several roots that has one; with 8, one in twenty."""


def several_roots(solved: tuple[AnnulusProblem, Array], azimuth: AzimuthNodes) -> Array:
    """Whether (11) has more than one root at a station; bool (B,).

    Below the largest root the residual is positive, unless there are further roots, which come in
    pairs and arise past stall: so a negative residual there tells of three.  It is sampled at four
    angles of every third station, with no more azimuth nodes than it takes: a diagnosis, on which
    the largest root does not depend.

    Parameters
    ----------
    solved : tuple of AnnulusProblem and Array
        Equation (11) at the stations, and its largest root [m/s], (S, B).
    azimuth : AzimuthNodes
        Nodes to average over.
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
