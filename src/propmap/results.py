"""What a rotor answers: loads with a status, vectors, derivatives, fields over the disk."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.typing import Floats

STATUSES = ("ok", "multiple_roots", "windmill", "coarse", "vortex_ring", "not_converged")
"""From harmless to fatal; where several apply, the last is given."""


@dataclass(frozen=True)
class LoadValues:
    """A value of each load and of the power; every field has the shape of the operating points.

    Attributes
    ----------
    thrust : ndarray
        Along the axis [N].
    drag : ndarray
        In the disk plane, against the in-plane velocity [N].
    torque : ndarray
        What turns the shaft [N m]; negative where the air drives the propeller.
    roll_moment : ndarray
        About the direction of the in-plane velocity [N m], positive where the advancing side is
        lifted, before the sign of the spin is applied.
    side_force : ndarray
        In the disk plane across the in-plane velocity [N], positive towards the retreating side.
        Zero, like the pitching moment, where the inflow does not vary around the disk.
    pitch_moment : ndarray
        About the axis across the in-plane velocity [N m], positive where the front is lifted.
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


Deviations = Callable[[], Mapping[str, LoadValues]]  # by source; empty where nothing is known


@dataclass(frozen=True)
class Loads(LoadValues):
    """Loads of a rotor; every field has the broadcast shape of the operating points.

    ``thrust``, ``drag``, ``torque``, ``roll_moment``, ``side_force``, ``pitch_moment`` and
    ``power`` are described in ``LoadValues``.

    Attributes
    ----------
    status : ndarray of str
        One of ``STATUSES``.  "multiple_roots": near stall the inflow has several solutions, the
        largest is used.  "windmill": descent so fast that the wake is above the disk.
        "vortex_ring": momentum theory does not hold and a measured inflow is blended in; not to be
        trusted.
        "coarse": loads vary so sharply along the blade that their error may exceed what the
        accuracy promises.  "not_converged": the loads are NaN.
    roots : ndarray of int
        Largest number of solutions of eq. (11) along the blade.
    reverse_flow : ndarray
        Share of the blades' disk that the air meets from behind [-].
    vortex_ring : ndarray
        Share of the measured vortex-ring inflow in the inflow used [-].
    mean_inflow : ndarray
        v_i of eq. (11) averaged over the disk [m/s]; the mean that harmonics of the inflow add,
        less than 1 % of it, is left out.
    deviations : callable, optional
        Gives ``std_by_source``.
    """

    status: NDArray[np.str_]
    roots: NDArray[np.int64]
    reverse_flow: Floats
    vortex_ring: Floats
    mean_inflow: Floats
    deviations: Deviations | None = field(default=None, repr=False, compare=False)

    @functools.cached_property
    def std_by_source(self) -> Mapping[str, LoadValues]:
        """Standard deviations by what they are from; empty where nothing is known of them.

        "parameters": those of the section law, with the covariance that its identification found;
        those of which its data said nothing are not counted.
        "geometry": chord and twist of a blade that was not measured.  "discrepancy": what the model
        errs by with the best constants.  "tunnel": what another tunnel, or the open air, would read
        differently.  They are independent.  Computed when first asked for, once; to first order in
        the parameters, which takes about twice as long as the loads did.
        """
        return self.deviations() if self.deviations is not None else {}

    @functools.cached_property
    def std(self) -> LoadValues:
        """Standard deviations of the loads and of the power, all sources together.

        NaN where the loads are.

        Raises
        ------
        InputError
            Where neither the section law nor the blade says how well it is known.
        """
        parts = list(self.std_by_source.values())
        if not parts:
            found = "nothing is known of the errors of these section constants"
            remedy = "use constants identified or expected by name, or those of a fit's file"
            raise InputError(found, remedy)
        return _load_values(lambda name: np.sqrt(sum(getattr(part, name) ** 2 for part in parts)))

    def interval(self, share: float = 0.95) -> tuple[LoadValues, LoadValues]:
        """Low and high ends of a band that holds the true load with a probability.

        The errors are taken to be normal.

        Parameters
        ----------
        share : float
            The probability, between 0 and 1.

        Raises
        ------
        InputError
            For another ``share``, and as ``std``.
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
    """Loads at operating points, and their derivatives by P quantities.

    Attributes
    ----------
    loads : ndarray, shape (L, ...)
        In the order of ``propmap.loads.LOADS`` [N], [N m]; NaN where not found.
    slopes : ndarray, shape (L, P, ...)
        Derivatives, per unit of each quantity.
    """

    loads: Floats
    slopes: Floats


@dataclass(frozen=True)
class Inflow:
    """Fields over the disk at one operating point; S stations and P azimuths.

    Attributes
    ----------
    radius : ndarray, shape (S,)
        y [m].
    azimuth : ndarray, shape (P,)
        psi [rad], pi/2 on the advancing side, 0 at the rear with respect to the in-plane velocity.
    inflow : ndarray, shape (S,)
        v_i(y) [m/s], positive against the thrust, its mean over azimuth.
    local_inflow : ndarray, shape (S, P)
        v_i [m/s]; the same at every azimuth where the model has no harmonics of it.
    thrust_per_radius, drag_per_radius, torque_per_radius : ndarray, shape (S,)
        Means over azimuth [N/m], [N/m], [N].
    alpha : ndarray, shape (S, P)
        Angle of attack from the chord line [rad], in (-pi, pi].
    u_tangential, u_normal : ndarray, shape (S, P)
        The section velocities (1) and (2) [m/s].
    past_stall : ndarray, shape (S, P)
        How far alpha is past the stall angle, negative before it [rad].
    stalled : ndarray, shape (S, P)
        Where ``past_stall`` is positive.
    reverse : ndarray, shape (S, P)
        Where the air meets the section from behind.
    normal_force : ndarray, shape (S, P)
        Force along the axis on one blade per radius [N/m].
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


