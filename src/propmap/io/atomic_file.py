"""Files that appear whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A path in the same folder to write to; renamed to ``path`` if the block succeeds.

    Whatever ends the block otherwise, an interruption included, leaves ``path`` as it was
    and nothing beside it.  An ``OSError``, of a full disk say, names ``path``.
    """
    part = path.with_name(f".{path.name[:100]}.{os.getpid()}.part")
    try:
        yield part
        part.replace(path)
    except OSError as error:
        if error.filename is not None and str(error.filename) != str(part):
            raise
        reason = error.strerror or str(error)
        raise OSError(error.errno or 0, reason, str(path)) from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def write_dataset(dataset: xarray.Dataset, path: Path) -> None:
    """Write a dataset as NetCDF, whole or not at all.

    It is made in memory first: where a disk is full, the HDF5 library ends the process.
    """
    with replacing(path) as part:
        part.write_bytes(dataset.to_netcdf(engine="h5netcdf"))
