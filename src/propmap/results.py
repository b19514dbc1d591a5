"""Results of a rotor: loads with a status, wrenches, derivatives, fields over the disk."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.typing import Floats

STATUSES = (
    "ok",
    "multiple_roots",
    "windmill",
    "coarse",
    "reversed",
    "vortex_ring",
    "not_converged",
)
"""Statuses of a point, from harmless to fatal; if several apply, the last is reported."""


@dataclass(frozen=True)
class LoadValues:
    """One value of each load and of the power; every field has the shape of the operating points.

    Attributes
    ----------
    thrust : ndarray
        Force along the axis [N].
    drag : ndarray
        Force in the disk plane, against the in-plane velocity [N].
    torque : ndarray
        Moment delivered by the shaft [N m]; negative if the air drives the propeller.
    roll_moment : ndarray
        Moment about the direction of the in-plane velocity [N m], before the sign of the spin is
        applied; positive if it lifts the advancing side.
    side_force : ndarray
        Force in the disk plane across the in-plane velocity [N], positive toward the retreating
        side.  Without inflow harmonics, side force and pitching moment are zero.
    pitch_moment : ndarray
        Moment about the axis across the in-plane velocity [N m], positive if it lifts the front.
    power : ndarray
        Torque times omega [W].
    """

    thrust: Floats
    drag: Floats
    torque: Floats
    roll_moment: Floats
    side_force: Floats
    pitch_moment: Floats
    power: Floats


Deviations = Callable[[], Mapping[str, LoadValues]]  # by source; empty without a covariance


@dataclass(frozen=True)
class Loads(LoadValues):
    """Loads of a rotor; every field has the broadcast shape of the operating points.

    ``LoadValues`` describes ``thrust``, ``drag``, ``torque``, ``roll_moment``, ``side_force``,
    ``pitch_moment`` and ``power``.

    Attributes
    ----------
    status : ndarray of str
        One of ``STATUSES``, per point:

        - "multiple_roots": near stall the inflow has several solutions; the largest is used.
        - "windmill": the descent is so fast that the wake is above the disk.
        - "coarse": loads vary sharply along the blade, so that their error may exceed the accuracy.
        - "reversed": the propeller turns backward, see ``propmap.backward``; no measurement
          confirms these loads.
        - "vortex_ring": momentum theory is not valid; a measured inflow is blended in.  The loads
          are not reliable.
        - "not_converged": the loads are NaN.
    roots : ndarray of int
        Number of solutions of eq. (11), 1 or 3: the largest number at the radii of the quadrature.
        A range of radii with three solutions is missed if it lies between two of these radii.
    reverse_flow : ndarray
        Share of the disk area in which the air meets the blades from behind [-].
    vortex_ring : ndarray
        Share of the measured vortex-ring inflow in the inflow used [-].
    mean_inflow : ndarray
        Inflow averaged over the disk [m/s]: v_i of eq. (11), blended with the measured inflow in
        the vortex ring state.  The harmonic v_0, less than 1 % of v_i, is excluded.
    deviations : callable, optional
        Function that computes ``std_by_source``.
    """

    status: NDArray[np.str_]
    roots: NDArray[np.int64]
    reverse_flow: Floats
    vortex_ring: Floats
    mean_inflow: Floats
    deviations: Deviations | None = field(default=None, repr=False, compare=False)

    @functools.cached_property
    def std_by_source(self) -> Mapping[str, LoadValues]:
        """Standard deviations by source; empty for section constants without a covariance.

        - "parameters": covariance of the section constants, without constants that the data do not
          determine;
        - "geometry": chord and twist of a blade that was not measured;
        - "discrepancy": error of the model with the best constants;
        - "tunnel": difference between specimens or runs, for constants from another tunnel;
        - "installation": unspecified properties of an installed rotor.

        The sources are independent.  The first access computes the standard deviations to first
        order in the parameters.  For many points, it takes about three times as long as the loads.
        """
        return self.deviations() if self.deviations is not None else {}

    @functools.cached_property
    def std(self) -> LoadValues:
        """Standard deviations of the loads and of the power, over all sources.

        They are NaN for loads that are NaN.

        Raises
        ------
        InputError
            For section constants without a covariance.
        """
        parts = list(self.std_by_source.values())
        if not parts:
            found = "these section constants have no covariance, so the loads have no bands"
            remedy = "use constants from the catalogue, or from a file of propmap fit"
            raise InputError(found, remedy)
        return _load_values(lambda name: np.sqrt(sum(getattr(part, name) ** 2 for part in parts)))

    def interval(self, share: float = 0.95) -> tuple[LoadValues, LoadValues]:
        """Return the lower and upper ends of a band that contains the true load.

        The errors are assumed to be normally distributed.

        Parameters
        ----------
        share : float
            Probability that the band contains the true load, between 0 and 1.

        Raises
        ------
        InputError
            For a ``share`` that is not between 0 and 1, and as in ``std``.
        """
        if not 0.0 < share < 1.0:
            raise InputError(f"the share is {share}", "give a probability such as 0.95")
        from statistics import NormalDist

        wide = NormalDist().inv_cdf(0.5 + 0.5 * share)

        def end(sign: float) -> LoadValues:
            return _load_values(
                lambda name: getattr(self, name) + sign * wide * getattr(self.std, name)
            )

        return end(-1.0), end(1.0)


class LoadGradients(NamedTuple):
    """Loads at operating points, and their derivatives with respect to P quantities.

    Attributes
    ----------
    loads : ndarray, shape (L, ...)
        Loads in the order of ``propmap.loads.LOADS`` [N], [N m]; NaN where no inflow was found.
    slopes : ndarray, shape (L, P, ...)
        Derivatives of the loads, per unit of each quantity.
    """

    loads: Floats
    slopes: Floats


@dataclass(frozen=True)
class Inflow:
    """Fields over the disk at one operating point, with S stations and P azimuths.

    Attributes
    ----------
    radius : ndarray, shape (S,)
        Radius y of the stations [m].
    azimuth : ndarray, shape (P,)
        Azimuth psi [rad]: 0 at the rear of the disk (downstream), pi/2 on the advancing side.
    inflow : ndarray, shape (S,)
        v_i(y), averaged over azimuth [m/s], positive against the thrust.
    local_inflow : ndarray, shape (S, P)
        v_i [m/s]; constant over azimuth for a model without inflow harmonics.
    thrust_per_radius, drag_per_radius, torque_per_radius : ndarray, shape (S,)
        Loads per radius, averaged over azimuth [N/m], [N/m], [N].
    alpha : ndarray, shape (S, P)
        Angle of attack from the chord line [rad], in (-pi, pi].
    u_tangential, u_normal : ndarray, shape (S, P)
        Section velocities of eqs. (1) and (2) [m/s].
    past_stall : ndarray, shape (S, P)
        alpha beyond the stall angle [rad]; negative for attached flow.
    stalled : ndarray, shape (S, P)
        Whether ``past_stall`` is positive.
    reverse : ndarray, shape (S, P)
        Whether the air meets the section from behind.
    normal_force : ndarray, shape (S, P)
        Force along the axis on one blade, per radius [N/m].
    """

    radius: Floats
    azimuth: Floats
    inflow: Floats
    local_inflow: Floats
    thrust_per_radius: Floats
    drag_per_radius: Floats
    torque_per_radius: Floats
    alpha: Floats
    u_tangential: Floats
    u_normal: Floats
    past_stall: Floats
    stalled: NDArray[np.bool_]
    reverse: NDArray[np.bool_]
    normal_force: Floats

    def share_of_disk(self, region: NDArray[np.bool_]) -> float:
        """Return the fraction of the disk from root to tip [-] that a ``region`` (S, P) covers."""
        around = region[:, :-1].mean(axis=1)
        area = np.trapezoid(around * self.radius, self.radius)
        return float(area / np.trapezoid(self.radius, self.radius))


def _load_values(of: Callable[[str], Any]) -> LoadValues:
    """Return ``LoadValues`` with the value ``of(name)`` in each field."""
    return LoadValues(**{each.name: of(each.name) for each in fields(LoadValues)})


class Wrench(NamedTuple):
    """Force and moment on the vehicle at the hub, in the rotor frame.

    Attributes
    ----------
    force, moment : ndarray, shape (..., 3)
        Force [N], and moment about the hub [N m].
    """

    force: Floats
    moment: Floats


def spin_sign(spin: str) -> float:
    """Return 1 for a ``spin`` "ccw", -1 for "cw"; raise ``InputError`` for another value."""
    if spin not in ("ccw", "cw"):
        raise InputError(f"spin is {spin!r}: it must be 'ccw' or 'cw', seen from above")
    return 1.0 if spin == "ccw" else -1.0


_UP = np.array([[0.0, 0.0, 1.0]])


def hub_wrench(loads: Floats, direction: Floats, signs: Floats) -> Wrench:
    """Return the wrenches of loads (L, N) in the right-handed rotor frame with z along the thrust.

    ``direction`` (..., 3) is the unit vector of the in-plane velocity; ``signs`` (1,) or (N,) are 1
    for "ccw".
    """
    from propmap import core

    axes = _UP if signs.size == 1 else np.tile(_UP, (signs.size, 1))
    found = core.hub_wrenches(axes, signs, -direction.reshape(-1, 3), loads[:, None])
    return Wrench(*(vectors.reshape(direction.shape) for vectors in found))
