"""The corrections that a model can have: what is added to the paper's physics, as values.

Here are their numbers and what makes them impossible.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from propmap.errors import InputError, located
from propmap.loads import DRAG_FACTOR, MOUNT_AREA
from propmap.model.propeller import Propeller
from propmap.typing import Floats
from propmap.units import SPEED_OF_SOUND

HUB_SHARE = 0.08  # hub's radius over R where it is not given: 16 mm across on 8 inches
LARGEST_UNTWIST = 0.2  # of the tip [rad]; a propeller's blade gives way no further

TYPICAL_FACTOR, TYPICAL_AREA = (1.9, 0.6), (0.1, 0.1)
"""Mean and standard deviation of how rotors on motors are installed: the factor on the blades' own
drag [-], and the area over the square of the propeller's radius [-], with which 20 propellers of
one tunnel (Gill and D'Andrea, Drones 3(4):77, 2019, doi 10.3390/drones3040077), one of another and
flights lie inside the bands: ``python -m tools.coverage``."""

STALL_DELAY_STRENGTH = 3.0  # Snel's factor of (c/y)^2 [-]


class CorrectedModel(Protocol):
    """The parts of a ``Model`` that its corrections use."""

    @property
    def propeller(self) -> Propeller:
        """Geometry."""

    @property
    def airfoil(self) -> Any:
        """Section law."""

    @property
    def span(self) -> tuple[float, float]:
        """First and last loaded radius of the blade [m]."""


class Correction:
    """A change to the physics, as a validated value: a frozen dataclass of numbers."""

    def check(self, model: CorrectedModel) -> None:
        """Raise ``InputError`` where it does not fit a ``model`` that has it."""

    def core_numbers(self, name: str, model: CorrectedModel) -> dict[str, Any]:  # noqa: ARG002
        """Give the core what it needs of it in a ``model``, by ``name``: its only number, or 1."""
        values = list(vars(self).values())
        return {name: values[0] if values else 1.0}


class InflowShape(Correction):
    """How the inflow varies around the disk: of these a model has one at most."""

    def core_numbers(self, name: str, model: CorrectedModel) -> dict[str, Any]:  # noqa: ARG002
        """Give the core the ``name`` of the shape."""
        return {"inflow": name}


@dataclass(frozen=True)
class BladeToHub(Correction):
    """The blade continued to the hub, inside its first measured station.

    The chord line keeps the geometric pitch of the first station, 2 pi y tan(theta), as it does on
    blades whose pitch is constant.  The chord goes on with its mean slope over the first tenth of
    the radius, but no wider than at the first station and no narrower than half of it.  The
    measured part stays as it is.

    Geometry files begin where the blade leaves the hub's fairing.  What lies inside stands steeply
    in the in-plane flow: on the APC 8x6E it is a hundredth or two of the thrust and more than a
    tenth of the rotor drag.  A blade that reaches the hub stays as it is.

    Attributes
    ----------
    radius_m : float or None
        Radius of the hub [m]; None for ``HUB_SHARE`` of the tip's radius.

    Raises
    ------
    InputError
        For a radius that is no positive number; in a ``Model``, for one outside the first station
        and for a blade that a root cut-out shortens.
    """

    radius_m: float | None = None

    def __post_init__(self) -> None:
        _check_radius(self.radius_m)

    def hub(self, propeller: Propeller) -> float:
        """Find where the blade of a ``propeller`` then begins [m]; ``InputError`` for a blade that
        a root cut-out shortens, and a hub outside the first station."""
        first, root = float(propeller.station[0]), propeller.root
        if root > first * (1.0 + 1e-9):
            found = (
                f"blade-to-hub continues the blade inwards, but its root is cut out at {root:g} m"
            )
            raise InputError(found, "leave out one of the two")
        hub = HUB_SHARE * propeller.radius if self.radius_m is None else self.radius_m
        if self.radius_m is not None and hub > first * (1.0 + 1e-9):
            found = f"radius_m of blade-to-hub is {hub:g} m, but the blade begins at {first:g} m"
            raise InputError(found, "give a smaller radius in metres, or leave the correction out")
        return root if hub >= first * (1.0 - 1e-9) else hub

    def check(self, model: CorrectedModel) -> None:
        """Check the propeller of a ``model``, as ``hub``."""
        self.hub(model.propeller)

    def core_numbers(self, name: str, model: CorrectedModel) -> dict[str, Any]:
        """Give the hub's radius by ``name``, where the blade of a ``model`` is continued."""
        hub = self.hub(model.propeller)
        return {name: hub} if hub < model.propeller.root else {}


@dataclass(frozen=True)
class BladeUntwist(Correction):
    """A blade that flattens as it turns: the centrifugal force twists it to the disk plane.

    A section's mass lies along its chord.  Turning at Omega pulls it outwards from the axis and so
    into the disk plane: the propeller moment -Omega^2 I sin(theta) cos(theta) per length.  A blade
    of length R that is held at its hub gives way to a moment that is the same all along it by

        delta(y) = delta_tip s (2 - s),   s = y / R,   delta_tip ~ Omega^2 .

    Between blades of one material and shape delta_tip goes as the square of the tip speed, whatever
    their size, and with (c/t)^2, the square of chord over thickness.  For c/t = 10 and a pitch of
    17 degrees it is 0.5 (rho_b (Omega R)^2 / G) (c/2t)^2 sin(theta) cos(theta), at a tip speed of
    100 m/s about 0.05 rad for polycarbonate and 0.02 rad for nylon with glass fibres.

    Attributes
    ----------
    tip_angle : float
        What the tip's twist loses at a tip speed of 100 m/s [rad]; it grows with Omega^2.

    Raises
    ------
    InputError
        For an angle beyond 0.2 rad either way.

    References
    ----------
    J. C. Houbolt, G. W. Brooks, "Differential Equations of Motion for Combined Flapwise Bending,
    Chordwise Bending, and Torsion of Twisted Nonuniform Rotor Blades", NACA Report 1346, 1958.
    """

    tip_angle: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.tip_angle) and abs(self.tip_angle) <= LARGEST_UNTWIST):
            found = f"tip_angle is {self.tip_angle}: give what the tip's twist loses at a tip "
            found += f"speed of 100 m/s, in rad, from {-LARGEST_UNTWIST:g} to {LARGEST_UNTWIST:g}"
            raise InputError(found)


