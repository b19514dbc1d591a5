"""Any geometry file: which format it is in, read from its content."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence

from propmap.errors import InputError, quoted
from propmap.io.apc_pe0 import read_apc_pe0
from propmap.io.csv_dialect import header_names, is_comment
from propmap.io.propeller_csv import QUANTITIES, read_propeller_csv
from propmap.io.propeller_toml import read_propeller_toml
from propmap.io.text_file import read_lines
from propmap.io.uiuc_geometry import HEADER, read_uiuc_geometry
from propmap.model.propeller import Propeller

READERS: dict[str, Callable[..., Propeller]] = {
    "apc-pe0": read_apc_pe0,
    "uiuc": read_uiuc_geometry,
    "csv": read_propeller_csv,
    "toml": read_propeller_toml,
}


def read_geometry_file(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """A propeller from a file in any format that propmap reads.

    The format is told by the content; the name of the file plays no part.

    Parameters
    ----------
    path : path
        Of the file.
    blades, radius : int, float, optional
        As in the reader of that format; ``radius`` in [m].

    Raises
    ------
    InputError
        For a file in no format that is known, or with faults.
    """
    where = os.fspath(path)
    kind = recognise(read_lines(path), where)
    return READERS[kind](path, blades=blades, radius=radius)


def recognise(lines: Sequence[str], where: str) -> str:
    """The format of a file, one of ``READERS``, from its lines; ``InputError`` if unknown."""
    body = [line for line in lines if line.strip() and not is_comment(line)]
    first = body[0] if body else ""
    if any(line.split()[:2] == ["STATION", "CHORD"] for line in body) or any(
        "AIRFOIL SUMMARY DATA" in line for line in body
    ):
        return "apc-pe0"
    if first.split()[:2] == HEADER[:2]:
        return "uiuc"
    if any(line.partition("=")[0].strip() == "schema" for line in body):
        return "toml"
    if _is_csv_header(first):
        return "csv"
    raise InputError(
        f"begins with {quoted(first.strip())}, which is no propeller geometry that propmap knows",
        "give an APC PE0 file, a UIUC geometry file (r/R c/R beta), a catalogue TOML file, "
        "or a CSV file with columns such as radius_m,chord_m,twist_deg",
        where,
    )


def _is_csv_header(line: str) -> bool:
    """Whether a column is named after a blade quantity, its unit right or wrong."""
    stems = {name.split("_")[0].lower() for names in QUANTITIES.values() for name in names}
    known = [name for several in QUANTITIES.values() for name in several]
    cells = header_names(line, known)
    return len(cells) > 1 and any(cell.split("_")[0] in stems for cell in cells)
