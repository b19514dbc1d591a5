"""Constants for every propeller of the UIUC database whose blade is in the catalogue."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

import numpy as np

from propmap import catalogue
from propmap.catalogue.identified import Identified
from propmap.catalogue.prior import POPULATION
from propmap.errors import InputError
from propmap.fit.population import identification
from propmap.fit.population.coefficients import AxialTest, airfoil_of
from propmap.fit.population.verdict import verdict
from propmap.fit.rows import INDEPENDENT
from propmap.io.uiuc_database import MeasuredPropeller

SPECIMENS = ("", "-b", "-c")
"""Endings of the names of a blade of which several were measured."""

MAKERS_FILES = {"apce": "apc-{}e", "apcsf": "apc-{}sf"}
"""Names in the catalogue of blades of these families by their maker's own files."""


def blade_names(tested: MeasuredPropeller) -> list[str]:
    """Names in the catalogue of the blades that a propeller of the database may have.

    Those that the database measured come first, then that of the maker's file.

    Parameters
    ----------
    tested : MeasuredPropeller
        The propeller.
    """
    family, _, size = tested.blade.partition(" ")
    try:
        size = "x".join(f"{float(part):g}" for part in size.split("x"))
    except ValueError:
        raise InputError(
            f"the blade's name is {tested.blade!r}", "expected one as in 'apce 8.0x6.0'"
        ) from None
    possible = [f"uiuc-{family}-{size}{end}" for end in SPECIMENS]
    if family in MAKERS_FILES:
        possible.append(MAKERS_FILES[family].format(size))
    known = catalogue.names()
    return [name for name in possible if name in known]


def identify_all(
    every: Iterable[MeasuredPropeller],
    known: Mapping[str, Identified],
    done: Callable[[list[Identified]], None],
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
        Called with all results so far after each new one.
    """
    found: list[Identified] = []
    for tested in every:
        names = blade_names(tested)
        specimens = sum(name.startswith("uiuc") for name in names)
        for name in names:
            test = AxialTest(replace(catalogue.load(name), blades=tested.blades), tested)
            key = _key(test)
            if key not in known:
                found.append(_entry(name, specimens, test, key))
                done(found)
            else:
                found.append(known[key])
    return found


def _entry(name: str, specimens: int, test: AxialTest, key: str) -> Identified:
    result, tested = identification.identify(test), test.tested
    told = verdict(tested, result)
    if not name.startswith("uiuc"):
        told = f"blade by its maker's file; {told}"
    elif specimens > 1:
        told = f"one of {specimens} blades measured, each tested in some of the runs; {told}"
    return Identified(
        propeller=name,
        blades=tested.blades,
        family=tested.family,
        tested=tested.name,
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
        verdict=told,
        key=key,
    )


def _key(test: AxialTest) -> str:
    """A short digest of all that a result depends on but the program itself."""
    settings = (
        INDEPENDENT,
        identification.FIRST_ERRORS,
        identification.LEAST_ERRORS,
        identification.MOST_ERRORS,
        POPULATION.mean.tolist(),
        POPULATION.deviation.tolist(),
    )
    digest = hashlib.sha256(repr(settings).encode())
    digest.update(test.propeller.fingerprint().encode())
    rows = (test.tested.rpm, test.tested.advance, test.tested.thrust, test.tested.power)
    digest.update(np.stack(rows).tobytes())
    return digest.hexdigest()[:16]
