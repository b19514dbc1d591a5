"""Section constants to expect of a propeller that was not identified: its family's, or any's."""

from __future__ import annotations

from typing import Any

import numpy as np

from propmap.catalogue.family_prior import family_prior
from propmap.catalogue.identified import PARAMETERS, all_identified
from propmap.catalogue.prior import HELD, constants_of, slopes_of
from propmap.catalogue.spread import spread
from propmap.model.airfoil import Airfoil
from propmap.model.section_covariance import SectionCovariance
from propmap.model.uncertainty import SectionUncertainty

MEDIAN_ERRORS = {"family": 0.11, "population": 0.14}
"""Of C_T and C_P of propellers that were left out, by ``python -m tools.left_out``: half of them
err less, rms over rms."""

DISCREPANCY = (0.0025, 0.0017)
"""Errors of C_T and C_P that the best constants leave, of a typical propeller."""


def expected_constants(family: str | None = None) -> tuple[Airfoil, str]:
    """The most likely constants of a small propeller, and in one line what they rest on.

    Parameters
    ----------
    family : str, optional
        Code of its series in the catalogue, such as "apcsf"; None where it is not known.

    Returns
    -------
    airfoil : Airfoil
        The constants.
    told : str
        How many propellers they are from and how far loads computed with them may err.
    """
    every = all_identified()
    members = [one for one in every if one.family == family]
    prior = family_prior(members, spread(every))
    place, slopes = prior.mean, slopes_of(prior.mean)
    known = SectionUncertainty(
        SectionCovariance(PARAMETERS, slopes @ np.diag(prior.deviation**2) @ slopes.T),
        *DISCREPANCY,
    )
    found = zip(PARAMETERS, constants_of(place).tolist(), strict=True)
    values: Any = {**HELD, **dict(found)}
    name = f"{family} expected" if members else "small propeller expected"
    source = f"prior over propellers by propmap, family {family if members else 'unknown'}"
    likely = MEDIAN_ERRORS["family" if members else "population"]
    of = (
        f"of its family, {family}, {len(members)} propellers"
        if members
        else f"of {len(every)} small propellers, none of its family"
    )
    told = (
        f"constants as to be expected by those {of}; it was not identified itself: half of such "
        f"propellers have thrust and torque within {likely:.0%} (rms) in axial flow, one in ten is "
        "off by twice that"
    )
    return Airfoil(**values, name=name, source=source, uncertainty=known), told
