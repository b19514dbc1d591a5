"""What a study varies: designs by a Latin hypercube or all combinations, and operating points."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from propmap.errors import InputError
from propmap.rotor import Rotor
from propmap.study.changed_blade import changed_blade
from propmap.sweep.points import Place
from propmap.sweep.quantities import AXES
from propmap.typing import Floats

GEOMETRY = {
    "diameter": ("m", "of the propeller"),
    "pitch": ("m", "of the blade at three quarters of the radius"),
    "chord_scale": ("1", "chords over those of the blade that the study begins with"),
    "twist_scale": ("1", "differences of twist over those of the blade that the study begins with"),
    "blades": ("1", "number of blades"),
}
"""What may vary of a propeller: unit and meaning."""

OPERATION = {name: (unit, meaning) for name, unit, meaning in AXES.values()}
"""The same of an operating point."""

VARIABLES = {**GEOMETRY, **OPERATION}

MOST_DESIGNS = 100_000_000


class Designs(NamedTuple):
    """The designs and operating points of one task.

    Attributes
    ----------
    rows : dict of str to ndarray, shape (n,)
        What varies, by name.
    axes : dict of str to ndarray
        Values of the operating point that every design is evaluated at, by name.
    """

    rows: dict[str, Floats]
    axes: dict[str, Floats]


@dataclass(frozen=True, eq=False)
class Study:
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
        Of the Latin hypercube.

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
                raise InputError(
                    f"{name} has {values.size} values", "a Latin hypercube takes two, from and to"
                )
        if self.designs is not None and not 2 <= self.designs <= MOST_DESIGNS:
            raise InputError(f"designs is {self.designs}", f"give 2 to {MOST_DESIGNS}")
        if self.count > MOST_DESIGNS:
            raise InputError(
                f"all combinations are {self.count} designs", "give fewer values of each"
            )
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

    def part(self, place: Place, chunk: tuple[int, ...]) -> Designs:
        """Designs and points of the task at this ``place``; tasks have the shape ``chunk``."""
        cuts = [slice(k * n, (k + 1) * n) for k, n in zip(place, chunk, strict=True)]
        rows = {name: values[cuts[0]] for name, values in self.rows.items()}
        names = [name for name in OPERATION if name in self.axes]
        axes = {name: self.axes[name][cut] for name, cut in zip(names, cuts[1:], strict=True)}
        return Designs(rows, axes)

    def design(self, values: Mapping[str, float]) -> Rotor:
        """The rotor of a design.

        Parameters
        ----------
        values : mapping of str to float
            What differs from the first one, by name; those of operating points do not matter.
        """
        from dataclasses import replace

        geometry: Any = {name: float(v) for name, v in values.items() if name in GEOMETRY}
        if "blades" in geometry:
            geometry["blades"] = round(geometry["blades"])
        model = self.rotor.model
        try:
            blade = changed_blade(model.propeller, **geometry)
            return self.rotor.with_model(replace(model, propeller=blade))
        except InputError as error:
            told = ", ".join(f"{name} {value:.4g}" for name, value in geometry.items())
            raise InputError(f"the design with {told}: {error}") from None

    def __getstate__(self) -> dict[str, Any]:
        """What workers need: each task brings its own designs."""
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
