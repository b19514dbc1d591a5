"""Constants for every propeller of the UIUC database, and the populations that they make up."""

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
    MeanBlade,
    Population,
    PopulationPrior,
    bundled_mean,
    families_measured,
    family_prior,
)
from propmap.catalogue.identified import Designation, Identified, designation
from propmap.errors import InputError
from propmap.fit.least_squares import INDEPENDENT
from propmap.fit.population import identification
from propmap.fit.population.coefficients import AxialTest, airfoil_of
from propmap.fit.population.populations import members_on
from propmap.fit.population.verdict import verdict
from propmap.io.uiuc import MeasuredPropeller
from propmap.model.model import Propeller
from propmap.tasks import InTurn, Workers

SPECIMENS = ("", "-b", "-c")
"""Endings of the names of a blade of which several were measured."""

MAKERS_FILES = {"apce": "apc-{}e", "apcsf": "apc-{}sf"}
"""Names in the catalogue of blades of these families by their maker's own files."""

TOGETHER = 4
"""Propellers of a task: half a second, long beside what it costs to hand out a task."""

Done = Callable[[list[Identified], list[Identified]], None]
"""Called after each task with the results before it and with its own."""


def blade_names(tested: MeasuredPropeller) -> list[str]:
    """Names in the catalogue of the blades that a propeller of the database may have.

    Those that the database measured come first, then that of the maker's file.

    Parameters
    ----------
    tested : MeasuredPropeller
        The propeller.
    """
    family, size = _named(tested)
    possible = [f"uiuc-{family}-{size}{end}" for end in SPECIMENS]
    if family in MAKERS_FILES:
        possible.append(MAKERS_FILES[family].format(size))
    known = catalogue.names()
    return [name for name in possible if name in known]


def identify_all(
    every: Iterable[MeasuredPropeller],
    known: Mapping[str, Identified],
    done: Done,
    workers: Workers | None = None,
) -> list[Identified]:
    """Constants of all propellers with a blade in the catalogue, in the order given.

    Parameters
    ----------
    every : iterable of MeasuredPropeller
        The database.
    known : mapping of str to Identified
        Results of an earlier, perhaps interrupted run, by their ``key``; they are taken as they
        are.
    done : callable
        Called after each task with all results before it and with its own.
    workers : Workers, optional
        Who identifies; by default this process.
    """
    wanted = []
    for tested in every:
        names = blade_names(tested)
        specimens = sum(name.startswith("uiuc") for name in names)
        for name in names:
            test = AxialTest(replace(catalogue.load(name), blades=tested.blades), tested)
            remark = ""
            if not name.startswith("uiuc"):
                remark = "blade by its maker's file; "
            elif specimens > 1:
                remark = f"one of {specimens} blades measured, each tested in some of the runs; "
            wanted.append(_Wanted(name, "measured", test, POPULATION, _key(test), remark))
    return _identified(wanted, known, done, workers)


def identify_without_blade(
    every: Iterable[MeasuredPropeller],
    measured: Sequence[Identified],
    populations: Mapping[str, Population],
    known: Mapping[str, Identified],
    done: Done,
    workers: Workers | None = None,
) -> list[Identified]:
    """Constants of the propellers whose blades were never measured, with their family's mean blade.

    Where none of the family was measured it is the mean of all.  Their prior is that of their
    family, and wider by what is not known of the blade.

    Parameters
    ----------
    every : iterable of MeasuredPropeller
        The database.
    measured : sequence of Identified
        What ``identify_all`` found.
    populations : mapping of str to Population
        What ``populations.populations_of`` makes of it.
    known : mapping of str to Identified
        As for ``identify_all``.
    done : callable
        As for ``identify_all``; results are those of this kind.
    workers : Workers, optional
        Who identifies; by default this process.
    """
    wanted = []
    before = [one.key for one in measured]
    for tested in every:
        if blade_names(tested):
            continue
        family, size = _named(tested)
        geometry = "family" if family in families_measured() else "population"
        shape = bundled_mean((family,) if geometry == "family" else ())
        test = AxialTest(mean_propeller(tested, shape), tested)
        members = members_on(measured, family, shape) if geometry == "family" else []
        label = label_of(tested)
        prior = family_prior(members, populations[geometry], (label.diameter, label.pitch))
        name = f"uiuc-{family}-{size}"
        wanted.append(_Wanted(name, geometry, test, prior, _key(test, before)))
    return _identified(wanted, known, done, workers)


class _Wanted(NamedTuple):
    """An identification to be made: arguments of ``_entry``, and what goes before its verdict."""

    name: str
    geometry: str
    test: AxialTest
    prior: PopulationPrior
    key: str
    remark: str = ""


def _identified(
    wanted: Sequence[_Wanted],
    known: Mapping[str, Identified],
    done: Done,
    workers: Workers | None,
) -> list[Identified]:
    """Those that are ``known``, and the others by ``workers``, in the order ``wanted``."""
    found = {place: known[one.key] for place, one in enumerate(wanted) if one.key in known}
    missing = [place for place in range(len(wanted)) if place not in found]
    tasks = [missing[k : k + TOGETHER] for k in range(0, len(missing), TOGETHER)]
    groups = [[wanted[place] for place in places] for places in tasks]
    for which, some in (workers or InTurn()).results(_identify, None, groups):
        before = [found[place] for place in sorted(found)]
        found |= zip(tasks[which], some, strict=True)
        done(before, some)
    return [found[place] for place in range(len(wanted))]


def _identify(_: None, task: Sequence[_Wanted]) -> list[Identified]:
    found = [_entry(one.name, one.geometry, one.test, one.prior, one.key) for one in task]
    return [
        replace(result, verdict=f"{one.remark}{result.verdict}")
        for one, result in zip(task, found, strict=True)
    ]


def mean_propeller(tested: MeasuredPropeller, shape: MeanBlade) -> Propeller:
    """What was ``tested``, with a blade of this ``shape``."""
    label = label_of(tested)
    return shape.propeller(tested.name, label.diameter, label.pitch, tested.blades)


def label_of(tested: MeasuredPropeller) -> Designation:
    """Size of a propeller of the database, by its blade's name."""
    found = designation(" ".join(_named(tested)))
    assert found is not None  # `_named` has read the numbers
    return found


def _named(tested: MeasuredPropeller) -> tuple[str, str]:
    """Family and size, as the catalogue's names have them."""
    family, _, size = tested.blade.partition(" ")
    try:
        return family, "x".join(f"{float(part):g}" for part in size.split("x"))
    except ValueError:
        raise InputError(
            f"the blade's name is {tested.blade!r}", "expected one as in 'apce 8.0x6.0'"
        ) from None


def _entry(
    name: str, geometry: str, test: AxialTest, prior: PopulationPrior, key: str
) -> Identified:
    result, tested = identification.identify(test, prior), test.tested
    label = label_of(tested)
    return Identified(
        propeller=name,
        blades=tested.blades,
        family=tested.family,
        tested=tested.name,
        geometry=geometry,
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
        verdict=verdict(tested, result),
        key=key,
    )


def _key(test: AxialTest, before: Sequence[str] = ()) -> str:
    """A short digest of all that a result depends on but the program itself.

    Parameters
    ----------
    test : AxialTest
        Blade and data.
    before : sequence of str
        Keys of the results that its prior is made of.
    """
    settings = (
        INDEPENDENT,
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
