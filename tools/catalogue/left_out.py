"""How well a propeller is predicted from the others, without its own rows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from propmap import catalogue
from propmap.catalogue.expected import (
    MeanBlade,
    Member,
    Population,
    PopulationPrior,
    families_measured,
    family_prior,
    mean_blade,
    measured_shapes,
    member_without_blade,
    on_mean_blade,
    shapes_without,
)
from propmap.catalogue.identified import Identified, one_of_each
from propmap.fit.population.catalogue import label_of, mean_propeller
from propmap.fit.population.coefficients import AxialTest
from propmap.fit.population.foretold import Foretold, foretold, posterior
from propmap.fit.population.hierarchy import population_of
from propmap.fit.population.identification import identify, updated
from propmap.fit.population.populations import all_members, errors_of
from propmap.io.uiuc import MeasuredPropeller
from propmap.typing import Floats

STEPS = 8
"""Of the search for a population without one propeller, from that with it."""

GROUPS = {
    "own": "own",
    "own_run": "own, one run left out",
    "own_fastest": "own, fastest run left out",
    "family": "family",
    "other_blade_of_family": "family, same blade left out too",
    "population": "population",
    "family_blade": "family, blade too",
    "population_blade": "population, blade too",
    "family_static": "family, after a static test",
    "population_static": "population, after a static test",
    "family_label": "family, never measured",
    "siblings_label": "siblings, family never measured",
    "population_label": "population, never measured",
}
"""What propellers are predicted from, and what that is called.

