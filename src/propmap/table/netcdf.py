"""A table as a NetCDF file, for people and their tools."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray

from propmap.io.atomic_file import write_dataset
from propmap.loads import LOADS

if TYPE_CHECKING:
    from propmap.table.query import LoadTable


def write_netcdf(table: LoadTable, path: str | os.PathLike[str]) -> None:
    """Write what a ``table`` holds to ``path``, with units and provenance, whole or not at all."""
    write_dataset(table_dataset(table), Path(path))


def table_dataset(table: LoadTable) -> xarray.Dataset:
    """Coefficients over omega, advance ratio and beta, and the cells' flags.

    The loads are those of the advance ratio V/(Omega R); the envelope in V is in the attributes.
    """
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
