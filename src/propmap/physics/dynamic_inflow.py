"""The inflow of the whole disk as air that has to be set in motion: Pitt and Peters, dynamic.

The state is the mean inflow over the disk and the two gradients of ``Harmonics``.  Written for the
deviation from the static solution, per density, with T the thrust, L the moment that lifts the
advancing side and M the one that lifts the rear:

    8/3 R^3    dv_0/dt = dT - 2 pi R^2 W dv_0,
    16/45 R^4  dv_s/dt = dL - dv_s / k_s,
    16/45 R^4  dv_c/dt = dM - (dv_c - k_t 2 pi R^2 W dv_0) / k_c,

d being the deviation and k_t, k_s and k_c the static gains of ``HarmonicResponse``.  The masses
are 8/(3 pi), 16/(45 pi) and 16/(45 pi) times rho A R and rho A R^2.  2 pi R^2 W dv_0 is the change
of the momentum's thrust 2 pi R^2 v sqrt((V sin(beta))^2 + (V cos(beta) + v)^2) between both mean
inflows; W, the sum of both in hover, is the mass-flow parameter for small deviations.  In hover the
mean inflow thus follows Carpenter and Fridovich.

References
----------
D. M. Pitt, D. A. Peters, "Theoretical Prediction of Dynamic-Inflow Derivatives", Vertica 5(1),
1981.
D. A. Peters, N. HaQuang, "Dynamic Inflow for Practical Applications", J. American Helicopter
Society 33(4), 1988.
P. J. Carpenter, B. Fridovich, "Effect of a Rapid Blade-Pitch Increase on the Thrust and Induced-
Velocity Response of a Full-Scale Helicopter Rotor", NACA TN 3044, 1953.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from propmap.typing import Floats

LEAST_SHARE = 0.5
"""Least W as a share of the mass-flow parameter at the static solution [-].  In hover it is that of
a disk without inflow; below are states against the stream, where momentum theory does not hold."""

LEAST_TIME = 1e-6
"""Least time constant of the gradient along the flight [s].  It goes to zero with cos(chi), in
edgewise flight without inflow; the gradient then follows the momentum's thrust at once."""


class Disk(NamedTuple):
    """What the motion of the inflow depends on, at N operating points; every field is (N,) but for
    those with another shape.

    Attributes
    ----------
    radius : float
        R [m].
    v_axial, v_inplane : ndarray
        V cos(beta) and V sin(beta) [m/s].
    steady : ndarray, shape (N, 3)
        The static solution: mean inflow, v_s and v_c [m/s].
    mass_flow : ndarray
        The mass-flow parameter V of ``DiskFlow`` there [m/s].
    by_thrust, by_roll, by_pitch : ndarray
        Gains of ``HarmonicResponse`` [s/m^3], [s/m^4], [s/m^4].
    slopes : ndarray, shape (N, 3, 3)
        Derivatives of thrust, rolling moment and moment that lifts the rear, per density, with the
        state, at the static solution [m^3/s], [m^4/s].
    """

    radius: float
    v_axial: Floats
    v_inplane: Floats
    steady: Floats
    mass_flow: Floats
    by_thrust: Floats
    by_roll: Floats
    by_pitch: Floats
    slopes: Floats

    @property
    def masses(self) -> Floats:
        """Apparent masses per density (3,) [m^3], [m^4], [m^4]."""
        return np.array([8.0 / 3.0, 16.0 / 45.0, 16.0 / 45.0]) * self.radius ** np.array([3, 4, 4])

    @property
    def longitudinal_time(self) -> Floats:
        """Time constant of v_c by momentum alone (N,) [s]."""
        return np.maximum(self.masses[2] * self.by_pitch, LEAST_TIME)


def momentum_matrix(disk: Disk, deviation: Floats) -> Floats:
    """Rates of the state's deviation (N, 3) by its own momentum (N, 3, 3) [1/s].

    Without the blades' forces the deviation's rate is this matrix times the deviation.
    """
    mass, roll_mass, _ = disk.masses
    slow = 1.0 / disk.longitudinal_time
    growth = 2.0 * np.pi * disk.radius**2 * _secant(disk, deviation[:, 0])
    matrix = np.zeros((deviation.shape[0], 3, 3))
    matrix[:, 0, 0] = -growth / mass
    matrix[:, 1, 1] = -1.0 / (roll_mass * disk.by_roll)
    matrix[:, 2, 0] = slow * disk.by_thrust * growth
    matrix[:, 2, 2] = -slow
    return matrix


