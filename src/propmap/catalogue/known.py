"""A model of a propeller from its name alone: blade, and the best constants known of it."""

from __future__ import annotations

import os

from propmap.catalogue import Entry
from propmap.catalogue.expected_blade import ExpectedBlade
from propmap.catalogue.expected_constants import ExpectedConstants, expected_constants, size_of
from propmap.catalogue.identified import Identified, identified
from propmap.catalogue.lookup import meant_by, propeller
from propmap.model.corrections import Correction, corrections_of
from propmap.model.model import Air, Model, Propeller


def known_model(
    name_or_path: str | os.PathLike[str],
    blades: int | None = None,
    *,
    air: Air | None = None,
    corrections: tuple[Correction, ...] | None = None,
) -> Model:
    """The model of a propeller by name: its blade, and the best constants that are known of it.

    The blade is that of ``propmap.propeller``.  The constants are those identified from the
    propeller's own loads; else those to be expected of its family, else of any small propeller.
    They carry how well they are known, so that loads have standard deviations.

    Parameters
    ----------
    name_or_path : str or path
        A name of the catalogue, a designation such as "HQ 5x4.3x3", or a geometry file.
    blades : int, optional
        Number of blades, where it is not said or another number is wanted.
    air : Air, optional
        By default the paper's.
    corrections : tuple, optional
        By default those of the recommended model.

    Raises
    ------
    InputError
        As ``propmap.propeller``.
    """
    blade = propeller(name_or_path, blades)
    meant = meant_by(name_or_path)
    known = own_constants(meant, blade.blades) or constants_to_expect(meant, blade)
    added = corrections_of("recommended") if corrections is None else corrections
    return Model(blade, known.airfoil, air or Air(), added)


def own_constants(meant: Entry | ExpectedBlade | None, blades: int) -> Identified | None:
    """The constants identified from a propeller's own loads with so many ``blades``, if any.

    Parameters
    ----------
    meant : Entry, ExpectedBlade or None
        What its name means, from ``meant_by``.
    blades : int
        Number of blades.
    """
    if isinstance(meant, ExpectedBlade):
        return meant.own if meant.own is not None and meant.own.blades == blades else None
    return identified(meant.name, blades) if meant is not None else None


def constants_to_expect(meant: Entry | ExpectedBlade | None, blade: Propeller) -> ExpectedConstants:
    """The constants to be expected of a propeller that was not identified itself.

    Parameters
    ----------
    meant : Entry, ExpectedBlade or None
        What its name means, from ``meant_by``; None of a geometry file.
    blade : Propeller
        Its blade.
    """
    return expected_constants(
        meant.family if meant is not None else None,
        size_of(meant, blade),
        meant.geometry if isinstance(meant, ExpectedBlade) else "measured",
    )
