"""How well a propeller is predicted from the others, without its own rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from propmap import catalogue
from propmap.arrays.types import Floats
from propmap.catalogue.designation import designation
from propmap.catalogue.expected_blade import ExpectedBlade, mean_blade, shapes_without
from propmap.catalogue.expected_constants import expected_constants
from propmap.catalogue.family_prior import family_prior
from propmap.catalogue.identified import PARAMETERS, Identified
from propmap.catalogue.lookup import designated
from propmap.catalogue.prior import constants_of
from propmap.catalogue.spread import spread
from propmap.fit.population.coefficients import AxialTest
from propmap.fit.population.summary import one_of_each
from propmap.io.uiuc_database import MeasuredPropeller
from propmap.model.propeller import Propeller


class LeftOut(NamedTuple):
    """Errors of C_T and C_P of one propeller, rms over rms of what was measured [-], (2,) each.

    Attributes
    ----------
    tested : str
        What the database calls it.
    own : ndarray
        With its own constants.
    family : ndarray or None
        With the mean of its family, itself left out; None of the only one of its family.
    population : ndarray
        With the mean of all families, itself left out.
    family_blade, population_blade : ndarray or None
        As these two, with the mean of the others' blades in place of its own; None where the
        family has no other constants or no other blade.
    """

    tested: str
    own: Floats
    family: Floats | None
    population: Floats
    family_blade: Floats | None
    population_blade: Floats


def left_out(entries: Sequence[Identified], every: Sequence[MeasuredPropeller]) -> list[LeftOut]:
    """The errors of each of ``entries``, with its rows left out, and its blade known or left out.

    Parameters
    ----------
    entries : sequence of Identified
        Constants of all propellers.
    every : sequence of MeasuredPropeller
        Their rows, as ``misfiled.refiled`` gives them.
    """
    rows = {tested.name: tested for tested in every}
    chosen = one_of_each(entries)
    found = []
    for one in chosen:
        rest = [other for other in chosen if other is not one]
        over = spread(rest)
        family = [other for other in rest if other.family == one.family]
        of_family, of_all = (constants_of(family_prior(some, over).mean) for some in (family, []))
        blade = replace(catalogue.load(one.propeller), blades=one.blades)
        known = AxialTest(blade, rows[one.tested])
        family_mean, mean = _means(one)
        like_family = AxialTest(family_mean, rows[one.tested]) if family_mean and family else None
        found.append(
            LeftOut(
                tested=one.tested,
                own=_errors(known, one.constants),
                family=_errors(known, of_family) if family else None,
                population=_errors(known, of_all),
                family_blade=_errors(like_family, of_family) if like_family else None,
                population_blade=_errors(AxialTest(mean, rows[one.tested]), of_all),
            )
        )
    return found


LOST_POINT = ("ancf 125.0x", "ancf 12.0x65.0", "ancf 13.0x65.0")
"""Propellers whose labels in the database have lost a decimal point: 12.5x7.5, 12x6.5."""


class ByDesignation(NamedTuple):
    """Errors of C_T and C_P of one propeller that is known by its label alone.

    Attributes
    ----------
    tested : str
        The label.
    family : str or None
        Code of the series by which it was predicted; None of all.
    errors : ndarray
        Rms over rms of what was measured [-], (2,).
    """

    tested: str
    family: str | None
    errors: Floats


def by_designation(every: Sequence[MeasuredPropeller]) -> list[ByDesignation]:
    """The errors of those propellers whose blades were never measured, by blade and constants.

    None of their rows plays any part in what they are predicted from.

    Parameters
    ----------
    every : sequence of MeasuredPropeller
        Rows of all propellers.
    """
    found = []
    for tested in every:
        meant = None if tested.name.startswith(LOST_POINT) else designated(tested.name)
        if isinstance(meant, ExpectedBlade):
            law, _ = expected_constants(meant.family)
            constants = np.array([getattr(law, name) for name in PARAMETERS])
            errors = _errors(AxialTest(meant.propeller, tested), constants)
            found.append(ByDesignation(tested.name, meant.family, errors))
    return found


def _means(one: Identified) -> tuple[Propeller | None, Propeller]:
    """The blade of ``one`` by the means of its family and of all, itself left out."""
    entry = catalogue.entry(one.propeller)
    label = designation(entry.title)
    assert label is not None  # a test reads all titles
    size = (one.tested, label.diameter, label.pitch, one.blades)
    others = shapes_without(entry)
    of_all = mean_blade(others).propeller(*size)
    if entry.family not in {other.family for other in others}:
        return None, of_all
    return mean_blade(others, [entry.family]).propeller(*size), of_all


def _errors(test: AxialTest, constants: Floats) -> Floats:
    error = test.modelled(constants)[0] - test.measured
    return np.sqrt(np.nanmean(error**2, axis=1) / np.mean(test.measured**2, axis=1))
