"""Parameters of fits: names, bounds, first guesses, the user's choice, and priors."""

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
    """One parameter: first guess (x0 of the paper, if any), bounds and spread in ``unit``."""

    unit: str
    start: float
    lower: float
    upper: float
    # Typical difference between propellers or vehicles, and the unit of sensitivities.  A parameter
    # is identified if its 95 % interval is not wider than this.
    spread: float
    meaning: str


SECTION = {
    name: Parameter(constant.unit, *constant.fit, constant.meaning)
    for name, constant in CONSTANTS.items()
    if constant.fit is not None
}  # parameters of the section law; the first four have x0 of (18) as first guess

_TABLES = tomllib.loads(Path(__file__).with_name("parameters.toml").read_text(encoding="utf-8"))


def _listed(table: str) -> dict[str, Parameter]:
    return {name: Parameter(*row) for name, row in _TABLES[table].items()}


MOUNT = _listed("mount")
INSTALLED = _listed("installed") | MOUNT
"""Parameters of the correction ``installed``; the model supplies values that a fit does not set."""

FLEX = _listed("flex")  # the model supplies a value that a fit does not set
ROTOR = SECTION | FLEX | INSTALLED  # parameters that change the loads of a rotor in a given flow
BODY, WING, SENSOR, TURNING = map(_listed, ("body", "wing", "sensor", "turning"))
WAKES = _listed("wakes")  # the vehicle file supplies values that a fit does not set
FLIGHT, THROTTLE = _listed("flight"), _listed("throttle")
ROTOR_SPEED = "rotor_speed_scale"
BEYOND_ROTORS = BODY | SENSOR | TURNING | WAKES | FLIGHT | THROTTLE
"""Parameters that act only in flight, except the wing's: table ``[fit.body]`` of fit files."""

PER_FLIGHT = {
    "thrust_scale": 0.02,  # batteries, payloads and temperatures
    "clock_offset": 0.01,  # [s]; sensor filters cause delays of some milliseconds
    # [rad]; trim of the attitude, and tilt of the body frame of motion-capture markers
    "sensor_tilt_x": 0.01,
    "sensor_tilt_y": 0.01,
}
"""Parameters with one value per flight, as in ``thrust_scale[FLIGHT]``, and their prior standard
deviations over flights.

``tools.flight_bands`` varies the deviations of the sensor tilts and ``comparison.DRAG_DEVIATION``.
With the values in use, the interval score over held-out flights is within 4 % of the smallest."""

EVERY = ROTOR | BODY | WING | SENSOR | TURNING | WAKES | FLIGHT | THROTTLE
_NOT_ALWAYS = FLEX | INSTALLED | WAKES | THROTTLE
FIRST_GUESS = {name: p.start for name, p in EVERY.items() if name not in _NOT_ALWAYS}


LINEAR = (*BODY, *SENSOR, *TURNING, "thrust_scale")  # forces are linear in these parameters


def constants_of(section: Section) -> Airfoil:
    """Return the section law if it has the parameters of ``SECTION``; refuse a section table."""
    if isinstance(section, Airfoil):
        return section
    found = f"{section.name!r} is a section table, without constants such as c_l1"
    raise InputError(found, "give a parameter set: fits and simulated flights need constants")


@dataclass(frozen=True)
class Prior:
    """Normal prior distribution of a parameter.

    Attributes
    ----------
    mean, deviation : float
        Mean and standard deviation, in the unit of the parameter.
    """

    mean: float
    deviation: float


IN_FLIGHT = {name: Prior(*known) for name, known in _TABLES["in_flight"].items()}
"""Priors for fits of whole flights; the same priors for vehicles of all sizes."""


