"""The distribution of section constants over propellers, by expectation and maximisation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from propmap.catalogue.expected import POPULATION, Member, Population, covariates, likeness
from propmap.typing import Floats

STEPS = 100
"""Of the search from afar; ten are enough from close by."""


class _Family(NamedTuple):
    members: list[Member]
    where: Floats
    alike: Floats


class _Expected(NamedTuple):
    """Of one family, given the population: means and sums of squares."""

    mean: Floats
    squares: Floats
    own: Floats
    own_squares: Floats
    evidence: float


def population_of(
    members: Sequence[Member],
    errors: Floats,
    start: Population | None = None,
    steps: int = STEPS,
) -> tuple[Population, float]:
    """The population under which the data of ``members`` are most likely.

    Each member's coordinates are taken to be normal given its data.  A step of expectation and
    maximisation puts each member where its data and its siblings let expect it, and takes mean,
    trend and covariances from there (Dempster, Laird, Rubin, J. R. Stat. Soc. B 39, 1977).

    Parameters
    ----------
    members : sequence of Member
        Propellers of two families at least.
    errors : ndarray, shape (2,)
        Standard deviations of C_T and C_P [-] about the model, to be kept with the rest.
    start : Population, optional
        Where the search starts.
    steps : int
        How many it takes.

    Returns
    -------
    population : Population
        What was found.
    evidence : float
        Logarithm of the likelihood before the last step, but for what the data alone determine.
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
    families = _families(members)
    evidence = np.nan
    for _ in range(steps):
        told = [_expected(found, one) for one in families]
        evidence = sum(one.evidence for one in told)
        mean = np.mean([one.mean for one in told], axis=0)
        squares = [
            one.squares + np.outer(one.mean - found.mean, one.mean - found.mean) for one in told
        ]
        # Siblings that are alike say less of the trend.
        back = [np.linalg.inv(one.alike) for one in families]
        by = sum(f.where.T @ b @ f.where for f, b in zip(families, back, strict=True))
        towards = sum(
            (t.own + f.where @ found.trend.T).T @ b @ f.where
            for t, f, b in zip(told, families, back, strict=True)
        )
        found = Population(
            mean=mean,
            trend=np.linalg.solve(by, np.transpose(towards)).T,
            between=np.mean(squares, axis=0),
            within=np.sum([one.own_squares for one in told], axis=0) / len(members),
            low=found.low,
            high=found.high,
            errors=errors,
        )
    return found, float(evidence)


def _families(members: Sequence[Member]) -> list[_Family]:
    found: dict[str, list[Member]] = {}
    for one in members:
        found.setdefault(one.family, []).append(one)
    return [
        _Family(
            some,
            np.stack([covariates(one.size) for one in some]),
            likeness([one.size for one in some]),
        )
        for some in found.values()
    ]


def _expected(population: Population, family: _Family) -> _Expected:
    """The family's mean and its members' own parts, jointly normal."""
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
