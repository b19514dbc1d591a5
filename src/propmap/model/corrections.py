"""The corrections of a model: terms beyond the physics of the paper, as validated values.

docs/theory.md and docs/how-to/corrections-and-tables.md contain the formulas and their limits.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from propmap.errors import InputError, located
from propmap.loads import DRAG_FACTOR, MOUNT_AREA
from propmap.model.propeller import Propeller
from propmap.units import SPEED_OF_SOUND

HUB_SHARE = 0.08  # default radius of the hub over R: 16 mm diameter for 8 inches
LARGEST_UNTWIST = 0.2  # largest untwist of the tip [rad]; real blades untwist less

TYPICAL_FACTOR, TYPICAL_AREA = (1.9, 0.6), (0.1, 0.1)
"""Mean and standard deviation for rotors on motors: factor on the drag of the blades [-], and mount
area over the square of the propeller radius [-].  With these values 20 propellers of one tunnel
(Gill and D'Andrea, Drones 3(4):77, 2019, doi 10.3390/drones3040077), one propeller of another
tunnel, and flights lie inside the bands: ``python -m tools.coverage``."""

STALL_DELAY_STRENGTH = 3.0  # Snel's factor on (c/y)^2 [-]


class CorrectedModel(Protocol):
    """The properties of a ``Model`` that its corrections use."""

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
    """Base class of the corrections: a term of the physics, as a frozen dataclass of numbers."""

    def check(self, model: CorrectedModel) -> None:
        """Raise ``InputError`` if the correction does not fit ``model``."""

    def core_numbers(self, name: str, model: CorrectedModel) -> dict[str, Any]:  # noqa: ARG002
        """Return the core's input ``name``: the value of the correction's field; 1 without one."""
        values = list(vars(self).values())
        return {name: values[0] if values else 1.0}


class InflowShape(Correction):
    """Base class of the variations of the inflow around the disk; a model has at most one."""

    def core_numbers(self, name: str, model: CorrectedModel) -> dict[str, Any]:  # noqa: ARG002
        """Return the ``name`` of the shape for the core."""
        return {"inflow": name}


@dataclass(frozen=True)
class BladeToHub(Correction):
    """Extension of the blade from its first measured station to the hub.

    Geometry files begin at the radius where the blade leaves the fairing of the hub.  On the APC
    8x6E, the added part increases the thrust by 1 to 2 % and the rotor drag by more than 10 %.

    Attributes
    ----------
    radius_m : float or None
        Radius of the hub [m]; None for ``HUB_SHARE`` times the tip radius.

    Raises
    ------
    InputError
        For a radius that is not a positive number; in a ``Model``, for a radius beyond the first
        station, and for a blade with a root cut-out.
    """

    radius_m: float | None = None

    def __post_init__(self) -> None:
        _check_radius(self.radius_m)

    def hub(self, propeller: Propeller) -> float:
        """Return the radius at which the extended blade of a ``propeller`` begins [m].

        Raise ``InputError`` for a blade with a root cut-out, and a hub beyond the first station.
        """
        first, root = float(propeller.station[0]), propeller.root
        if root > first * (1.0 + 1e-9):
            found = f"blade-to-hub extends the blade inward, but its root is cut out at {root:g} m"
            raise InputError(found, "remove the correction or the root cut-out")
        hub = HUB_SHARE * propeller.radius if self.radius_m is None else self.radius_m
        if self.radius_m is not None and hub > first * (1.0 + 1e-9):
            found = f"radius_m of blade-to-hub is {hub:g} m, but the blade begins at {first:g} m"
            raise InputError(found, "give a smaller radius in meters, or remove the correction")
        return root if hub >= first * (1.0 - 1e-9) else hub

    def check(self, model: CorrectedModel) -> None:
        """Check the propeller of a ``model``, as in ``hub``."""
        self.hub(model.propeller)

    def core_numbers(self, name: str, model: CorrectedModel) -> dict[str, Any]:  # noqa: ARG002
        """Return no ``name``: the core receives the blade of the ``model`` already extended."""
        return {}


@dataclass(frozen=True)
class BladeUntwist(Correction):
    """Elastic untwist: the centrifugal force twists the blade toward the disk plane.

    A blade of length R that is clamped at its hub twists by delta_tip s (2 - s), s = y / R, if the
    moment per length is constant.  For one material and shape, delta_tip grows with the square of
    the tip speed and does not depend on the size.  For a tip speed of 100 m/s and c/t = 10,
    delta_tip is about 0.05 rad for polycarbonate and 0.02 rad for nylon with glass fibers.

    Attributes
    ----------
    tip_angle : float
        Decrease of the tip twist at a tip speed of 100 m/s [rad]; it grows with Omega^2.

    Raises
    ------
    InputError
        For an angle outside -0.2 to 0.2 rad.

    References
    ----------
    J. C. Houbolt, G. W. Brooks, "Differential Equations of Motion for Combined Flapwise Bending,
    Chordwise Bending, and Torsion of Twisted Nonuniform Rotor Blades", NACA Report 1346, 1958.
    """

    tip_angle: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.tip_angle) and abs(self.tip_angle) <= LARGEST_UNTWIST):
            found = f"tip_angle is {self.tip_angle}: give the decrease of the tip twist at a tip "
            found += f"speed of 100 m/s, in rad, from {-LARGEST_UNTWIST:g} to {LARGEST_UNTWIST:g}"
            raise InputError(found)


@dataclass(frozen=True)
class TipLoss(Correction):
    """Prandtl's tip loss: a factor on the momentum thrust for a finite number of blades.

    References
    ----------
    L. Prandtl, appendix to A. Betz, "Schraubenpropeller mit geringstem Energieverlust",
    Nachrichten von der Gesellschaft der Wissenschaften zu Goettingen, 1919.
    H. Glauert, "Airplane Propellers", in W. F. Durand, Aerodynamic Theory IV, 1935.
    """


@dataclass(frozen=True)
class HubLoss(Correction):
    """Prandtl's hub loss: the factor of ``TipLoss`` for the distance from the hub.

    Attributes
    ----------
    radius_m : float or None
        Radius r of the hub [m]; None for the radius at which the blade begins.

    Raises
    ------
    InputError
        For a radius that is not a positive number; in a ``Model``, for a radius beyond the blade
        root.
    """

    radius_m: float | None = None

    def __post_init__(self) -> None:
        _check_radius(self.radius_m)

    def radius(self, root: float) -> float:
        """Return the radius of the hub [m] for a blade that begins at ``root`` [m]."""
        return root if self.radius_m is None else self.radius_m

    def check(self, model: CorrectedModel) -> None:
        """Raise ``InputError`` if the hub is larger than the root radius of the ``model``."""
        root, _ = model.span
        radius = self.radius(root)
        if radius > root * (1.0 + 1e-9):
            found = f"radius_m of the hub loss is {radius:g} m, but the blade begins at {root:g} m"
            raise InputError(found, "give a smaller radius, or a root cut-out")

    def core_numbers(self, name: str, model: CorrectedModel) -> dict[str, Any]:
        """Return the radius of the hub in a ``model``, under ``name``."""
        return {name: self.radius(model.span[0])}


@dataclass(frozen=True)
class PittPeters(InflowShape):
    """Steady inflow of Pitt and Peters, with feedback of the moments.

    A part of the disk with more lift has more downwash.  The mean inflow is the solution of eq.
    (11), averaged over the disk; Pitt and Peters use a uniform mean inflow.

    References
    ----------
    D. M. Pitt, D. A. Peters, "Theoretical Prediction of Dynamic-Inflow Derivatives",
    Vertica 5(1), 1981.
    D. A. Peters, N. HaQuang, "Dynamic Inflow for Practical Applications",
    J. American Helicopter Society 33(4), 1988.
    """


@dataclass(frozen=True)
class PittPetersGradient(InflowShape):
    """Inflow gradient of Pitt and Peters from the thrust, without feedback of the moments.

    v_c = 15 pi/32 tan(chi/2) times the mean inflow; see ``PittPeters``.
    """


@dataclass(frozen=True)
class Coleman(InflowShape):
    """Inflow gradient of Coleman: v_c = tan(chi/2) times the mean inflow.

    References
    ----------
    R. P. Coleman, A. M. Feingold, C. W. Stempin, "Evaluation of the Induced-Velocity Field of an
    Idealized Helicopter Rotor", NACA ARR L5E10, 1945.
    """


@dataclass(frozen=True)
class Drees(InflowShape):
    """Inflow gradients of Drees.

    v_c = 4/3 (1 - cos(chi) - 1.8 mu^2) / sin(chi) and v_s = -2 mu, times the mean inflow, with
    mu = V sin(beta)/(Omega R) limited to 0.5.

    References
    ----------
    J. M. Drees, "A Theory of Airflow Through Rotors and Its Application to Some Helicopter
    Problems", J. Helicopter Association of Great Britain 3(2), 1949.
    """


@dataclass(frozen=True)
class WhiteBlake(InflowShape):
    """Inflow gradient of White and Blake: v_c = sqrt(2) sin(chi) times the mean inflow.

    References
    ----------
    F. White, B. B. Blake, "Improved Method of Predicting Helicopter Control Response and Gust
    Sensitivity", 35th Annual Forum of the American Helicopter Society, 1979.
    """


@dataclass(frozen=True)
class Installed(Correction):
    """Rotor drag of an installed rotor, on its motor, arm or stand.

    The correction changes only the rotor drag, at the hub, and adds no moment.  On all measured
    mounts the rotor drag exceeds the drag of bare blades.  A factor increases the drag of the
    blades, which is linear in Omega V.  The drag of the parts in the slipstream is added.

    Attributes
    ----------
    factor : float or None
        Factor k on the rotor drag of the blades [-]; None for the mean of ``TYPICAL_FACTOR``.
    area_m2 : float or None
        Area f [m^2], drag coefficient times area of the parts in the slipstream; None for the mean
        of ``TYPICAL_AREA``.
    wake : float
        Inflow at these parts over the inflow at the disk, w [-]: 1 for a motor close to the disk,
        up to 2 far below, 0 outside the slipstream.

    Raises
    ------
    InputError
        For a negative factor or area, or a ``wake`` outside 0 to 2.
    """

    factor: float | None = None
    area_m2: float | None = None
    wake: float = 1.0

    def __post_init__(self) -> None:
        if self.factor is not None and not 0.0 <= self.factor < math.inf:
            raise InputError(f"factor is {self.factor}: give 1 for the drag of the blades, or more")
        if self.area_m2 is not None and not 0.0 <= self.area_m2 < math.inf:
            raise InputError(f"area_m2 is {self.area_m2}: give an area of 0 m^2 or more")
        if not 0.0 <= self.wake <= 2.0:
            found = f"wake is {self.wake}: give inflow at the mount over inflow at the disk, 0 to 2"
            raise InputError(found)

    @property
    def blade_factor(self) -> float:
        """Factor k on the rotor drag of the blades [-]."""
        return TYPICAL_FACTOR[0] if self.factor is None else self.factor

    def area(self, radius: float) -> float:
        """Return the area f [m^2] for a propeller of this ``radius`` [m]."""
        return TYPICAL_AREA[0] * radius**2 if self.area_m2 is None else self.area_m2

    def deviations(self, radius: float) -> dict[str, float]:
        """Return the standard deviations of factor and area, if not given, for this ``radius`` [m].

        The names are those of ``Rotor.gradients``.
        """
        factor = {} if self.factor is not None else {DRAG_FACTOR: TYPICAL_FACTOR[1]}
        area = {} if self.area_m2 is not None else {MOUNT_AREA: TYPICAL_AREA[1] * radius**2}
        return factor | area

    def core_numbers(self, name: str, model: CorrectedModel) -> dict[str, Any]:
        """Return the factor under ``name``, the area for a ``model``, and ``wake``."""
        area = self.area(model.propeller.radius)
        return {name: self.blade_factor, "mount-area": area, "mount-wake": self.wake}


@dataclass(frozen=True)
class StallDelay(Correction):
    """Stall delay of the inner blade after Snel: rotation keeps the separated flow on the blade.

    The drag does not change.  The rule was developed for the slender blades of wind turbines.  For
    large c/y, the rule removes stall completely.

    Attributes
    ----------
    strength : float
        Factor k on (c/y)^2 [-].

    Raises
    ------
    InputError
        For a negative strength; in a ``Model``, for a section law without attached lift.

    References
    ----------
    H. Snel, R. Houwink, J. Bosschers, "Sectional Prediction of Lift Coefficients on Rotating Wind
    Turbine Blades in Stall", ECN-C--93-052, 1994.  The report uses the lift of a thin plate instead
    of s a.
    """

    strength: float = STALL_DELAY_STRENGTH

    def __post_init__(self) -> None:
        if not 0.0 <= self.strength < math.inf:
            found = f"strength of the stall delay is {self.strength}"
            raise InputError(found, "give a number of 0 or more; Snel's value is 3")

    def check(self, model: CorrectedModel) -> None:
        """Raise ``InputError`` for a ``model`` whose section law has no attached lift."""
        if not getattr(model.airfoil, "has_attached_lift", True):
            found = "stall-delay restores attached lift beyond stall, but this section law has no "
            found += "attached lift"
            raise InputError(found, "remove the correction, or give another section law")


@dataclass(frozen=True)
class PrandtlGlauert(Correction):
    """Prandtl-Glauert rule: the lift is divided by sqrt(1 - M^2), where M is the Mach number.

    Above M = 0.6, the rule uses a smaller M, which levels off at 0.7.  The rule does not change the
    drag and therefore excludes the drag rise due to shocks.

    Attributes
    ----------
    sound_mps : float
        Speed of sound [m/s].

    Raises
    ------
    InputError
        For a speed that is not a positive number.

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
    """Viscous drag along the whole velocity, including its component along the blade.

    In forward flight air also flows along the blade, outward at U_R = V sin(beta) cos(psi).  By the
    independence principle, lift and pressure drag do not depend on U_R, as in the paper.  The
    viscous drag of the section law, 1/2 rho U C_v c (U_T, U_P), becomes
    1/2 rho W C_v c (U_T, U_P, U_R), with W the magnitude of the whole velocity.

    Two effects are neglected.  First, friction changes the axial force by less than 1e-3 of the
    thrust, which also changes the inflow.  Second, if the inflow varies around the disk, friction
    differs between rear and front, which causes a side force.

    References
    ----------
    R. T. Jones, "Effects of Sweepback on Boundary Layer and Separation", NACA TR 884, 1947.
    W. Johnson, Helicopter Theory, 1980, section 5-12, on the radial drag of helicopter blades.
    """


def _check_radius(radius: float | None) -> None:
    if radius is not None and not 0.0 < radius < math.inf:
        raise InputError(f"radius_m is {radius}: give the radius of the hub in meters")


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
"""Corrections by name, in the order in which they act: the shape of the blade comes first.  The
order of the corrections in a model does not matter."""

MODELS = {"recommended": ("pitt-peters", "radial-friction"), "paper": ()}
"""Corrections of each named model.  "recommended" is the default of the commands.  "paper" is the
model of Gill & D'Andrea, CCTA 2017, doi 10.1109/CCTA.2017.8062443, without changes."""


INSTALLED = "installed"
"""Name of the correction that describes the installation of a rotor.  Section constants do not
depend on it, so it may differ from the installation in the test of the constants."""


def correction(text: str) -> Correction:
    """Return the correction for a text such as ``hub-loss:radius_m=0.012``.

    Parameters
    ----------
    text : str
        A name from ``CORRECTIONS``; after a colon its fields, separated by commas.

    Raises
    ------
    InputError
        For an unknown name or field, or a value that is not a number.
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
                found, remedy = f"{part!r} is not field=number", f"write {name}:field=number"
                raise InputError(found, remedy) from None
            if field not in known_fields:
                has = f"it has {', '.join(known_fields) or 'no fields'}"
                raise InputError(f"unknown field {field!r}", has)
        for field, about in known_fields.items():
            if about.default is dataclasses.MISSING and field not in numbers:
                raise InputError(f"no {field}", f"write {name}:{field}=number")
    return kind(**numbers)


def model_corrections(
    model: str = "recommended", added: Sequence[str] = (), *, installed: bool = False
) -> tuple[Correction, ...]:
    """Return the corrections of a named model, for ``propmap.Model``.

    Parameters
    ----------
    model : str
        "recommended" or "paper", see ``MODELS``.
    added : sequence of str
        More corrections, as texts for ``correction``.  An added correction replaces the model's
        correction of the same kind.  All variations of the inflow around the disk are one kind.
    installed : bool
        Whether to add ``Installed()``, a typical rotor on a motor, to the recommended model if
        ``added`` does not contain "installed".

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
    """Return the checked correction texts of a file, or None for unknown corrections."""
    if texts is None:
        return None
    if not isinstance(texts, (list, tuple)) or not all(isinstance(text, str) for text in texts):
        raise InputError(f'corrections is {texts!r}: write a list such as ["tip-loss"]')
    return tuple(as_text(correction(text)) for text in texts)


def agreed(section: str, own: Sequence[str] | None, given: Sequence[str]) -> tuple[str, ...]:
    """Return the corrections for the section law ``section``, with the ``given`` installation.

    Raise ``InputError`` if ``given`` differs from ``own``, the corrections with which the law was
    fitted (None if unknown).
    """
    wanted, mount = split_mount(as_texts(given) or ())
    if own is None:
        return *wanted, *mount
    found, own_mount = split_mount(own)
    if sorted(found) != sorted(wanted):
        raise InputError(
            f"{section} was fitted with {in_words(found)}, not with {in_words(wanted)}",
            "omit --model and --correction to use the corrections of the fit, or fit again",
        )
    return *found, *(mount or own_mount)


def split_mount(texts: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Split ``texts`` into corrections of the physics and those of the installation."""
    mount = tuple(text for text in texts if text.partition(":")[0] == INSTALLED)
    return tuple(text for text in texts if text not in mount), mount


def in_words(texts: Sequence[str]) -> str:
    """Return the names of corrections, "tip-loss, pitt-peters", or "the paper's model"."""
    return ", ".join(texts) or "the paper's model"


def name_of(value: Correction) -> str:
    """Return the name of a correction; raise ``InputError`` for another object."""
    for name, kind in CORRECTIONS.items():
        if type(value) is kind:
            return name
    found = f"{value!r} is not a correction"
    raise InputError(found, f"give one of {', '.join(CORRECTIONS)}, see propmap.correction")


def as_text(value: Correction) -> str:
    """Return the text from which ``correction`` makes this correction."""
    fields = dataclasses.fields(value)  # type: ignore[arg-type]
    numbers = {field.name: (getattr(value, field.name), field.default) for field in fields}
    given = ",".join(
        f"{name}={own!r}" for name, (own, default) in numbers.items() if own != default
    )
    return f"{name_of(value)}:{given}" if given else name_of(value)
