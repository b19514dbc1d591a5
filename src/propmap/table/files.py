"""Tables as files: NumPy's .npz, which the package reads, and NetCDF for other programs."""

from __future__ import annotations

import json
import os
import zipfile
import zlib
from dataclasses import MISSING, Field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from propmap.errors import InputError, quoted
from propmap.io.csv import replacing, write_dataset
from propmap.loads import LOADS
from propmap.table.certificate import Certificate
from propmap.table.interpolation import TableContent

if TYPE_CHECKING:
    import xarray

    from propmap.table.query import LoadTable


# -------------------------------------------------------------------------------------------------
# Tables as files: NumPy's .npz, without pickle.

FORMAT = "propmap-table"
FORMAT_VERSION = 1

ARRAYS = ("advance", "beta", "omega", "speed", "coefficients", "cells")

SINGLE = ("coefficients", "deviations")
"""Arrays in single precision; the second is there where the model's errors are known."""

MOST_BYTES = 200_000_000

_REMEDY = "give a file that `propmap table` wrote"


def write_table(content: TableContent, path: str | os.PathLike[str]) -> None:
    """Write a table to a .npz file, whole or not at all.

    The coefficients are kept in single precision, 6e-8 of their size, which is far below any
    tolerance; ``info`` is JSON text.
    """
    head = {"format": FORMAT, "format_version": FORMAT_VERSION, **content.info}
    arrays: dict[str, Any] = {name: getattr(content, name) for name in ARRAYS}
    for name in SINGLE:
        if getattr(content, name) is not None:
            arrays[name] = getattr(content, name).astype(np.float32)
    text = np.array(json.dumps(head, allow_nan=False, ensure_ascii=False))
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
            found = _arrays(stream, where)
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError("no such file", "check the path", where) from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(
            f"cannot read it: {reason}", "check the path and the file", where
        ) from None
    except (ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error, NotImplementedError):
        # What NumPy and zipfile raise for files cut short, altered, pickled or of another kind.
        raise InputError("this is no table, or a damaged one", _REMEDY, where) from None
    info = _info(found, where)
    try:
        return TableContent(**_typed(found), info=info)
    except InputError as error:
        raise InputError(error.found, "the file is damaged; build the table again", where) from None


def _arrays(stream: BinaryIO, where: str) -> dict[str, Any]:
    file = np.load(stream, allow_pickle=False)
    if not isinstance(file, np.lib.npyio.NpzFile):
        raise InputError("this is a single array, no table", _REMEDY, where)
    with file:
        return {name: file[name] for name in file.files if name in (*ARRAYS, *SINGLE, "info")}


def _info(found: dict[str, Any], where: str) -> dict[str, Any]:
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
        raise InputError(
            f"the table holds {quoted(info['loads'])}, this propmap has {', '.join(LOADS)}",
            "build the table again",
            where,
        )
    missing = [name for name in ARRAYS if name not in found]
    if missing:
        raise InputError(f"the table has no {missing[0]}", _REMEDY, where)
    certificate = info.get("certificate")
    if certificate:
        lacking = [field.name for field in fields(Certificate) if not _told(certificate, field)]
        if lacking:
            raise InputError(
                f"the table's certificate does not say {lacking[0]}", "build the table again", where
            )
    return dict(info)


def _told(certificate: Any, field: Field[Any]) -> bool:
    """Whether a certificate has a number there, or one for each load; or nothing, where earlier
    versions wrote nothing."""
    if not isinstance(certificate, dict):
        return False
    later = field.default is not MISSING or field.default_factory is not MISSING
    value = certificate.get(field.name)
    if later and value in (None, {}):
        return True
    numbers = [value]
    if str(field.type).startswith("dict"):
        if not (isinstance(value, dict) and sorted(value) == sorted(LOADS)):
            return False
        numbers = list(value.values())
    return all(isinstance(n, (int, float)) and not isinstance(n, bool) for n in numbers)


def _typed(found: dict[str, Any]) -> dict[str, Any]:
    names = [name for name in dict.fromkeys((*ARRAYS, *SINGLE)) if name in found]
    for name in names:
        kind = found[name].dtype.kind
        if kind not in ("u" if name == "cells" else "f"):
            raise InputError(f"{name} holds values of another kind ({found[name].dtype})")
    numbers = {name: found[name].astype(np.float64) for name in names if name != "cells"}
    return {**numbers, "cells": found["cells"].astype(np.uint8)}


# -------------------------------------------------------------------------------------------------
# A table as a NetCDF file, for people and their tools.


def write_netcdf(table: LoadTable, path: str | os.PathLike[str]) -> None:
    """Write what a ``table`` holds to ``path``, with units and provenance, whole or not at all."""
    write_dataset(table_dataset(table), Path(path))


def table_dataset(table: LoadTable) -> xarray.Dataset:
    """Coefficients over omega, advance ratio and beta, and the cells' flags.

    The loads are those of the advance ratio V/(Omega R); the envelope in V is in the attributes.
    """
    import xarray

    content = table.content
    coordinates = {
        "omega": ("omega", content.omega, {"units": "rad/s", "long_name": "rotational speed"}),
        "advance": (
            "advance",
            content.advance,
            {"units": "1", "long_name": "advance ratio V/(Omega R)"},
        ),
        "beta": (
            "beta",
            content.beta,
            {"units": "rad", "long_name": "angle from the axis to the velocity, 0 in climb"},
        ),
    }
    variables = {
        name: (
            ("omega", "advance", "beta"),
            content.coefficients[:, k].astype(np.float32),
            {"units": "1", "long_name": f"{load.label} over rho pi R^{4 + load.moment} Omega^2"},
        )
        for k, (name, load) in enumerate(LOADS.items())
    }
    if content.deviations is not None:
        for k, (name, load) in enumerate(LOADS.items()):
            variables[f"{name}_std"] = (
                ("omega", "advance", "beta"),
                content.deviations[:, k].astype(np.float32),
                {
                    "units": "1",
                    "long_name": f"standard deviation of {load.label} over rho pi "
                    f"R^{4 + load.moment} Omega^2",
                },
            )
    found = xarray.Dataset(variables, coordinates, _attributes(table))
    found["cells"] = (
        ("advance_interval", "beta_interval"),
        content.cells,
        {
            "long_name": "where between the knots the loads are not to be relied on",
            "flag_masks": np.array([1, 2], np.uint8),
            "flag_meanings": "vortex_ring unresolved",
        },
    )
    return found


def _attributes(table: LoadTable) -> dict[str, str | float]:
    """``info`` without its nesting; ``speed_low_m_s`` and the like for the envelope."""
    low, high = table.envelope["speed"]
    flat: dict[str, str | float] = {"speed_low_m_s": low, "speed_high_m_s": high}
    for key, value in table.info.items():
        if isinstance(value, dict) and key in ("propeller", "airfoil", "air"):
            flat |= {f"{key}_{name}": entry for name, entry in value.items()}
        elif isinstance(value, (str, float, int)):
            flat[key] = value
        elif value is not None:
            flat[key] = json.dumps(value, ensure_ascii=False)
    return flat
