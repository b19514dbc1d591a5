"""Forces of a blade element and their mean over a turn, eqs. (1)-(7)."""

from __future__ import annotations

from typing import NamedTuple

from propmap.arrays.elementary import sine_and_cosine
from propmap.arrays.materialize import materialize
from propmap.arrays.namespace import Array, xp
from propmap.physics.blade_untwist import untwisting
from propmap.physics.geometry import Blade, blade_shape
from propmap.physics.inflow_harmonics import Harmonics
from propmap.physics.sections.law import SectionFlow, SectionLaw
from propmap.physics.velocities import (
    AzimuthNodes,
    angle_of,
    floored_norm,
    normal_velocity,
    tangential_velocity,
)


class Medium(NamedTuple):
    """The air; scalars.

    Attributes
    ----------
    density : Array
        rho [kg/m^3].
    viscosity : Array
        mu [Pa s], dynamic.
    """

    density: Array
    viscosity: Array


class Station(NamedTuple):
    """The blade at S radii; arrays (S, 1), or (S, B) where each operating point has its own.

    Attributes
    ----------
    radius, chord : Array
        y and c [m].
    sine, cosine : Array
        Of the angle of the zero-lift line to the disk plane [-].
    reynolds_per_speed : Array
        rho c / mu [s/m].
    inverse_root : Array
        ``reynolds_per_speed`` to the power -1/2 [m^0.5/s^0.5].
    drag_sine, drag_cosine : Array or None
        Of the angle of the line of least pressure drag to the disk plane [-]; None where the law
        takes the zero-lift line for it.
    """

    radius: Array
    chord: Array
    sine: Array
    cosine: Array
    reynolds_per_speed: Array
    inverse_root: Array
    drag_sine: Array | None = None
    drag_cosine: Array | None = None


class Annulus(NamedTuple):
    """Blade and flow at an annulus: with an inflow, all that its forces depend on; a pytree.

    Attributes
    ----------
    station : Station
        The blade at its radius.
    omega, v_axial, v_inplane : Array
        Omega [rad/s], V cos(beta) and V sin(beta) [m/s], shape (B,).
    blades, root, tip : Array
        N_b [-], and the radii at which the blade begins and ends [m]; scalars.
    law : SectionLaw
        Lift and drag of its section.
    """

    station: Station
    omega: Array
    v_axial: Array
    v_inplane: Array
    blades: Array
    root: Array
    tip: Array
    law: SectionLaw

    @property
    def radius(self) -> Array:
        """y [m]."""
        return self.station.radius

    @property
    def chord(self) -> Array:
        """c [m]."""
        return self.station.chord

    @property
    def turning(self) -> Array:
        """Omega y [m/s]."""
        return self.omega * self.station.radius

    @property
    def zero_lift(self) -> Array:
        """Angle of attack of zero lift, from the chord line [rad]."""
        return self.law.zero_lift_at(self.station.reynolds_per_speed * self.turning)


class SectionLines(NamedTuple):
    """What a section's lift and drag depend on besides the flow; shapes as in ``Station``.

    Attributes
    ----------
    chord : Array
        c [m].
    reynolds_per_speed, inverse_root : Array
        As in ``Station``.
    lift_line : Array
        Angle of the zero-lift line to the disk plane [rad].
    drag_line : Array or None
        Angle of the line of least pressure drag to the disk plane [rad]; None where the law takes
        the zero-lift line for it.
    """

    chord: Array
    reynolds_per_speed: Array
    inverse_root: Array
    lift_line: Array
    drag_line: Array | None


def section_lines(
    blade: Blade, law: SectionLaw, medium: Medium, radius: Array, omega: Array
) -> SectionLines:
    """The section at a ``radius`` [m], (S, 1) or (S, B); ``omega`` is as in ``Annulus``."""
    chord, twist = blade_shape(blade, radius)
    if blade.untwist is not None:
        twist = twist - untwisting(blade.untwist, blade.tip, radius, omega)
    reynolds_per_speed = medium.density / medium.viscosity * chord
    # At a pointed tip Re goes to zero and C_D to infinity, but C_D times the chord goes to zero.
    root = xp.sqrt(1.0 / xp.maximum(reynolds_per_speed, 1e-30))
    lift_line = twist - law.zero_lift_at(reynolds_per_speed * (omega * radius))
    least_drag = law.least_drag_angle
    drag_line = None if least_drag is None else twist - least_drag
    return SectionLines(chord, reynolds_per_speed, root, lift_line, drag_line)


