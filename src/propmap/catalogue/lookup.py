"""Propellers, section laws, models and measured loads, looked up by name."""

from __future__ import annotations

import difflib
import functools
import os
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from propmap import catalogue
from propmap.catalogue import Entry, designation, expected, identified
from propmap.errors import InputError, located, quoted
from propmap.io.csv import read_lines
from propmap.io.formats import PE0, format_of
from propmap.io.geometry import check_radius, read_geometry_file
from propmap.io.sections import read_section_table
from propmap.loads import LOADS
from propmap.model.air import Air
from propmap.model.airfoil import Airfoil, SectionTable, airfoil_names, parameter_set
from propmap.model.corrections import Correction, model_corrections
from propmap.model.model import Model
from propmap.model.propeller import Propeller, check_blades
from propmap.typing import Floats
from propmap.units import INCH

_SIZE_AT_END = re.compile(r"\s+\d\S*( mm)?( \(.*\))?$")
_NAME = re.compile(r"[A-Za-z][^\s-]*(-[^\s-]+)+")


def propeller(
    name_or_path: str | os.PathLike[str],
    blades: int | None = None,
    radius: float | None = None,
    root_cutout: float | None = None,
) -> Propeller:
    """Return a propeller from the catalogue or a geometry file, or predict it from a designation.

    The first of these sources that applies is used:

    1. a name in the catalogue;
    2. a file;
    3. the catalogue propeller of a designation with manufacturer or series;
    4. the mean blade of the named series, or of all series if the manufacturer is unknown or the
       designation contains only the size.

    Parameters
    ----------
    name_or_path : str or path
        A name that ``propmap props`` lists, ignoring case; a designation such as "APC 11x7E" or
        "HQ 5x4.3x3"; or the path of a file in a supported format.
    blades : int, optional
        Number of blades; required if a file does not contain it.  Otherwise it replaces the number
        of the file or the catalogue.
    radius : float, optional
        Tip radius [m]; required for a file with fractions of the radius.  It must agree with the
        radius of any other geometry.
    root_cutout : float, optional
        Radius at which the loaded part of the blade begins [m].

    Raises
    ------
    InputError
        For an unknown name (the message lists similar names), a designation that fits several
        series, and a file without a propeller.
    """
    meant = _named(name_or_path, blades)
    if meant is None:
        found = read_geometry_file(os.fspath(name_or_path), blades=blades, radius=radius)
    else:
        if isinstance(meant, expected.ExpectedBlade):
            found = meant.propeller
        else:
            found = replace(catalogue.load(meant.name), blades=meant.blades)
        with located(found.name):
            check_radius(found.radius, radius)
    return found if root_cutout is None else found.with_root_cutout(root_cutout)


def meant_by(name_or_path: str | os.PathLike[str], blades: int | None = None) -> expected.Meant:
    """Return the entry or predicted blade that ``propeller`` uses, with ``blades`` if given.

    For a file of APC, return the entry of the propeller in its title; for other files, None.  Raise
    the errors of ``propeller``.
    """
    return _named(name_or_path, blades) or _of_apc_file(Path(name_or_path))


def _named(name_or_path: str | os.PathLike[str], blades: int | None) -> expected.Meant:
    """Return the entry or predicted blade for a name or a designation; None for a file."""
    text = os.fspath(name_or_path)
    name = text.strip().lower()
    if not name:
        remedy = "give a catalogue name, a designation such as 'HQ 5x4.3x3', or a file"
        raise InputError("the name of the propeller is empty", remedy)
    if blades is not None:
        blades = check_blades(blades)
    found: catalogue.Entry | expected.ExpectedBlade
    if name in catalogue.names():
        found = catalogue.entry(name)
    elif (one := identified.named_without_blade(name)) is not None:
        found = expected.blade_of(
            text, designation.Designation((one.family,), *one.size, None), one
        )
    elif looks_like_path(name_or_path):
        return None
    else:
        found = designated(text)
    if isinstance(found, expected.ExpectedBlade):
        return found.with_blades(blades)
    return found if blades is None else replace(found, blades=blades)


def _of_apc_file(path: Path) -> catalogue.Entry | None:
    """Return the entry of the propeller in the title of an APC file; None for other files."""
    lines = read_lines(path) if path.is_file() else []
    if not lines or format_of(lines) is not PE0:
        return None
    title = next(iter(lines[0].split()), "")
    try:
        size = designation.designation(title)
    except InputError:  # an impossible size, so the title is not a designation
        return None
    return catalogue.of_makers_file(title, size.blades or 2, size.diameter) if size else None


