"""How well a propeller is predicted from the others, without its own rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from propmap import catalogue
from propmap.arrays.types import Floats
from propmap.catalogue.identified import Identified
from propmap.fit.population.coefficients import AxialTest
from propmap.fit.population.families import family_prior
from propmap.fit.population.prior import constants_of
from propmap.fit.population.summary import one_of_each, spread
from propmap.io.uiuc_database import MeasuredPropeller


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
    """

    tested: str
    own: Floats
    family: Floats | None
    population: Floats


def left_out(entries: Sequence[Identified], every: Sequence[MeasuredPropeller]) -> list[LeftOut]:
    """The errors of each of ``entries``, with its blade known and its rows left out.

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
        blade = replace(catalogue.load(one.propeller), blades=one.blades)
        test = AxialTest(blade, rows[one.tested])
        at_mean = [constants_of(family_prior(some, over).mean) for some in (family, [])]
        own, of_family, of_all = (_errors(test, c) for c in (one.constants, *at_mean))
        found.append(LeftOut(one.tested, own, of_family if family else None, of_all))
    return found


def _errors(test: AxialTest, constants: Floats) -> Floats:
    error = test.modelled(constants)[0] - test.measured
    return np.sqrt(np.nanmean(error**2, axis=1) / np.mean(test.measured**2, axis=1))
