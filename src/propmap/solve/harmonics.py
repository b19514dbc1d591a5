"""The harmonics of the inflow and the loads that belong to each other, by Newton's method.

The annulus inflow is the root of (11).  The harmonics depend on thrust, rolling and pitching moment
of the whole disk, and these on the harmonics: three equations for each operating point.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import jax

from propmap.arrays.loops import while_loop
from propmap.arrays.materialize import materialize
from propmap.arrays.namespace import Array, custom_jvp, stop_gradient, xp
from propmap.arrays.precision import precision_of
from propmap.physics.element import (
    Annulus,
    AnnulusLoads,
    element_forces,
    loads_of_forces,
    local_inflow,
)
from propmap.physics.inflow_harmonics import DiskFlow, HarmonicResponse, Harmonics, InflowShape
from propmap.physics.loads import RadialNodes
from propmap.physics.velocities import AzimuthNodes

MAX_STEPS = 40
"""Newton steps after which the search is given up."""

CLOSE = 4e-4
"""Newton step, relative to the air's speed at the tip [-], with which the search ends.  The error
after it is of the second order: 3e-8 of that speed in 400 random oblique points of the soft set."""

Triple = tuple[Array, Array, Array]

LONGEST = 0.05
"""Longest Newton step, relative to the air's speed at the tip [-]."""


class HarmonicProblem(NamedTuple):
    """What the harmonics depend on; a pytree.

    Attributes
    ----------
    at : Annulus
        Blade and flow at the radial nodes.
    nodes : RadialNodes
        These nodes.
    inflow : Array
        Mean inflow of the annuli [m/s], (S, B).
    flow : DiskFlow
        Mean flow through the disk.
    strength : Array
        Factor on the harmonics [-], (B,), less than 1 within the vortex ring.
    shape : InflowShape
        How the inflow varies.
    """

    at: Annulus
    nodes: RadialNodes
    inflow: Array
    flow: DiskFlow
    strength: Array
    shape: InflowShape

    @property
    def response(self) -> HarmonicResponse:
        """How the harmonics depend on the loads."""
        found = self.shape.response(self.flow, self.at.tip)
        return HarmonicResponse(*(self.strength * part for part in found))


class HarmonicSolution(NamedTuple):
    """The harmonics and the loads that go with them; a pytree.

    Attributes
    ----------
    harmonics : Harmonics
        [m/s]; NaN where they were not found.
    loads : AnnulusLoads
        Loads of the rotor per density, (B,).
    integrand : Array
        Thrust and torque of the annuli times the weights of their nodes, per density, (2, S, B).
    """

    harmonics: Harmonics
    loads: AnnulusLoads
    integrand: Array


def find_harmonics(problem: HarmonicProblem, azimuth: AzimuthNodes) -> HarmonicSolution:
    """The harmonics and the loads, without derivatives.

    The first step starts without harmonics.  The second one usually is so short that the loads at
    its end follow from those at its beginning and their slopes.
    """
    problem = stop_gradient(problem)
    at = problem.at
    speed = at.omega * at.tip + problem.flow.speed
    within = xp.maximum(CLOSE, 1e3 * precision_of(speed).left_over)
    zero = xp.zeros_like(speed)

    none = Harmonics(zero, zero, zero)
    moments, slopes = _without_harmonics(problem, azimuth)
    change, size = _newton_step(problem, none, moments, slopes, moments.thrust, speed)
    first = Harmonics(*change)

    def unfinished(state: tuple[HarmonicSolution, Array, Array]) -> Array:
        _, size, steps = state
        return (steps < MAX_STEPS) & xp.any(size > within)

    def again(
        state: tuple[HarmonicSolution, Array, Array],
    ) -> tuple[HarmonicSolution, Array, Array]:
        before, last, steps = state
        now, active = before.harmonics, last > within
        loads, slopes, integrand = loads_and_slopes(problem, now, azimuth)
        own = tuple(_moments_of(by) for by in slopes)
        change, size = _newton_step(problem, now, _moments_of(loads), own, moments.thrust, speed)
        ahead = AnnulusLoads(
            *(
                load + sum(by * step for by, step in zip(bys, change, strict=True))
                for load, *bys in zip(loads, *slopes, strict=True)
            )
        )
        moved = Harmonics(*(a + b for a, b in zip(now, change, strict=True)))
        # A point that has been found stays as it is: its loads do not depend on its neighbours.
        solution = jax.tree.map(
            lambda new, old: xp.where(active, new, old),
            HarmonicSolution(moved, ahead, integrand),
            before,
        )
        return solution, xp.where(active, size, last), steps + 1

    nothing = AnnulusLoads(*(zero for _ in AnnulusLoads._fields))
    start = HarmonicSolution(first, nothing, xp.zeros((2, *xp.shape(problem.inflow))))
    found, size, _ = while_loop(unfinished, again, (start, zero + xp.inf, xp.array(0)))
    lost = ~(size <= within)
    return found._replace(
        harmonics=Harmonics(*(xp.where(lost, xp.nan, part) for part in found.harmonics)),
        loads=AnnulusLoads(*(xp.where(lost, xp.nan, load) for load in found.loads)),
    )


