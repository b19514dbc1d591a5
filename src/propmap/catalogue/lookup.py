"""Propellers and section laws by their name in the catalogue, or from a file."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from propmap import catalogue
from propmap.io.blade_table import check_radius
from propmap.io.geometry_file import read_geometry_file
from propmap.model.airfoil import parameter_set
from propmap.model.model import Section
from propmap.model.propeller import Propeller


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
        A name that ``propmap props`` lists, in upper or lower case, or a path.
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
        For an unknown name, with close ones, and for a file that holds no propeller.
    """
    text = os.fspath(name_or_path)
    if text.strip().lower() in catalogue.names():
        found = catalogue.load(text)
        if radius is not None:
            check_radius(found.radius, radius, where=found.name)
        if blades is not None:
            found = replace(found, blades=blades)
    elif _looks_like_path(name_or_path):
        found = read_geometry_file(text, blades=blades, radius=radius)
    else:
        raise catalogue.unknown_name(text)
    return found if root_cutout is None else found.with_root_cutout(root_cutout)


def airfoil(name_or_path: str | os.PathLike[str]) -> Section:
    """A section law: a named set of constants, a parameter file, or a section table.

    Parameters
    ----------
    name_or_path : str or path
        "paper-soft", "paper-stiff" or "paper-apc" (Table I), or the path of a parameter file
        (.toml).

    Raises
    ------
    InputError
        For an unknown name, and for a file that holds no section law.
    """
    return parameter_set(os.fspath(name_or_path))


def _looks_like_path(name_or_path: str | os.PathLike[str]) -> bool:
    if not isinstance(name_or_path, str) or "/" in name_or_path or os.sep in name_or_path:
        return True
    try:
        path = Path(name_or_path)
        # A pitch such as 8x4.5 ends like a suffix, so a suffix counts only if it has a letter.
        return path.exists() or path.suffix[1:2].isalpha()
    except (OSError, ValueError):
        return True
