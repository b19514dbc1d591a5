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

FORMULA = (
    "thrust and drag are rho pi R^4 omega^2 times the coefficient, torque and roll moment "
    "rho pi R^5 omega^2; in between, the coefficients are linear in omega^(-1/2) and cubic in "
    "the advance ratio V/(omega R) and in beta."
)


def npz_files(table: LoadTable) -> Files:
    """The map as ``propmap.table.LoadTable`` reads it."""
    paragraphs = ["The map itself, for propmap.table.LoadTable.load, which needs NumPy alone."]
    return {
        f"{identifier(table)}.npz": table.save,
        "README-npz.txt": note(table, "npz", paragraphs),
    }


def nc_files(table: LoadTable) -> Files:
    """The map as NetCDF."""
    from propmap.table.netcdf import write_netcdf

    paragraphs = [f"The map's coefficients with units, for xarray and its like: {FORMULA}"]
    return {
        f"{identifier(table)}.nc": lambda path: write_netcdf(table, path),
        "README-nc.txt": note(table, "nc", paragraphs),
    }


def csv_files(table: LoadTable) -> Files:
    """The map's knots as rows of numbers."""
    paragraphs = [
        f"A row for each knot of the map: {FORMULA} Empty where there is no value. Which cells "
        "between the knots are vortex ring or unresolved is not in it."
    ]
    return {
        f"{identifier(table)}.csv": _rows(table),
        "README-csv.txt": note(table, "csv", paragraphs),
    }


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
