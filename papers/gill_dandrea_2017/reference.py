"""The paper's model and the recommended model in plain Python, written to be read, not to be fast.

"The paper" is R. Gill, R. D'Andrea, "Propeller Thrust and Drag in Forward Flight", IEEE CCTA 2017,
doi 10.1109/CCTA.2017.8062443.  The functions follow its order.  A comment such as ``# Eq. (10)``
marks the code of an equation.  Symbols are the paper's: y is the radius of a blade element [m], psi
the azimuth [rad], 0 at the rear and pi/2 on the advancing side, v_i the induced velocity [m/s].

The module shares only the model with ``propmap.Rotor``: it scans for every inflow, and sums every
integral over equal steps.  Comments mark the points at which the paper is wrong or silent.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq, fsolve
from scipy.special import expit

from propmap.errors import InputError
from propmap.model.airfoil import Airfoil
from propmap.model.model import Model

__all__ = ["ReferenceLoads", "loads"]

Floats = NDArray[Any]

SCAN = 400  # number of v_i at which both sides of (11) are compared, at each radius

WINDMILL_BELOW = -0.95
"""V cos(beta)/v_h below which the windmill branch applies; ``vortex_ring`` hides the switch."""


class ReferenceLoads(NamedTuple):
    """Loads of one rotor at one operating point, with the signs of ``propmap.Loads``.

    Attributes
    ----------
    thrust, drag, torque : float
        T [N], D [N] and tau [N m], eqs. (13) to (15).
    roll_moment, side_force, pitch_moment : float
        [N m], [N] and [N m]; not in the paper.
    """

    thrust: float
    drag: float
    torque: float
    roll_moment: float
    side_force: float
    pitch_moment: float


def loads(
    model: Model,
    omega: float,
    v_axial: float,
    v_inplane: float,
    radii: int = 200,
    azimuths: int = 64,
) -> ReferenceLoads:
    """Compute the loads of one rotor at one operating point, eqs. (1)-(15).

    Parameters
    ----------
    model : Model
        Propeller, ``Airfoil`` and air, without corrections (the paper's model) or with
        ``pitt-peters``, ``radial-friction`` or both (the recommended model).
    omega : float
        Omega [rad/s], >= 0.
    v_axial, v_inplane : float
        V cos(beta), positive in climb, and V sin(beta), >= 0 [m/s].
    radii : int
        Equal steps along the blade.  With 200, errors are within 0.1 % of the static loads, and
        within 0.2 % where the inflow jumps at stall.
    azimuths : int
        Equal steps around the disk, at least 3.  Use more than 64 above an advance ratio
        V sin(beta)/(Omega R) of 0.3.

    Returns
    -------
    ReferenceLoads
        Forces [N] and moments [N m].

    Raises
    ------
    InputError
        For a model that the reference does not implement, invalid points, too few steps, or blades
        that are too wide.

    References
    ----------
    R. Gill, R. D'Andrea, IEEE CCTA 2017, doi 10.1109/CCTA.2017.8062443.
    D. M. Pitt, D. A. Peters, Vertica 5(1), 1981.
    """
    case = make_case(model, omega, v_axial, v_inplane, radii, azimuths)
    share, measured = 0.0, 0.0
    if v_axial < 0.0:
        v_h = static_inflow(case)
        share, measured = vortex_ring(case, v_h)
        case = replace(case, windmill=v_axial < WINDMILL_BELOW * v_h)
    v_i = np.array([annulus_inflow(case, y) for y in case.y])
    v_i = (1.0 - share) * v_i + share * measured
    around = np.tile(v_i[:, None], case.psi.size)  # in the paper v_i does not vary with psi
    if "pitt-peters" in model.correction_texts and v_inplane > 0.0:
        around = around + pitt_peters(case, v_i, 1.0 - share)
    found = disk_loads(case, around)
    if "radial-friction" not in model.correction_texts:
        return found
    drag, torque = radial_friction(case, v_i[:, None])
    return found._replace(drag=found.drag + drag, torque=found.torque + torque)


@dataclass(frozen=True)
class Case:
    """A rotor at an operating point, and the steps of its integrals.

    As in the formulas of the paper, beta is the angle from the velocity to the axis: 0 in axial
    climb, pi/2 edgewise, pi in axial descent.  (The prose of the paper measures beta from the
    disk plane.)
    """

    model: Model
    airfoil: Airfoil
    omega: float  # [rad/s]
    v_axial: float  # V cos(beta) [m/s]
    v_inplane: float  # V sin(beta) [m/s]
    y: Floats  # radii of the annuli [m]
    dy: float  # their width [m]
    psi: Floats  # azimuths [rad]
    chord: Callable[[Any], Any]  # c(y) [m]
    twist: Callable[[Any], Any]  # theta(y) [rad]
    windmill: bool = False


def make_case(
    model: Model, omega: float, v_axial: float, v_inplane: float, radii: int, azimuths: int
) -> Case:
    """Make the case of ``loads`` from its arguments; reject models outside the reference."""
    others = set(model.correction_texts) - {"pitt-peters", "radial-friction"}
    if others:
        found = f"correction {min(others)} is not in the reference"
        raise InputError(found, "leave it out, or use propmap.Rotor")
    if not isinstance(model.airfoil, Airfoil):
        found = f"airfoil {model.airfoil.name} is a {type(model.airfoil).__name__}"
        remedy = "give an Airfoil, or use propmap.Rotor; the reference has eqs. (3) and (4) only"
        raise InputError(found, remedy)
    for name, value in (("omega", omega), ("v_axial", v_axial), ("v_inplane", v_inplane)):
        if np.ndim(value) != 0 or not math.isfinite(value):
            raise InputError(f"{name} is {value}", "give one finite number")
        if name != "v_axial" and value < 0.0:
            raise InputError(f"{name} is {value}: it must not be negative")
    if radii < 1 or azimuths < 3:
        raise InputError(f"{radii} radii and {azimuths} azimuths", "give at least 1 and 3")
    blade = model.propeller
    chord, twist = (PchipInterpolator(blade.station, a) for a in (blade.chord, blade.twist))
    dy = (blade.radius - blade.root) / radii
    y = blade.root + dy * (np.arange(radii) + 0.5)
    # In axial flow all azimuths are alike; over four of them sin(psi) and cos(psi) average to
    # zero.  0 and 2 pi are one azimuth, counted once.
    count = azimuths if v_inplane > 0.0 else 4
    psi = 2.0 * np.pi * np.arange(count) / count
    return Case(model, model.airfoil, omega, v_axial, v_inplane, y, dy, psi, chord, twist)


def separated_share(alpha: Floats, airfoil: Airfoil) -> Floats:
    """Compute sigma, the share of separated flow, at angles of attack from zero lift [rad]."""
    # The paper's sigma is (1 + A + B) / ((1 + A)(1 + B)) with A = exp(-M (alpha - alpha_0)) and
    # B = exp(M (alpha + alpha_0)).  In this form it overflows, in single precision near 1.4 rad.
    # It equals 1 - A/(1 + A) B/(1 + B), where exp(z)/(1 + exp(z)) is the logistic function of z.
    m, alpha_0 = airfoil.sharpness, airfoil.alpha_0
    return 1.0 - expit(-m * (alpha - alpha_0)) * expit(m * (alpha + alpha_0))


def lift_coefficient(alpha: Floats, airfoil: Airfoil, growth: Any = 1.0) -> Floats:
    """Compute C_L at angles of attack from zero lift [rad]; ``growth`` multiplies c_l1."""
    separated = airfoil.c_l2 * np.sin(alpha) * np.cos(alpha)
    if airfoil.lift_law == "plate":  # Not in the paper
        separated = separated / (0.56 + 0.44 * np.abs(np.sin(alpha)))
    if airfoil.lift_law == "simplified":
        return separated  # Footnote 1
    sigma = separated_share(alpha, airfoil)
    return (1.0 - sigma) * growth * airfoil.c_l1 * alpha + sigma * separated  # Eq. (3)


def drag_coefficient(
    alpha: Floats, reynolds: Floats, airfoil: Airfoil, growth: Any = 1.0
) -> Floats:
    """Compute C_D; ``alpha`` is measured from the angle of least pressure drag [rad].

    ``growth`` multiplies the drag except friction.
    """
    # At Re = 0 the velocity and the drag are zero, so that any finite C_D is correct.
    friction = 2.0 * 1.02 * airfoil.c_p / np.sqrt(np.maximum(reynolds, 1e-12))
    return growth * (airfoil.c_d * np.sin(alpha) ** 2 + airfoil.c_d0) + friction  # Eq. (4)


def wrapped(angle: Floats) -> Floats:
    """Wrap angles [rad] to (-pi, pi]."""
    return angle - 2.0 * np.pi * np.ceil(angle / (2.0 * np.pi) - 0.5)


def reynolds_ratio(case: Case, y: Any) -> Any:
    """Compute Re / 5e4, with Re of the rotation alone, limited to 1e4 to 1.2e5."""
    air = case.model.air
    reynolds = air.density * case.omega * y * case.chord(y) / air.viscosity
    return np.clip(reynolds, 1e4, 1.2e5) / 5e4


def zero_lift_angle(case: Case, y: Any) -> Any:
    """Compute the angle of attack of zero lift [rad], which is 0 in the paper.

    It grows with the logarithm of the Reynolds number.
    """
    growth = np.log(reynolds_ratio(case, y))
    return case.airfoil.zero_lift_angle + case.airfoil.reynolds_camber * growth


def drag_growth(case: Case, y: Any, alpha: Floats) -> Any:
    """Compute the factor on pressure drag and constant drag, which is 1 in separated flow."""
    attached = 1.0 - separated_share(alpha, case.airfoil)
    attached = attached * (case.airfoil.lift_law != "simplified")
    return 1.0 + attached * (reynolds_ratio(case, y) ** case.airfoil.reynolds_drag - 1.0)


def blade_element(case: Case, y: Any, v_i: Any) -> tuple[Floats, Floats]:
    """Compute the force per radius of one blade [N/m], along the thrust and against the rotation.

    The last axis is psi; ``y`` [m] and ``v_i`` [m/s] broadcast against it.
    """
    airfoil, air = case.airfoil, case.model.air
    chord, theta = case.chord(y), case.twist(y)
    u_t = case.omega * y + case.v_inplane * np.sin(case.psi)  # Eq. (1)
    u_p = case.v_axial + v_i  # Eq. (2)
    u = np.sqrt(u_t**2 + u_p**2)
    # On the retreating side U_T may be negative.  There the arctangent of U_P/U_T would reverse
    # the force: phi must be the angle of the vector.
    phi = np.arctan2(u_p, u_t)
    reynolds = air.density * u * chord / air.viscosity
    # alpha = theta - phi, wrapped, since (3) has a term linear in alpha.
    alpha = wrapped(theta - phi - zero_lift_angle(case, y))
    c_l = lift_coefficient(alpha, airfoil, reynolds_ratio(case, y) ** airfoil.reynolds_lift)
    from_least_drag = theta - phi - airfoil.zero_lift_angle - airfoil.drag_angle
    c_d = drag_coefficient(from_least_drag, reynolds, airfoil, drag_growth(case, y, alpha))
    pressure = 0.5 * air.density * u**2 * chord
    lift, drag = pressure * c_l, pressure * c_d  # dL/dy and dD/dy, before Eq. (5)
    normal = lift * np.cos(phi) - drag * np.sin(phi)
    tangential = lift * np.sin(phi) + drag * np.cos(phi)
    return normal, tangential


def annulus_thrust(case: Case, y: float, v_i: Floats) -> Floats:
    """Compute the thrust of the blades per radius [N/m] at each inflow [m/s]."""
    normal, _ = blade_element(case, y, v_i[:, None])
    # N_b/(2 pi) times the integral over a turn is N_b times the mean.
    return case.model.propeller.blades * normal.mean(axis=-1)  # Eq. (5)


def momentum_thrust(case: Case, y: float, v_i: Any) -> Any:
    """Compute the thrust of an annulus per radius [N/m] by momentum theory.

    Eq. (8) is mass flow times the change of velocity, 2 v_i.  The paper negates it where the wake
    is above the disk, which is correct for a mass flow with a sign.  The mass flow of (10) has no
    sign, and the velocity changes by 2 v_i against the thrust for both directions of the flow.
    Eq. (9) is (10) in axial flow.
    """
    v_axial, v_inplane, rho = case.v_axial, case.v_inplane, case.model.air.density

    def glauert(v: Any) -> Any:
        speed = np.sqrt(v_inplane**2 + (v_axial + v) ** 2)
        return 4.0 * rho * np.pi * y * v * speed  # Eq. (10)

    # In descent within 19.5 deg of the axis, eq. (10) falls with v_i between two turning points,
    # the roots of 2 v^2 + 3 V cos(beta) v + V^2 = 0.  Momentum theory holds up to the first.
    # Beyond it the falling part is mirrored upwards, and averaged with a parabola like Buhl's
    # (NREL/TP-500-36834), whose weight is 1 in axial flow.  The paper has no such branch.
    square = v_axial**2 - 8.0 * v_inplane**2
    if not case.windmill or square <= 0.0:
        return glauert(v_i)
    first, second = ((-3.0 * v_axial + sign * math.sqrt(square)) / 4.0 for sign in (-1.0, 1.0))
    top, foot = glauert(first), glauert(second)
    mirrored = np.where(v_i < second, 2.0 * top - glauert(v_i), glauert(v_i) + 2.0 * (top - foot))
    parabola = top + 4.0 * rho * np.pi * y * (v_i - first) ** 2
    weight = square / v_axial**2
    return np.where(v_i < first, glauert(v_i), weight * parabola + (1.0 - weight) * mirrored)


def annulus_inflow(case: Case, y: float) -> float:
    """Find the hybrid inflow v_i(y) [m/s], the largest root of (11).

    Near stall, in hover and slow flight, (11) has three roots.  The largest one belongs to attached
    flow.  Unlike a root found from the initial guess (12), it does not depend on the search.
    """

    def residual(v: Floats) -> Floats:
        return annulus_thrust(case, y, v) - momentum_thrust(case, y, v)  # Eq. (11)

    # Air passes the disk no faster than this, unless the blades nearly fill the disk.
    reach = case.omega * y + math.hypot(case.v_axial, case.v_inplane)
    if reach == 0.0:
        return 0.0
    v_i = np.linspace(-reach, reach, SCAN) - case.v_axial
    more = residual(v_i) > 0.0
    ends = np.flatnonzero(more[:-1] & ~more[1:])
    if more[-1] or not ends.size:
        raise InputError(
            f"eq. (11) has no largest root at a radius of {y:g} m: the blades are too wide there",
            "move the root cutout outwards, or use fewer blades",
        )
    low, high = v_i[ends[-1]], v_i[ends[-1] + 1]
    return float(brentq(lambda v: float(residual(np.array([v]))[0]), low, high))


def static_inflow(case: Case) -> float:
    """Compute the static inflow v_i0 [m/s] at the same Omega, also called v_h."""
    rest = replace(case, v_axial=0.0, v_inplane=0.0, psi=0.5 * np.pi * np.arange(4))
    v_i = np.array([annulus_inflow(rest, y) for y in rest.y])
    thrust = max(disk_loads(rest, np.tile(v_i[:, None], 4)).thrust, 0.0)
    area = np.pi * case.model.propeller.radius**2
    return math.sqrt(thrust / (2.0 * case.model.air.density * area))  # Eq. (12)


def vortex_ring(case: Case, v_h: float) -> tuple[float, float]:
    """Compute the share [-] of the measured inflow in descent, and this inflow [m/s].

    The paper uses (12) wherever V cos(beta) < 0 < V cos(beta) + v_i.  Loads would then jump at
    beta = 90 deg, where fast flight carries the wake away and (10) holds.  Here (12) is limited to
    the region of Johnson (NASA/TP-2005-213477, table 4), with smooth edges, and multiplied by
    Leishman's fit to measurements (Principles of Helicopter Aerodynamics, 2006, section 2.13).
    """
    if v_h == 0.0:
        return 0.0, 0.0
    z, x = case.v_axial / v_h, case.v_inplane / v_h

    def step(t: float) -> float:
        t = min(max(t, 0.0), 1.0)
        return t**3 * (10.0 - 15.0 * t + 6.0 * t**2)

    entered = step((z + 0.2) / (-0.45 + 0.2))
    left = step((z + 1.5) / (-2.0 + 1.5))
    swept = step((x - 0.5) / (0.95 - 0.5))
    measured = 1.0 - 1.125 * z - 1.372 * z**2 - 1.718 * z**3 - 0.655 * z**4
    return entered * (1.0 - left) * (1.0 - swept), v_h * measured


def disk_loads(case: Case, v_i: Floats) -> ReferenceLoads:
    """Sum the loads for a known inflow [m/s] at each radius and azimuth, (radii, azimuths)."""
    normal, tangential = blade_element(case, case.y[:, None], v_i)
    sine, cosine, y = np.sin(case.psi), np.cos(case.psi), case.y

    def mean(force: Floats) -> Floats:
        return case.model.propeller.blades * force.mean(axis=1)

    per_radius = (
        mean(normal),  # Eq. (5)
        mean(tangential * sine),  # Eq. (6)
        y * mean(tangential),  # Eq. (7)
        y * mean(normal * sine),
        mean(tangential * cosine),
        -y * mean(normal * cosine),
    )
    return ReferenceLoads(*(float(load.sum() * case.dy) for load in per_radius))  # Eqs. (13)-(15)


def radial_friction(case: Case, v_i: Floats) -> tuple[float, float]:
    """Compute the increase of D and tau by friction, the only force that spanwise flow changes."""
    air, y, blades = case.model.air, case.y[:, None], case.model.propeller.blades
    chord, sine = case.chord(y), np.sin(case.psi)
    u_t, u_r = case.omega * y + case.v_inplane * sine, case.v_inplane * np.cos(case.psi)
    u = np.hypot(u_t, case.v_axial + v_i)
    none = 0.0 * u
    growth = drag_growth(case, y, none)

    def per_speed(speed: Floats) -> Floats:
        reynolds = air.density * speed * chord / air.viscosity
        friction = drag_coefficient(none, reynolds, case.airfoil, growth)
        return 0.5 * air.viscosity * reynolds * friction

    turning = (per_speed(np.hypot(u, u_r)) - per_speed(u)) * u_t
    along = turning * sine + per_speed(np.hypot(u, u_r)) * u_r * np.cos(case.psi)
    drag, torque = ((blades * f.mean(axis=1)).sum() * case.dy for f in (along, y * turning))
    return drag, torque


def pitt_peters(case: Case, v_i: Floats, strength: float) -> Floats:
    """Compute the harmonics that are added to the annulus inflow [m/s], (radii, azimuths).

    They are v_0 + (y/R) (v_s sin(psi) + v_c cos(psi)).  Harmonics and loads depend on each other;
    v_0 is proportional to the change of thrust that the harmonics cause.  In the paper a moment
    induces no inflow.  ``strength`` is 1 outside the vortex ring.
    """
    radius = case.model.propeller.radius
    per_radius = (case.y / radius)[:, None]
    mean = float((case.y * v_i).sum() / case.y.sum())  # over the disk's area
    through = case.v_axial + mean
    speed = math.hypot(case.v_inplane, through)
    # `meets` is the part of the inflow that the upward flow of a descent cancels.  Where no air
    # passes the disk, the wake is assumed to leave along the axis at this speed.
    meets = max(min(-case.v_axial, mean), 0.0)
    # The mass-flow parameter of Peters and HaQuang is d(v_i speed)/dv_i.  It has a lower limit,
    # because it would vanish where a braking rotor reverses the flow.
    mass_flow = max(speed + mean * through / speed, 0.5 * speed, meets)
    chi = math.atan2(case.v_inplane, max(abs(through), meets))  # skew of the wake to the axis
    gain = strength / (case.model.air.density * np.pi * radius**2 * mass_flow)  # [m/s per N]
    alone = disk_loads(case, np.tile(v_i[:, None], case.psi.size))

    def added(state: Floats) -> Floats:
        v_0, v_s, v_c = state
        return v_0 + per_radius * (v_s * np.sin(case.psi) + v_c * np.cos(case.psi))

    def left_over(state: Floats) -> Floats:
        now = disk_loads(case, v_i[:, None] + added(state))
        roll, lifts_rear = now.roll_moment / radius, -now.pitch_moment / radius
        v_0 = 0.5 * gain * (now.thrust - alone.thrust)
        v_s = gain * 4.0 / (1.0 + math.cos(chi)) * roll
        v_c = gain * 15.0 * np.pi / 64.0 * math.tan(0.5 * chi) * now.thrust
        v_c += gain * 4.0 * math.cos(chi) / (1.0 + math.cos(chi)) * lifts_rear
        return np.array([v_0, v_s, v_c]) - state

    state, _, found, message = fsolve(left_over, np.zeros(3), xtol=1e-10, full_output=True)
    if found != 1:
        raise InputError(f"the inflow harmonics did not converge: {message}", "change azimuths")
    return added(state)