def _secant(disk: Disk, mean: Floats) -> Floats:
    """W [m/s]: the change of v times the air's speed at the disk, over that of v; v is the mean
    inflow, ``mean`` (N,) its deviation."""
    here, there = disk.steady[:, 0] + mean, disk.steady[:, 0]
    speeds = (np.hypot(disk.v_inplane, disk.v_axial + v) for v in (here, there))
    total = sum(speeds) + 1e-30
    # By (a W_a - b W_b)/(a - b), without the difference of nearly equal numbers.
    rise = (2.0 * disk.v_axial + here + there) / total
    found = 0.5 * total + 0.5 * (here + there) * rise
    return np.maximum(found, LEAST_SHARE * disk.mass_flow)


def rates(disk: Disk, deviation: Floats, forces: Floats) -> Floats:
    """Rates of the state (N, 3) [m/s^2].

    Parameters
    ----------
    disk : Disk
        The operating points.
    deviation : ndarray, shape (N, 3)
        The state minus the static one [m/s].
    forces : ndarray, shape (N, 3)
        Thrust, rolling moment and moment that lifts the rear, per density, minus those at the
        static solution [m^4/s^2], [m^5/s^2].
    """
    momentum = momentum_matrix(disk, deviation)
    return forces * _mobility(disk) + np.einsum("nij,nj->ni", momentum, deviation)


def linear_rates(disk: Disk) -> Floats:
    """Derivatives of ``rates`` with the state at the static solution (N, 3, 3) [1/s]."""
    still = np.zeros_like(disk.steady)
    return momentum_matrix(disk, still) + disk.slopes * _mobility(disk)[:, :, None]


def later(disk: Disk, deviation: Floats, forces: Floats, time: Floats) -> Floats:
    """The deviation (N, 3) [m/s] a ``time`` (N,) [s] later.

    The operating point stays as it is meanwhile.  The rates are taken to be a matrix times the
    deviation, the one that gives ``rates`` now and is nearest to the one at the static solution.
    Its exponential is exact where the forces are linear, and stable for any time.  Where the
    blades, in stall, would drive the inflow away from the static solution, they are left out of
    that matrix.

    Parameters
    ----------
    disk, deviation, forces
        As for ``rates``.
    time : ndarray, shape (N,)
        [s].
    """
    size = np.einsum("ni,ni->n", deviation, deviation)
    missing = forces - np.einsum("nij,nj->ni", disk.slopes, deviation)
    per = deviation / np.where(size > 0.0, size, 1.0)[:, None]
    blades = (disk.slopes + missing[:, :, None] * per[:, None, :]) * _mobility(disk)[:, :, None]
    momentum = momentum_matrix(disk, deviation)
    known = np.isfinite(blades).all(axis=(1, 2)) & np.isfinite(momentum).all(axis=(1, 2))
    matrix = np.where(known[:, None, None], momentum + blades, 0.0)
    runs_away = np.linalg.eigvals(matrix).real.max(axis=1) >= 0.0
    matrix = np.where(runs_away[:, None, None], momentum, matrix)
    found = np.einsum("nij,nj->ni", _exponential(matrix * time[:, None, None]), deviation)
    return np.where(known[:, None], found, np.nan)


def _mobility(disk: Disk) -> Floats:
    """Rates per force and density (N, 3) [1/m^3], [1/m^4], [1/m^4]."""
    mass, roll_mass, _ = disk.masses
    ones = np.ones_like(disk.by_pitch)
    pitch = disk.by_pitch / disk.longitudinal_time
    return np.stack([ones / mass, ones / roll_mass, pitch], axis=-1)


def _exponential(matrices: Floats) -> Floats:
    """The exponentials of (N, 3, 3) matrices, by scaling and squaring of the Taylor series."""
    size = np.abs(matrices).sum(axis=2).max(axis=1)
    halvings = np.ceil(np.log2(np.maximum(size, 0.25))).astype(int) + 2
    small = matrices / 2.0 ** halvings[:, None, None]
    term = found = np.broadcast_to(np.eye(3), matrices.shape)
    for k in range(1, 13):  # 0.25^13/13! is 2e-18
        term = term @ small / k
        found = found + term
    for k in range(int(halvings.max(initial=0))):
        found = np.where((k < halvings)[:, None, None], found @ found, found)
    return found
