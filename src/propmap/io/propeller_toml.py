"""Blade geometry in propmap's own format, one TOML file per propeller."""

from __future__ import annotations

import os
import tomllib
from typing import Any

import numpy as np

from propmap.arrays.types import Floats
from propmap.errors import InputError, quoted
from propmap.io.blade_table import build_propeller, check_radius
from propmap.io.text_file import read_lines
from propmap.model.blade_check import check_blades, check_root_cutout
from propmap.model.propeller import Propeller

SCHEMA = 1
TEXT_KEYS = ("name", "title", "family", "source", "citation")
ARRAY_KEYS = ("station_m", "chord_m", "twist_rad")
REQUIRED = ("schema", "name", "blades", "radius_m", *ARRAY_KEYS)
OPTIONAL = ("title", "family", "source", "citation", "root_cutout_m")


def read_propeller_toml(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """A propeller from a file in the format of the catalogue.

    Parameters
    ----------
    path : path
        Of the file.
    blades : int, optional
        Replaces the file's.
    radius : float, optional
        Tip radius [m], which must agree with the file.

    Raises
    ------
    InputError
        Naming the field.
    """
    where = os.fspath(path)
    return parse_propeller_toml("\n".join(read_lines(path)), where, blades, radius)


def parse_propeller_toml(
    text: str, where: str, blades: int | None = None, radius: float | None = None
) -> Propeller:
    """``read_propeller_toml`` for text already in memory; ``where`` names it in messages."""
    fields = parse_toml(text, where, SCHEMA)
    _check_keys(fields, where)
    station, chord, twist = (float_array(fields[key], key, where) for key in ARRAY_KEYS)
    labels = [f"entry {i}" for i in range(station.size)]
    count = fields["blades"] if blades is None else blades
    result = build_propeller(
        where,
        labels,
        fields["name"],
        check_blades(count, where),
        station,
        chord,
        twist,
        source=fields.get("source", ""),
        citation=fields.get("citation", ""),
    )
    for stated in (_number(fields["radius_m"], "radius_m", where), radius):
        if stated is not None:
            check_radius(result.radius, stated, where)
    if "root_cutout_m" not in fields:
        return result
    root = _number(fields["root_cutout_m"], "root_cutout_m", where)
    return result.with_root_cutout(check_root_cutout(root, station, f"{where}: root_cutout_m"))


def parse_toml(text: str, where: str, schema: int) -> dict[str, Any]:
    """The fields of a TOML text whose ``schema`` is as expected, or ``InputError``."""
    try:
        fields = tomllib.loads(text)
    # A number of thousands of digits is a plain ValueError, deep nesting a RecursionError.
    except (ValueError, RecursionError) as error:
        raise InputError(f"not TOML: {error}", "correct the syntax", where) from None
    if fields.get("schema") != schema or isinstance(fields.get("schema"), bool):
        raise InputError(
            f"schema is {quoted(fields.get('schema'))}, expected {schema}",
            f"write schema = {schema}, or update propmap if the file is newer",
            where,
        )
    return fields


def float_array(values: Any, key: str, where: str) -> Floats:
    """A TOML array of numbers as float64, or ``InputError``."""
    if isinstance(values, list):
        return np.array([_number(v, key, where) for v in values], dtype=np.float64)
    raise InputError(
        f"{key} is {quoted(values)}, expected a list of numbers", f"write {key} = [...]", where
    )


def _number(value: Any, key: str, where: str) -> float:
    # A TOML integer may be too long for a float.
    try:
        if isinstance(value, int | float) and not isinstance(value, bool):
            return float(value)
    except OverflowError:
        pass
    raise InputError(
        f"{key} has the entry {quoted(value)}, expected a number", "write a number", where
    )


def _check_keys(fields: dict[str, Any], where: str) -> None:
    for key in REQUIRED:
        if key not in fields:
            raise InputError(f"no field {key}", f"add {key} = ...", where)
    for key, value in fields.items():
        if key not in REQUIRED + OPTIONAL:
            raise InputError(
                f"found field {quoted(key)}, expected one of {', '.join(REQUIRED + OPTIONAL)}",
                "rename, comment or remove it",
                where,
            )
        if key in TEXT_KEYS and not isinstance(value, str):
            raise InputError(f"{key} is {quoted(value)}, expected text", "use quotes", where)
