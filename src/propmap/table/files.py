"""Files of tables: NumPy's .npz without pickle (read and written), and NetCDF (written)."""

from __future__ import annotations

import json
import math
import os
import zlib
from dataclasses import fields
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import numpy as np

from propmap.errors import InputError, quoted, require
from propmap.io.csv import replacing, write_dataset
from propmap.loads import LOADS
from propmap.table.certificate import Certificate
from propmap.table.interpolation import TableContent

FORMAT = "propmap-table"
FORMAT_VERSION = 1

ARRAYS = dict.fromkeys(("advance", "beta", "omega", "speed"), "f8") | {
    "coefficients": "f4",
    "cells": "u1",
    "deviations": "f4",  # optional
}
"""Names and types of the arrays of a file, in either byte order."""

MOST_UNPACKED = 400_000_000  # largest size of its arrays according to the zip directory [bytes]

_DAMAGED = BadZipFile, zlib.error
_REMEDY = "give a file written by `propmap table`"


def write_table(content: TableContent, path: str | os.PathLike[str]) -> None:
    """Write a table to a .npz file atomically, with ``info`` as JSON text."""
    about = {"format": FORMAT, "format_version": FORMAT_VERSION, "sha256": content.sha256}
    known = {name: getattr(content, name) for name in ARRAYS}
    arrays: dict[str, Any] = {n: x.astype(ARRAYS[n]) for n, x in known.items() if x is not None}
    text = np.array(json.dumps({**content.info, **about}, allow_nan=False, ensure_ascii=False))
    with replacing(Path(path)) as part, part.open("xb") as file:
        np.savez_compressed(file, info=text, **arrays)


def read_table(path: str | os.PathLike[str]) -> TableContent:
    """Read a table; raise ``InputError`` for a missing, damaged, foreign or newer file."""
    where = os.fspath(path)
    try:
        with Path(where).open("rb") as stream:
            announced = sum(part.file_size for part in ZipFile(stream).infolist())
            if announced > MOST_UNPACKED:
                size = f"the file unpacks to {announced / 1e9:.1f} GB, more than any table"
                raise InputError(size, _REMEDY, where)
            stream.seek(0)
            with np.load(stream, allow_pickle=False) as file:
                read = {name: file[name] for name in file.files if name in (*ARRAYS, "info")}
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError("no such file", "check the path", where) from None
    except OSError as error:
        reason = error.strerror or str(error)
        found = f"cannot read the file: {reason}"
        raise InputError(found, "check the path and the file", where) from None
    except (ValueError, TypeError, LookupError, EOFError, RuntimeError, MemoryError, *_DAMAGED):
        # NumPy and zipfile raise these for truncated, altered, pickled, encrypted or foreign files.
        raise InputError("the file is not a table, or it is damaged", _REMEDY, where) from None
    try:
        info = _info(read)
        stated, arrays = info.pop("sha256", None), dict[str, Any]()
        for name in read.keys() - {"info"}:
            if read[name].dtype.str[1:] != ARRAYS[name]:
                raise InputError(f"{name} has values of the wrong type ({read[name].dtype})")
            arrays[name] = read[name].astype(np.uint8 if name == "cells" else np.float64)
        content = TableContent(**arrays, info=info)
        if stated != content.sha256:
            raise InputError("the numbers do not match the checksum")
        return content
    except InputError as error:
        remedy = error.remedy or "the file is damaged; build the table again"
        raise InputError(error.found, remedy, where) from None


def _info(found: dict[str, Any]) -> dict[str, Any]:
    """Check the format, loads, arrays and certificate of a file, and return its ``info``."""
    try:
        info = json.loads(str(found["info"][()]))
        name, version = info.pop("format"), info.pop("format_version")
    except (KeyError, ValueError, TypeError, AttributeError, RecursionError):
        raise InputError("the file does not describe a table", _REMEDY) from None
    if name != FORMAT:
        raise InputError(f"the format is {quoted(name)}, expected {FORMAT!r}", _REMEDY)
    if version != FORMAT_VERSION:
        fault = f"the table's format version is {quoted(version)}, this propmap reads "
        remedy = "install the propmap version that wrote it, or build the table again"
        raise InputError(f"{fault}{FORMAT_VERSION}", remedy)
    if info.get("loads", list(LOADS)) != list(LOADS):
        fault = f"the table contains {quoted(info['loads'])}, this propmap has {', '.join(LOADS)}"
        raise InputError(fault, "build the table again")
    missing = [name for name in ARRAYS if name not in (*found, "deviations")]
    if missing:
        raise InputError(f"the table has no {missing[0]}", _REMEDY)
    if info.get("certificate"):
        _check(info["certificate"])
    return dict(info)


def _check(certificate: Any) -> None:
    """Raise ``InputError`` for invalid numbers, and for errors that exceed the tolerance."""
    for field in fields(Certificate):
        try:
            value = certificate.get(field.name)
            by_load = str(field.type).startswith("dict")
            numbers = [value[load] for load in LOADS] if by_load else [value]
        except (AttributeError, TypeError, KeyError):
            numbers = [None]
        least = -math.inf if field.name == "max_omega" else 0.0
        if not all(type(n) in (int, float) and least <= n < math.inf for n in numbers):
            raise InputError(f"certificate: {field.name} is missing or not a finite number >= 0")
    if max(certificate["max_error"][load] for load in LOADS) > certificate["tolerance"]:
        raise InputError("certificate: the errors exceed the tolerance")


def write_netcdf(content: TableContent, path: str | os.PathLike[str]) -> None:
    """Write a table as NetCDF to ``path`` atomically, with units and provenance."""
    require("netcdf")
    import xarray

    axes = ("omega", "advance", "beta")
    meanings = {
        "omega": ("rad/s", "rotational speed"),
        "advance": ("1", "advance ratio V/(Omega R)"),
        "beta": ("rad", "angle between rotor axis and velocity, 0 in axial climb"),
    }
    coordinates = {
        name: (name, getattr(content, name), {"units": unit, "long_name": meaning})
        for name, (unit, meaning) in meanings.items()
    }
    variables: dict[str, Any] = {}
    for suffix, what, values in (
        ("", "", content.coefficients),
        ("_std", "standard deviation of ", content.deviations),
    ):
        if values is None:
            continue
        for k, (name, load) in enumerate(LOADS.items()):
            meaning = f"{what}{load.label} over rho pi R^{4 + load.moment} Omega^2"
            attributes = {"units": "1", "long_name": meaning}
            variables[name + suffix] = (axes, values[:, k].astype(np.float32), attributes)
    found = xarray.Dataset(variables, coordinates, _attributes(content))
    found["cells"] = (
        ("advance_interval", "beta_interval"),
        content.cells,
        {
            "long_name": "cells between the knots in which the loads are unreliable",
            "flag_masks": np.array([1, 2], np.uint8),
            "flag_meanings": "vortex_ring unresolved",
        },
    )
    write_dataset(found, Path(path))


def _attributes(content: TableContent) -> dict[str, str | float]:
    """Return ``info`` without nesting, with ``speed_low_m_s`` and ``speed_high_m_s``."""
    low, high = map(float, content.speed)
    flat: dict[str, str | float] = {"speed_low_m_s": low, "speed_high_m_s": high}
    for key, value in content.info.items():
        if isinstance(value, dict) and key in ("propeller", "airfoil", "air"):
            flat |= {f"{key}_{name}": entry for name, entry in value.items()}
        elif isinstance(value, (str, float, int)):
            flat[key] = value
        elif value is not None:
            flat[key] = json.dumps(value, ensure_ascii=False)
    return flat
