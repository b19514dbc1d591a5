"""Distribution of section constants over propellers, by expectation maximization.

There are three populations, one for each of ``GEOMETRIES``.  They contain the constants for the
measured blades, for mean blades of the family, and for mean blades of all families.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from propmap import catalogue
from propmap.catalogue.apc import apc_blades
from propmap.catalogue.designation import designation
from propmap.catalogue.expected import (
    GEOMETRIES,
    POPULATION,
    MeanBlade,
    MeasuredShape,
    Member,
    Population,
    covariates,
    label_size,
    likeness,
    mean_blade,
    measured_shapes,
    member,
    on_mean_blade,
)
from propmap.catalogue.identified import Identified, one_of_each
from propmap.tasks import InTurn, Workers, in_order
from propmap.typing import Floats

STEPS = 100
"""Steps from the default start; from a similar population, ten are enough."""


def populations_of(
    entries: Sequence[Identified], workers: Workers | None = None
) -> dict[str, Population]:
    """Estimate the populations from ``entries`` with measured blades, of at least two families."""
    members = all_members(entries)
    tasks = list(members.values())
    found = in_order((workers or InTurn()).results(_population, errors_of(entries), tasks))
    return dict(zip(members, found, strict=True))


def _population(errors: Floats, members: Sequence[Member]) -> Population:
    return population_of(members, errors)[0]


def all_members(entries: Sequence[Identified]) -> dict[str, list[Member]]:
    """Return all members of each population, by ``GEOMETRIES``.

    The mean blade of a propeller excludes its own blade, so the spread over propellers includes the
    error of a mean blade.  Without another measured blade of its family, a propeller is not in the
    population "family".
    """
    found: dict[str, list[Member]] = {name: [] for name in GEOMETRIES}
    for one in _counted(entries):
        found["measured"].append(member(one))
        others = shapes_without(catalogue.entry(one.propeller))
        if one.family in {other.family for other in others}:
            found["family"].append(on_mean_blade(one, mean_blade(others, [one.family])))
        found["population"].append(on_mean_blade(one, mean_blade(others)))
    return found


def shapes_without(entry: catalogue.Entry) -> list[MeasuredShape]:
    """Return ``measured_shapes`` without the propeller with the blade ``entry``."""
    label = designation(entry.title)
    own = label and (entry.family, label_size(label))
    return [one for one in measured_shapes() if (one.family, one.size) != own]


def members_on(entries: Sequence[Identified], family: str, shape: MeanBlade) -> list[Member]:
    """Return the members of a ``family``, with constants for a blade of this ``shape``."""
    return [on_mean_blade(one, shape) for one in one_of_each(entries) if one.family == family]


def errors_of(entries: Sequence[Identified]) -> Floats:
    """Return the rms over propellers of the residual errors of C_T and C_P [-], (2,)."""
    each = [one.discrepancy for one in _counted(entries)]
    return np.sqrt(np.mean(np.square(each), axis=0))


def _counted(entries: Sequence[Identified]) -> list[Identified]:
    """Return one entry per propeller, without blades from APC's files.

    The errors of these blades are no spread of section constants.
    """
    return [one for one in one_of_each(entries) if one.propeller not in apc_blades()]


class _Family(NamedTuple):
    members: list[Member]
    where: Floats  # covariates (n, 2)
    alike: Floats  # likeness (n, n)


class _Expected(NamedTuple):
    """Expectations of one family of n members, given the population."""

    mean: Floats  # mean of the family, (P,)
    squares: Floats  # covariance of this mean, (P, P)
    own: Floats  # deviations of the members from this mean and the trend, (n, P)
    own_squares: Floats  # sum of their squares, weighted by the inverse likeness, (P, P)
    evidence: float


def population_of(
    members: Sequence[Member],
    errors: Floats,
    start: Population | None = None,
    steps: int = STEPS,
) -> tuple[Population, float]:
    """Return the maximum-likelihood population of ``members``, and its log likelihood.

    The data of each member determine its coordinates with normal errors.  Each step first computes
    the expected coordinates of the members from their data, their family and the population.  Then
    it estimates mean, trend and covariances from these expectations (Dempster, Laird, Rubin,
    J. R. Stat. Soc. B 39, 1977).  The log likelihood is that before the last step, without terms
    that depend only on the data.  ``errors`` (2,) of C_T and C_P [-] are stored in the population.
    """
    where = np.stack([covariates(one.size) for one in members])
    spread = np.diag(POPULATION.deviation**2)
    found = Population(
        mean=start.mean if start else POPULATION.mean,
        trend=start.trend if start else np.zeros((POPULATION.mean.size, 2)),
        between=start.between if start else 0.6 * spread,
        within=start.within if start else 0.3 * spread,
        low=where.min(axis=0),
        high=where.max(axis=0),
        errors=errors,
    )
    by_family: dict[str, list[Member]] = {}
    for one in members:
        by_family.setdefault(one.family, []).append(one)
    families = [
        _Family(
            some,
            np.stack([covariates(one.size) for one in some]),
            likeness([one.size for one in some]),
        )
        for some in by_family.values()
    ]
    evidence = np.nan
    for _ in range(steps):
        expected = [_expected(found, family) for family in families]
        evidence = sum(one.evidence for one in expected)
        squares = [
            one.squares + np.outer(one.mean - found.mean, one.mean - found.mean) for one in expected
        ]
        # The weights account for correlation: members of similar size carry less information.
        back = [np.linalg.inv(family.alike) for family in families]
        by = sum(f.where.T @ b @ f.where for f, b in zip(families, back, strict=True))
        towards = sum(
            (e.own + f.where @ found.trend.T).T @ b @ f.where
            for e, f, b in zip(expected, families, back, strict=True)
        )
        found = Population(
            mean=np.mean([one.mean for one in expected], axis=0),
            trend=np.linalg.solve(by, np.transpose(towards)).T,
            between=np.mean(squares, axis=0),
            within=np.sum([one.own_squares for one in expected], axis=0) / len(members),
            low=found.low,
            high=found.high,
            errors=errors,
        )
    return found, float(evidence)


def _expected(population: Population, family: _Family) -> _Expected:
    """Return the joint expectation of the mean of a ``family`` and its members' deviations."""
    k, n = population.mean.size, len(family.members)
    between, alike = np.linalg.inv(population.between), np.linalg.inv(family.alike)
    precision = np.zeros(((n + 1) * k, (n + 1) * k))
    precision[:k, :k] = between
    precision[k:, k:] = np.kron(alike, np.linalg.inv(population.within))
    pull = np.zeros((n + 1) * k)
    pull[:k] = between @ population.mean
    evidence = -0.5 * population.mean @ between @ population.mean
    evidence -= 0.5 * (np.linalg.slogdet(population.between)[1])
    evidence -= 0.5 * (
        n * np.linalg.slogdet(population.within)[1] + k * np.linalg.slogdet(family.alike)[1]
    )
    for j, one in enumerate(family.members):
        shift = population.shift(one.size)
        places = slice(0, k), slice((j + 1) * k, (j + 2) * k)
        left = one.pull - one.precision @ shift
        evidence += shift @ (one.pull + left) / 2.0
        for a in places:
            pull[a] += left
            for b in places:
                precision[a, b] += one.precision
    covariance = np.asarray(np.linalg.inv(precision), float)
    place = covariance @ pull
    evidence += 0.5 * pull @ place - 0.5 * np.linalg.slogdet(precision)[1]
    own = place[k:].reshape(n, k)
    spread = covariance[k:, k:].reshape(n, k, n, k)
    return _Expected(
        mean=place[:k],
        squares=covariance[:k, :k],
        own=own,
        own_squares=np.einsum("ij,iajb->ab", alike, spread) + own.T @ alike @ own,
        evidence=float(evidence),
    )
