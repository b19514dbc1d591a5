"""Partial derivatives of a blade element's forces, and their means over a turn, in one pass.

Whatever changes the forces of an element does so by its velocities, by the angles of its section,
or by C_L and C_D.  The derivatives by velocities and angles follow from the slopes that a section
law gives beside its coefficients.  A section constant changes C_L and C_D alone at a given flow.
So all derivatives take a few operations each beside one evaluation of the law.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from propmap.arrays.materialize import materialize
from propmap.arrays.namespace import Array, xp
from propmap.arrays.sparse_derivative import derivative
from propmap.physics.element import Annulus, local_inflow, section_flow
from propmap.physics.inflow_harmonics import Harmonics
from propmap.physics.sections.law import SectionFlow
from propmap.physics.velocities import (
    AzimuthNodes,
    floored_norm,
    normal_velocity,
    tangential_velocity,
)

Force = tuple[Array, ...]
"""The normal and the tangential force of ``element.ElementForces``, or the normal one alone."""

Turn = tuple[Force, ...]
"""Means of forces over a turn, of their products with sin(psi) and of those with cos(psi); without
the later ones where they are not needed."""

FORCES, THROUGH, TURNING, PITCH, TILT = "forces", "through", "turning", "pitch", "tilt"
"""The forces themselves, and their derivatives: by U_P and U_T [m/s], by the angle of both of the
section's lines to the disk plane and by that of the line of least drag alone [rad]."""


class SectionChange(NamedTuple):
    """Change of a section at a given flow, per unit of what it follows from; None for none.

    Attributes
    ----------
    chord, reynolds_per_speed, inverse_root : Array or None
        Of these entries of ``element.Station``.
    radius : float
        Of its radius [m].
    """

    chord: Array | None
    reynolds_per_speed: Array | None
    inverse_root: Array | None
    radius: float = 0.0


@dataclass(frozen=True)
class Sources:
    """What the forces are differentiated by, besides U_P.

    Attributes
    ----------
    turning, pitch, tilt : bool
        Whether by ``TURNING``, ``PITCH`` and ``TILT``.
    constants : tuple of str
        Parameters of the section law, for what they change at a given flow.
    sections : mapping of str to SectionChange
        Changes of the section, by any name that is not yet in use.
    inplane : bool
        Whether the velocity in the disk plane changes.
    """

    turning: bool
    pitch: bool
    tilt: bool
    constants: tuple[str, ...]
    sections: Mapping[str, SectionChange]
    inplane: bool


class Means(NamedTuple):
    """Means of one derivative over a turn.

    Attributes
    ----------
    turn : Turn
        With 1, sin(psi) and cos(psi).
    squares : Turn
        With sin^2(psi) and with sin(psi) cos(psi), where these are needed.
    """

    turn: Turn
    squares: Turn = ()

    @property
    def by_sine(self) -> Turn:
        """``turn`` of what changes in proportion to sin(psi)."""
        return *self.turn[1:2], *self.squares

    @property
    def by_cosine(self) -> Turn:
        """``turn`` of what changes in proportion to cos(psi)."""
        (mean, _, cosine), (sine_square, sine_cosine) = self.turn, self.squares
        rest = tuple(a - b for a, b in zip(mean, sine_square, strict=True))
        return cosine, sine_cosine, rest  # cos^2 = 1 - sin^2


class Motion(NamedTuple):
    """How the elements of an annulus move, turn and change; None for what they do not.

    Attributes
    ----------
    through : Array or None
        Change of U_P [m/s].
    lateral, longitudinal : Array or None
        Its change by the sine and by the cosine of the azimuth [m/s].
    turning : Array or None
        Change of U_T [m/s].
    inplane : Array or None
        Its change by the sine of the azimuth [m/s].
    pitch : Array or None
        Change of the angle of both lines [rad].
    tilt : Array or None
        Further change of that of the line of least drag [rad].
    own : str
        Name of the change at a given flow.
    """

    through: Array | None = None
    lateral: Array | None = None
    longitudinal: Array | None = None
    turning: Array | None = None
    inplane: Array | None = None
    pitch: Array | None = None
    tilt: Array | None = None
    own: str = ""