def designated(text: str) -> catalogue.Entry | expected.ExpectedBlade:
    """Return the catalogue propeller for a designation, with its number of blades, or a prediction.

    A size alone selects no catalogue propeller.  A blade from a manufacturer's file requires the
    series and, for other than 2 blades, their number.  Raise ``InputError`` for other text, an
    unknown name in the form of a catalogue name, and a designation that fits several series.
    """
    wanted = designation.designation(text)
    if wanted is None or "edf" in wanted.words:
        raise designation.without_size(text)
    found, series = designation.candidates(wanted), designation.series_named(wanted.words)[0]
    meant = [
        one
        for one in found
        if one.geometry == "measured" or (len(series) == 1 and one.blades in (2, wanted.blades))
    ]
    if wanted.words and len(meant) == 1:
        return replace(meant[0], blades=wanted.blades or meant[0].blades)
    if series and _NAME.fullmatch(text.strip()):
        raise catalogue.unknown_name(text)
    if wanted.words and meant:
        names = ", ".join(entry.name for entry in meant)
        remedy = "give one of these names; see `propmap props`"
        raise InputError(f"{quoted(text)} may be {names}", remedy)
    return expected.expected_blade(text, wanted, [entry.name for entry in found])


def airfoil(name_or_path: str | os.PathLike[str]) -> Airfoil | SectionTable:
    """Return a section law: a named set of constants, a parameter file, or a section table.

    Parameters
    ----------
    name_or_path : str or path
        "paper-soft", "paper-stiff" or "paper-apc" (Table I), "apc-8x6e-2019" (fitted to oblique
        flow in a wind tunnel), the path of a parameter file or a fit (.toml), or the path of a
        section table for ``read_section_table``: a file of AeroDyn, XFOIL, CACTUS or CSV, or a
        folder with XFOIL polars.

    Raises
    ------
    InputError
        For an unknown name, and for a file without a section law.
    """
    text = os.fspath(name_or_path)
    path = Path(text)
    named = text.lower() in airfoil_names() or path.suffix.lower() == ".toml"
    if not named and path.exists():
        return read_section_table(path)
    return parameter_set(text)


def search(text: str) -> list[catalogue.Entry]:
    """Return entries as ``catalogue.search``, including propellers without a measured blade."""
    others = map(_without_blade, identified.identified_without_blade())
    return catalogue.matching(text, [*catalogue.entries(), *others])


def _without_blade(one: identified.Identified) -> catalogue.Entry:
    series = designation.WITHOUT_BLADE.get(one.family)
    if series is None:
        titles = [entry.title for entry in catalogue.entries() if entry.family == one.family]
        # The last title is from the database, after those of manufacturers, and ends with the size.
        series = _SIZE_AT_END.sub("", titles[-1])
    size = "x".join(f"{length / INCH:.4g}" for length in one.size)
    title = f"{series} {size}, blade not measured"
    source = f"loads: UIUC Propeller Database; geometry: the mean of its {one.geometry}"
    return Entry(one.propeller, title, one.family, one.blades, one.diameter_m, source)


def looks_like_path(name_or_path: str | os.PathLike[str]) -> bool:
    """Return whether ``name_or_path`` is the path of a file, not a name in the catalogue."""
    if not isinstance(name_or_path, str) or "/" in name_or_path or os.sep in name_or_path:
        return True
    try:
        path = Path(name_or_path)
        # A size such as 8x4.5 seems to have a suffix, so a suffix must begin with a letter.
        return path.exists() or path.suffix[1:2].isalpha()
    except (OSError, ValueError):
        return True


# --- Catalogue predictions: the model of a propeller with the best known constants ---------------


def catalogue_model(
    name_or_path: str | os.PathLike[str],
    blades: int | None = None,
    *,
    air: Air | None = None,
    corrections: tuple[Correction, ...] | None = None,
) -> Model:
    """Return the model of a propeller: its blade, and the best known section constants.

    ``propmap.propeller`` provides the blade.  The constants were identified from measured loads of
    this propeller.  Without measured loads, the constants are predicted from its family, or from
    all small propellers.  The constants have a covariance, so the loads have standard deviations.

    Parameters
    ----------
    name_or_path : str or path
        A name in the catalogue, a designation such as "HQ 5x4.3x3", or a geometry file.
    blades : int, optional
        Number of blades, as in ``propmap.propeller``.
    air : Air, optional
        By default the air of the paper.
    corrections : tuple, optional
        By default the corrections of the recommended model, and ``Installed()``: the rotor drag of
        a rotor on a motor, with its uncertainty.

    Raises
    ------
    InputError
        As in ``propmap.propeller``.
    """
    blade = propeller(name_or_path, blades)
    known = best_constants(meant_by(name_or_path, blades), blade)
    added = corrections
    if added is None:
        added = model_corrections("recommended", installed=True)
    return Model(blade, known.airfoil, air or Air(), added)


