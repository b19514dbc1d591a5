"""A study: designs made from a blade, evaluated in tasks as a sweep is."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from propmap.errors import InputError
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.sweep.points import AXES, Part, Place
from propmap.sweep.run import Evaluation, Values
from propmap.typing import Floats

POINTS_PER_TASK = 8192  # of all its designs: one to some seconds of one core
SAMPLE = 4  # designs by which the time of a study is predicted

GEOMETRY = {
    "diameter": ("m", "of the propeller"),
    "pitch": ("m", "of the blade at three quarters of the radius"),
    "chord_scale": ("1", "chords over those of the blade that the study begins with"),
    "twist_scale": ("1", "differences of twist over those of the blade that the study begins with"),
    "blades": ("1", "number of blades"),
}  # what may vary of a propeller: unit and meaning

OPERATION = {name: (unit, meaning) for name, unit, meaning in AXES.values()}
"""Unit and meaning of what may vary of an operating point."""

VARIABLES = {**GEOMETRY, **OPERATION}

MOST_DESIGNS = 100_000_000


class Designs(NamedTuple):
    """The designs and operating points of one task."""

    rows: dict[str, Floats]  # what varies (n,), by name
    axes: dict[str, Floats]  # values of the operating point that every design has, by name


@dataclass(frozen=True, eq=False)
class Study(Evaluation):
    """Which designs are evaluated at which operating points.

    Attributes
    ----------
    rotor : Rotor
        The design to begin with; all have its section law, air and corrections.
    varied : mapping of str to ndarray
        Values of what varies from design to design, by names of ``VARIABLES``: all levels of a
        full factorial; or least and largest of a Latin hypercube, but for ``blades``, of which
        it has all that are named.
    axes : mapping of str to ndarray
        Values of the rest of ``OPERATION``: every design is evaluated at all combinations.
    designs : int or None
        How many a Latin hypercube has; None for the full factorial.
    seed : int
        Seed of the Latin hypercube.
    points_per_task : int
        Operating points that are computed together, at most.

    Raises
    ------
    InputError
        Where these do not make a study, or a blade of it cannot be.
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
            raise InputError("nothing varies", f"give values of {', '.join(VARIABLES)}")
        for name in OPERATION:
            if (name in self.varied) == (name in self.axes):
                times = "twice" if name in self.axes else "nowhere"
                raise InputError(f"{name} is given {times}", "give it once, varied or as points")
        for name, values in [*self.varied.items(), *self.axes.items()]:
            _check_values(name, values)
            both = self.designs is not None and name in self.varied and name != "blades"
            if both and values.size != 2:
                found = f"{name} has {values.size} values"
                raise InputError(found, "a Latin hypercube takes two, from and to")
        if self.designs is not None and not 2 <= self.designs <= MOST_DESIGNS:
            raise InputError(f"designs is {self.designs}", f"give 2 to {MOST_DESIGNS}")
        if self.count > MOST_DESIGNS:
            found = f"all combinations are {self.count} designs"
            raise InputError(found, "give fewer values of each")
        ends = {n: np.unique(v[[0, -1]]) for n, v in self.varied.items() if n in GEOMETRY}
        for corner in itertools.product(*ends.values()):
            self.design(dict(zip(ends, corner, strict=True)))

    @property
    def count(self) -> int:
        """Number of designs."""
        return self.designs or math.prod(values.size for values in self.varied.values())

    @cached_property
    def rows(self) -> dict[str, Floats]:
        """What varies, by name, each (n,)."""
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
        """ "design", then those of the operating points that all designs share."""
        return ("design", *(dim for dim, (name, _, _) in AXES.items() if name in self.axes))

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return (self.count, *(self.axes[name].size for name in OPERATION if name in self.axes))

    def coordinates(self) -> dict[str, tuple[tuple[str, ...], Floats, dict[str, str]]]:
        """What varies, along the designs, and the axes of the operating points they share."""
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
        """Attributes of a file with the results, asked for by this ``command``."""
        title = f"Designs made from {self.rotor.model.propeller.name}"
        random = f"Latin hypercube, seed {self.seed}"
        sampling = "full factorial" if self.designs is None else random
        return {**super().described(command), "title": title, "sampling": sampling}

    def part(self, place: Place, chunk: tuple[int, ...]) -> Designs:
        """Designs and points of the task at this ``place``; tasks have the shape ``chunk``."""
        cuts = [slice(k * n, (k + 1) * n) for k, n in zip(place, chunk, strict=True)]
        rows = {name: values[cuts[0]] for name, values in self.rows.items()}
        names = [name for name in OPERATION if name in self.axes]
        axes = {name: self.axes[name][cut] for name, cut in zip(names, cuts[1:], strict=True)}
        return Designs(rows, axes)

    def sample(self) -> tuple[Designs, int]:
        """Designs spread over all, at all operating points."""
        some = np.unique(np.linspace(0, self.count - 1, SAMPLE).astype(int))
        rows = {name: values[some] for name, values in self.rows.items()}
        return Designs(rows, dict(self.axes)), some.size * math.prod(self.shape[1:])

    def batches(self, part: Designs) -> Iterator[tuple[Rotor, Part]]:
        """Each design of a ``part`` with its operating points."""
        for row in zip(*part.rows.values(), strict=True):
            values = dict(zip(part.rows, map(float, row), strict=True))
            axes = [part.axes.get(name, np.array([values.get(name, 0.0)])) for name in OPERATION]
            yield self.design(values), Part(*np.meshgrid(*axes, indexing="ij"))

    def values(self, part: Designs) -> Values:
        """What is filed of a ``part``, over the designs and the axes that they share."""
        shape = [part.axes[name].size for name in OPERATION if name in part.axes]
        found = super().values(part)
        return {name: values.reshape(len(values), *shape) for name, values in found.items()}

    def design(self, values: Mapping[str, float]) -> Rotor:
        """The rotor of the design that differs from the first one by ``values``, by name."""
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
        raise InputError(f"{name} cannot vary", f"known are {', '.join(VARIABLES)}")
    if values.ndim != 1 or not values.size or not np.isfinite(values).all():
        raise InputError(f"{name} is no list of numbers", "give one or more")
    if (np.diff(values) <= 0.0).any():
        raise InputError(f"the values of {name} do not rise", "write each once, rising")
    if name == "blades" and (values != np.round(values)).any():
        raise InputError("blades are whole numbers", "give them as 2, 3, 4")
    if name != "beta_deg" and values[0] < 0.0:
        raise InputError(f"{name} is negative", "give 0 or more")


