"""What identified propellers say of one that is not: of its family, or of any."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from propmap.catalogue.identified import Identified
from propmap.catalogue.population import Population, Size, likeness
from propmap.catalogue.prior import POPULATION, PopulationPrior, coordinate_covariance, coordinates
from propmap.typing import Floats


class Member(NamedTuple):
    """What one propeller's own data say, without its prior: exp(pull x - x precision x / 2).

    Attributes
    ----------
    family, tested : str
        Code of its series, and what the source calls it.
    size : tuple of float
        Labelled diameter and pitch [m].
    precision : ndarray, shape (7, 7)
        Of its coordinates; singular where its data say nothing of some.
    pull : ndarray, shape (7,)
        ``precision`` times the coordinates that fit best.
    """

    family: str
    tested: str
    size: Size
    precision: Floats
    pull: Floats

    def moved(self, shift: Floats) -> Member:
        """The same with ``shift`` (7,) added to its coordinates."""
        return self._replace(pull=self.pull + self.precision @ shift)


def member(one: Identified, prior: PopulationPrior = POPULATION) -> Member:
    """What the data of ``one`` say, which was identified with this ``prior``."""
    place = coordinates(one.constants)
    both = np.linalg.inv(coordinate_covariance(one.constants, one.covariance))
    before = np.linalg.inv(prior.covariance)
    values, vectors = np.linalg.eigh(both - before)
    # Data say nothing where rounding makes them say less.
    precision = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return Member(one.family, one.tested, one.size, precision, both @ place - before @ prior.mean)


def family_prior(members: Sequence[Member], population: Population, size: Size) -> PopulationPrior:
    """The distribution of a further propeller of the family of which ``members`` are known.

    The normal distribution of its coordinates, given theirs, as ``Population`` puts them together:
    siblings of a similar size say the most.  Without members it is that over all propellers.

    Parameters
    ----------
    members : sequence of Member
        Other propellers of the family.
    population : Population
        Of families and within them.
    size : tuple of float
        Labelled diameter and pitch [m].
    """
    own = population.mean + population.shift(size)
    alike = likeness([*(one.size for one in members), size])
    joint = np.kron(np.ones_like(alike), population.between) + np.kron(alike, population.within)
    if not members:
        return PopulationPrior.of(own, joint)
    known = own.size * len(members)
    precision = np.zeros((known, known))
    for k, one in enumerate(members):
        place = slice(k * own.size, (k + 1) * own.size)
        precision[place, place] = one.precision
    centre = np.concatenate([population.mean + population.shift(one.size) for one in members])
    pull = np.concatenate([one.pull for one in members]) - precision @ centre
    towards = joint[known:, :known] @ np.linalg.inv(
        np.eye(known) + precision @ joint[:known, :known]
    )
    covariance = joint[known:, known:] - towards @ precision @ joint[:known, known:]
    return PopulationPrior.of(own + towards @ pull, 0.5 * (covariance + covariance.T))