def annulus(
    blade: Blade,
    law: SectionLaw,
    medium: Medium,
    radius: Array,
    omega: Array,
    v_axial: Array,
    v_inplane: Array,
) -> Annulus:
    """The annulus at ``radius`` [m], shape (S, 1) or (S, B); the flow is as in ``Annulus``."""
    lines = section_lines(blade, law, medium, radius, omega)
    sine, cosine = materialize(lambda: sine_and_cosine(lines.lift_line), blade.root)
    tilted: tuple[Array | None, Array | None] = (None, None)
    drag_line = lines.drag_line
    if drag_line is not None:
        tilted = materialize(lambda: sine_and_cosine(drag_line), blade.root)
    of_chord = lines.reynolds_per_speed, lines.inverse_root
    station = Station(radius, lines.chord, sine, cosine, *of_chord, *tilted)
    return Annulus(station, omega, v_axial, v_inplane, blade.blades, blade.root, blade.tip, law)


class ElementForces(NamedTuple):
    """Forces of one blade element per radius and density.

    Attributes
    ----------
    normal : Array
        Along the thrust, dL cos(phi) - dD sin(phi) [m^3/s^2].
    tangential : Array
        Against the rotation, dL sin(phi) + dD cos(phi) [m^3/s^2].
    normal_slope : Array
        Derivative of ``normal`` with respect to the inflow [m^2/s].
    tangential_slope : Array
        Derivative of ``tangential`` with respect to the inflow [m^2/s].
    """

    normal: Array
    tangential: Array
    normal_slope: Array
    tangential_slope: Array


def element_forces(at: Annulus, inflow: Array, sine: Array) -> ElementForces:
    """Forces of one blade element, eqs. (1)-(4).

    With sin(phi) = U_P / U and cos(phi) = U_T / U, reverse flow needs no case of its own.  The
    derivatives are written out because automatic differentiation takes longer.

    Parameters
    ----------
    at : Annulus
        Blade and flow.
    inflow : Array
        v_i [m/s], shape (S, B).
    sine : Array
        sin(psi) [-], scalar or (B,).
    """
    u_t = tangential_velocity(at.omega, at.radius, at.v_inplane, sine)  # Eq. (1)
    u_p = normal_velocity(at.v_axial, inflow)  # Eq. (2)
    u = floored_norm(u_t, u_p)
    per_u = 1.0 / u
    sin_phi, cos_phi = u_p * per_u, u_t * per_u
    flow = section_flow(at.station, sin_phi, cos_phi, u, per_u)
    c = at.law.coefficients(flow)  # Eqs. (3)(4)
    # In eqs. (5)-(7): dL = 1/2 rho U^2 C_L c dy, dD = 1/2 rho U^2 C_D c dy.
    half = 0.5 * at.chord * u
    normal = half * (c.lift * u_t - c.drag * u_p)
    tangential = half * (c.lift * u_p + c.drag * u_t)
    # d(alpha)/dv_i = -cos(phi)/U, dU/dv_i = sin(phi).
    lift = (c.lift + c.lift_by_log_re) * sin_phi - c.lift_slope * cos_phi
    drag = (c.drag + c.drag_by_log_re) * sin_phi - c.drag_slope * cos_phi
    normal_slope = 0.5 * at.chord * (u_t * lift - u_p * drag - u * c.drag)
    tangential_slope = 0.5 * at.chord * (u_p * lift + u_t * drag + u * c.lift)
    return ElementForces(normal, tangential, normal_slope, tangential_slope)


def section_flow(
    station: Station, sin_phi: Array, cos_phi: Array, speed: Array, per_speed: Array
) -> SectionFlow:
    """The flow at alpha = theta - phi; ``station`` has theta from the zero-lift line."""
    sine = station.sine * cos_phi - station.cosine * sin_phi
    cosine = station.cosine * cos_phi + station.sine * sin_phi
    drag_sine = drag_cosine = None
    if station.drag_sine is not None and station.drag_cosine is not None:
        drag_sine = station.drag_sine * cos_phi - station.drag_cosine * sin_phi
        drag_cosine = station.drag_cosine * cos_phi + station.drag_sine * sin_phi
    return SectionFlow(
        angle=angle_of(cosine, sine, xp.ones_like(cosine)),
        sine=sine,
        cosine=cosine,
        reynolds=station.reynolds_per_speed * speed,
        inverse_root_reynolds=station.inverse_root * xp.sqrt(speed) * per_speed,
        drag_sine=drag_sine,
        drag_cosine=drag_cosine,
        speed=speed,
        chord=station.chord,
        radius=station.radius,
    )


class AnnulusLoads(NamedTuple):
    """Loads per radius and density of an annulus; multiply by rho for N/m and N.

    Attributes
    ----------
    thrust, drag : Array
        [m^3/s^2], eqs. (5) and (6).
    torque : Array
        [m^4/s^2], eq. (7).
    roll_moment : Array
        [m^4/s^2], about the in-plane velocity, positive where the advancing side is lifted.
        Not in the paper, like the two below.
    side_force : Array
        [m^3/s^2], in the disk plane across the in-plane velocity, positive towards the retreating
        side.
    pitch_moment : Array
        [m^4/s^2], about the axis across the in-plane velocity, positive where the front is lifted.
    """

    thrust: Array
    drag: Array
    torque: Array
    roll_moment: Array
    side_force: Array
    pitch_moment: Array


