"""Inflow that varies around the disk: first harmonics on top of the annulus inflow of eq. (11).

At radius y and azimuth psi, 0 at the rear and pi/2 on the advancing side, the inflow is

    v_i(y) + v_0 + (y/R) (v_s sin(psi) + v_c cos(psi)).

The paper averages each annulus over azimuth, v_0 = v_s = v_c = 0: then a rolling moment induces no
inflow, and the theory's own is a quarter too large.  The harmonics take off some thrust; v_0 is the
change of the mean inflow that goes with that, so that the momentum of the whole disk is right.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import jax
import numpy as np

from propmap.arrays.namespace import Array, xp
from propmap.physics.velocities import SPEED_FLOOR, floored_norm

LEAST_MASS_FLOW = 0.5
"""Least ``DiskFlow.mass_flow``, as a share of the air's speed at the disk [-]: it goes to zero
where a braking rotor turns the air back, which no such theory describes."""

LARGEST_ADVANCE = 0.5
"""mu [-] up to which the factors of ``Drees`` are used; they were meant for less."""


class Harmonics(NamedTuple):
    """What is added to the annulus inflow; all (B,).

    Attributes
    ----------
    mean : Array
        v_0 [m/s], at all radii and azimuths.
    lateral : Array
        v_s [m/s], positive where there is more downwash on the advancing side.
    longitudinal : Array
        v_c [m/s], positive where there is more downwash at the rear.
    """

    mean: Array
    lateral: Array
    longitudinal: Array


class DiskFlow(NamedTuple):
    """Mean flow through the disk; all (B,).

    Attributes
    ----------
    omega : Array
        Omega [rad/s].
    v_axial, v_inplane : Array
        V cos(beta) and V sin(beta) [m/s].
    inflow : Array
        v_i averaged over the disk's area [m/s].
    """

    omega: Array
    v_axial: Array
    v_inplane: Array
    inflow: Array

    @property
    def speed(self) -> Array:
        """Speed of the air at the disk [m/s], Glauert's resultant."""
        return floored_norm(self.v_inplane, self.v_axial + self.inflow)

    @property
    def mass_flow(self) -> Array:
        """The mass-flow parameter V of Peters and HaQuang [m/s].

        It is d(v_i W)/dv_i, W being ``speed``: 2 v_i in hover, W in fast flight.  It has a lower
        limit, see ``LEAST_MASS_FLOW`` and ``recirculation``.
        """
        through, speed = self.v_axial + self.inflow, self.speed
        least = xp.maximum(LEAST_MASS_FLOW * speed, self.recirculation)
        return xp.maximum(speed + self.inflow * through / speed, least)

    @property
    def recirculation(self) -> Array:
        """The part of the inflow that meets air from below [m/s]; zero but in descent.

        Where the two are equal, no air goes through the disk in axial descent, and the wake has no
        direction.  The flow is then taken to have this speed along the axis.
        """
        return xp.maximum(xp.minimum(-self.v_axial, self.inflow), 0.0)

    @property
    def skew_cosine(self) -> Array:
        """cos(chi) [-] of the wake's angle chi to the axis, which is 1 in axial flow.

        A wake above the disk is taken as the mirror image of one below.
        """
        along = self._along
        return along / floored_norm(self.v_inplane, along)

    @property
    def half_skew_tangent(self) -> Array:
        """tan(chi/2) [-]: 0 in axial flow, 1 edgewise."""
        along = self._along
        return self.v_inplane / (floored_norm(self.v_inplane, along) + along)

    @property
    def _along(self) -> Array:
        """Speed along the axis that carries the wake away [m/s]."""
        return xp.maximum(xp.abs(self.v_axial + self.inflow), self.recirculation)

    def mean_by_thrust(self, tip: Array) -> Array:
        """Change of the mean inflow per thrust and density, 1/(2 pi R^2 V) [s/m^3]."""
        return 1.0 / (2.0 * np.pi * tip**2 * self.mass_flow)


class HarmonicResponse(NamedTuple):
    """The harmonics as a linear function of the loads; all (B,), loads per density.

    Attributes
    ----------
    mean_by_thrust : Array
        v_0 per change of thrust [s/m^3].
    lateral, longitudinal : Array
        v_s and v_c where all three loads are zero [m/s].
    by_thrust : Array
        v_c per thrust [s/m^3].
    by_roll : Array
        v_s per rolling moment [s/m^4].
    by_pitch : Array
        v_c per moment that lifts the rear [s/m^4].
    """

    mean_by_thrust: Array
    lateral: Array
    longitudinal: Array
    by_thrust: Array
    by_roll: Array
    by_pitch: Array

    def harmonics(
        self, thrust: Array, roll: Array, lifts_rear: Array, thrust_without: Array
    ) -> Harmonics:
        """The harmonics [m/s] that belong to loads per density [m^4/s^2], [m^5/s^2].

        ``thrust_without`` is the thrust of the annulus inflow alone.
        """
        return Harmonics(
            self.mean_by_thrust * (thrust - thrust_without),
            self.lateral + self.by_roll * roll,
            self.longitudinal + self.by_thrust * thrust + self.by_pitch * lifts_rear,
        )


class InflowShape(Protocol):
    """How the inflow varies around the disk; hashable, without arrays."""

    def response(self, flow: DiskFlow, tip: Array) -> HarmonicResponse:
        """The harmonics' dependence on the loads of a rotor of radius ``tip`` [m]."""
        ...