@dataclass(frozen=True)
class TipLoss(Correction):
    """Prandtl's loss at the tip: a factor on the momentum thrust for a finite number of blades.

    The thrust (10) of an annulus is multiplied by F = 2/pi arccos(exp(-f)) with
    f = N_b (R - y) / (2 y sin(phi)).  phi is the inflow angle with V sin(beta) left out,
    tan(phi) = |U_P| / (Omega y): an annulus has one inflow at all azimuths, hence one F.

    References
    ----------
    L. Prandtl, appendix to A. Betz, "Schraubenpropeller mit geringstem Energieverlust",
    Nachrichten von der Gesellschaft der Wissenschaften zu Goettingen, 1919.
    H. Glauert, "Airplane Propellers", in W. F. Durand, Aerodynamic Theory IV, 1935.
    """


@dataclass(frozen=True)
class HubLoss(Correction):
    """Prandtl's loss at the hub: as ``TipLoss`` with f = N_b (y - r) / (2 r sin(phi)).

    Attributes
    ----------
    radius_m : float or None
        r, of the hub [m]; None for the radius at which the blade begins.

    Raises
    ------
    InputError
        For a radius that is no positive number; in a ``Model``, for one outside the blade's root.
    """

    radius_m: float | None = None

    def __post_init__(self) -> None:
        _check_radius(self.radius_m)

    def radius(self, root: float) -> float:
        """Give the hub's radius [m] on a blade that begins at ``root`` [m]."""
        return root if self.radius_m is None else self.radius_m

    def check(self, model: CorrectedModel) -> None:
        """Refuse a hub that is larger than where the blade of a ``model`` begins."""
        root, _ = model.span
        radius = self.radius(root)
        if radius > root * (1.0 + 1e-9):
            found = f"radius_m of the hub loss is {radius:g} m, but the blade begins at {root:g} m"
            raise InputError(found, "give a smaller radius, or a root cut-out")

    def core_numbers(self, name: str, model: CorrectedModel) -> dict[str, Any]:
        """Give the hub's radius in a ``model``, by ``name``."""
        return {name: self.radius(model.span[0])}


