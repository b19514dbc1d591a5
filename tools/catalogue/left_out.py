"""Predict propellers of the UIUC database from the other propellers; print errors and bands.

Usage: python -m tools.catalogue.left_out LOADS FILES

LOADS is the loads.csv of the UIUC database.  FILES is a folder with APC's PE0 files.  The section
constants are those of the catalogue.  Errors are rms errors over the rows of a propeller, divided
by the rms of the measured values.  Coverage is the fraction of rows inside the 95 % band, as a mean
over propellers.  Half width and interval score of the bands are divided by the rms of the measured
values.  The bands were not tuned to their coverage.  A second table compares mean blades with
blades from manufacturers' files for APC's series.  The tool writes
benchmarks/results/left_out.json.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap import catalogue
from propmap.bands import TUNNEL_GAIN
from propmap.catalogue.expected import (
    MeanBlade,
    Member,
    Population,
    PopulationPrior,
    constants_of,
    coordinates,
    families_measured,
    family_prior,
    mean_blade,
    measured_shapes,
    member_without_blade,
    on_makers_blade,
    on_mean_blade,
    on_measured_blade,
    slopes_of,
)
from propmap.catalogue.identified import (
    Identified,
    all_identified,
    identified_without_blade,
    one_of_each,
)
from propmap.io.csv import replacing
from propmap.io.geometry import read_apc_pe0
from propmap.model.propeller import Propeller
from propmap.typing import Floats
from tools.catalogue.database import (
    MeasuredPropeller,
    label_of,
    makers_name,
    mean_propeller,
    read_uiuc_database,
    refiled,
    with_rows,
)
from tools.catalogue.identification import AxialTest, identify, updated
from tools.catalogue.population import (
    all_members,
    errors_of,
    population_of,
    populations_of,
    shapes_without,
)

RESULTS = Path(__file__).resolve().parents[2] / "benchmarks" / "results" / "left_out.json"

BAND = 1.959964
"""Half width of the 95 % interval of a normal distribution, in standard deviations."""


def interval_score(error: Floats, deviation: Floats) -> Floats:
    """Return the interval score of 95 % bands: width plus 40 times the distance outside."""
    half = BAND * deviation
    return np.asarray(2.0 * half + 40.0 * np.maximum(np.abs(error) - half, 0.0))


STEPS = 8
"""Steps of expectation and maximization for the population without one propeller.  They start from
the population of all propellers."""

GROUPS = {
    "own": "own rows",
    "own_run": "own rows, middle run held out",
    "own_fastest": "own rows, fastest run held out",
    "family": "family",
    "other_blade_of_family": "family, other blades only",
    "population": "all propellers",
    "maker": "family, manufacturer's blade",
    "family_blade": "family, mean blade",
    "population_blade": "all, mean blade",
    "family_static": "family and own static rows",
    "population_static": "all and own static rows",
    "family_label": "family, blade unknown",
    "siblings_label": "family, all its blades unknown",
    "population_label": "all, blades of family unknown",
}
"""Groups of predictions, with their labels in the printed table.

The groups differ in the data from which the constants of a propeller are predicted, and in its
blade.  Unless stated otherwise, the blade is that of the catalogue, and all rows of the propeller
are held out.

- ``own``: constants identified from all rows of the propeller.
- ``own_run``, ``own_fastest``: constants identified without one run, at the middle or the highest
  rotational speed.  Errors and bands are those of this run.
- ``family``, ``population``: constants from the other propellers of the family, or from all others.
- ``other_blade_of_family``: like ``family``, but without propellers that have the same blade and
  another number of blades.
- ``maker``: like ``family``, with the blade of the manufacturer's file.  The measured blade of the
  propeller is not used.
- ``family_blade``, ``population_blade``: with the mean blade of the other propellers.
- ``family_static``, ``population_static``: the propeller's own static rows update the prediction.
  Errors and bands are those of its other rows.
- ``family_label``: propellers without geometry in the database and in the catalogue, with the mean
  blade and the constants of their family.  Their loads do not enter any population.
- ``siblings_label``, ``population_label``: like ``family_label`` for families without a measured
  blade, with the mean blade of all propellers.  The constants are from the family, or from all.
