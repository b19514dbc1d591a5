"""Section constants to expect of a propeller that was not identified: its family's, or any's."""

from __future__ import annotations

from typing import Any

from propmap.arrays.types import Floats
from propmap.catalogue.family_prior import family_prior
from propmap.catalogue.identified import PARAMETERS, all_identified
from propmap.catalogue.prior import HELD, PopulationPrior, constants_of
from propmap.catalogue.spread import spread
from propmap.model.airfoil import Airfoil

MEDIAN_ERRORS = {"family": 0.11, "population": 0.14}
"""Of C_T and C_P of propellers that were left out, by ``python -m tools.left_out``: half of them
err less, rms over rms."""


def expected_prior(
    family: str | None = None, without: str | None = None
) -> tuple[PopulationPrior, int]:
    """The distribution of the constants of a small propeller, and how many of its family it is by.

    Parameters
    ----------
    family : str, optional
        Code of its series in the catalogue, such as "apcsf"; None where it is not known.
    without : str, optional
        Name of a propeller of the catalogue whose own constants are left out.
    """
    every = [one for one in all_identified() if one.propeller != without]
    members = [one for one in every if one.family == family]
    return family_prior(members, spread(every)), len(members)


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
    distribution, members = expected_prior(family)
    name = f"{family} expected" if members else "small propeller expected"
    source = f"prior over propellers by propmap, family {family if members else 'unknown'}"
    likely = MEDIAN_ERRORS["family" if members else "population"]
    of = (
        f"of its family, {family}, {members} propellers"
        if members
        else f"of {len(all_identified())} small propellers, none of its family"
    )
    told = (
        f"constants as to be expected by those {of}; it was not identified itself: half of such "
        f"propellers have thrust and torque within {likely:.0%} (rms) in axial flow, one in ten is "
        "off by twice that"
    )
    return airfoil_at(distribution.mean, name, source), told


def airfoil_at(place: Floats, name: str, source: str) -> Airfoil:
    """The section law at coordinates (7,) of the constants."""
    found = zip(PARAMETERS, constants_of(place).tolist(), strict=True)
    values: Any = {**HELD, **dict(found)}
    return Airfoil(**values, name=name, source=source)
