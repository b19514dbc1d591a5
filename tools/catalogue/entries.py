"""Identified constants of every propeller of the UIUC database, computed in tasks."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from propmap import catalogue
from propmap.catalogue.expected import (
    LIKENESS_WIDTH,
    OWN_SHARE,
    POPULATION,
    Population,
    PopulationPrior,
    bundled_mean,
    families_measured,
    family_prior,
)
from propmap.catalogue.identified import LIFT_LAW, PARAMETERS, Identified, one_of_each
from propmap.fit.least_squares import INDEPENDENT, INDEPENDENT_AT_REST
from propmap.tasks import InTurn, Workers
from tools.catalogue import identification
from tools.catalogue.database import (
    MeasuredPropeller,
    blade_names,
    family_and_size,
    label_of,
    mean_propeller,
)
from tools.catalogue.identification import AxialTest, airfoil_of
from tools.catalogue.population import members_on
from tools.catalogue.verdict import verdict

TOGETHER = 4
"""Propellers per task.  A task takes half a second; to assign it to a worker takes far less."""

Done = Callable[[list[Identified], list[Identified]], None]
"""Callback after each task.  The arguments are all earlier results and the results of the task."""


class _Wanted(NamedTuple):
    """An identification that the caller needs."""

    name: str  # of the propeller in the catalogue
    geometry: str  # see ``Identified.geometry``
    test: AxialTest
    prior: PopulationPrior
    key: str
    remark: str = ""  # precedes the verdict


def identify_all(
    every: Iterable[MeasuredPropeller],
    known: Mapping[str, Identified],
    done: Done,
    workers: Workers | None = None,
) -> list[Identified]:
    """Identify all propellers with a blade in the catalogue, in the given order.

    ``known`` contains results of an earlier run by ``key``; these are not computed again.
    """
    wanted = []
    for tested in every:
        names = blade_names(tested)
        specimens = sum(name.startswith("uiuc") for name in names)
        for name in names:
            test = AxialTest(replace(catalogue.load(name), blades=tested.blades), tested)
            geometry, remark = catalogue.entry(name).geometry, ""
            if geometry == "maker":
                remark = "blade from the manufacturer's file; "
            elif specimens > 1:
                remark = f"one of {specimens} blades measured, each tested in some of the runs; "
            wanted.append(_Wanted(name, geometry, test, POPULATION, _key(test), remark))
    return _identified(wanted, known, done, workers)


def identify_without_blade(
    every: Iterable[MeasuredPropeller],
    measured: Sequence[Identified],
    populations: Mapping[str, Population],
    known: Mapping[str, Identified],
    done: Done,
    workers: Workers | None = None,
) -> list[Identified]:
    """Identify the propellers without a blade in the catalogue, with a mean blade.

    The blade is the mean of the family, or of all families if no blade of the family was measured.
    The prior is the distribution over the family, widened by the uncertainty of the blade.  It is
    computed from ``measured``, the results of ``identify_all``, and their ``populations``.
    """
    wanted = []
    before = [one.key for one in one_of_each(measured)]
    for tested in every:
        if blade_names(tested):
            continue
        family, size = family_and_size(tested)
        geometry = "family" if family in families_measured() else "population"
        shape = bundled_mean((family,) if geometry == "family" else ())
        test = AxialTest(mean_propeller(tested, shape), tested)
        members = members_on(measured, family, shape) if geometry == "family" else []
        label = label_of(tested)
        prior = family_prior(members, populations[geometry], (label.diameter, label.pitch))
        name = f"uiuc-{family}-{size}"
        wanted.append(_Wanted(name, geometry, test, prior, _key(test, before)))
    return _identified(wanted, known, done, workers)


def _identified(
    wanted: Sequence[_Wanted],
    known: Mapping[str, Identified],
    done: Done,
    workers: Workers | None,
) -> list[Identified]:
    found = {place: known[one.key] for place, one in enumerate(wanted) if one.key in known}
    missing = [place for place in range(len(wanted)) if place not in found]
    tasks = [missing[k : k + TOGETHER] for k in range(0, len(missing), TOGETHER)]
    groups = [[wanted[place] for place in places] for places in tasks]
    for which, some in (workers or InTurn()).results(_entries, None, groups):
        before = [found[place] for place in sorted(found)]
        found |= zip(tasks[which], some, strict=True)
        done(before, some)
    return [found[place] for place in range(len(wanted))]


def _entries(_: None, task: Sequence[_Wanted]) -> list[Identified]:
    return [_entry(one) for one in task]


def _entry(one: _Wanted) -> Identified:
    tested, label = one.test.tested, label_of(one.test.tested)
    result = identification.identify(one.test, one.prior)
    return Identified(
        propeller=one.name,
        blades=tested.blades,
        family=tested.family,
        tested=tested.name,
        geometry=one.geometry,
        diameter_m=label.diameter,
        pitch_m=label.pitch,
        airfoil=airfoil_of(result.constants),
        covariance=result.covariance,
        thrust_rms=result.thrust_rms,
        power_rms=result.power_rms,
        static_thrust_rms=result.static_thrust_rms,
        static_power_rms=result.static_power_rms,
        rows=tested.rpm.size,
        static_rows=int((tested.advance == 0.0).sum()),
        rpm_low=float(tested.rpm.min()),
        rpm_high=float(tested.rpm.max()),
        advance_high=float(tested.advance.max()),
        verdict=one.remark + verdict(tested, result),
        key=one.key,
    )


def _key(test: AxialTest, before: Sequence[str] = ()) -> str:
    """Return a short digest of the inputs and settings of an identification.

    The digest does not cover the program itself.  ``before`` are the keys of the results from which
    the prior is computed.
    """
    settings = (
        LIFT_LAW,
        *PARAMETERS,
        INDEPENDENT,
        INDEPENDENT_AT_REST,
        identification.FIRST_ERRORS,
        identification.LEAST_ERRORS,
        identification.MOST_ERRORS,
        POPULATION.mean.tolist(),
        POPULATION.deviation.tolist(),
        *((LIKENESS_WIDTH, OWN_SHARE, *before) if before else ()),
    )
    digest = hashlib.sha256(repr(settings).encode())
    digest.update(test.propeller.fingerprint().encode())
    rows = (test.tested.rpm, test.tested.advance, test.tested.thrust, test.tested.power)
    digest.update(np.stack(rows).tobytes())
    return digest.hexdigest()[:16]