"Own" are a propeller's own constants, and with a run left out, those found without the run at the
middle one of its rotational speeds or at the highest, of which errors and bands are; all others
leave its rows out.  "Blade too" is with the mean blade of the others in place of its own.  "After a
static test", its rows at rest, and they alone, have updated what the others say, and errors and
bands are those of its moving rows.  "Never measured" are propellers without geometry in the
database, whose loads play no part in any population; "siblings" are of the same family and no more
measured.
"""


class LeftOut(NamedTuple):
    """One propeller, predicted in one way.

    Attributes
    ----------
    group : str
        Which way, one of ``GROUPS``.
    tested : str
        What the database calls it.
    found : Foretold
        Errors, and what the bands hold.
    """

    group: str
    tested: str
    found: Foretold


def left_out(
    entries: Sequence[Identified], every: Sequence[MeasuredPropeller]
) -> Iterator[LeftOut]:
    """Each of ``entries`` as the others foretell it, its blade known or left out too.

    Parameters
    ----------
    entries : sequence of Identified
        Constants of all propellers with measured blades.
    every : sequence of MeasuredPropeller
        Rows, as ``misfiled.refiled`` gives them, of those that are to be left out in turn.
    """
    rows = {tested.name: tested for tested in every}
    chosen = one_of_each(entries)
    members, errors = all_members(chosen), errors_of(chosen)
    whole = {name: population_of(some, errors)[0] for name, some in members.items()}
    for one in chosen:
        if one.tested not in rows:
            continue
        rest = [other for other in chosen if other is not one]
        without = {
            name: population_of(
                [m for m in some if (m.family, m.tested) != (one.family, one.tested)],
                errors_of(rest),
                whole[name],
                STEPS,
            )[0]
            for name, some in members.items()
        }
        siblings = [other for other in rest if other.family == one.family]
        test = AxialTest(
            replace(catalogue.load(one.propeller), blades=one.blades), rows[one.tested]
        )
        yield LeftOut(
            "own",
            one.tested,
            foretold(test, posterior(one.constants, one.covariance), np.array(one.discrepancy)),
        )
        yield from _one_run(one.tested, test)
        yield from _known_blade(one, siblings, members["measured"], without["measured"], test)
        yield from _mean_blade(one, siblings, without, rows[one.tested])


def _one_run(name: str, test: AxialTest) -> Iterator[LeftOut]:
    tested = test.tested
    moving = tested.advance > 0.0
    runs = {int(k): float(tested.rpm[tested.run == k].mean()) for k in set(tested.run[moving])}
    if len(runs) < 2:
        return
    order = sorted(runs, key=lambda k: (runs[k], k))
    for group, run in (("own_run", order[len(order) // 2]), ("own_fastest", order[-1])):
        left = tested.run == run
        result = identify(AxialTest(test.propeller, _rows(tested, ~left)))
        found = foretold(
            AxialTest(test.propeller, _rows(tested, left)),
            posterior(result.constants, result.covariance),
            np.array([result.thrust_rms, result.power_rms]),
        )
        yield LeftOut(group, name, found)


def _known_blade(
    one: Identified,
    siblings: Sequence[Identified],
    members: Sequence[Member],
    population: Population,
    test: AxialTest,
) -> Iterator[LeftOut]:
    def of(some: Sequence[Identified]) -> PopulationPrior:
        tested = {other.tested for other in some}
        known = [m for m in members if m.family == one.family and m.tested in tested]
        return family_prior(known, population, one.size)

    still = test.tested.advance == 0.0
    at_rest = AxialTest(test.propeller, _rows(test.tested, still)) if still.any() else None

    def both(group: str, prior: PopulationPrior) -> Iterator[LeftOut]:
        yield LeftOut(group, one.tested, foretold(test, prior, population.errors))
        if at_rest is not None and not still.all():
            after = updated(at_rest, prior, population.errors)
            found = foretold(test, after, population.errors, moving_only=True)
            yield LeftOut(f"{group}_static", one.tested, found)

    yield from both("population", of([]))
    if siblings:
        yield from both("family", of(siblings))
    others = [other for other in siblings if other.propeller != one.propeller]
    if others:
        found = foretold(test, of(others), population.errors)
        yield LeftOut("other_blade_of_family", one.tested, found)


def _mean_blade(
    one: Identified,
    siblings: Sequence[Identified],
    populations: Mapping[str, Population],
    tested: MeasuredPropeller,
) -> Iterator[LeftOut]:
    shapes = shapes_without(catalogue.entry(one.propeller))
    shape = mean_blade(shapes)
    yield _on_mean("population_blade", [], populations["population"], shape, tested)
    if siblings and one.family in {other.family for other in shapes}:
        shape = mean_blade(shapes, [one.family])
        members = [on_mean_blade(other, shape) for other in siblings]
        yield _on_mean("family_blade", members, populations["family"], shape, tested)


def never_measured(
    entries: Sequence[Identified],
    without_blade: Sequence[Identified],
    every: Sequence[MeasuredPropeller],
    populations: Mapping[str, Population],
) -> Iterator[LeftOut]:
    """Propellers without measured blades, as those with measured blades foretell them.

    Parameters
    ----------
    entries, without_blade : sequence of Identified
        Constants of all propellers with measured blades and without.
    every : sequence of MeasuredPropeller
        Their rows, as ``misfiled.refiled`` gives them.
    populations : mapping of str to Population
        Of those with measured blades, by ``populations.populations_of``.
    """
    rows = {tested.name: tested for tested in every}
    chosen = one_of_each(entries)
    shapes = measured_shapes()
    for one in without_blade:
        tested = rows[one.tested]
        if one.family in families_measured():
            shape = mean_blade(shapes, [one.family])
            members = [on_mean_blade(m, shape) for m in chosen if m.family == one.family]
            yield _on_mean("family_label", members, populations["family"], shape, tested)
            continue
        shape, population = mean_blade(shapes), populations["population"]
        yield _on_mean("population_label", [], population, shape, tested)
        siblings = [
            member_without_blade(other)
            for other in without_blade
            if other.family == one.family and other is not one
        ]
        if siblings:
            yield _on_mean("siblings_label", siblings, population, shape, tested)


def _on_mean(
    group: str,
    members: Sequence[Member],
    population: Population,
    shape: MeanBlade,
    tested: MeasuredPropeller,
) -> LeftOut:
    label = label_of(tested)
    prior = family_prior(members, population, (label.diameter, label.pitch))
    test = AxialTest(mean_propeller(tested, shape), tested)
    return LeftOut(group, tested.name, foretold(test, prior, population.errors))


def _rows(tested: MeasuredPropeller, which: Floats) -> MeasuredPropeller:
    return tested._replace(
        **{
            name: getattr(tested, name)[which]
            for name in ("rpm", "advance", "thrust", "power", "run")
        }
    )
