"""Populations: of made-up propellers the truth is found again, and settings are the likeliest."""

from __future__ import annotations

import numpy as np

import propmap.catalogue.expected as settings
from propmap.catalogue.expected import (
    POPULATION,
    Member,
    Population,
    Size,
    coordinate_covariance,
    coordinates,
    family_prior,
    likeness,
    member,
)
from propmap.catalogue.identified import all_identified
from propmap.typing import Floats
from tools.catalogue.population import population_of

DEVIATION = POPULATION.deviation
SIZES: list[Size] = [(0.13, 0.09), (0.23, 0.11), (0.25, 0.18), (0.36, 0.30)]


def correlated(scale: float, correlation: float) -> Floats:
    own = np.eye(DEVIATION.size)
    one = correlation * (1.0 - own) + own
    return scale**2 * np.outer(DEVIATION, DEVIATION) * one


TRUTH = Population(
    mean=POPULATION.mean + 0.3 * DEVIATION,
    trend=np.stack([0.5 * DEVIATION, -1.0 * DEVIATION], axis=1),
    between=correlated(0.8, 0.3),
    within=correlated(0.4, -0.1),
    low=np.array([-1.0, -1.0]),
    high=np.array([1.0, 1.0]),
    errors=np.array([0.003, 0.002]),
)


def drawn(families: int, error: float) -> tuple[list[Member], list[Floats]]:
    """Propellers of ``TRUTH`` in the sizes of ``SIZES``, and where they are."""
    rng = np.random.default_rng(27)
    alike = np.linalg.cholesky(likeness(SIZES))
    roots = [np.linalg.cholesky(part) for part in (TRUTH.between, TRUTH.within)]
    precision = np.diag((error * DEVIATION) ** -2)
    found, places = [], []
    for family in range(families):
        center = TRUTH.mean + roots[0] @ rng.normal(size=DEVIATION.size)
        own = alike @ rng.normal(size=(len(SIZES), DEVIATION.size)) @ roots[1].T
        for size, part in zip(SIZES, own, strict=True):
            place = center + TRUTH.shift(size) + part
            seen = place + error * DEVIATION * rng.normal(size=DEVIATION.size)
            found.append(Member(str(family), str(size), size, precision, precision @ seen))
            places.append(place)
    return found, places


def test_the_population_of_made_up_propellers_is_found_again() -> None:
    """And the evidence grows with every step."""
    members, told = drawn(150, 0.1)[0], []
    found: Population | None = None
    for _ in range(20):
        found, evidence = population_of(members, TRUTH.errors, found, 1)
        told.append(evidence)
    assert found is not None and told[-1] > told[0] + 1.0
    assert (np.diff(told) > -1e-9 * np.abs(told[-1])).all()
    # Four standard deviations of 150 families' sample variance are 0.3 of it.
    np.testing.assert_allclose((found.mean - TRUTH.mean) / DEVIATION, 0.0, atol=0.25)
    np.testing.assert_allclose((found.trend - TRUTH.trend) / DEVIATION[:, None], 0.0, atol=0.25)
    for name, tolerance in (("between", 0.25), ("within", 0.035)):
        apart = getattr(found, name) - getattr(TRUTH, name)
        np.testing.assert_allclose(apart / np.outer(DEVIATION, DEVIATION), 0.0, atol=tolerance)


def test_a_sibling_says_more_the_more_is_known_of_it_and_the_closer_its_size_is() -> None:
    alone = family_prior([], TRUTH, SIZES[1])
    np.testing.assert_allclose(alone.mean, TRUTH.mean + TRUTH.shift(SIZES[1]))
    np.testing.assert_allclose(alone.covariance, TRUTH.between + TRUTH.within, rtol=1e-10)
    nothing = np.zeros((DEVIATION.size, DEVIATION.size))
    blank = family_prior([Member("a", "b", SIZES[0], nothing, nothing[0])], TRUTH, SIZES[1])
    np.testing.assert_allclose(blank.mean, alone.mean, rtol=1e-12)
    np.testing.assert_allclose(blank.covariance, alone.covariance, rtol=1e-9)
    members, _ = drawn(1, 0.05)
    far, near = (family_prior([members[k]], TRUTH, SIZES[1]).deviation for k in (3, 1))
    assert (far < alone.deviation).all() and (near < far).all()
    # No sibling makes it sure: propellers of one size differ too.
    assert (near > np.sqrt(settings.OWN_SHARE * np.diag(TRUTH.within))).all()


def test_a_member_is_its_posterior_without_its_prior() -> None:
    one = all_identified()[0]
    found, place = member(one), coordinates(one.constants)
    both = found.precision + np.linalg.inv(POPULATION.covariance)
    own = coordinate_covariance(one.constants, one.covariance)
    np.testing.assert_allclose(np.linalg.inv(both), own, rtol=1e-6, atol=1e-9)
    # It is centered at the constants, although the prior drew them towards its mean.
    np.testing.assert_allclose(found.pull, found.precision @ place)
    assert np.linalg.eigvalsh(found.precision).min() > -1e-9 * found.precision.max()
