"""Propellers and section laws by their name in the catalogue, or from a file."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path

from propmap import catalogue
from propmap.catalogue.designation import (
    INCH,
    WITHOUT_BLADE,
    Designation,
    candidates,
    designation,
    series_named,
)
from propmap.catalogue.expected_blade import ExpectedBlade, blade_of, expected_blade
from propmap.catalogue.identified import (
    Identified,
    identified_without_blade,
    named_without_blade,
)
from propmap.errors import InputError, quoted
from propmap.io.geometry import check_radius, read_geometry_file
from propmap.io.sections import looks_like_section_table, read_section_table
from propmap.model.airfoil import Airfoil, SectionTable, airfoil_names, parameter_set
from propmap.model.model import Propeller

_SIZE_AT_END = re.compile(r"\s+\d\S*( mm)?( \(.*\))?$")
_NAME = re.compile(r"[A-Za-z][^\s-]*(-[^\s-]+)+")


def propeller(
    name_or_path: str | os.PathLike[str],
    blades: int | None = None,
    radius: float | None = None,
    root_cutout: float | None = None,
) -> Propeller:
    """A propeller from the catalogue, from a geometry file, or as its designation lets expect.

    In this order: a name in the catalogue; a file; the one measured propeller that a designation
    with a maker or series means; the means over the series that it names, or over all series, for
    a size that was not measured or a size alone.

    Parameters
    ----------
    name_or_path : str or path
        A name that ``propmap props`` lists, in upper or lower case; a designation such as "APC
        11x7E" or "HQ 5x4.3x3"; or the path of a file of any format propmap reads.
    blades : int, optional
        Number of blades, where the file gives none or another number is wanted.
    radius : float, optional
        Tip radius [m], where the file gives fractions of it; where the geometry has a radius of
        its own, the two must agree.
    root_cutout : float, optional
        Where the loaded part of the blade begins [m].

    Raises
    ------
    InputError
        For an unknown name, with close ones, a designation that propellers of several series have,
        and a file that holds no propeller.
    """
    meant = meant_by(name_or_path)
    if meant is None:
        found = read_geometry_file(os.fspath(name_or_path), blades=blades, radius=radius)
    else:
        if isinstance(meant, ExpectedBlade):
            found = meant.propeller
        else:
            found = replace(catalogue.load(meant.name), blades=meant.blades)
        if radius is not None:
            check_radius(found.radius, radius, where=found.name)
        if blades is not None:
            found = replace(found, blades=blades)
    return found if root_cutout is None else found.with_root_cutout(root_cutout)


def meant_by(name_or_path: str | os.PathLike[str]) -> catalogue.Entry | ExpectedBlade | None:
    """What ``propeller`` would give the blade of; None for a file.

    Raises
    ------
    InputError
        As ``propeller``, but for what is wrong in a file.
    """
    text = os.fspath(name_or_path)
    name = text.strip().lower()
    if name in catalogue.names():
        return catalogue.entry(name)
    one = named_without_blade(name)
    if one is not None:
        return blade_of(text, Designation((one.family,), *one.size, None), one)
    return None if looks_like_path(name_or_path) else designated(text)


def designated(text: str) -> catalogue.Entry | ExpectedBlade:
    """The measured propeller that a designation means, else what is to be expected of it.

    The entry has the number of blades that the designation says.  A size alone means no maker, even
    where only one of that size was measured.  What is written like a name of the catalogue, maker
    and size joined by hyphens, must be one.

    Raises
    ------
    InputError
        For what is no designation, and where measured propellers of several series have it.
    """
    wanted = designation(text)
    if wanted is None:
        raise catalogue.unknown_name(text)
    found = candidates(wanted)
    if wanted.words and len(found) == 1:
        return replace(found[0], blades=wanted.blades or found[0].blades)
    if series_named(wanted.words)[0] and _NAME.fullmatch(text.strip()):
        raise catalogue.unknown_name(text)
    if wanted.words and found:
        names = ", ".join(entry.name for entry in found)
        raise InputError(
            f"{quoted(text)} may be {names}", "give one of these names; see `propmap props`"
        )
    return expected_blade(text, wanted, [entry.name for entry in found])


def airfoil(name_or_path: str | os.PathLike[str]) -> Airfoil | SectionTable:
    """A section law: a named set of constants, a parameter file, or a section table.

    Parameters
    ----------
    name_or_path : str or path
        "paper-soft", "paper-stiff" or "paper-apc" (Table I), "apc-8x6e-2019" (fitted to a wind
        tunnel's oblique flow), the path of a parameter file or a fit (.toml), or that of a section
        table as ``read_section_table`` takes it: a file of AeroDyn, XFOIL, CACTUS or CSV, or a
        folder with XFOIL's polars.

    Raises
    ------
    InputError
        For an unknown name, and for a file that holds no section law.
    """
    text = os.fspath(name_or_path)
    path = Path(text)
    named = text.lower() in airfoil_names() or path.suffix.lower() == ".toml"
    if not named and path.exists() and looks_like_section_table(path):
        return read_section_table(path)
    return parameter_set(text)


def search(text: str) -> list[catalogue.Entry]:
    """``catalogue.search``, and the propellers whose loads are known and whose blades are not."""
    words = text.lower().split()
    others = [_without_blade(one) for one in identified_without_blade()]
    return catalogue.search(text) + [
        entry
        for entry in others
        if all(word in f"{entry.name} {entry.title} {entry.family}".lower() for word in words)
    ]


def _without_blade(one: Identified) -> catalogue.Entry:
    series = WITHOUT_BLADE.get(one.family)
    if series is None:
        titles = [entry.title for entry in catalogue.entries() if entry.family == one.family]
        # The database's entries come after the makers', and have the size at the end.
        series = _SIZE_AT_END.sub("", titles[-1])
    size = "x".join(f"{length / INCH:.4g}" for length in one.size)
    return catalogue.Entry(
        name=one.propeller,
        title=f"{series} {size}, blade not measured",
        family=one.family,
        blades=one.blades,
        diameter_m=one.diameter_m,
        source=f"loads: UIUC Propeller Database; geometry by the means of its {one.geometry}",
    )


def looks_like_path(name_or_path: str | os.PathLike[str]) -> bool:
    """Whether ``name_or_path`` names a file rather than an entry of the catalogue."""
    if not isinstance(name_or_path, str) or "/" in name_or_path or os.sep in name_or_path:
        return True
    try:
        path = Path(name_or_path)
        # A pitch such as 8x4.5 ends like a suffix, so a suffix counts only if it has a letter.
        return path.exists() or path.suffix[1:2].isalpha()
    except (OSError, ValueError):
        return True