"""


class Prediction(NamedTuple):
    """Errors of C_T and C_P and properties of their 95 % bands, (2,) each."""

    errors: Floats  # rms errors over the rms of the measured values [-]
    at_rest: Floats  # fraction of the static rows inside the band; NaN without static rows
    moving: Floats  # the same for all other rows
    half_width: Floats  # median of half the width of the 95 % band, over the rms [-]
    score: Floats  # mean interval score of the 95 % band, over the rms [-]


class LeftOut(NamedTuple):
    """Prediction of one propeller."""

    group: str  # key of ``GROUPS``
    tested: str  # name of the propeller in the database
    found: Prediction


def predicted(
    test: AxialTest, prior: PopulationPrior, errors: Floats, moving_only: bool = False
) -> Prediction:
    """Predict the rows of ``test`` with the mean and the covariance of ``prior``.

    ``errors`` (2,) are standard deviations of C_T and C_P [-] about the model with the best
    constants.  With ``moving_only``, errors, width and score exclude static rows.
    """
    value, slope = test.modeled(constants_of(prior.mean))
    by_place = np.einsum("lcn,cp->lpn", slope, slopes_of(prior.mean))
    variance = np.einsum("lpn,pq,lqn->ln", by_place, prior.covariance, by_place)
    error = value - test.measured
    # Without a solution for the inflow, the deviation is NaN and the row counts as outside.
    deviation = np.sqrt(variance + np.square(errors)[:, None] + np.square(TUNNEL_GAIN * value))
    inside = np.abs(error) <= BAND * deviation
    moving = test.tested.advance > 0.0
    counted = moving if moving_only else np.ones_like(moving)
    squares = np.nanmean(error[:, counted] ** 2, axis=1)

    def share(which: NDArray[np.bool_]) -> Floats:
        return inside[:, which].mean(axis=1) if which.any() else np.full(2, np.nan)

    size = np.sqrt(np.mean(test.measured[:, counted] ** 2, axis=1))
    return Prediction(
        errors=np.sqrt(squares) / size,
        at_rest=share(~moving),
        moving=share(moving),
        half_width=np.nanmedian(BAND * deviation[:, counted], axis=1) / size,
        score=np.nanmean(interval_score(error, deviation)[:, counted], axis=1) / size,
    )


def posterior(constants: Floats, covariance: Floats) -> PopulationPrior:
    """Return the distribution of the coordinates from ``constants`` (P,) and their ``covariance``.

    The shape of the covariance is (P, P).
    """
    place = coordinates(constants)
    back = np.linalg.inv(slopes_of(place))
    return PopulationPrior.of(place, back @ covariance @ back.T)


def left_out(
    entries: Sequence[Identified],
    every: Sequence[MeasuredPropeller],
    files: Mapping[str, Propeller],
) -> Iterator[LeftOut]:
    """Predict each propeller of ``entries`` from the others, in all groups except ``*_label``.

    ``entries`` are the identified constants of propellers with known blades.  ``every`` contains
    the refiled rows of the propellers to hold out in turn.  ``files`` contains the blades of
    manufacturers' files by catalogue name.
    """
    rows = {tested.name: tested for tested in every}
    chosen = one_of_each(entries)
    known = [on_measured_blade(one) for one in chosen]
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
        own = posterior(one.constants, one.covariance)
        yield LeftOut("own", one.tested, predicted(test, own, np.array(one.discrepancy)))
        yield from _one_run(one.tested, test)
        yield from _known_blade(one, siblings, known, without["measured"], test)
        yield from _mean_blade(one, siblings, without, rows[one.tested])
        yield from _makers_blade(one, known, without["measured"], rows[one.tested], files)


def _one_run(name: str, test: AxialTest) -> Iterator[LeftOut]:
    tested = test.tested
    moving = tested.advance > 0.0
    runs = {int(k): float(tested.rpm[tested.run == k].mean()) for k in set(tested.run[moving])}
    if len(runs) < 2:
        return
    order = sorted(runs, key=lambda k: (runs[k], k))
    for group, run in (("own_run", order[len(order) // 2]), ("own_fastest", order[-1])):
        left = tested.run == run
        result = identify(AxialTest(test.propeller, with_rows(tested, ~left)))
        found = predicted(
            AxialTest(test.propeller, with_rows(tested, left)),
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
    def prior_from(some: Sequence[Identified]) -> PopulationPrior:
        tested = {other.tested for other in some}
        known = [m for m in members if m.family == one.family and m.tested in tested]
        prior = family_prior(known, population, one.size)
        return on_makers_blade(prior, one.family) if one.geometry == "maker" else prior

    still = test.tested.advance == 0.0

    def both(group: str, prior: PopulationPrior) -> Iterator[LeftOut]:
        yield LeftOut(group, one.tested, predicted(test, prior, population.errors))
        if still.any() and not still.all():
            at_rest = AxialTest(test.propeller, with_rows(test.tested, still))
            after = updated(at_rest, prior, population.errors)
            found = predicted(test, after, population.errors, moving_only=True)
            yield LeftOut(f"{group}_static", one.tested, found)

    yield from both("population", prior_from([]))
    if siblings:
        yield from both("family", prior_from(siblings))
    others = [other for other in siblings if other.propeller != one.propeller]
    if others:
        found = predicted(test, prior_from(others), population.errors)
        yield LeftOut("other_blade_of_family", one.tested, found)


def _makers_blade(
    one: Identified,
    members: Sequence[Member],
    population: Population,
    tested: MeasuredPropeller,
    files: Mapping[str, Propeller],
) -> Iterator[LeftOut]:
    """Predict ``one`` with the blade of the manufacturer's file, if there is one.

    ``members`` have the constants for measured blades.
    """
    name = makers_name(tested)
    if name in files:
        siblings = [m for m in members if m.family == one.family and m.tested != one.tested]
        prior = family_prior(siblings, population, one.size)
        test = AxialTest(replace(files[name], blades=one.blades), tested)
        found = predicted(test, on_makers_blade(prior, one.family, name), population.errors)
        yield LeftOut("maker", one.tested, found)


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
    files: Mapping[str, Propeller],
) -> Iterator[LeftOut]:
    """Predict the propellers ``without_blade`` in the groups ``*_label`` and ``maker``.

    ``entries`` are the identified constants of propellers with known blades, and ``populations``
    are derived from them.  ``every`` contains the refiled rows of the propellers ``without_blade``.
    ``files`` contains the blades of manufacturers' files by catalogue name.
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
            known = [on_measured_blade(m) for m in chosen]
            yield from _makers_blade(one, known, populations["measured"], tested, files)
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
    return LeftOut(group, tested.name, predicted(test, prior, population.errors))