def best_constants(
    meant: expected.Meant, blade: Propeller
) -> identified.Identified | expected.ExpectedConstants:
    """Return the identified constants of this propeller, or else predicted constants."""
    return own_constants(meant, blade.blades) or predicted_constants(meant, blade)


def own_constants(meant: expected.Meant, blades: int) -> identified.Identified | None:
    """Return the constants identified from loads of this propeller with this number of blades."""
    if isinstance(meant, expected.ExpectedBlade):
        return meant.own if meant.own is not None and meant.own.blades == blades else None
    return identified.identified(meant.name, blades) if meant is not None else None


def predicted_constants(meant: expected.Meant, blade: Propeller) -> expected.ExpectedConstants:
    """Return predicted constants of a propeller without identified ones; ``meant`` may be None."""
    family = meant.family if meant is not None else None
    size, geometry = expected.size_of(meant, blade), geometry_of(meant, blade)
    return expected.expected_constants(
        family, size, geometry, blade.blades, doubt_of(meant, blade.blades)
    )


def doubt_of(meant: expected.Meant, blades: int) -> float:
    """Return the probability that a designation does not mean this number of ``blades``."""
    if not isinstance(meant, expected.ExpectedBlade) or blades != meant.propeller.blades:
        return 0.0
    return meant.wanted.doubt


def geometry_of(meant: expected.Meant, blade: Propeller) -> str:
    """Return the origin of the ``blade``, in the words of ``expected_constants``."""
    if not isinstance(meant, expected.ExpectedBlade):
        return meant.geometry if meant is not None else "measured"
    # An option may have increased the number of blades.
    return meant.with_blades(blade.blades if blade.blades > 2 else None).geometry


# --- Bundled measurements of loads, one TOML file each in ``measurements/`` ----------------------

SUFFIX = ".toml"
_FOLDER = Path(__file__).parent / "measurements"


@dataclass(frozen=True, eq=False)
class Measurement:
    """Published loads of one propeller at n operating points.

    Attributes
    ----------
    name, propeller : str
        Names of the measurement and of the propeller in the catalogue.
    kind : str
        "measured" points, points "digitized" from a figure, or a published "fit".
    air_density : float
        Air density [kg/m^3].
    note, citation : str
        Treatment of the published values, and the reference to cite.
    omega, speed, beta : ndarray, shape (n,)
        Operating points [rad/s], [m/s], [rad].
    loads : mapping of str to ndarray, shape (n,)
        Published loads, by their names in ``propmap.loads.LOADS`` [N], [N m].
    """

    name: str
    propeller: str
    kind: str
    air_density: float
    note: str
    citation: str
    omega: Floats
    speed: Floats
    beta: Floats
    loads: Mapping[str, Floats]


def measurement_names() -> list[str]:
    """Return the names of all measurements, in alphabetical order."""
    return sorted(file.stem for file in _FOLDER.glob(f"*{SUFFIX}"))


@functools.lru_cache(maxsize=32)
def measurement(name: str) -> Measurement:
    """Return the measurement ``name``, ignoring case; raise ``InputError`` if it is unknown."""
    key, known = name.strip().lower(), measurement_names()
    if key not in known:
        close = difflib.get_close_matches(key, known, n=3, cutoff=0.3) or known
        found = f"{quoted(name)} is not a measurement of the catalogue"
        raise InputError(found, f"choose one of {', '.join(close)}")
    file = _FOLDER / f"{key}{SUFFIX}"
    fields = tomllib.loads(file.read_text(encoding="utf-8"))

    def array(column: str) -> Floats:
        values = np.array(fields[column], dtype=np.float64)
        values.flags.writeable = False
        return values

    return Measurement(
        name=key,
        **{text: fields[text] for text in ("propeller", "kind", "note", "citation")},
        air_density=float(fields["air_density"]),
        omega=array("omega_rad_s"),
        speed=array("speed_m_s"),
        beta=array("beta_rad"),
        loads={n: array(load.column) for n, load in LOADS.items() if load.column in fields},
    )
