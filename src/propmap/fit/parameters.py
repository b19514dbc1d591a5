"""What a fit may vary: names, bounds, first guesses, the user's choice, and priors."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from propmap.catalogue.expected import LOGARITHMIC, PopulationPrior, coordinates, slopes_of
from propmap.catalogue.expected import constants_of as prior_constants
from propmap.catalogue.identified import PARAMETERS
from propmap.errors import InputError, quoted
from propmap.model.airfoil import CONSTANTS, PAPER_FOUR, Airfoil
from propmap.model.model import Section
from propmap.typing import Floats


@dataclass(frozen=True)
class Parameter:
    """One parameter in ``unit``, its bounds and first guess, the paper's x0 where it has one."""

    unit: str
    start: float
    lower: float
    upper: float
    # By how much real propellers or vehicles differ: the unit in which sensitivities are compared.
    # A parameter is identified where its 95 % interval is no wider.
    spread: float
    meaning: str


SECTION = {
    name: Parameter(constant.unit, *constant.fit, constant.meaning)
    for name, constant in CONSTANTS.items()
    if constant.fit is not None
}  # parameters of the section law; x0 of (18) is that of the first four

_TABLES = tomllib.loads(Path(__file__).with_name("parameters.toml").read_text(encoding="utf-8"))


def _listed(table: str) -> dict[str, Parameter]:
    return {name: Parameter(*row) for name, row in _TABLES[table].items()}


MOUNT = _listed("mount")
INSTALLED = _listed("installed") | MOUNT
"""The correction ``installed``, the model's own where it is neither free nor fixed."""

FLEX = _listed("flex")  # the model's own where it is neither free nor fixed
ROTOR = SECTION | FLEX | INSTALLED  # what changes the loads of a rotor at a given flow
BODY, WING, SENSOR, TURNING = map(_listed, ("body", "wing", "sensor", "turning"))
WAKES = _listed("wakes")  # what is neither free nor fixed is the vehicle file's
FLIGHT, THROTTLE = _listed("flight"), _listed("throttle")
ROTOR_SPEED = "rotor_speed_scale"
BEYOND_ROTORS = BODY | SENSOR | TURNING | WAKES | FLIGHT | THROTTLE
"""What acts in flight alone, without the wing's: the table ``[fit.body]`` of a fit's file."""

PER_FLIGHT = ("thrust_scale", "clock_offset")  # named as ``thrust_scale[FLIGHT]``

EVERY = ROTOR | BODY | WING | SENSOR | TURNING | WAKES | FLIGHT | THROTTLE
_NOT_ALWAYS = FLEX | INSTALLED | WAKES | THROTTLE
FIRST_GUESS = {name: p.start for name, p in EVERY.items() if name not in _NOT_ALWAYS}


LINEAR = (*BODY, *SENSOR, *TURNING, "thrust_scale")  # forces are linear in these


def constants_of(section: Section) -> Airfoil:
    """The section law if it has the parameters of ``SECTION``; refuse a section table."""
    if isinstance(section, Airfoil):
        return section
    found = f"{section.name!r} is no set of constants such as c_l1"
    raise InputError(found, "a fit and a simulated flight need constants: give a parameter set")


@dataclass(frozen=True)
class Prior:
    """What is known of a parameter beforehand.

    Attributes
    ----------
    mean, deviation : float
        Mean and standard deviation, in the unit of the parameter.
    """

    mean: float
    deviation: float


IN_FLIGHT = {name: Prior(*known) for name, known in _TABLES["in_flight"].items()}
"""What is known of some parameters before a fit of whole flights, of vehicles of any size."""


@dataclass(frozen=True)
class Choice:
    """Which parameters are free, and what holds the others.

    Attributes
    ----------
    free : tuple of str
        Names, in order.
    fixed : mapping of str to float
        Values of any others that are not at their first guess.
    priors : mapping of str to Prior
        Priors of free parameters.
    start : mapping of str to float
        Values to start from first, where these are not the first guesses.
    expected : SectionPrior, optional
        Prior, from other propellers, of the free section constants that have none of their own.

    Raises
    ------
    InputError
        For unknown or repeated names and values out of bounds.
    """

    free: tuple[str, ...] = PAPER_FOUR
    fixed: Mapping[str, float] = field(default_factory=dict)
    priors: Mapping[str, Prior] = field(default_factory=dict)
    start: Mapping[str, float] = field(default_factory=dict)
    expected: SectionPrior | None = None

    def __post_init__(self) -> None:
        if not self.free:
            raise InputError("no parameter is free", f"name some of {', '.join(EVERY)}")
        for name in (*self.free, *self.fixed, *self.priors, *self.start):
            known(name)
        for name in self.free:
            if self.free.count(name) > 1:
                raise InputError(f"{name} is named twice as free", "name it once")
            if name in self.fixed:
                raise InputError(f"{name} is both free and fixed", "choose one")
        for name, prior in self.priors.items():
            if name not in self.free:
                raise InputError(f"{name} has a prior but is not free", "add it to the free ones")
            if not np.isfinite(prior.mean):
                raise InputError(f"the prior of {name} has no number as mean", "give one")
            if not prior.deviation > 0.0:
                found = f"the prior of {name} has the deviation {prior.deviation:g}"
                raise InputError(found, "give one above zero, as in c_l2=2.0:0.3")
        for name, value in (*self.fixed.items(), *self.start.items()):
            p = described(name)
            if not p.lower <= value <= p.upper:
                fault = f"{name} is {value:g} {p.unit}"
                raise InputError(fault, f"give a value from {p.lower:g} to {p.upper:g}")

    def values(self, x: Floats) -> dict[str, float]:
        """All parameters by name.

        Parameters
        ----------
        x : ndarray, shape (P,)
            The free ones.
        """
        return {**FIRST_GUESS, **self.fixed, **dict(zip(self.free, x.tolist(), strict=True))}

    def column(self, attribute: str) -> Floats:
        """An ``attribute`` (P,) of the free parameters."""
        return np.array([getattr(described(name), attribute) for name in self.free])

    def prior_of(self, name: str) -> Prior | None:
        """The prior of the free parameter ``name``; None without one."""
        if name in self.priors or self.expected is None:
            return self.priors.get(name)
        found = self.expected.of_constant(name)
        return Prior(*found) if found else None

    def prior_residuals(self, x: Floats) -> tuple[Floats, Floats]:
        """Distances (K,) of ``x`` (P,) from K priors, in deviations, and slopes (K, P)."""
        own = [k for k, name in enumerate(self.free) if name in self.priors]
        given = [self.priors[self.free[k]] for k in own]
        deviation = np.array([p.deviation for p in given])
        residuals = (x[own] - np.array([p.mean for p in given])) / deviation
        slopes = np.eye(x.size)[own] / deviation[:, None]
        if self.expected is None:
            return residuals, slopes
        constants = [name for name in self.free if name in PARAMETERS]
        kept = [PARAMETERS.index(name) for name in constants if name not in self.priors]
        more, by_constant = self.expected.penalty(self.values(x), kept)
        by_free = np.zeros((len(kept), x.size))
        for name in constants:
            by_free[:, self.free.index(name)] = by_constant[:, PARAMETERS.index(name)]
        return np.concatenate([residuals, more]), np.concatenate([slopes, by_free])

    @property
    def first(self) -> Floats:
        """Where the search starts (P,)."""
        return np.array([self.start.get(name, described(name).start) for name in self.free])