@dataclass(frozen=True)
class PittPeters(InflowShape):
    """Static inflow of Pitt and Peters, with the moments' feedback.

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


@dataclass(frozen=True)
class PittPetersGradient(InflowShape):
    """The gradient of Pitt and Peters that thrust drives, without the moments' feedback.

    v_c = 15 pi/32 tan(chi/2) times the mean inflow; see ``PittPeters``.
    """


@dataclass(frozen=True)
class Coleman(InflowShape):
    """v_c = tan(chi/2) times the mean inflow.

    References
    ----------
    R. P. Coleman, A. M. Feingold, C. W. Stempin, "Evaluation of the Induced-Velocity Field of an
    Idealized Helicopter Rotor", NACA ARR L5E10, 1945.
    """


@dataclass(frozen=True)
class Drees(InflowShape):
    """v_c = 4/3 (1 - cos(chi) - 1.8 mu^2) / sin(chi) and v_s = -2 mu, times the mean inflow.

    mu = V sin(beta)/(Omega R), held at 0.5 above it.

    References
    ----------
    J. M. Drees, "A Theory of Airflow Through Rotors and Its Application to Some Helicopter
    Problems", J. Helicopter Association of Great Britain 3(2), 1949.
    """


@dataclass(frozen=True)
class WhiteBlake(InflowShape):
    """v_c = sqrt(2) sin(chi) times the mean inflow.

    References
    ----------
    F. White, B. B. Blake, "Improved Method of Predicting Helicopter Control Response and Gust
    Sensitivity", 35th Annual Forum of the American Helicopter Society, 1979.
    """


@dataclass(frozen=True)
class Installed(Correction):
    """A rotor on its motor, arm or stand, whose force in the disk plane is not that of bare blades.

    It changes the rotor drag alone, at the hub: no moment comes from it; see ``drag``.  On every
    mount that was measured it is larger than blade theory has it, in two ways: by a factor on the
    blades' own, linear in Omega V, and as the drag of what stands in the slipstream.

    Attributes
    ----------
    factor : float or None
        k, factor on the rotor drag of the blades [-]; None for that of ``TYPICAL_FACTOR``.
    area_m2 : float or None
        f, drag coefficient times area of what is mounted across the flow [m^2]; None for that of
        ``TYPICAL_AREA``.
    wake : float
        The share of the disk's inflow in the air that it meets [-]: 1 at the disk, where a motor
        sits, towards 2 far below, 0 outside the slipstream.

    Raises
    ------
    InputError
        For a factor or an area below zero and a share that is not from 0 to 2.
    """

    factor: float | None = None
    area_m2: float | None = None
    wake: float = 1.0

    def __post_init__(self) -> None:
        if self.factor is not None and not 0.0 <= self.factor < math.inf:
            raise InputError(f"factor is {self.factor}: give 1 for the blades' own drag, or more")
        if self.area_m2 is not None and not 0.0 <= self.area_m2 < math.inf:
            raise InputError(f"area_m2 is {self.area_m2}: give an area of 0 m^2 or more")
        if not 0.0 <= self.wake <= 2.0:
            found = f"wake is {self.wake}: give a share of the inflow, 1 at the disk to 2 far below"
            raise InputError(found)

    @property
    def blade_factor(self) -> float:
        """k [-]."""
        return TYPICAL_FACTOR[0] if self.factor is None else self.factor

    def area(self, radius: float) -> float:
        """Give f [m^2] below a propeller of this ``radius`` [m]."""
        return TYPICAL_AREA[0] * radius**2 if self.area_m2 is None else self.area_m2

    def deviations(self, radius: float) -> dict[str, float]:
        """Give the standard deviations of what is not stated, by the names of ``Rotor.gradients``,
        below a propeller of this ``radius`` [m]."""
        factor = {} if self.factor is not None else {DRAG_FACTOR: TYPICAL_FACTOR[1]}
        area = {} if self.area_m2 is not None else {MOUNT_AREA: TYPICAL_AREA[1] * radius**2}
        return factor | area

    def core_numbers(self, name: str, model: CorrectedModel) -> dict[str, Any]:
        """Give the factor by ``name``, the area in a ``model``, and the share of the inflow."""
        area = self.area(model.propeller.radius)
        return {name: self.blade_factor, "mount-area": area, "mount-wake": self.wake}

    def drag(
        self,
        radius: float,
        density: float,
        v_axial: Floats,
        v_inplane: Floats,
        inflow: Floats,
        blades: Floats,
    ) -> Floats:
        """D = k D_blades + 1/2 rho f V_inplane sqrt(V_inplane^2 + (V_axial + w v_i)^2).

        The second term is the part in the disk plane of a drag along the air's velocity, so that
        the slipstream raises it: in slow flight it too grows with the in-plane velocity itself.

        Parameters
        ----------
        radius : float
            R [m].
        density : float
            rho [kg/m^3].
        v_axial, v_inplane : ndarray, shape (...)
            V cos(beta) and V sin(beta) [m/s].
        inflow : ndarray, shape (...)
            v_i averaged over the disk's area [m/s].
        blades : ndarray, shape (...)
            Rotor drag of the blades [N].

        Returns
        -------
        ndarray, shape (...)
            [N], against the in-plane velocity.
        """
        speed = np.hypot(v_inplane, v_axial + self.wake * inflow)
        mount = 0.5 * density * self.area(radius) * v_inplane * speed
        return np.asarray(self.blade_factor * blades + mount)


@dataclass(frozen=True)
class StallDelay(Correction):
    """Stall delay of the inner blade by Snel: rotation holds the separated flow on the blade.

    Lift is C_L + min(k (c/y)^2, 1) w (s a - C_L), s being the attached lift's slope, a the angle
    from zero lift and w a weight, 1 up to 30 degrees on either side and 0 from 60 on.  Drag is left
    as it is.  Made for the slender blades of wind turbines: where c/y is large no stall is left.

    Attributes
    ----------
    strength : float
        k, factor of (c/y)^2 [-].

    Raises
    ------
    InputError
        For a strength below zero; in a ``Model``, for a section law without attached lift.

    References
    ----------
    H. Snel, R. Houwink, J. Bosschers, "Sectional Prediction of Lift Coefficients on Rotating Wind
    Turbine Blades in Stall", ECN-C--93-052, 1994, which has the lift of a thin plate for s a.
    """

    strength: float = STALL_DELAY_STRENGTH

    def __post_init__(self) -> None:
        if not 0.0 <= self.strength < math.inf:
            found = f"strength of the stall delay is {self.strength}"
            raise InputError(found, "give a number, 3 in Snel's form")

    def check(self, model: CorrectedModel) -> None:
        """Refuse a ``model`` whose section law says that it has no attached lift."""
        if not getattr(model.airfoil, "has_attached_lift", True):
            found = "stall-delay gives lift back that stall takes, but this section law has no "
            found += "attached lift that could be continued"
            raise InputError(found, "leave the correction out, or give another law")


@dataclass(frozen=True)
class PrandtlGlauert(Correction):
    """Lift by the rule of Prandtl and Glauert: divided by sqrt(1 - M^2), M being the Mach number.

    The rule is used as it is up to M = 0.6, and held at 0.7 above some 0.79.  The lift of separated
    flow is raised with the rest; drag is left as it is, without the rise that shocks bring.

    Attributes
    ----------
    sound_mps : float
        Speed of sound [m/s].

    Raises
    ------
    InputError
        For a speed that is no positive number.

    References
    ----------
    H. Glauert, "The Effect of Compressibility on the Lift of an Aerofoil", Proc. R. Soc. A
    118(779), 1928, doi 10.1098/rspa.1928.0039.
    """

    sound_mps: float = SPEED_OF_SOUND

    def __post_init__(self) -> None:
        if not 0.0 < self.sound_mps < math.inf:
            raise InputError(f"sound_mps is {self.sound_mps}: give the speed of sound in m/s")


@dataclass(frozen=True)
class RadialFriction(Correction):
    """Viscous drag along the flow with its part along the blade.

    In forward flight air also moves along the blade, outwards with U_R = V sin(beta) cos(psi).  By
    the independence principle lift and pressure drag do not feel it, as in the paper; friction
    does, and acts along the whole velocity, whose size is W = sqrt(U_T^2 + U_P^2 + U_R^2).  So the
    law's viscous drag 1/2 rho U C_v c (U_T, U_P) becomes 1/2 rho W C_v c (U_T, U_P, U_R), C_v being
    taken at the Reynolds number of W.  The part along the blade adds to the rotor drag, and the
    larger velocity to drag and torque.  In axial flow nothing changes.

    A law's drag at zero lift is taken to be viscous: c_d0 and the friction in eq. (4).

    Not taken into account: what friction adds to the forces along the axis, less than 1e-3 of the
    thrust, and hence to the inflow; and how it differs between the rear and the front of a disk
    whose inflow varies, which would give a force across.

    References
    ----------
    R. T. Jones, "Effects of Sweepback on Boundary Layer and Separation", NACA TR 884, 1947.
    W. Johnson, Helicopter Theory, 1980, section 5-12, on the radial drag of helicopter blades.
    """


def _check_radius(radius: float | None) -> None:
    if radius is not None and not 0.0 < radius < math.inf:
        raise InputError(f"radius_m is {radius}: give the hub's radius in metres")


CORRECTIONS: dict[str, type[Correction]] = {
    "blade-to-hub": BladeToHub,
    "blade-untwist": BladeUntwist,
    "tip-loss": TipLoss,
    "hub-loss": HubLoss,
    "pitt-peters": PittPeters,
    "pitt-peters-gradient": PittPetersGradient,
    "coleman": Coleman,
    "drees": Drees,
    "white-blake": WhiteBlake,
    "installed": Installed,
    "stall-delay": StallDelay,
    "prandtl-glauert": PrandtlGlauert,
    "radial-friction": RadialFriction,
}
"""Each by its name.  They act in this order, whichever way they are given: the blade's shape comes
first."""

MODELS = {"recommended": ("pitt-peters", "radial-friction"), "paper": ()}
"""Corrections by the model's name.  The commands take "recommended" where nothing else is said;
"paper" is Gill & D'Andrea, CCTA 2017, doi 10.1109/CCTA.2017.8062443, to the letter."""


