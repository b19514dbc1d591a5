"""What a fit starts from: section constants to be expected of the propeller's family, or of any."""

from __future__ import annotations

import difflib
from typing import Annotated

import typer

from propmap.catalogue import Entry
from propmap.catalogue.expected import ExpectedBlade, airfoil_at, expected_prior, siblings, size_of
from propmap.catalogue.identified import all_identified
from propmap.catalogue.lookup import meant_by, own_constants
from propmap.errors import InputError, quoted
from propmap.fit.parameters import SectionPrior
from propmap.model.model import Propeller

PriorFrom = Annotated[
    str | None,
    typer.Option(
        "--prior-from",
        metavar="family|population|none|CODE",
        help="Propellers that tell what constants to expect: those of its family, or any where it "
        "is not known; any; none; those of the family CODE, as apcsf. By default family, and none "
        "where --free or --airfoil says what to fit.",
    ),
]


def section_prior(
    wanted: str | None, prop: str, blade: Propeller | None = None, *, by_default: bool
) -> SectionPrior | None:
    """What other propellers tell of ``prop``; None for no prior.

    Parameters
    ----------
    wanted : str or None
        As ``--prior-from``.
    prop : str
        The propeller: a name of the catalogue, a designation, or anything else for an unknown one.
    blade : Propeller, optional
        Its blade, which tells its size; a middling one where it is not given.
    by_default : bool
        Whether there is a prior where none is asked for.

    Raises
    ------
    InputError
        For an unknown family.
    """
    source = (wanted or ("family" if by_default else "none")).strip().lower()
    if source == "none":
        return None
    meant = _meant(prop)
    family = meant.family if meant is not None else None
    known = None if meant is None or blade is None else own_constants(meant, blade.blades)
    own = known.tested if known is not None else None
    if source == "population":
        family = None
    elif source != "family":
        family = _family(source)
    size = None if blade is None else size_of(meant, blade)
    geometry = meant.geometry if isinstance(meant, ExpectedBlade) else "measured"
    distribution = expected_prior(family, size, geometry, without=own)
    members = siblings(family, without=own)
    few = "one propeller" if members == 1 else f"{members} propellers"
    of = f"{few} of the family {family}" if members else "small propellers of all families"
    told = f"what {of} let expect is the prior of the section constants"
    if own:
        told += " (its own in the catalogue left out)"
    return SectionPrior(distribution, airfoil_at(distribution.mean, "expected", told), told)


def say_prior(prior: SectionPrior | None) -> list[str]:
    """Say on standard error what a fit started from; the same as remarks for its file."""
    if prior is None:
        return []
    typer.echo(f"note: {prior.told}; without, by --prior-from none", err=True)
    return [prior.told]


def _meant(prop: str) -> Entry | ExpectedBlade | None:
    """What a name means; None for a file, or for the name of a blade in one."""
    try:
        return meant_by(prop)
    except InputError:
        return None


def _family(code: str) -> str:
    known = sorted({one.family for one in all_identified()})
    if code not in known:
        close = difflib.get_close_matches(code, known, n=3) or known
        raise InputError(
            f"{quoted(code)} is no family of identified propellers",
            f"give family, population, none or a code such as {', '.join(close)}",
            "--prior-from",
        )
    return code
