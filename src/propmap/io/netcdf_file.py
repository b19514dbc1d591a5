"""NetCDF files that appear whole or not at all."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from propmap.io.atomic_file import replacing

if TYPE_CHECKING:
    import xarray


def write_dataset(dataset: xarray.Dataset, path: Path) -> None:
    """Write a dataset, whole or not at all.

    It is made in memory first: where a disk is full, the HDF5 library ends the process.
    """
    with replacing(path) as part:
        part.write_bytes(dataset.to_netcdf(engine="h5netcdf"))