INSTALLED = "installed"
"""The correction that describes a rotor's surroundings: no section constant depends on it, so that
it may differ from that of the test that the constants are from."""


def correction(text: str) -> Correction:
    """Make a correction from its name and numbers, as in ``hub-loss:radius_m=0.012``.

    Parameters
    ----------
    text : str
        A name of ``CORRECTIONS``; behind a colon its fields, separated by commas.

    Raises
    ------
    InputError
        For an unknown name or field, or a value that is no number.
    """
    name, colon, given = text.partition(":")
    if name not in CORRECTIONS:
        known = f"this version has {', '.join(CORRECTIONS)}"
        raise InputError(f"correction {name!r} is not known", known)
    kind: Any = CORRECTIONS[name]
    known_fields = {field.name: field for field in dataclasses.fields(kind)}
    numbers: dict[str, float] = {}
    with located(f"correction {name}"):
        for part in given.split(",") if colon else ():
            field, _, value = part.partition("=")
            field = field.strip()
            if field in numbers:
                raise InputError(f"{field} is given twice", "give it once")
            try:
                numbers[field] = float(value)
            except ValueError:
                found, remedy = f"{part!r} is no field with a number", f"write {name}:field=number"
                raise InputError(found, remedy) from None
            if field not in known_fields:
                has = f"it has {', '.join(known_fields) or 'no fields'}"
                raise InputError(f"unknown field {field!r}", has)
        for field, about in known_fields.items():
            if about.default is dataclasses.MISSING and field not in numbers:
                raise InputError(f"no {field}", f"write {name}:{field}=number")
    return kind(**numbers)


