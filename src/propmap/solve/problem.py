"""Equation (11): blade-element thrust equals momentum thrust; and its residual."""

from __future__ import annotations

from typing import NamedTuple

import jax

from propmap.arrays.namespace import Array
from propmap.physics import element
from propmap.physics.element import Annulus, annulus
from propmap.physics.rotor import RotorArrays
from propmap.physics.velocities import AzimuthNodes
from propmap.physics.vortex_ring import on_windmill_branch
from propmap.physics.wake import Wake


class Case(NamedTuple):
    """A rotor at B operating points: all that the inflow depends on; a pytree.

    Attributes
    ----------
    rotor : RotorArrays
        The rotor.
    omega : Array
        Omega [rad/s], >= 0, (B,).
    v_axial, v_inplane : Array
        V cos(beta), positive in climb, and V sin(beta) >= 0 [m/s], (B,).
    v_hover : Array or None
        Static inflow (12) at the same Omega [m/s], (B,), used where v_axial < 0; None if no point
        descends.
    """

    rotor: RotorArrays
    omega: Array
    v_axial: Array
    v_inplane: Array
    v_hover: Array | None


class AnnulusProblem(NamedTuple):
    """Equation (11) at stations (S) and operating points (B); a pytree."""

    at: Annulus
    wake: Wake

    def stations(self, part: slice) -> AnnulusProblem:
        """Equation (11) at some of the stations."""
        station = jax.tree.map(lambda a: a[part], self.at.station)
        return self._replace(at=self.at._replace(station=station))


def annulus_problem(case: Case, radius: Array) -> AnnulusProblem:
    """Equation (11) at ``radius`` [m], (S, 1) or (S, B)."""
    rotor = case.rotor
    blade = (rotor.blade, rotor.law, rotor.medium)
    at = annulus(*blade, radius, case.omega, case.v_axial, case.v_inplane)
    windmill = None if case.v_hover is None else on_windmill_branch(case.v_axial, case.v_hover)
    return AnnulusProblem(at, Wake(windmill, rotor.factors))


def residual(problem: AnnulusProblem, inflow: Array, azimuth: AzimuthNodes) -> Array:
    """Blade-element thrust (5) minus momentum thrust (10), per radius and density [m^3/s^2].

    Parameters
    ----------
    problem : AnnulusProblem
        Annuli and their wakes.
    inflow : Array
        v_i [m/s], (S, B).
    azimuth : AzimuthNodes
        Azimuths to average over.
    """
    blade = element.annulus_thrust(problem.at, inflow, azimuth)
    return blade - problem.wake.thrust_slope(problem.at, inflow)[0]  # Eq. (11)


def residual_slope(
    problem: AnnulusProblem, inflow: Array, azimuth: AzimuthNodes
) -> tuple[Array, Array]:
    """``residual``, and its derivative with respect to the inflow [m^2/s]."""
    thrust, slope = element.annulus_thrust_slope(problem.at, inflow, azimuth)
    wake, wake_slope = problem.wake.thrust_slope(problem.at, inflow)
    return thrust - wake, slope - wake_slope  # Eq. (11)