def general(name: str) -> str:
    """``name`` without the flight that it is of, if it is of one."""
    head, bracket, flight = name.partition("[")
    return head if bracket and head in PER_FLIGHT and flight[:-1] and flight[-1] == "]" else name


def of_flight(name: str, flight: str) -> str:
    """The parameter ``name`` of one ``flight``."""
    return f"{name}[{flight}]"


def described(name: str) -> Parameter:
    """The parameter of this ``name``, be it of one flight or of all."""
    return EVERY[general(name)]


def known(name: str) -> str:
    """``name`` if it is a parameter's; raises ``InputError`` with the closest ones otherwise."""
    if general(name) not in EVERY:
        close = difflib.get_close_matches(name, EVERY, n=2) or list(EVERY)
        raise InputError(f"{quoted(name)} is not a parameter", f"choose from {', '.join(close)}")
    return name


SMALLEST = 1e-6  # for a constant at its bound of 0, whose logarithm is infinitely far

LEAST_ERROR = 0.03
"""Standard deviation of residuals at least, as a share of their scale, where such a prior is
weighed against them: no stand and no model is better, however well few rows are fitted.  With it,
after a fit to static rows, a propeller's rows in flight lie within their intervals as often as they
should: ``python -m tools.after_static``."""

LEAST_IN_FLIGHT = 0.01
"""That of the forces in whole flights, as a share of the weight: across the flight they are a few
hundredths of it themselves, and stretches of a second already count what samples have in common."""


@dataclass(frozen=True, eq=False)
class SectionPrior:
    """A distribution of section constants over propellers, as the prior of one of them.

    The constants are not independent of each other: it is the angle of least drag from the chord
    line that propellers have in common, so that ``drag_angle`` falls as ``zero_lift_angle`` rises.

    Attributes
    ----------
    distribution : PopulationPrior
        Distribution of the coordinates of the constants.
    airfoil : Airfoil
        The most likely constants.
    source : str
        One line that says of which propellers this is.
    """

    distribution: PopulationPrior
    airfoil: Airfoil
    source: str

    def z_scores(self, values: Mapping[str, float]) -> tuple[Floats, Floats]:
        """Standard deviations (P,) between coordinates and means of constants ``values`` by name,
        in the order of ``PARAMETERS``, and derivatives (P, P)."""
        constants = np.array([values[name] for name in PARAMETERS])
        inside = np.where(LOGARITHMIC, np.maximum(constants, SMALLEST), constants)
        place = coordinates(inside)
        deviation = self.distribution.deviation
        slopes = np.linalg.inv(slopes_of(place)) / deviation[:, None]
        return (place - self.distribution.mean) / deviation, slopes

    def penalty(self, values: Mapping[str, float], kept: Sequence[int]) -> tuple[Floats, Floats]:
        """Numbers (K,) independent and of variance 1 beforehand, of the coordinates ``kept`` at the
        constants ``values`` by name; their slopes (K, 7)."""
        scores, slopes = self.z_scores(values)
        own = list(kept)
        root = np.linalg.cholesky(self.distribution.correlation[np.ix_(own, own)])
        return np.linalg.solve(root, scores[own]), np.linalg.solve(root, slopes[own])

    def of_constant(self, name: str) -> tuple[float, float] | None:
        """Mean and standard deviation of the constant ``name``; None where there is none."""
        if name not in PARAMETERS:
            return None
        k = PARAMETERS.index(name)
        place = self.distribution.mean
        slopes = slopes_of(place)[k]
        variance = slopes @ self.distribution.covariance @ slopes
        return float(prior_constants(place)[k]), float(np.sqrt(variance))