def corrections_of(
    model: str = "recommended", added: Sequence[str] = (), *, installed: bool = False
) -> tuple[Correction, ...]:
    """Collect the corrections of a model by its name, for ``propmap.Model``.

    Parameters
    ----------
    model : str
        "recommended" or "paper", see ``MODELS``.
    added : sequence of str
        More of them, as ``correction`` reads them.  One that sets how the inflow varies around the
        disk, and one with other fields, takes the place of the model's own.
    installed : bool
        Whether to add ``Installed()``, a rotor on a motor as they are, to the recommended model
        where ``added`` does not say how it is installed.

    Raises
    ------
    InputError
        For an unknown model or correction.
    """
    if model not in MODELS:
        raise InputError(f"model {model!r} is not known", f"give one of {', '.join(MODELS)}")
    more = tuple(correction(text) for text in added)
    if installed and model == "recommended" and not split_mount(list(added))[1]:
        more = (*more, Installed())
    kinds = {type(one) for one in more}
    shaped = any(isinstance(one, InflowShape) for one in more)
    own = [correction(text) for text in MODELS[model]]
    kept = [
        one
        for one in own
        if type(one) not in kinds and not (shaped and isinstance(one, InflowShape))
    ]
    return *kept, *more


def as_texts(texts: Any) -> tuple[str, ...] | None:
    """Check texts of corrections of a file; None, where nothing is said of them, stays None."""
    if texts is None:
        return None
    if not isinstance(texts, (list, tuple)) or not all(isinstance(text, str) for text in texts):
        raise InputError(f'corrections is {texts!r}: write a list such as ["tip-loss"]')
    return tuple(as_text(correction(text)) for text in texts)