class _Moments(NamedTuple):
    thrust: Array  # per density, (B,), like the others
    roll: Array
    lifts_rear: Array


def _moments_of(loads: AnnulusLoads) -> _Moments:
    return _Moments(loads.thrust, loads.roll_moment, -loads.pitch_moment)


def _newton_step(
    problem: HarmonicProblem,
    now: Harmonics,
    moments: _Moments,
    slopes: tuple[_Moments, ...],
    without: Array,
    speed: Array,
) -> tuple[Triple, Array]:
    """Change of the harmonics [m/s], and its size over ``speed`` before it is shortened."""
    response = problem.response
    residual = _difference(response.harmonics(*moments, without), now)
    change = _solve(_rows(response, slopes), residual)
    size = functools.reduce(xp.maximum, (xp.abs(part) for part in change)) / speed
    share = xp.minimum(1.0, LONGEST / xp.maximum(size, 1e-30))
    mean, lateral, longitudinal = (share * part for part in change)
    return (mean, lateral, longitudinal), size


def _difference(a: Harmonics, b: Harmonics) -> Triple:
    return a.mean - b.mean, a.lateral - b.lateral, a.longitudinal - b.longitudinal


def _rows(response: HarmonicResponse, slopes: tuple[_Moments, ...]) -> tuple[Triple, ...]:
    """Derivatives of the harmonics minus those that belong to the loads, by the harmonics."""
    mean = [-response.mean_by_thrust * by.thrust for by in slopes]
    lateral = [-response.by_roll * by.roll for by in slopes]
    longitudinal = [
        -(response.by_thrust * by.thrust + response.by_pitch * by.lifts_rear) for by in slopes
    ]
    return (
        (1.0 + mean[0], mean[1], mean[2]),
        (lateral[0], 1.0 + lateral[1], lateral[2]),
        (longitudinal[0], longitudinal[1], 1.0 + longitudinal[2]),
    )


def _solve(rows: tuple[Triple, ...], right: Triple) -> Triple:
    """The solution of three linear equations, by Cramer's rule."""
    crosses = [_cross(rows[1], rows[2]), _cross(rows[2], rows[0]), _cross(rows[0], rows[1])]
    determinant = sum(a * b for a, b in zip(rows[0], crosses[0], strict=True))
    per = 1.0 / xp.where(determinant == 0.0, 1e-30, determinant)
    x, y, z = (
        per * sum(f * cross[k] for f, cross in zip(right, crosses, strict=True)) for k in range(3)
    )
    return x, y, z


def _cross(a: Triple, b: Triple) -> Triple:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def _without_harmonics(
    problem: HarmonicProblem, azimuth: AzimuthNodes
) -> tuple[_Moments, tuple[_Moments, ...]]:
    """Moments of the annulus inflow alone, and their derivatives by the three ``Harmonics``."""
    at = problem.at

    def terms(sine: Array) -> tuple[Array, ...]:
        def forces() -> tuple[Array, Array]:
            found = element_forces(at, problem.inflow, sine)
            return found.normal, found.normal_slope

        normal, slope = materialize(forces, at.blades)
        along = slope * sine
        return normal, normal * sine, slope, along, along * sine

    normal, rolling, m, s, ss = azimuth.mean(terms)
    weight = at.blades * problem.nodes.weight
    share = at.radius / at.tip
    sums = (normal, at.radius * rolling, m, at.radius * s, share * s, share * at.radius * ss)
    thrust, roll, by_mean, roll_by_mean, by_lateral, square = (
        xp.sum(weight * values, axis=0) for values in sums
    )
    whole = xp.sum(weight * share * at.radius * m, axis=0)
    none = xp.zeros_like(thrust)
    return _Moments(thrust, roll, none), (
        _Moments(by_mean, roll_by_mean, none),
        _Moments(by_lateral, square, none),
        _Moments(none, none, whole - square),  # cos^2 = 1 - sin^2
    )