# -------------------------------------------------------------------------------------------------
# The command prints medians and 90th percentiles over propellers, and coverage of the bands.


def main(loads: Path, folder: Path) -> None:
    """Print the tables and write the results."""
    blades = [read_apc_pe0(path) for path in folder.glob("*.PE0")]
    files = {blade.name: blade for blade in blades}
    every = refiled(read_uiuc_database(loads))
    measured = all_identified()
    populations = populations_of(measured)
    all_found = [
        *left_out(measured, every, files),
        *never_measured(measured, identified_without_blade(), every, populations, files),
    ]
    found: dict[str, list[Prediction]] = {name: [] for name in GROUPS}
    for each in all_found:
        found[each.group].append(each.found)
    results = {name: _summary(some) for name, some in found.items()}
    print(f"{'':<37}errors, median (90 %)           inside bands, C_T and C_P")
    print(f"{'constants from':<34}n  C_T            C_P            at rest      moving")
    for name, words in GROUPS.items():
        one = results[name]
        shown = [
            *(
                f"{half:5.1%} ({most:5.1%})"
                for half, most in zip(one["median"], one["nine_in_ten"], strict=True)
            ),
            *(" ".join(map(_percent, one[key])) for key in ("at_rest", "moving")),
        ]
        print(f"{words:<32}{one['propellers']:>3}  {'  '.join(shown)}")
    results["makers"] = by_series(all_found, measured)
    print(f"\n{'':<34}n  mean blade, median (rms)       blade of the maker's file")
    for name, one in results["makers"].items():
        shown = [
            f"{half:5.1%} ({rms:5.1%})"
            for group in ("mean", "maker")
            for half, rms in zip(one[group], one[f"{group}_rms"], strict=True)
        ]
        print(f"{name:<32}{one['propellers']:>3}  {'  '.join(shown)}")
    with replacing(RESULTS) as path:
        path.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")


def by_series(found: Sequence[LeftOut], entries: Sequence[Identified]) -> dict[str, Any]:
    """Return errors with mean blades and with blades of manufacturers' files, by series.

    Of the predictions ``found``, only those of propellers with both blades count.  An additional
    row of a series covers its propellers without a measured blade in ``entries``.
    """
    errors: dict[str, dict[str, Floats]] = {}
    for one in found:
        group = "mean" if one.group in ("family_blade", "family_label") else one.group
        errors.setdefault(one.tested, {})[group] = one.found.errors
    measured = {one.tested for one in entries if one.geometry == "measured"}
    series: dict[str, list[str]] = {}
    for tested, by_group in errors.items():
        if {"mean", "maker"} <= set(by_group):
            family = tested.partition(" ")[0]
            series.setdefault(family, []).append(tested)
            if tested not in measured:
                series.setdefault(f"{family}, no measured blade", []).append(tested)
    told: dict[str, Any] = {}
    for name in sorted(series):
        told[name] = {"propellers": len(series[name])}
        for group in ("mean", "maker"):
            each = np.stack([errors[tested][group] for tested in series[name]])
            told[name][group] = np.round(np.median(each, axis=0), 5).tolist()
            told[name][f"{group}_rms"] = np.round(np.sqrt(np.mean(each**2, axis=0)), 5).tolist()
    return told


def _summary(some: list[Prediction]) -> dict[str, Any]:
    half, most = np.quantile([one.errors for one in some], (0.5, 0.9), axis=0)
    held = {name: _mean([getattr(one, name) for one in some]) for name in ("at_rest", "moving")}
    return {
        "propellers": len(some),
        "median": np.round(half, 5).tolist(),
        "nine_in_ten": np.round(most, 5).tolist(),
        "half_width": np.round(np.median([one.half_width for one in some], axis=0), 4).tolist(),
        "score": np.round(np.mean([one.score for one in some], axis=0), 4).tolist(),
        **held,
    }


def _percent(share: float | None) -> str:
    return "    -" if share is None else f"{share:5.1%}"


def _mean(shares: list[Floats]) -> list[float | None]:
    """Return the means of C_T and C_P over propellers; None if no propeller has such rows.

    A share is NaN for a propeller without such rows.
    """
    known = [share for share in shares if np.isfinite(share).all()]
    if not known:
        return [None, None]
    return [round(float(share), 4) for share in np.mean(known, axis=0)]


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(Path(sys.argv[1]), Path(sys.argv[2]))
