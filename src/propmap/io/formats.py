"""Recognition of file formats by content, of supported and of other formats."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from propmap.errors import InputError, quoted

HEAD = 60  # number of lines of a file that are searched for the sign of a format


class Format(NamedTuple):
    """A format of text files."""

    name: str
    sign: str  # a pattern that one of the first lines matches
    use: str  # what to do with such a file


BLADE = "use it as the argument PROP of a command"
POLAR = "use it with --airfoil"
AS_CSV = "write radius_m,chord_m,twist_deg as CSV"
LOADS = "use it with propmap fit or propmap check"

PE0 = Format("an APC PE0 file", r"\s*STATION\s+CHORD\b|.*AIRFOIL SUMMARY DATA", BLADE)
UIUC_GEOMETRY = Format("a UIUC geometry file", r"\s*r/R[\s,;]+c/R[\s,;]+beta\s*$", BLADE)
QPROP = Format("a QPROP propeller", r".*!\s*(Nblades|Rfac|CL0)\b|\s*[#!]\s*r\s+chord\s", BLADE)
XROTOR = Format("an XROTOR file", r"\s*XROTOR\s+VERSION", BLADE)
BEM = Format("an OpenVSP .bem file", r"\.*\s*BEM Propeller", BLADE)
TOML = Format("a TOML file of propmap", r"\s*schema\s*=", "name it .toml")
AERODYN_15 = Format("AeroDyn v15", r"[^!]*\S\s+NumTabs\b", POLAR)
AERODYN = Format("AeroDyn", r".*number of airfoil tables in this file", POLAR)
QBLADE = Format("QBlade", r".*\bPOLARNAME\b|[\d.e+ ]+REYNOLDS *(-|$)|\s*REYNOLDS +\d", POLAR)
XFOIL = Format("XFOIL", r"\s*(alpha|aoa)\s+CL\s+CD\b", POLAR)
CACTUS = Format("CACTUS", r"reynolds number:", POLAR)
UIUC_LOADS = Format("UIUC loads", r"\s*(J|RPM)[\s,]+CT[\s,]+CP\b", LOADS)
PERFILES = Format("a PERFILE of APC, with computed loads", r"\s*PROP\s+RPM\s*=", LOADS)

FORMATS = (
    *(PE0, UIUC_GEOMETRY, QPROP, XROTOR, BEM, AERODYN_15, AERODYN, QBLADE, XFOIL, CACTUS),
    *(UIUC_LOADS, PERFILES, TOML),
    Format("an AeroDyn blade file", r"\s*BlSpn\s+BlCrvAC", f"it has no tip radius; {AS_CSV}"),
    Format("a DFDC case", r"\s*DFDC\s+VERSION", f"ducts are not modeled; {AS_CSV}"),
    Format("a QBlade or JBLADE project", r".*(QBlade|JBLADE)", "export blade and polars as text"),
    Format("an STL surface", r"\s*solid\b", AS_CSV),
    Format("coordinates of an airfoil", r"\s*1\.0*\s+-?0?\.0\d*\s*$", "give its polar past stall"),
)
"""All formats, likelier ones first, because a file may match several signs."""


def format_of(lines: Sequence[str]) -> Format | None:
    """Return the format of the lines of a file; None for CSV and for unknown formats."""
    head = [line for line in lines if line.strip()][:HEAD]
    for one in FORMATS:
        sign = re.compile(one.sign, re.IGNORECASE)
        if any(sign.match(line) for line in head):
            return one
    return None


def not_read(lines: Sequence[str], what: str, wanted: str, where: str) -> InputError:
    """Return the error for a file that is not a ``what``, with its format and a remedy."""
    found = format_of(lines)
    if found is not None:
        return InputError(f"this is {found.name}, not a {what}", found.use, where)
    first = next((line for line in lines if line.strip()), "")
    return InputError(
        f"begins with {quoted(first.strip(), 120)}, which is not a {what}", wanted, where
    )
