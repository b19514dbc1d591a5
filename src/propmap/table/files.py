"""Tables as files: NumPy's .npz without pickle, which the package reads, and NetCDF."""

from __future__ import annotations

import json
import os
import zlib
from dataclasses import MISSING, Field, fields
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile, is_zipfile

import numpy as np

from propmap.errors import InputError, quoted, require
from propmap.io.csv import replacing, write_dataset
from propmap.loads import LOADS
from propmap.table.certificate import Certificate
from propmap.table.interpolation import TableContent

FORMAT = "propmap-table"
FORMAT_VERSION = 1

ARRAYS = ("advance", "beta", "omega", "speed", "coefficients", "cells")

SINGLE = ("coefficients", "deviations")  # in single precision; the second may lack
MOST_BYTES = 200_000_000
MOST_UNPACKED = 400_000_000  # bytes that the arrays of a file may announce

_REMEDY = "give a file that `propmap table` wrote"


def write_table(content: TableContent, path: str | os.PathLike[str]) -> None:
    """Write a table to a .npz file, whole or not at all, with ``info`` as JSON text."""
    about = {"format": FORMAT, "format_version": FORMAT_VERSION, "sha256": content.sha256}
    arrays: dict[str, Any] = {name: getattr(content, name) for name in ARRAYS}
    for name in SINGLE:
        if getattr(content, name) is not None:
            arrays[name] = getattr(content, name).astype(np.float32)
    text = np.array(json.dumps({**content.info, **about}, allow_nan=False, ensure_ascii=False))
    with replacing(Path(path)) as part, part.open("xb") as file:
        np.savez_compressed(file, info=text, **arrays)


def read_table(path: str | os.PathLike[str]) -> TableContent:
    """Read a table; ``InputError`` for a missing, damaged or foreign file or a later format."""
    where = os.fspath(path)
    try:
        if Path(where).stat().st_size > MOST_BYTES:
            raise InputError(f"more than {MOST_BYTES / 1e6:g} MB is no table", _REMEDY, where)
        # Opened here, since NumPy leaves a file open that it cannot make sense of.
        with Path(where).open("rb") as stream:
            if is_zipfile(stream):
                announced = sum(part.file_size for part in ZipFile(stream).infolist())
                if announced > MOST_UNPACKED:
                    size = f"it unpacks to {announced / 1e9:.1f} GB, more than a table has"
                    raise InputError(size, _REMEDY, where)
            stream.seek(0)
            file = np.load(stream, allow_pickle=False)
            if not isinstance(file, np.lib.npyio.NpzFile):
                raise InputError("this is a single array, no table", _REMEDY, where)
            known = (*ARRAYS, *SINGLE, "info")
            with file:
                read = {name: file[name] for name in file.files if name in known}
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError("no such file", "check the path", where) from None
    except OSError as error:
        reason = error.strerror or str(error)
        found = f"cannot read it: {reason}"
        raise InputError(found, "check the path and the file", where) from None
    except (ValueError, EOFError, KeyError, BadZipFile, zlib.error, RuntimeError, MemoryError):
        # What NumPy and zipfile raise for files cut short, altered, pickled, locked, or foreign.
        raise InputError("this is no table, or a damaged one", _REMEDY, where) from None
    info = _info(read, where)
    stated = info.pop("sha256", None)
    try:
        arrays: dict[str, Any] = {}
        for name in dict.fromkeys((*ARRAYS, *SINGLE)):
            if name not in read:
                continue
            if read[name].dtype.kind != ("u" if name == "cells" else "f"):
                raise InputError(f"{name} holds values of another kind ({read[name].dtype})")
            arrays[name] = read[name].astype(np.uint8 if name == "cells" else np.float64)
        content = TableContent(**arrays, info=info)
        if stated != content.sha256:
            raise InputError("its numbers are not those of its checksum")
        return content
    except InputError as error:
        raise InputError(error.found, "the file is damaged; build the table again", where) from None


def _info(found: dict[str, Any], where: str) -> dict[str, Any]:
    """Check what a file says of itself, and return what it says of its table."""
    try:
        info = json.loads(str(found["info"][()]))
        name, version = info.pop("format"), info.pop("format_version")
    except (KeyError, ValueError, TypeError, AttributeError, RecursionError):
        raise InputError("the file says nothing of a table", _REMEDY, where) from None
    if name != FORMAT:
        raise InputError(f"the format is {quoted(name)}, expected {FORMAT!r}", _REMEDY, where)
    if version != FORMAT_VERSION:
        raise InputError(
            f"the table's format version is {quoted(version)}, this propmap reads {FORMAT_VERSION}",
            "install the propmap that wrote it, or build the table again",
            where,
        )
    if info.get("loads", list(LOADS)) != list(LOADS):
        fault = f"the table holds {quoted(info['loads'])}, this propmap has {', '.join(LOADS)}"
        raise InputError(fault, "build the table again", where)
    missing = [name for name in ARRAYS if name not in found]
    if missing:
        raise InputError(f"the table has no {missing[0]}", _REMEDY, where)
    certificate = info.get("certificate")
    if certificate:
        lacking = [field.name for field in fields(Certificate) if not _states(certificate, field)]
        if lacking:
            fault = f"the table's certificate does not say {lacking[0]}"
            raise InputError(fault, "build the table again", where)
    return dict(info)


def _states(certificate: Any, field: Field[Any]) -> bool:
    """Say whether a certificate has a number there, or one for each load, or the field is newer."""
    if not isinstance(certificate, dict):
        return False
    value = certificate.get(field.name)
    newer = field.default is not MISSING or field.default_factory is not MISSING
    if newer and value in (None, {}):
        return True
    numbers = [value]
    if str(field.type).startswith("dict"):
        if not (isinstance(value, dict) and sorted(value) == sorted(LOADS)):
            return False
        numbers = list(value.values())
    return all(isinstance(n, (int, float)) and not isinstance(n, bool) for n in numbers)


def write_netcdf(content: TableContent, path: str | os.PathLike[str]) -> None:
    """Write a table as NetCDF to ``path``, with units and provenance, whole or not at all."""
    require("netcdf")
    import xarray

    axes = ("omega", "advance", "beta")
    meanings = {
        "omega": ("rad/s", "rotational speed"),
        "advance": ("1", "advance ratio V/(Omega R)"),
        "beta": ("rad", "angle from the axis to the velocity, 0 in climb"),
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
            "long_name": "where between the knots the loads are not to be relied on",
            "flag_masks": np.array([1, 2], np.uint8),
            "flag_meanings": "vortex_ring unresolved",
        },
    )
    write_dataset(found, Path(path))


def _attributes(content: TableContent) -> dict[str, str | float]:
    """Flatten ``info``, with ``speed_low_m_s`` and the like for the envelope."""
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
