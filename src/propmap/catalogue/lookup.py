"""Propellers and section laws by their name in the catalogue, or from a file."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from propmap import catalogue
from propmap.catalogue.designation import candidates, designation, nearest
from propmap.errors import InputError, quoted
from propmap.io.blade_table import check_radius
from propmap.io.geometry_file import read_geometry_file
from propmap.io.section_tables import looks_like_section_table, read_section_table
from propmap.model.airfoil import Airfoil, airfoil_names, parameter_set
from propmap.model.propeller import Propeller
from propmap.model.section_table import SectionTable


def propeller(
    name_or_path: str | os.PathLike[str],
    blades: int | None = None,
    radius: float | None = None,
    root_cutout: float | None = None,
) -> Propeller:
    """A propeller from the catalogue, or from a geometry file of any format propmap reads.

    Parameters
    ----------
    name_or_path : str or path
        A name that ``propmap props`` lists, in upper or lower case; a designation that means one
        of them, such as "APC 11x7E" or "master airscrew 9x6"; or a path.
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
        For an unknown name, with close ones, a designation that several propellers have, and a file
        that holds no propeller.
    """
    text, name = os.fspath(name_or_path), catalogue_name(name_or_path)
    if name is not None:
        found = catalogue.load(name)
        if radius is not None:
            check_radius(found.radius, radius, where=found.name)
        if blades is not None:
            found = replace(found, blades=blades)
    else:
        found = read_geometry_file(text, blades=blades, radius=radius)
    return found if root_cutout is None else found.with_root_cutout(root_cutout)


def catalogue_name(name_or_path: str | os.PathLike[str]) -> str | None:
    """The name in the catalogue of what ``propeller`` would give; None for a file.

    Raises
    ------
    InputError
        For what is neither a file nor means one propeller.
    """
    text = os.fspath(name_or_path)
    name = text.strip().lower()
    if name in catalogue.names():
        return name
    return None if looks_like_path(name_or_path) else designated(text).name


def designated(text: str) -> catalogue.Entry:
    """The one propeller of the catalogue that a designation means; ``InputError`` if not one."""
    wanted = designation(text)
    if wanted is None:
        raise catalogue.unknown_name(text)
    found = candidates(wanted)
    if not found:
        raise InputError(
            f"no propeller of the catalogue is {quoted(text)}",
            f"the next in size are {', '.join(nearest(wanted))}; see `propmap props`, or give a "
            "geometry file",
        )
    if len(found) > 1:
        names = ", ".join(entry.name for entry in found)
        raise InputError(
            f"{quoted(text)} may be {names}", "give one of these names; see `propmap props`"
        )
    return found[0]


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
