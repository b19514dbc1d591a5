"""Derivatives of the loads of a disk whose nodes and inflow follow what changes."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from propmap.arrays.namespace import Array
from propmap.arrays.sparse_derivative import derivative
from propmap.physics.added_loads import with_added
from propmap.physics.element import Annulus, AnnulusLoads, loads_of_forces
from propmap.physics.element_slopes import (
    FORCES,
    THROUGH,
    Means,
    Motion,
    Turn,
    mean_slopes,
    moved_forces,
)
from propmap.physics.inflow_harmonics import DiskFlow, HarmonicResponse, Harmonics
from propmap.physics.loads import RadialNodes, integrate, mean_over_disk
from propmap.physics.velocities import AzimuthNodes
from propmap.solve.disk import DiskInflow, DiskSolution
from propmap.solve.harmonics import followed
from propmap.solve.moved_case import RADIUS, Change, motion_of, moved, sources_of
from propmap.solve.problem import AnnulusProblem, Case, annulus_problem
from propmap.solve.rotor_loads import with_vortex_ring


class EdgeMove(NamedTuple):
    """What moves with an edge of the panels.

    Attributes
    ----------
    nodes : RadialNodes
        Changes of radii and weights per change of the edge's radius [-], (S, B).
    inflow : Array
        That of the root of (11) at the nodes [1/s], (S, B).
    slopes : Array
        Changes of the edge's radius, per unit of each name [m], (D, B).
    """

    nodes: RadialNodes
    inflow: Array
    slopes: Array


class _Sums(NamedTuple):
    """Changes per unit of a name, where the harmonics stay.

    Attributes
    ----------
    loads : Array
        Of the loads [N], [N m], (L, B).
    inflow : Array
        Of the annuli's inflow [m/s], (S, B).
    mean_inflow : Array
        Of its mean [m/s], (B,).
    ring : Array
        Of the share of the vortex ring's [-], (B,).
    without : Array
        Of the thrust per density without harmonics [m^4/s^2], (B,).
    """

    loads: Array
    inflow: Array
    mean_inflow: Array
    ring: Array
    without: Array


@dataclass(frozen=True)
class FollowedLoads:
    """The loads of a disk at a solution of (11), and what changes there.

    Attributes
    ----------
    case, azimuth, harmonics
        As in ``rotor_loads.loads_over_disk``.
    disk : DiskInflow
        Nodes, equation (11) and its root.
    inflow, ring : Array
        As ``rotor_loads.with_vortex_ring`` gives them.
    changes : mapping of str to Change
        At the nodes, by name; with ``RADIUS`` if nodes move.
    means, without : mapping of str to Means
        Derivatives of the forces at ``inflow``, and those of the normal force without harmonics.
    """

    case: Case
    azimuth: AzimuthNodes
    harmonics: Harmonics | None
    disk: DiskInflow
    inflow: Array
    ring: Array
    changes: Mapping[str, Change]
    means: Mapping[str, Means]
    without: Mapping[str, Means]

    @classmethod
    def at(
        cls,
        case: Case,
        solution: DiskSolution,
        nodes: RadialNodes,
        azimuth: AzimuthNodes,
        problem: AnnulusProblem,
        changes: Mapping[str, Change],
        means: Mapping[str, Means],
    ) -> FollowedLoads:
        """Those at a ``solution``.

        ``means`` are at the root of (11), those of the normal force alone where the loads have
        another inflow; the other arguments are as in ``FollowedLoads`` and ``load_slopes``.
        """
        disk, harmonics = DiskInflow(nodes, problem, solution.inflow), solution.harmonics
        inflow, ring = with_vortex_ring(case, disk)
        here, without = (problem.at, inflow, azimuth, sources_of(problem.at, changes)), means
        if harmonics is not None and case.v_hover is not None:
            without = mean_slopes(*here, None, thrust_alone=True)
        if harmonics is not None or case.v_hover is not None:
            means = mean_slopes(*here, harmonics)
        return cls(case, azimuth, harmonics, disk, inflow, ring, changes, means, without)

    def slopes(
        self,
        inflow: Mapping[str, Array],
        edges: Sequence[EdgeMove],
        v_hover_slopes: Array | None,
    ) -> Array:
        """Derivatives of the loads, (D, L, B).

        Parameters
        ----------
        inflow : mapping of str to Array
            Changes of the root of (11) [m/s], (S, B), per unit of D names, the nodes staying where
            they are.
        edges : sequence of EdgeMove
            How the nodes move.
        v_hover_slopes : Array or None
            As in ``load_slopes.load_slopes``.
        """
        every = []
        for k, (name, change) in enumerate(inflow.items()):
            v_hover_slope = None if v_hover_slopes is None else v_hover_slopes[k]
            every.append(self._sums(name, change, None, v_hover_slope))
        sums: _Sums = jax.tree.map(lambda *parts: jnp.stack(parts), *every)
        for edge in edges:
            by_edge = self._sums(RADIUS, edge.inflow, edge.nodes, None)
            sums = jax.tree.map(functools.partial(_with_edge, edge.slopes), sums, by_edge)
        names, loads, rotor = tuple(inflow), sums.loads, self.case.rotor
        if self.harmonics is not None or rotor.mount is not None:
            loads = self._with_whole_disk(names, sums)
        if rotor.added and not self.azimuth.axial:
            loads = loads + self._added(names, sums.inflow, edges)
        return loads

    def _sums(
        self,
        name: str,
        root: Array,
        node_slopes: RadialNodes | None,
        v_hover_slope: Array | None,
    ) -> _Sums:
        """Changes by a ``name`` with its change of the ``root`` of (11); or by ``RADIUS``, with
        changes of the nodes."""
        case, at, nodes = self.case, self.disk.problem.at, self.disk.nodes

        def now(x: Array) -> Case:
            return case if name == RADIUS else moved(case, {name: x})

        def blended(x: Array) -> tuple[Array, Array]:
            here = now(x)
            if v_hover_slope is not None:
                here = here._replace(v_hover=case.v_hover + x * v_hover_slope)  # type: ignore[operator]
            return with_vortex_ring(here, self.disk._replace(inflow=self.disk.inflow + x * root))

        inflow, ring = (root, None) if case.v_hover is None else derivative(blended)
        motion = motion_of(at, name, self.changes[name])
        if node_slopes is not None:
            lateral = longitudinal = None
            if self.harmonics is not None:
                lateral = self.harmonics.lateral / at.tip
                longitudinal = self.harmonics.longitudinal / at.tip
            outwards = motion._replace(lateral=lateral, longitudinal=longitudinal)
            motion = Motion()
        through = inflow if motion.through is None else inflow + motion.through
        motion = motion._replace(through=through)
        turn = moved_forces(self.means, motion)
        without = None if self.harmonics is None else moved_forces(self.without, motion)
        radius = weight = None
        if node_slopes is not None:
            radius, weight = node_slopes
            turn = _changed(turn, moved_forces(self.means, outwards), radius)
            if without is not None:
                still = outwards._replace(lateral=None, longitudinal=None)
                without = _changed(without, moved_forces(self.without, still), radius)

        def loads(x: Array) -> Array:
            station = at.station._replace(radius=_changed(at.radius, radius, x))
            moved_at = at._replace(station=station, law=now(x).rotor.law)
            per_radius = loads_of_turn(moved_at, _changed(self.means[FORCES].turn, turn, x))
            here = _changed(nodes.weight, weight, x)
            return case.rotor.medium.density * _sums_along(per_radius, here)

        def mean(x: Array) -> Array:
            return mean_over_disk(self.inflow + x * inflow, _changed(nodes, node_slopes, x))

        def thrust(x: Array) -> Array:
            here = _changed(nodes.weight, weight, x)
            normal = _changed(self.without[FORCES].turn, without, x)[0][0]
            return jnp.sum(at.blades * here * normal, axis=0)

        none = jnp.zeros_like(case.omega)
        return _Sums(
            derivative(loads),
            inflow,
            derivative(mean),
            none if ring is None else ring,
            none if without is None else derivative(thrust),
        )

    def _with_whole_disk(self, names: tuple[str, ...], sums: _Sums) -> Array:
        """Changes of the loads (D, L, B) with what follows from the mean flow through the disk: the
        harmonics, and the drag of what is mounted."""
        case, at, nodes = self.case, self.disk.problem.at, self.disk.nodes
        rotor, density = case.rotor, case.rotor.medium.density
        mean_inflow = mean_over_disk(self.inflow, nodes)
        turn = self.means[FORCES].turn
        loads = AnnulusLoads(*_sums_along(loads_of_turn(at, turn), nodes.weight))
        normal = self.without[FORCES].turn[0][0]
        without = jnp.sum(at.blades * nodes.weight * normal, axis=0)

        def along(way: Array, change: _Sums) -> Array:
            by = AnnulusLoads(*change.loads)

            def parts(x: Array) -> tuple[HarmonicResponse | None, Harmonics | None, Array | None]:
                now = moved(case, {name: x * way[k] for k, name in enumerate(names)})
                mean = mean_inflow + x * change.mean_inflow
                mount = now.rotor.mount
                mounted = None
                if mount is not None:
                    mounted = mount.drag(density, now.v_axial, now.v_inplane, mean)
                if self.harmonics is None or rotor.shape is None:
                    return None, None, mounted
                flow = DiskFlow(now.omega, now.v_axial, now.v_inplane, mean)
                strength = 1.0 - self.ring - x * change.ring
                found = rotor.shape.response(flow, at.tip)
                response = HarmonicResponse(*(strength * part for part in found))
                moments = (
                    loads.thrust + x * by.thrust / density,
                    loads.roll_moment + x * by.roll_moment / density,
                    -(loads.pitch_moment + x * by.pitch_moment / density),
                )
                harmonics = response.harmonics(*moments, without + x * change.without)
                return response, harmonics, mounted

            (response, *_), (_, harmonics, mounted) = jax.jvp(parts, (0.0,), (1.0,))
            if harmonics is not None and response is not None:
                slopes = self._by_harmonics()
                steps = followed(response, slopes, harmonics)
                more = (
                    sum(step * part for step, part in zip(steps, parts, strict=True))
                    for parts in zip(*slopes, strict=True)
                )
                by = AnnulusLoads(*(a + density * b for a, b in zip(by, more, strict=True)))
            if mounted is not None:
                by = by._replace(drag=by.drag + mounted)
            return jnp.stack(by)

        return jax.vmap(along)(jnp.eye(len(names)), sums)

    def _by_harmonics(self) -> tuple[AnnulusLoads, ...]:
        """Derivatives of the loads, per density, by the three ``Harmonics``."""
        at, weight, by = self.disk.problem.at, self.disk.nodes.weight, self.means[THROUGH]
        share = weight * (at.radius / at.tip)
        shapes = ((weight, by.turn), (share, by.by_sine), (share, by.by_cosine))
        return tuple(
            AnnulusLoads(*_sums_along(loads_of_turn(at, turn), shape)) for shape, turn in shapes
        )

    def _added(
        self, names: tuple[str, ...], inflow_slopes: Array, edges: Sequence[EdgeMove]
    ) -> Array:
        """Changes of the loads that corrections add, (D, L, B)."""
        case, nodes, node_slopes = self.case, self.disk.nodes, None
        if edges:
            every = [jax.tree.map(lambda a: e.slopes[:, None] * a, e.nodes) for e in edges]  # noqa: B023
            node_slopes = jax.tree.map(lambda *parts: sum(parts), *every)

        def along(way: Array, inflow_slope: Array, node_slope: RadialNodes | None) -> Array:
            def added(x: Array) -> Array:
                now = moved(case, {name: x * way[k] for k, name in enumerate(names)})
                here = nodes
                if node_slope is not None:
                    here = jax.tree.map(lambda a, b: a + x * b, nodes, node_slope)
                at = annulus_problem(now, here.radius).at
                inflow = self.inflow + x * inflow_slope
                none = AnnulusLoads(*(jnp.zeros_like(inflow) for _ in AnnulusLoads._fields))
                found = with_added(none, now.rotor.added, at, inflow, self.azimuth)
                return jnp.stack(integrate(found, here, now.rotor.medium.density))

            return jax.jvp(added, (0.0,), (1.0,))[1]

        return jax.vmap(along)(jnp.eye(len(names)), inflow_slopes, node_slopes)


def _with_edge(slopes: Array, by_name: Array, by_edge: Array) -> Array:
    """Changes (D, ..., B) by each name with those by an edge, whose ``slopes`` are (D, B)."""
    ahead = (1,) * (by_edge.ndim - 1)
    return by_name + slopes.reshape(slopes.shape[0], *ahead, -1) * by_edge


def loads_of_turn(at: Annulus, turn: Turn) -> AnnulusLoads:
    """Loads of annuli per radius and density from the means of their elements' forces."""
    normal, tangential = (tuple(force[k] for force in turn) for k in range(2))
    if len(turn) == 2:
        # The forces at psi and pi - psi are the same: nothing is left of those across.
        normal, tangential = (*normal, 0.0 * normal[0]), (*tangential, 0.0 * tangential[0])
    return loads_of_forces(at, normal, tangential)  # type: ignore[arg-type]


def _changed(values: Any, change: Any, x: Array) -> Any:
    """A tree of ``values`` and ``x`` times its ``change``, if that is not None."""
    return values if change is None else jax.tree.map(lambda a, b: a + x * b, values, change)


def _sums_along(per_radius: AnnulusLoads, weight: Array) -> Array:
    """Sums along the blade, (L, B)."""
    return jnp.stack([jnp.sum(weight * load, axis=0) for load in per_radius])
