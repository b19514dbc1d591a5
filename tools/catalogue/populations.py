"""The three populations of constants: on propellers' own blades, and on mean blades."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from propmap import catalogue
from propmap.catalogue.expected import (
    GEOMETRIES,
    MeanBlade,
    Member,
    Population,
    mean_blade,
    member,
    on_mean_blade,
    shapes_without,
)
from propmap.catalogue.identified import Identified, one_of_each
from propmap.fit.population.hierarchy import population_of
from propmap.tasks import InTurn, Workers, in_order
from propmap.typing import Floats


def members_on(entries: Sequence[Identified], family: str, shape: MeanBlade) -> list[Member]:
    """What the data of a family's propellers say of constants with a blade of this ``shape``."""
    return [on_mean_blade(one, shape) for one in one_of_each(entries) if one.family == family]


def all_members(entries: Sequence[Identified]) -> dict[str, list[Member]]:
    """What is known of all propellers, on the blade of each of ``GEOMETRIES``.

    Mean blades are those of the others: so the spread over propellers holds what a mean blade
    misses.  Those without measured siblings have none of their family.
    """
    found: dict[str, list[Member]] = {name: [] for name in GEOMETRIES}
    for one in one_of_each(entries):
        found["measured"].append(member(one))
        others = shapes_without(catalogue.entry(one.propeller))
        if one.family in {other.family for other in others}:
            found["family"].append(on_mean_blade(one, mean_blade(others, [one.family])))
        found["population"].append(on_mean_blade(one, mean_blade(others)))
    return found


def errors_of(entries: Sequence[Identified]) -> Floats:
    """Root mean squares over propellers of the errors of C_T and C_P that are left [-], (2,)."""
    each = [one.discrepancy for one in one_of_each(entries)]
    return np.sqrt(np.mean(np.square(each), axis=0))


def populations_of(
    entries: Sequence[Identified], workers: Workers | None = None
) -> dict[str, Population]:
    """The populations that ``entries`` of measured blades make up, by ``GEOMETRIES``.

    Parameters
    ----------
    entries : sequence of Identified
        Of two families at least.
    workers : Workers, optional
        Who finds them; by default this process.
    """
    members = all_members(entries)
    tasks = list(members.values())
    found = in_order((workers or InTurn()).results(_population, errors_of(entries), tasks))
    return dict(zip(members, found, strict=True))


def _population(errors: Floats, members: Sequence[Member]) -> Population:
    return population_of(members, errors)[0]
