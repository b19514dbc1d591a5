"""A study: designs derived from a baseline propeller, evaluated in tasks like a sweep."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from propmap.errors import InputError
from propmap.io.csv import OperatingPoints
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.sweep.points import AXES, Place
from propmap.sweep.run import Evaluation, Values
from propmap.typing import Floats

POINTS_PER_TASK = 8192  # operating points of all designs of a task: some seconds on one core
SAMPLE = 4  # designs whose evaluation is timed to predict the time of a study

GEOMETRY = {
    "diameter": ("m", "of the propeller"),
    "pitch": ("m", "of the blade at three quarters of the radius"),
    "chord_scale": ("1", "of all chords relative to the baseline blade"),
    "twist_scale": ("1", "of the twist differences relative to the baseline blade"),
    "blades": ("1", "of the propeller"),
}  # variables of the propeller: unit and meaning

OPERATION = {name: (unit, meaning) for name, unit, meaning in AXES.values()}
"""Unit and meaning of the variables of the operating point."""

VARIABLES = {**GEOMETRY, **OPERATION}

MOST_DESIGNS = 100_000_000


class Designs(NamedTuple):
    """The designs and operating points of one task."""

    rows: dict[str, Floats]  # varied values (n,) by name
    axes: dict[str, Floats]  # values shared by all designs, by name


@dataclass(frozen=True, eq=False)
class Study(Evaluation):
    """The designs of a study and the operating points at which each design is evaluated.

    Attributes
    ----------
    rotor : Rotor
        Baseline design; all designs have its section law, air and corrections.
    varied : mapping of str to ndarray
        Values of the varied variables: "diameter" and "pitch" [m], "chord_scale", "twist_scale",
        "blades" [-], "rpm" [1/min], "speed_mps" and "beta_deg".  A full factorial uses all values.
        A Latin hypercube uses only the least and the largest value of each variable, except
        "blades", of which it uses all values.
    axes : mapping of str to ndarray
        Values of "rpm", "speed_mps" and "beta_deg" if they are not varied: every design is
        evaluated at all combinations.
    designs : int or None
        Number of designs of a Latin hypercube; None for the full factorial.
    seed : int
        Seed of the Latin hypercube.
    points_per_task : int
        Largest number of operating points per task.

    Raises
    ------
    InputError
        For an invalid combination of values, and for an impossible blade.
    """

    rotor: Rotor
    varied: Mapping[str, Floats]
    axes: Mapping[str, Floats]
    designs: int | None = None
    seed: int = 1
    points_per_task: int = POINTS_PER_TASK
    kind = "study"
    bands = by_source = False

    def __post_init__(self) -> None:
        if not self.varied:
            raise InputError("nothing varies", f"vary one or more of {', '.join(VARIABLES)}")
        for name in OPERATION:
            if (name in self.varied) == (name in self.axes):
                times = "twice" if name in self.axes else "nowhere"
                raise InputError(f"{name} is given {times}", "give it once, in [vary] or [points]")
        for name, values in [*self.varied.items(), *self.axes.items()]:
            _check_values(name, values)
            both = self.designs is not None and name in self.varied and name != "blades"
            if both and values.size != 2:
                found = f"{name} has {values.size} values"
                raise InputError(found, "give a Latin hypercube two values: least and largest")
        if self.designs is not None and not 2 <= self.designs <= MOST_DESIGNS:
            raise InputError(f"designs is {self.designs}", f"give 2 to {MOST_DESIGNS}")
        if self.count > MOST_DESIGNS:
            found = f"all combinations make {self.count} designs"
            raise InputError(found, "give fewer values of each variable")
        ends = {n: np.unique(v[[0, -1]]) for n, v in self.varied.items() if n in GEOMETRY}
        for corner in itertools.product(*ends.values()):
            self.design(dict(zip(ends, corner, strict=True)))

    @property
    def count(self) -> int:
        """Number of designs."""
        return self.designs or math.prod(values.size for values in self.varied.values())

    @cached_property
    def rows(self) -> dict[str, Floats]:
        """Values of each variable at all designs (n,), by name."""
        names = list(self.varied)
        if self.designs is None:
            mesh = np.meshgrid(*self.varied.values(), indexing="ij")
            return {name: axis.ravel() for name, axis in zip(names, mesh, strict=True)}
        from scipy.stats import qmc

        sampler = qmc.LatinHypercube(len(names), rng=np.random.default_rng(self.seed))
        unit = sampler.random(self.designs)
        found = {}
        for name, share in zip(names, unit.T, strict=True):
            values = self.varied[name]
            if name == "blades":
                found[name] = values[np.minimum((share * values.size).astype(int), values.size - 1)]
            else:
                found[name] = values[0] + share * (values[1] - values[0])
        return found

    @property
    def dims(self) -> tuple[str, ...]:
        """ "design", then the dimensions of the shared operating points."""
        return ("design", *(dim for dim, (name, _, _) in AXES.items() if name in self.axes))

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return (self.count, *(self.axes[name].size for name in OPERATION if name in self.axes))

    def coordinates(self) -> dict[str, tuple[tuple[str, ...], Floats, dict[str, str]]]:
        """Return the varied values along the designs, and the axes of shared operating points."""
        found = {name: ("design", values) for name, values in self.rows.items()}
        found |= {
            name: (dim, self.axes[name]) for dim, (name, _, _) in AXES.items() if name in self.axes
        }
        texts = {n: (unit, f"{n} {meaning}") for n, (unit, meaning) in GEOMETRY.items()} | OPERATION
        return {
            name: ((dim,), values, dict(zip(("units", "long_name"), texts[name], strict=True)))
            for name, (dim, values) in found.items()
        }

    def described(self, command: str) -> dict[str, Any]:
        """Return the attributes of a file with the results of this ``command``."""
        title = f"Designs made from {self.rotor.model.propeller.name}"
        random = f"Latin hypercube, seed {self.seed}"
        sampling = "full factorial" if self.designs is None else random
        return {**super().described(command), "title": title, "sampling": sampling}

    def part(self, place: Place, chunk: tuple[int, ...]) -> Designs:
        """Return designs and points of the task at this ``place``; tasks have shape ``chunk``."""
        cuts = [slice(k * n, (k + 1) * n) for k, n in zip(place, chunk, strict=True)]
        rows = {name: values[cuts[0]] for name, values in self.rows.items()}
        names = [name for name in OPERATION if name in self.axes]
        axes = {name: self.axes[name][cut] for name, cut in zip(names, cuts[1:], strict=True)}
        return Designs(rows, axes)

    def sample(self) -> tuple[Designs, int]:
        """Return evenly chosen designs at all operating points, and the number of points."""
        some = np.unique(np.linspace(0, self.count - 1, SAMPLE).astype(int))
        rows = {name: values[some] for name, values in self.rows.items()}
        return Designs(rows, dict(self.axes)), some.size * math.prod(self.shape[1:])

    def batches(self, part: Designs) -> Iterator[tuple[Rotor, OperatingPoints]]:
        """Yield each design of a ``part`` with its operating points."""
        for row in zip(*part.rows.values(), strict=True):
            values = dict(zip(part.rows, map(float, row), strict=True))
            axes = [part.axes.get(name, np.array([values.get(name, 0.0)])) for name in OPERATION]
            w, v, b = np.meshgrid(*axes, indexing="ij")
            yield self.design(values), OperatingPoints(w, v, b)

    def values(self, part: Designs) -> Values:
        """Return the quantities to store for a ``part``, over the designs and the shared axes."""
        shape = [part.axes[name].size for name in OPERATION if name in part.axes]
        found = super().values(part)
        return {name: values.reshape(len(values), *shape) for name, values in found.items()}

    def design(self, values: Mapping[str, float]) -> Rotor:
        """Return the rotor of the design with these ``values`` by name."""
        geometry: Any = {name: float(v) for name, v in values.items() if name in GEOMETRY}
        if "blades" in geometry:
            geometry["blades"] = round(geometry["blades"])
        model = self.rotor.model
        try:
            blade = changed_blade(model.propeller, **geometry)
            return self.rotor.with_model(replace(model, propeller=blade))
        except InputError as error:
            differing = ", ".join(f"{name} {value:.4g}" for name, value in geometry.items())
            raise InputError(f"the design with {differing}: {error}") from None

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in vars(self).items() if key != "rows"}


def _check_values(name: str, values: Floats) -> None:
    if name not in VARIABLES:
        raise InputError(f"{name} cannot vary", f"choose from {', '.join(VARIABLES)}")
    if values.ndim != 1 or not values.size or not np.isfinite(values).all():
        raise InputError(f"{name} is not a list of numbers", "give one or more numbers")
    if (np.diff(values) <= 0.0).any():
        raise InputError(f"the values of {name} do not increase", "sort them, each value once")
    if name == "blades" and (values != np.round(values)).any():
        raise InputError("blades has fractions", "give whole numbers, such as 2, 3, 4")
    if name != "beta_deg" and values[0] < 0.0:
        raise InputError(f"{name} is negative", "give 0 or more")


# --- Propellers derived from another one by changes of size, pitch, chord or twist ---------------

PITCH_AT = 0.75  # r/R of the nominal pitch


def pitch_of(blade: Propeller) -> float:
    """Return the pitch of a ``blade`` at three quarters of the radius, 2 pi r tan(theta) [m]."""
    radius = PITCH_AT * blade.radius
    return 2.0 * math.pi * radius * float(np.interp(radius, blade.station, np.tan(blade.twist)))


def changed_blade(
    blade: Propeller,
    *,
    diameter: float | None = None,
    pitch: float | None = None,
    chord_scale: float = 1.0,
    twist_scale: float = 1.0,
    blades: int | None = None,
) -> Propeller:
    """Return a propeller derived from another one.

    Parameters
    ----------
    blade : Propeller
        Original propeller.
    diameter : float, optional
        New diameter [m]; one factor scales all radii and chords.
    pitch : float, optional
        New pitch at three quarters of the radius [m].  One factor scales the tangents of all twist
        angles, and thereby the pitch at each station.  By default the pitch scales with the
        diameter.
    chord_scale : float
        Factor on all chords after the change of diameter [-].
    twist_scale : float
        Factor on the difference between the twist and the twist at three quarters of the radius
        [-]: 0 removes the twist, 1 keeps it.
    blades : int, optional
        New number of blades.

    Raises
    ------
    InputError
        For an impossible blade.
    """
    for name, value in (("diameter", diameter), ("pitch", pitch), ("chord_scale", chord_scale)):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} is {value}", "give a number above 0")
    size = 1.0 if diameter is None else diameter / blade.diameter
    station, twist = size * blade.station, blade.twist
    if pitch is not None:
        own = size * pitch_of(blade)
        if own <= 0.0:
            fault = f"the pitch of {blade.name} is {own:g} m"
            raise InputError(fault, "choose a propeller with positive pitch")
        twist = np.arctan(np.tan(twist) * (pitch / own))
    middle = np.arctan(np.interp(PITCH_AT * station[-1], station, np.tan(twist)))
    return replace(
        blade,
        blades=blade.blades if blades is None else blades,
        station=station,
        chord=size * chord_scale * blade.chord,
        twist=middle + twist_scale * (twist - middle),
        root_cutout=None if blade.root_cutout is None else size * blade.root_cutout,
    )