def moved_forces(means: Mapping[str, Means], motion: Motion) -> Turn:
    """Change of the means of the forces over a turn.

    Parameters
    ----------
    means : mapping of str to Means
        From ``mean_slopes``.
    motion : Motion
        How the elements move; broadcast with the means.
    """
    through, turning = means[THROUGH], means.get(TURNING)
    changes: list[tuple[Array | float, Turn]] = []

    def add(by: Array | float | None, turn: Turn) -> None:
        if by is not None:
            changes.append((by, turn))

    add(motion.through, through.turn)
    add(motion.lateral, through.by_sine if motion.lateral is not None else ())
    add(motion.longitudinal, through.by_cosine if motion.longitudinal is not None else ())
    if turning is not None:
        add(motion.turning, turning.turn)
        add(motion.inplane, turning.by_sine)
    for name, by in ((PITCH, motion.pitch), (TILT, motion.tilt), (motion.own, 1.0)):
        if name in means:
            add(by, means[name].turn)
    like = means[FORCES].turn
    if not changes:
        return tuple(tuple(xp.zeros_like(part) for part in force) for force in like)
    return tuple(
        tuple(
            sum(by * turn[n][k] for by, turn in changes)  # type: ignore[misc]
            for k in range(len(like[n]))
        )
        for n in range(len(like))
    )


def mean_slopes(
    at: Annulus,
    inflow: Array,
    azimuth: AzimuthNodes,
    sources: Sources,
    harmonics: Harmonics | None,
    *,
    thrust_alone: bool = False,
) -> dict[str, Means]:
    """Means over a turn of the forces of annuli and of their derivatives, by name.

    Parameters
    ----------
    at, inflow, azimuth, harmonics
        As in ``element.annulus_loads``.
    sources : Sources
        The derivatives wanted.  A constant that changes nothing at a given flow is left out.
    thrust_alone : bool
        Whether only the mean of the normal force is wanted.
    """

    def weighted(name: str, sine: Array, even: Force, odd: Force) -> Means:
        along = name == TURNING and sources.inplane
        if thrust_alone:
            return Means((even, _times(sine, even)) if along else (even,))
        by_sine = _times(sine, even)
        if not along and not (name == THROUGH and odd):
            return Means((even, by_sine, odd) if odd else (even, by_sine))
        square = _times(sine, by_sine)
        if not odd:
            return Means((even, by_sine), (square,))
        return Means((even, by_sine, odd), (square, _times(sine, odd)))

    def terms(sine: Array) -> dict[str, Means]:
        def around(v: Array) -> dict[str, Force]:
            def forces() -> dict[str, Force]:
                found = _element_slopes(at, v, sine, sources)
                return {name: f[:1] for name, f in found.items()} if thrust_alone else found

            return materialize(forces, at.blades)

        if harmonics is None:
            return {name: weighted(name, sine, f, ()) for name, f in around(inflow).items()}
        rear, front = local_inflow(at, inflow, harmonics, sine)
        # Side by side, so that there is one program for both.
        both = around(xp.stack([rear, front]))
        cosine = 0.5 * xp.sqrt(xp.maximum(1.0 - sine * sine, 0.0))
        found = {}
        for name, force in both.items():
            even = tuple(0.5 * (part[0] + part[1]) for part in force)
            odd = tuple((part[0] - part[1]) * cosine for part in force)
            found[name] = weighted(name, sine, even, odd)
        return found

    # One azimuth at a time: it is many independent computations already.
    means: dict[str, Means] = azimuth.mean(terms, together=1)
    return means


def _times(by: Array, force: Force) -> Force:
    return tuple(by * part for part in force)