@dataclass(frozen=True)
class SearchReport:
    """How equation (11) was solved at one operating point; S stations from root to tip.

    Attributes
    ----------
    radius : ndarray, shape (S,)
        y [m].
    inflow : ndarray, shape (S,)
        v_i where the search ended [m/s].
    residual : ndarray, shape (S,)
        Blade-element thrust less momentum thrust there [N/m].
    found : ndarray, shape (S,)
        Whether the search found the largest root.
    edges : ndarray, shape (P + 1,)
        Radii at which the panels meet that the stations belong to, root and tip included [m].
        Inner ones follow stall.
    azimuths : int
        Azimuths that loads are averaged over.
    tip : float
        Blade radius R [m].
    """

    radius: Floats
    inflow: Floats
    residual: Floats
    found: NDArray[np.bool_]
    edges: Floats
    azimuths: int
    tip: float

    def __str__(self) -> str:
        lost = np.flatnonzero(~self.found)
        if not lost.size:
            worst = float(np.abs(self.residual).max())
            return (
                f"all {self.radius.size} stations converged, over {self.azimuths} azimuths; the "
                f"largest residual is {worst:.1g} N/m"
            )
        k = int(lost[0])
        return (
            f"{lost.size} of {self.radius.size} stations did not converge; the first at "
            f"y = {self.radius[k]:.5f} m (y/R = {self.radius[k] / self.tip:.3f})"
        )


def joined(parts: Sequence[Loads]) -> Loads:
    """Join loads of any shapes to those of all points, each field (n,)."""

    def all_points(values: Iterable[Any], name: str) -> Any:
        return np.concatenate([getattr(one, name).ravel() for one in values])

    names = (each.name for each in fields(Loads) if each.name != "deviations")
    arrays: Any = {name: all_points(parts, name) for name in names}
    if parts[0].deviations is None:
        return Loads(**arrays)

    def deviations() -> dict[str, LoadValues]:
        names = parts[0].std_by_source
        each = {name: [part.std_by_source[name] for part in parts] for name in names}
        return {n: _load_values(functools.partial(all_points, its)) for n, its in each.items()}

    return Loads(**arrays, deviations=deviations)


def _load_values(of: Callable[[str], Any]) -> LoadValues:
    """Values ``of`` each field by its name."""
    return LoadValues(**{each.name: of(each.name) for each in fields(LoadValues)})


@dataclass(frozen=True)
class Wrench:
    """Force and moment on the vehicle at the hub, in the rotor frame.

    Attributes
    ----------
    force, moment : ndarray, shape (..., 3)
        [N], and about the hub [N m].
    """

    force: Floats
    moment: Floats


def spin_sign(spin: str) -> float:
    """Take 1 for a ``spin`` "ccw", -1 for "cw"; ``InputError`` for another."""
    if spin not in ("ccw", "cw"):
        raise InputError(f"spin is {spin!r}: it must be 'ccw' or 'cw', seen from above")
    return 1.0 if spin == "ccw" else -1.0


_UP = np.array([[0.0, 0.0, 1.0]])


def hub_wrench(loads: Floats, direction: Floats, sign: float) -> Wrench:
    """Make vectors of loads (L, N) in the right-handed rotor frame with z along the thrust, for the
    unit vector ``direction`` (..., 3) of the in-plane velocity and the ``sign`` of the spin."""
    from propmap import core

    found = core.hub_wrenches(_UP, np.array([sign]), -direction.reshape(-1, 3), loads[:, None])
    return Wrench(*(vectors.reshape(direction.shape) for vectors in found))
