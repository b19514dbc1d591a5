"""Targets ``npz``, ``nc`` and ``csv``: the map itself, in other files."""

from __future__ import annotations

import csv
import io

import numpy as np

from propmap.export.folder import Files
from propmap.export.note import note
from propmap.export.provenance import identifier
from propmap.loads import LOADS
from propmap.table.query import LoadTable


def npz_files(table: LoadTable) -> Files:
    """The map as ``propmap.table.LoadTable`` reads it."""
    return {f"{identifier(table)}.npz": table.save, "README-npz.txt": note(table, "npz")}


def nc_files(table: LoadTable) -> Files:
    """The map as NetCDF."""
    from propmap.table.files import write_netcdf

    return {
        f"{identifier(table)}.nc": lambda path: write_netcdf(table, path),
        "README-nc.txt": note(table, "nc"),
    }


def csv_files(table: LoadTable) -> Files:
    """The map's knots as rows of numbers."""
    return {f"{identifier(table)}.csv": _rows(table), "README-csv.txt": note(table, "csv")}


def _rows(table: LoadTable) -> str:
    content = table.content
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        ["omega_rad_s", "advance", "beta_rad", *(f"{name}_coefficient" for name in LOADS)]
    )
    for omega, level in zip(content.omega.tolist(), content.coefficients, strict=True):
        for i, advance in enumerate(content.advance.tolist()):
            for j, beta in enumerate(content.beta.tolist()):
                values = level[:, i, j].astype(np.float32)
                shown = ["" if np.isnan(value) else str(value) for value in values]
                writer.writerow([omega, advance, beta, *shown])
    return text.getvalue()