def _element_slopes(at: Annulus, inflow: Array, sine: Array, sources: Sources) -> dict[str, Force]:
    """Forces of one blade element, eqs. (1)-(4), and their derivatives."""
    u_t = tangential_velocity(at.omega, at.radius, at.v_inplane, sine)  # Eq. (1)
    u_p = normal_velocity(at.v_axial, inflow)  # Eq. (2)
    u = floored_norm(u_t, u_p)
    per_u = 1.0 / u
    sin_phi, cos_phi = u_p * per_u, u_t * per_u
    flow = section_flow(at.station, sin_phi, cos_phi, u, per_u)
    c = at.law.coefficients(flow)  # Eqs. (3)(4)
    half_chord = 0.5 * at.chord
    half = half_chord * u

    def force(lift: Array | None, drag: Array | None, size: Array) -> Force:
        """Of these coefficients, as in eqs. (5)-(7)."""
        if lift is None:
            assert drag is not None
            drag = size * drag
            return -drag * u_p, drag * u_t
        lift = size * lift
        if drag is None:
            return lift * u_t, lift * u_p
        drag = size * drag
        return lift * u_t - drag * u_p, lift * u_p + drag * u_t

    found = {FORCES: force(c.lift, c.drag, half)}
    # d(alpha)/dU_P = -cos(phi)/U and dU/dU_P = sin(phi); by U_T they are sin(phi)/U and cos(phi).
    by_speed = c.lift + c.lift_by_log_re, c.drag + c.drag_by_log_re
    lift = by_speed[0] * sin_phi - c.lift_slope * cos_phi
    drag = by_speed[1] * sin_phi - c.drag_slope * cos_phi
    normal, tangential = force(lift, drag, half_chord)
    found[THROUGH] = normal - half * c.drag, tangential + half * c.lift
    if sources.turning:
        lift = by_speed[0] * cos_phi + c.lift_slope * sin_phi
        drag = by_speed[1] * cos_phi + c.drag_slope * sin_phi
        normal, tangential = force(lift, drag, half_chord)
        found[TURNING] = normal + half * c.lift, tangential + half * c.drag
    if sources.pitch:
        found[PITCH] = force(c.lift_slope, c.drag_slope, half)

    def coefficients(moved: SectionFlow, **change: Any) -> tuple[Array, Array]:
        c = at.law.plus(**change).coefficients(moved)
        return c.lift, c.drag

    def add(name: str, by: tuple[Array | None, Array | None]) -> None:
        if any(one is not None for one in by):
            found[name] = force(*by, half)

    if sources.tilt:
        add(TILT, derivative(lambda x: coefficients(_tilted(flow, x))))
    for name in sources.constants:
        add(name, derivative(lambda x, name=name: coefficients(flow, **{name: x})))  # type: ignore[misc]
    for name, change in sources.sections.items():
        inner = derivative(lambda x, by=change: coefficients(_changed(flow, by, x)))  # type: ignore[misc]
        add(name, inner)
        if change.chord is not None:
            wider = force(c.lift, c.drag, 0.5 * u * change.chord)
            old = found.get(name)
            found[name] = (
                wider if old is None else tuple(a + b for a, b in zip(old, wider, strict=True))
            )
    return found


def _tilted(flow: SectionFlow, angle: Array) -> SectionFlow:
    """The flow with the line of least drag turned by a small ``angle`` [rad]."""
    sine, cosine = flow.from_least_drag
    return flow._replace(drag_sine=sine + cosine * angle, drag_cosine=cosine - sine * angle)


def _changed(flow: SectionFlow, by: SectionChange, x: Array) -> SectionFlow:
    """The flow at a section that has changed by ``x`` times ``by``; the chord's factor aside."""
    new: dict[str, Any] = {}
    if by.reynolds_per_speed is not None:
        new["reynolds"] = flow.reynolds + x * by.reynolds_per_speed * flow.speed
    if by.inverse_root is not None:
        per_root = by.inverse_root * xp.sqrt(flow.speed) * (1.0 / flow.speed)
        new["inverse_root_reynolds"] = flow.inverse_root_reynolds + x * per_root
    if by.chord is not None:
        new["chord"] = flow.chord + x * by.chord
    if by.radius:
        new["radius"] = flow.radius + x * by.radius
    return flow._replace(**new)
