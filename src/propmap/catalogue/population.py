"""How section constants are spread over small propellers: by size, between families, within them.

A propeller's coordinates are the mean of its family, a trend by size common to all families, and a
part of its own, which is like that of its siblings of a similar size.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from pathlib import Path

import numpy as np

from propmap.typing import Floats

MIDDLE = (0.2286, 0.6)
"""Diameter [m] and pitch over diameter at which a family's mean is stated."""

ALIKE = (0.4, 0.3)
"""Standard deviations of the bell by which likeness falls with the distance between siblings in the
logarithm of the diameter and in pitch over diameter; with ``APART``, those of the largest
likelihood on a grid, over all three populations."""

APART = 0.25
"""Share of the variance within families in which siblings of one size differ."""

GEOMETRIES = ("measured", "family", "population")
"""Which blade the constants of a population belong to, as in ``Identified.geometry``."""

Size = tuple[float, float]
"""Labelled diameter and pitch [m]."""


@dataclass(frozen=True, eq=False)
class Population:
    """A normal distribution over propellers of the coordinates of ``prior.PopulationPrior``.

    Attributes
    ----------
    mean : ndarray, shape (7,)
        Over families, of a propeller of the size ``MIDDLE``.
    trend : ndarray, shape (7, 2)
        By the logarithm of the diameter, and by pitch over diameter.
    between, within : ndarray, shape (7, 7)
        Covariance of families' means, and of propellers about that of their family.
    low, high : ndarray, shape (2,)
        Range of the two in the data; the trend ends there.
    errors : ndarray, shape (2,)
        Standard deviations of C_T and C_P [-] about the model with the best constants.
    """

    mean: Floats
    trend: Floats
    between: Floats
    within: Floats
    low: Floats
    high: Floats
    errors: Floats

    def shift(self, size: Size) -> Floats:
        """What the trend adds to the coordinates at a ``size``, (7,)."""
        return self.trend @ np.clip(covariates(size), self.low, self.high)


def covariates(size: Size) -> Floats:
    """Logarithm of the diameter, and pitch over diameter, from ``MIDDLE``, (2,)."""
    diameter, pitch = size
    return np.array([np.log(diameter / MIDDLE[0]), pitch / diameter - MIDDLE[1]])


def likeness(sizes: Sequence[Size]) -> Floats:
    """Correlation (n, n) of siblings about their family's mean; of one size, 1 - ``APART``."""
    place = np.stack([covariates(size) for size in sizes]) / ALIKE
    distance = ((place[:, None] - place[None]) ** 2).sum(axis=-1)
    return (1.0 - APART) * np.exp(-0.5 * distance) + APART * np.eye(len(place))


def bundled_population(geometry: str = "measured") -> Population:
    """The population of propellers whose blade is known, or is expected: one of ``GEOMETRIES``."""
    return _bundled()[geometry]


def as_toml(populations: Mapping[str, Population]) -> str:
    """The text of a file that ``parse_populations`` reads."""
    lines = ["# Written by `propmap fit catalogue`; see propmap.catalogue.population."]
    for name, one in populations.items():
        lines += ["", f"[{name}]"]
        lines += [f"{f.name} = {_listed(getattr(one, f.name))}" for f in fields(one)]
    return "\n".join(lines) + "\n"


def parse_populations(text: str) -> dict[str, Population]:
    """The populations of a file's ``text``, by the blade that their constants belong to."""
    return {
        name: Population(**{key: np.array(value) for key, value in table.items()})
        for name, table in tomllib.loads(text).items()
    }


def _listed(values: Floats) -> str:
    if values.ndim == 1:
        return "[" + ", ".join(f"{value:.8e}" for value in values) + "]"
    return "[\n" + "".join(f"  {_listed(row)},\n" for row in values) + "]"


@lru_cache(maxsize=1)
def _bundled() -> dict[str, Population]:
    file = Path(__file__).parent / "identified" / "population.toml"
    return parse_populations(file.read_text(encoding="utf-8"))