@dataclass(frozen=True)
class Choice:
    """Free parameters, fixed parameters, priors and starts of a fit.

    Attributes
    ----------
    free : tuple of str
        Names of the free parameters, in order.
    fixed : mapping of str to float
        Values of other parameters; parameters without a value have their first guess.
    priors : mapping of str to Prior
        Priors of free parameters.
    start : mapping of str to float
        Values from which the first search starts, instead of the first guesses.
    expected : SectionPrior, optional
        Prior from other propellers, for the free section constants without an entry in ``priors``.

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
            raise InputError("no parameter is free", f"name one or more of {', '.join(EVERY)}")
        for name in (*self.free, *self.fixed, *self.priors, *self.start):
            known(name)
        for name in self.free:
            if self.free.count(name) > 1:
                raise InputError(f"{name} is named twice as free", "name it once")
            if name in self.fixed:
                raise InputError(f"{name} is both free and fixed", "choose one")
        for name, prior in self.priors.items():
            if name not in self.free:
                raise InputError(f"{name} has a prior but is not free", f"free {name} as well")
            if not np.isfinite(prior.mean):
                raise InputError(f"the prior of {name} has no finite mean", "give a number")
            if not prior.deviation > 0.0:
                found = f"the prior of {name} has the standard deviation {prior.deviation:g}"
                raise InputError(found, "give one above zero, as in c_l2=2.0:0.3")
        for name, value in (*self.fixed.items(), *self.start.items()):
            p = described(name)
            if not p.lower <= value <= p.upper:
                fault = f"{name} is {value:g} {p.unit}"
                raise InputError(fault, f"give a value from {p.lower:g} to {p.upper:g}")

    def values(self, x: Floats) -> dict[str, float]:
        """Return all parameters by name.

        Parameters
        ----------
        x : ndarray, shape (P,)
            Values of the free parameters.
        """
        return {**FIRST_GUESS, **self.fixed, **dict(zip(self.free, x.tolist(), strict=True))}

    def column(self, attribute: str) -> Floats:
        """Return an ``attribute`` of ``Parameter``, for all free parameters (P,)."""
        return np.array([getattr(described(name), attribute) for name in self.free])

    def prior_of(self, name: str) -> Prior | None:
        """Return the prior of the free parameter ``name``; None without a prior."""
        if name in self.priors or self.expected is None:
            return self.priors.get(name)
        found = self.expected.of_constant(name)
        return Prior(*found) if found else None

    def prior_residuals(self, x: Floats) -> tuple[Floats, Floats]:
        """Return the residuals (K,) of K priors at ``x`` (P,), of unit variance; slopes (K, P)."""
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
        """Start of the first search (P,)."""
        return np.array([self.start.get(name, described(name).start) for name in self.free])


def general(name: str) -> str:
    """Return ``name`` without its suffix ``[FLIGHT]``, if any."""
    head, bracket, flight = name.partition("[")
    return head if bracket and head in PER_FLIGHT and flight[:-1] and flight[-1] == "]" else name


def of_flight(name: str, flight: str) -> str:
    """Return the name of the parameter ``name`` of one ``flight``."""
    return f"{name}[{flight}]"


def described(name: str) -> Parameter:
    """Return the parameter called ``name``, with or without a suffix ``[FLIGHT]``."""
    return EVERY[general(name)]


def known(name: str) -> str:
    """Return ``name`` if it is a parameter; raise ``InputError`` with similar names otherwise."""
    if general(name) not in EVERY:
        close = difflib.get_close_matches(name, EVERY, n=2) or list(EVERY)
        raise InputError(f"{quoted(name)} is not a parameter", f"choose from {', '.join(close)}")
    return name


SMALLEST = 1e-6  # replaces constants at their bound of 0, which have no logarithm

LEAST_ERROR = 0.03
"""Least standard deviation of residuals as a share of their scale, in fits with a ``SectionPrior``.
No stand and no model is more accurate, even if a fit to few rows leaves smaller residuals.  With
this value, the 95 % intervals after a fit to static rows contain 95 % of a propeller's flight rows:
``python -m tools.after_static``."""

LEAST_IN_FLIGHT = 0.01
"""``LEAST_ERROR`` of the forces in whole flights, as a share of the weight.  It is smaller because
side forces are a few hundredths of the weight.  Also, each segment of correlated samples counts as
one measurement."""


@dataclass(frozen=True, eq=False)
class SectionPrior:
    """Distribution of section constants over propellers, as the prior of one propeller.

    The constants are correlated.  ``zero_lift_angle`` + ``drag_angle``, the angle of least pressure
    drag from the chord line, is similar for all propellers: one falls as the other rises.

    Attributes
    ----------
    distribution : PopulationPrior
        Distribution of the coordinates: the transformed constants that are distributed normally.
    airfoil : Airfoil
        Most likely constants.
    source : str
        One line that names the propellers of the distribution.
    """

    distribution: PopulationPrior
    airfoil: Airfoil
    source: str

    def z_scores(self, values: Mapping[str, float]) -> tuple[Floats, Floats]:
        """Return the z-scores (P,) of the coordinates of the constants ``values``, in the order of
        ``PARAMETERS``, and their derivatives (P, P)."""
        constants = np.array([values[name] for name in PARAMETERS])
        inside = np.where(LOGARITHMIC, np.maximum(constants, SMALLEST), constants)
        place = coordinates(inside)
        deviation = self.distribution.deviation
        slopes = np.linalg.inv(slopes_of(place)) / deviation[:, None]
        return (place - self.distribution.mean) / deviation, slopes

    def penalty(self, values: Mapping[str, float], kept: Sequence[int]) -> tuple[Floats, Floats]:
        """Return residuals (K,) of the coordinates ``kept`` at ``values``, and slopes (K, P).

        In this distribution, the residuals are independent and have the variance 1.
        """
        scores, slopes = self.z_scores(values)
        own = list(kept)
        root = np.linalg.cholesky(self.distribution.correlation[np.ix_(own, own)])
        return np.linalg.solve(root, scores[own]), np.linalg.solve(root, slopes[own])

    def of_constant(self, name: str) -> tuple[float, float] | None:
        """Return mean and standard deviation of the constant ``name``; None for another name."""
        if name not in PARAMETERS:
            return None
        k = PARAMETERS.index(name)
        place = self.distribution.mean
        slopes = slopes_of(place)[k]
        variance = slopes @ self.distribution.covariance @ slopes
        return float(prior_constants(place)[k]), float(np.sqrt(variance))