def loads_and_slopes(
    problem: HarmonicProblem, harmonics: Harmonics, azimuth: AzimuthNodes
) -> tuple[AnnulusLoads, tuple[AnnulusLoads, ...], Array]:
    """Loads of the disk per density, derivatives with each of the ``harmonics``, the integrand."""
    at = problem.at

    def terms(sine: Array) -> tuple[Array, ...]:
        rear, front = local_inflow(at, problem.inflow, harmonics, sine)
        sides = xp.stack([rear, front])
        both = materialize(lambda: element_forces(at, sides, sine), at.blades)
        cosine = 0.5 * xp.sqrt(xp.maximum(1.0 - sine * sine, 0.0))
        even = [0.5 * (part[0] + part[1]) for part in both]
        odd = [(part[0] - part[1]) * cosine for part in both]
        along = [part * sine for part in even]
        return (
            *(*even, *along, *odd),
            *(along[2] * sine, odd[2] * sine, along[3] * sine, odd[3] * sine),
        )

    n, t, n_m, t_m, ns, ts, n_ms, t_ms, nc, tc, n_mc, t_mc, n_ss, n_sc, t_ss, t_sc = azimuth.mean(
        terms
    )
    share, weight = at.radius / at.tip, problem.nodes.weight

    def total(per_radius: AnnulusLoads, by: Array) -> AnnulusLoads:
        return AnnulusLoads(*(xp.sum(by * part, axis=0) for part in per_radius))

    here = loads_of_forces(at, (n, ns, nc), (t, ts, tc))
    by_mean = loads_of_forces(at, (n_m, n_ms, n_mc), (t_m, t_ms, t_mc))
    by_lateral = loads_of_forces(at, (n_ms, n_ss, n_sc), (t_ms, t_ss, t_sc))
    # cos^2 = 1 - sin^2
    squares = (n_mc, n_sc, n_m - n_ss), (t_mc, t_sc, t_m - t_ss)
    by_longitudinal = loads_of_forces(at, *squares)
    slopes = (
        total(by_mean, weight),
        total(by_lateral, weight * share),
        total(by_longitudinal, weight * share),
    )
    return total(here, weight), slopes, weight * xp.stack([here.thrust, here.torque])


@custom_jvp
def moving_harmonics(
    problem: HarmonicProblem,  # noqa: ARG001 - the derivative below needs it
    found: Harmonics,
    azimuth: AzimuthNodes,  # noqa: ARG001
) -> Harmonics:
    """The harmonics ``found``, differentiable with respect to everything in ``problem``.

    The derivative follows from the implicit function theorem.
    """
    return found


@moving_harmonics.defjvp
def _moving_harmonics_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    (problem, found, azimuth), (problem_dot, *_) = primals, tangents
    now = moving_harmonics(problem, found, azimuth)

    def wanted(asked: HarmonicProblem) -> Harmonics:
        loads = _moments_of(loads_and_slopes(asked, now, azimuth)[0])
        without = _without_harmonics(asked, azimuth)[0].thrust
        return asked.response.harmonics(*loads, without)

    _, change = jax.jvp(wanted, (problem,), (problem_dot,))
    slopes = loads_and_slopes(problem, now, azimuth)[1]
    return now, followed(problem.response, slopes, change)


def followed(
    response: HarmonicResponse, slopes: tuple[AnnulusLoads, ...], change: Harmonics
) -> Harmonics:
    """Change of the harmonics [m/s], (B,), by the implicit function theorem.

    Parameters
    ----------
    response : HarmonicResponse
        How the harmonics depend on the loads.
    slopes : tuple of 3 AnnulusLoads
        Derivatives of the loads, per density, by the three ``Harmonics``.
    change : Harmonics
        Change of those that belong to the loads, where the harmonics themselves stay.
    """
    rows = _rows(response, tuple(_moments_of(by) for by in slopes))
    return Harmonics(*_solve(rows, tuple(change)))  # type: ignore[arg-type]