# -------------------------------------------------------------------------------------------------
# Blades made from another: of another size, pitch, width or twist.

PITCH_AT = 0.75  # share of the radius at which a blade's pitch is taken


def pitch_of(blade: Propeller) -> float:
    """The pitch of a ``blade`` at three quarters of the radius, 2 pi r tan(theta) [m]."""
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
    """A propeller made from another.

    Parameters
    ----------
    blade : Propeller
        The one to begin with.
    diameter : float, optional
        [m]; radii and chords grow by one factor.
    pitch : float, optional
        At three quarters of the radius [m]; the tangents of all twists change by one factor, so
        that the pitch of each station does. By default it grows with the diameter.
    chord_scale : float
        Factor on all chords, after the diameter [-].
    twist_scale : float
        Factor on what the twist differs by from that at three quarters of the radius [-]: 0 is a
        blade without twist, 1 leaves it.
    blades : int, optional
        How many.

    Raises
    ------
    InputError
        For a blade that cannot be.
    """
    for name, value in (("diameter", diameter), ("pitch", pitch), ("chord_scale", chord_scale)):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} is {value}", "give a number above 0")
    size = 1.0 if diameter is None else diameter / blade.diameter
    station, twist = size * blade.station, blade.twist
    if pitch is not None:
        own = size * pitch_of(blade)
        if own <= 0.0:
            raise InputError(f"the pitch of {blade.name} is {own:g} m", "begin with another blade")
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
