"""What loads can be differentiated by, and what that changes at a given radius and inflow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from propmap.arrays.namespace import Array
from propmap.arrays.sparse_derivative import derivative
from propmap.loads import FLOW, GEOMETRY, MOUNT_AREA
from propmap.physics.element import Annulus, SectionLines, section_lines
from propmap.physics.element_slopes import Motion, SectionChange, Sources
from propmap.physics.rotor import RotorArrays
from propmap.solve.problem import Case, annulus_problem

RADIUS = "radius"
"""The radius of a node [m], by which the residual of (11) is differentiated too."""


def moving(rotor: RotorArrays) -> tuple[str, ...]:
    """Names of what the loads of a rotor can be differentiated by, besides ``GEOMETRY``: the law's
    parameters, the area of what is mounted, the flow."""
    mounted = () if rotor.mount is None else (MOUNT_AREA,)
    return (*rotor.law.parameters, *mounted, *FLOW)


def with_terms(rotor: RotorArrays, names: Sequence[str]) -> RotorArrays:
    """The rotor with those terms of its law among ``names`` that were left out of it as zero."""
    left_out = [name for name in names if name not in (*moving(rotor), *GEOMETRY)]
    if not left_out:
        return rotor
    zero: Any = dict.fromkeys(left_out, np.float64(0.0))
    return rotor._replace(law=rotor.law.plus(**zero))


def moved_rotor(rotor: RotorArrays, change: Mapping[str, Array]) -> RotorArrays:
    """The rotor with ``change`` added to what it names of ``moving``, but the flow, and
    ``GEOMETRY``."""
    by_name = dict(change)
    area = by_name.pop(MOUNT_AREA, None)
    if area is not None and rotor.mount is not None:
        rotor = rotor._replace(mount=rotor.mount._replace(area=rotor.mount.area + area))
    shape = {}
    for name in GEOMETRY:
        if name in by_name:
            old, by = getattr(rotor.blade, name), by_name.pop(name)
            shape[name] = by if old is None else old + by
    if shape:
        rotor = rotor._replace(blade=rotor.blade._replace(**shape))
    return rotor._replace(law=rotor.law.plus(**by_name)) if by_name else rotor


def moved(case: Case, change: Mapping[str, Array]) -> Case:
    """The case with ``change`` added to what it names of ``moving`` and ``GEOMETRY``."""
    flow = {name: getattr(case, name) + by for name, by in change.items() if name in FLOW}
    other = {name: by for name, by in change.items() if name not in FLOW}
    return case._replace(rotor=moved_rotor(case.rotor, other), **flow)


class Change(NamedTuple):
    """What changes at a given radius and inflow, per unit of a name; None for what stays.

    Attributes
    ----------
    lines : SectionLines
        The section.
    wake : Array or None
        Thrust of the wake per radius and density [m^3/s^2].
    omega, v_axial, v_inplane : Array or None
        The flow, as in ``Case``.
    """

    lines: SectionLines
    wake: Array | None
    omega: Array | None
    v_axial: Array | None
    v_inplane: Array | None


def change_of(case: Case, radius: Array, inflow: Array, name: str) -> Change:
    """Change at ``radius`` [m] and ``inflow`` [m/s], (S, B), per unit of a ``name``.

    That is one of ``moving`` or ``GEOMETRY`` at a ``case``, or ``RADIUS``.
    """

    def at(x: Array) -> Change:
        now, y = (case, radius + x) if name == RADIUS else (moved(case, {name: x}), radius)
        rotor, problem = now.rotor, annulus_problem(now, y)
        return Change(
            section_lines(rotor.blade, rotor.law, rotor.medium, y, now.omega),
            problem.wake.thrust_slope(problem.at, inflow)[0],
            now.omega,
            now.v_axial,
            now.v_inplane,
        )

    change: Change = derivative(at)
    return change


def motion_of(at: Annulus, name: str, change: Change) -> Motion:
    """How blade elements ``at`` annuli move by a ``change`` at a given inflow, that by ``name``."""
    turning: Any = None if change.omega is None else change.omega * at.radius
    pitch, tilt = change.lines.lift_line, change.lines.drag_line
    if at.station.drag_sine is None:
        tilt = None
    elif pitch is not None:
        tilt = (0.0 if tilt is None else tilt) - pitch
    return Motion(
        through=change.v_axial,
        turning=at.omega if name == RADIUS else turning,
        inplane=change.v_inplane,
        pitch=pitch,
        tilt=tilt,
        own=name,
    )


def sources_of(at: Annulus, changes: Mapping[str, Change]) -> Sources:
    """All that the forces of blade elements ``at`` annuli are differentiated by for ``changes``."""
    motions = [motion_of(at, name, change) for name, change in changes.items()]
    sections = {}
    for name, change in changes.items():
        lines = change.lines
        if name == RADIUS or lines.chord is not None:
            of_chord = lines.chord, lines.reynolds_per_speed, lines.inverse_root
            sections[name] = SectionChange(*of_chord, radius=1.0 if name == RADIUS else 0.0)
    return Sources(
        turning=any(m.turning is not None or m.inplane is not None for m in motions),
        pitch=any(m.pitch is not None for m in motions),
        tilt=any(m.tilt is not None for m in motions),
        constants=tuple(name for name in changes if name in at.law.parameters),
        sections=sections,
        inplane=any(m.inplane is not None for m in motions),
    )