def local_inflow(
    at: Annulus, inflow: Array, harmonics: Harmonics, sine: Array
) -> tuple[Array, Array]:
    """v_i [m/s] at the azimuths psi and pi - psi, which have the same sin(psi), see ``Harmonics``.

    The first of them has cos(psi) >= 0.
    """
    share = at.radius / at.tip
    even = inflow + harmonics.mean + share * harmonics.lateral * sine
    odd = share * harmonics.longitudinal * xp.sqrt(xp.maximum(1.0 - sine * sine, 0.0))
    return even + odd, even - odd


def annulus_loads(
    at: Annulus, inflow: Array, azimuth: AzimuthNodes, harmonics: Harmonics | None = None
) -> AnnulusLoads:
    """Loads of an annulus, eqs. (5)-(7), averaged over a turn.

    Parameters
    ----------
    at : Annulus
        Blade and flow.
    inflow : Array
        v_i [m/s], shape (S, B); the results are of that shape.
    azimuth : AzimuthNodes
        Azimuths to average over.
    harmonics : Harmonics, optional
        How the inflow varies around the disk.
    """

    def terms(sine: Array) -> tuple[Array, ...]:
        if harmonics is None:
            normal, tangential = materialize(
                lambda: element_forces(at, inflow, sine)[:2], at.blades
            )
            # The forces at psi and pi - psi are the same: nothing is left of those across.
            return normal, normal * sine, tangential, tangential * sine
        rear, front = local_inflow(at, inflow, harmonics, sine)
        behind = materialize(lambda: element_forces(at, rear, sine)[:2], at.blades)
        before = materialize(lambda: element_forces(at, front, sine)[:2], at.blades)
        cosine = 0.5 * xp.sqrt(xp.maximum(1.0 - sine * sine, 0.0))
        normal, tangential = (0.5 * (a + b) for a, b in zip(behind, before, strict=True))
        along = (normal, normal * sine, tangential, tangential * sine)
        return *along, *((a - b) * cosine for a, b in zip(behind, before, strict=True))

    n, n_sine, t, t_sine, *across = azimuth.mean(terms)
    n_cosine, t_cosine = across or (0.0 * n, 0.0 * n)
    return loads_of_forces(at, (n, n_sine, n_cosine), (t, t_sine, t_cosine))


def loads_of_forces(
    at: Annulus, normal: tuple[Array, Array, Array], tangential: tuple[Array, Array, Array]
) -> AnnulusLoads:
    """Loads of an annulus from the means over azimuth of its element's forces.

    Parameters
    ----------
    at : Annulus
        Blade and flow.
    normal, tangential : tuple of 3 Array
        Means of ``ElementForces`` [m^3/s^2], of their products with sin(psi), and of those with
        cos(psi).
    """
    arm, drag_factor = at.radius, at.law.drag_factor
    n = at.blades
    return AnnulusLoads(
        thrust=n * normal[0],  # Eq. (5)
        drag=n * drag_factor * tangential[1],  # Eq. (6)
        torque=n * arm * tangential[0],  # Eq. (7)
        roll_moment=n * arm * normal[1],
        side_force=n * drag_factor * tangential[2],
        pitch_moment=-(n * arm * normal[2]),
    )


def annulus_thrust(at: Annulus, inflow: Array, azimuth: AzimuthNodes) -> Array:
    """Thrust of the blade elements per radius and density [m^3/s^2], eq. (5)."""
    mean: Array = azimuth.mean(lambda s: element_forces(at, inflow, s).normal)
    return at.blades * mean  # Eq. (5)


def annulus_thrust_slope(at: Annulus, inflow: Array, azimuth: AzimuthNodes) -> tuple[Array, Array]:
    """``annulus_thrust``, and its derivative with respect to the inflow [m^2/s]."""

    def terms(sine: Array) -> tuple[Array, Array]:
        forces = element_forces(at, inflow, sine)
        return forces.normal, forces.normal_slope

    thrust, slope = azimuth.mean(terms)
    return at.blades * thrust, at.blades * slope  # Eq. (5)


def mean_angle_of_attack(at: Annulus, inflow: Array) -> Array:
    """Angle of attack from zero lift [rad] with V sin(beta) left out; shape of ``inflow``."""
    u_t, u_p = at.turning, normal_velocity(at.v_axial, inflow)
    sine = at.station.sine * u_t - at.station.cosine * u_p
    cosine = at.station.cosine * u_t + at.station.sine * u_p
    return angle_of(cosine, sine, floored_norm(u_t, u_p))