def agreed(section: str, own: Sequence[str] | None, given: Sequence[str]) -> tuple[str, ...]:
    """Give the corrections for a section law that was found with its ``own``, None if unknown, the
    mount as ``given``; ``InputError`` where others than its own are given to the law called
    ``section``."""
    wanted, mount = split_mount(as_texts(given) or ())
    if own is None:
        return *wanted, *mount
    found, own_mount = split_mount(own)
    if sorted(found) != sorted(wanted):
        raise InputError(
            f"{section} was found with {in_words(found)}, not with {in_words(wanted)}",
            "leave --model and --correction out, which takes what it was found with, or fit again",
        )
    return *found, *(mount or own_mount)


def split_mount(texts: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Part the corrections of the physics from those that describe what is mounted."""
    mount = tuple(text for text in texts if text.partition(":")[0] == INSTALLED)
    return tuple(text for text in texts if text not in mount), mount


def in_words(texts: Sequence[str]) -> str:
    """Name corrections: "tip-loss, pitt-peters", or that there are none."""
    return ", ".join(texts) or "the paper's model"


def name_of(value: Correction) -> str:
    """Find the name by which ``correction`` knows it; ``InputError`` for what is no correction."""
    for name, kind in CORRECTIONS.items():
        if type(value) is kind:
            return name
    found = f"{value!r} is no correction"
    raise InputError(found, f"give one of {', '.join(CORRECTIONS)}, see propmap.correction")


def as_text(value: Correction) -> str:
    """Write the text from which ``correction`` makes it again."""
    fields = dataclasses.fields(value)  # type: ignore[arg-type]
    numbers = {field.name: (getattr(value, field.name), field.default) for field in fields}
    given = ",".join(
        f"{name}={own!r}" for name, (own, default) in numbers.items() if own != default
    )
    return f"{name_of(value)}:{given}" if given else name_of(value)