def _gradient(flow: DiskFlow, tip: Array, lateral: Array, longitudinal: Array) -> HarmonicResponse:
    """v_s and v_c in proportion to the mean inflow, by factors [-]."""
    none = xp.zeros_like(flow.inflow)
    own = (lateral * flow.inflow, longitudinal * flow.inflow)
    return HarmonicResponse(flow.mean_by_thrust(tip), *own, none, none, none)


@jax.tree_util.register_static
@dataclass(frozen=True)
class PittPeters:
    """Static inflow of Pitt and Peters with the moments' feedback.

    With coefficients by rho A (Omega R)^2, times R for moments, chi the wake's skew and V its
    mass-flow parameter:

        lambda_s = 4 / (1 + cos(chi)) C_roll / V,
        lambda_c = 15 pi/64 tan(chi/2) C_T / V + 4 cos(chi) / (1 + cos(chi)) C_rear / V,

    C_rear being the moment that lifts the rear: there is more downwash where the disk lifts more.
    The mean inflow is that of eq. (11), averaged over the disk, where Pitt and Peters have a
    uniform one.

    References
    ----------
    D. M. Pitt, D. A. Peters, "Theoretical Prediction of Dynamic-Inflow Derivatives",
    Vertica 5(1), 1981.
    D. A. Peters, N. HaQuang, "Dynamic Inflow for Practical Applications",
    J. American Helicopter Society 33(4), 1988.
    """

    def response(self, flow: DiskFlow, tip: Array) -> HarmonicResponse:
        """As ``InflowShape.response`` of ``flow`` and ``tip``."""
        none, cosine = xp.zeros_like(flow.inflow), flow.skew_cosine
        per_load = 1.0 / (np.pi * tip**2 * flow.mass_flow)
        per_moment = 4.0 * per_load / (tip * (1.0 + cosine))
        return HarmonicResponse(
            flow.mean_by_thrust(tip),
            none,
            none,
            15.0 * np.pi / 64.0 * flow.half_skew_tangent * per_load,
            per_moment,
            cosine * per_moment,
        )


@jax.tree_util.register_static
@dataclass(frozen=True)
class PittPetersGradient:
    """The gradient of Pitt and Peters that thrust drives, without the moments' feedback.

    v_c = 15 pi/32 tan(chi/2) times the mean inflow; see ``PittPeters``.
    """

    def response(self, flow: DiskFlow, tip: Array) -> HarmonicResponse:
        """As ``InflowShape.response`` of ``flow`` and ``tip``."""
        none = xp.zeros_like(flow.inflow)
        return _gradient(flow, tip, none, 15.0 * np.pi / 32.0 * flow.half_skew_tangent)


@jax.tree_util.register_static
@dataclass(frozen=True)
class Coleman:
    """v_c = tan(chi/2) times the mean inflow.

    References
    ----------
    R. P. Coleman, A. M. Feingold, C. W. Stempin, "Evaluation of the Induced-Velocity Field of an
    Idealized Helicopter Rotor", NACA ARR L5E10, 1945.
    """

    def response(self, flow: DiskFlow, tip: Array) -> HarmonicResponse:
        """As ``InflowShape.response`` of ``flow`` and ``tip``."""
        return _gradient(flow, tip, xp.zeros_like(flow.inflow), flow.half_skew_tangent)


@jax.tree_util.register_static
@dataclass(frozen=True)
class WhiteBlake:
    """v_c = sqrt(2) sin(chi) times the mean inflow.

    References
    ----------
    F. White, B. B. Blake, "Improved Method of Predicting Helicopter Control Response and Gust
    Sensitivity", 35th Annual Forum of the American Helicopter Society, 1979.
    """

    def response(self, flow: DiskFlow, tip: Array) -> HarmonicResponse:
        """As ``InflowShape.response`` of ``flow`` and ``tip``."""
        sine = flow.v_inplane / flow.speed
        return _gradient(flow, tip, xp.zeros_like(sine), math.sqrt(2.0) * sine)


@jax.tree_util.register_static
@dataclass(frozen=True)
class Drees:
    """v_c = 4/3 (1 - cos(chi) - 1.8 mu^2) / sin(chi) and v_s = -2 mu, times the mean inflow.

    mu = V sin(beta)/(Omega R), held at ``LARGEST_ADVANCE`` above it.

    References
    ----------
    J. M. Drees, "A Theory of Airflow Through Rotors and Its Application to Some Helicopter
    Problems", J. Helicopter Association of Great Britain 3(2), 1949.
    """

    def response(self, flow: DiskFlow, tip: Array) -> HarmonicResponse:
        """As ``InflowShape.response`` of ``flow`` and ``tip``."""
        tip_speed = flow.omega * tip
        slow = xp.maximum(tip_speed, flow.v_inplane / LARGEST_ADVANCE) + SPEED_FLOOR
        # mu^2 / sin(chi) = V sin(beta) W / (Omega R)^2, W being the speed at the disk.
        square = flow.v_inplane * flow.speed / slow**2
        longitudinal = 4.0 / 3.0 * (flow.half_skew_tangent - 1.8 * square)
        return _gradient(flow, tip, -2.0 * flow.v_inplane / slow, longitudinal)
