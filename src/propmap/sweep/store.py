"""Results of tasks in one Zarr store, which a run that was killed leaves fit to go on.

A part of the results is a file per quantity, written under another name and then renamed, and the
part counts as done once its last file is there.  So a killed process or a full disk costs the parts
under way, no more; to write a part again changes nothing.  Any number of processes may write, each
its own parts.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import uuid
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from propmap.errors import InputError
from propmap.sweep.points import Place, parts_along

if TYPE_CHECKING:
    from numpy.typing import NDArray

RUN = "propmap_run"
"""Attribute of the store with what its results depend on."""

SAME = {
    "kind": "kind of run",
    "propmap": "version of propmap",
    "model": "model",
    "points": "set of operating points",
    "accuracy": "accuracy",
    "quantities": "set of quantities",
    "chunk": "size of tasks",
}
"""What must be the same for a run to go on, in words."""

NOT_DONE = 255
"""Status of points that have not been computed yet."""


@dataclass(frozen=True)
class Layout:
    """What a store holds.

    Attributes
    ----------
    sizes : dict of str to int
        Dimensions and their lengths.
    chunk : tuple of int
        Shape of the parts.
    coordinates : mapping
        Dimensions, values and attributes by name.
    quantities : mapping
        Type and attributes by name; the last one is written last.
    attributes : mapping
        Of the store, as JSON has them.
    depends_on : mapping of str to str
        The entries of ``SAME``.
    """

    sizes: Mapping[str, int]
    chunk: tuple[int, ...]
    coordinates: Mapping[str, tuple[tuple[str, ...], NDArray[Any], Mapping[str, Any]]]
    quantities: Mapping[str, tuple[np.dtype[Any], Mapping[str, Any]]]
    attributes: Mapping[str, Any] = field(default_factory=dict)
    depends_on: Mapping[str, str] = field(default_factory=dict)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return tuple(self.sizes.values())

    @property
    def bytes(self) -> int:
        """Size of the quantities before they are compressed."""
        return math.prod(self.shape) * sum(kind.itemsize for kind, _ in self.quantities.values())


@dataclass(frozen=True)
class Store:
    """A store on disk.

    Attributes
    ----------
    path : Path
        Its folder.
    run : str
        Made up when it was created, so that another machine can tell whether it sees this store.
    """

    path: Path
    run: str

    @classmethod
    def create(cls, path: Path, layout: Layout) -> Store:
        """A new store; it appears whole or not at all.

        Parameters
        ----------
        path : Path
            Where nothing is yet.
        layout : Layout
            What it is to hold.
        """
        zarr = _zarr()
        part = path.with_name(f".{path.name}.part")
        shutil.rmtree(part, ignore_errors=True)
        run = uuid.uuid4().hex
        # What are coordinates though they are not named as a dimension, as CF has it.
        others = " ".join(name for name in layout.coordinates if name not in layout.sizes)
        told = {**layout.attributes, "coordinates": others}
        told[RUN] = {**layout.depends_on, "run": run}
        try:
            group = zarr.create_group(str(part), zarr_format=3, attributes=told)
            for name, (dims, values, attributes) in layout.coordinates.items():
                array = group.create_array(
                    name,
                    data=np.asarray(values),
                    dimension_names=dims,
                    attributes=dict(attributes),
                )
            for name, (kind, attributes) in layout.quantities.items():
                array = group.create_array(
                    name,
                    shape=layout.shape,
                    chunks=layout.chunk,
                    dtype=kind,
                    fill_value=np.nan if kind.kind == "f" else NOT_DONE,
                    dimension_names=tuple(layout.sizes),
                    attributes=_plain(attributes),
                )
                assert array.chunks == layout.chunk
            with warnings.catch_warnings():
                # Readers ask for it and warn where it is not there; so does zarr where it is made.
                warnings.filterwarnings("ignore", "Consolidated metadata is currently not part")
                zarr.consolidate_metadata(str(part))
            part.replace(path)
        except BaseException:
            shutil.rmtree(part, ignore_errors=True)
            raise
        return cls(path, run)

    @classmethod
    def resume(cls, path: Path, layout: Layout) -> Store:
        """The store at a path, for a run that goes on; what was left half written is removed.

        Parameters
        ----------
        path : Path
            Of its folder.
        layout : Layout
            What it ought to hold.

        Raises
        ------
        InputError
            Where it is no store of propmap's, or results would differ from those it has.
        """
        before = begun(path)
        for name, words in SAME.items():
            if before.get(name) != layout.depends_on.get(name):
                was = before.get(name, "")
                told = f" ({was})" if was and len(was) <= len("0.10.2") else ""
                raise InputError(
                    f"it was begun with another {words}{told}",
                    "choose another name, or pass --force to begin anew",
                    str(path),
                )
        for left in path.rglob("*.partial"):
            left.unlink(missing_ok=True)
        return cls(path, before["run"])

    @property
    def here(self) -> bool:
        """Whether this process sees the store."""
        try:
            return begun(self.path).get("run") == self.run
        except InputError:
            return False

    def write(self, place: Place, values: Mapping[str, NDArray[Any]]) -> None:
        """File the values of a part, by quantity.

        Parameters
        ----------
        place : tuple of int
            Of the part.
        values : mapping of str to ndarray
            Of the part's shape, all quantities, in the order of the layout.

        Raises
        ------
        OSError
            Such as that of a full disk; it names the store.
        """
        group = _zarr().open_group(str(self.path), mode="r+")
        for name, part in values.items():
            array = group[name]
            cut = tuple(
                slice(k * n, min((k + 1) * n, length))
                for k, n, length in zip(place, array.chunks, array.shape, strict=True)
            )
            try:
                array[cut] = part
            except OSError as error:
                reason = error.strerror or str(error)
                raise OSError(error.errno, reason, str(self.path)) from None

    def done(self, layout: Layout) -> NDArray[np.bool_]:
        """Which parts are filed, by place.

        Parameters
        ----------
        layout : Layout
            Of the store.
        """
        found = np.zeros(parts_along(layout.shape, layout.chunk), bool)
        top = self.path / list(layout.quantities)[-1] / "c"
        for folder, _, files in os.walk(top):
            before = Path(folder).relative_to(top).parts
            for name in files:
                if name.isdecimal():
                    found[(*map(int, before), int(name))] = True
        return found


def begun(path: Path) -> dict[str, str]:
    """What the results of the store at ``path`` depend on, as ``Layout.depends_on``, and its run.

    Raises ``InputError`` where no store of propmap's is there.
    """
    try:
        told = json.loads((path / "zarr.json").read_text(encoding="utf-8"))
        return dict(told["attributes"][RUN])
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError(
            "this is no store of propmap's", "choose another name", str(path)
        ) from None


def _plain(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes as JSON has them."""
    return {
        key: value.tolist() if isinstance(value, np.ndarray) else value
        for key, value in attributes.items()
    }


def _zarr() -> Any:
    try:
        import zarr
    except ImportError:
        raise InputError(
            "this needs zarr", "pip install '.[cluster]' in propmap's checkout"
        ) from None
    return zarr
