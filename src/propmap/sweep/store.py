"""Results of tasks, in one Zarr store that a killed run leaves fit to go on, or in memory.

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
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from propmap.errors import InputError
from propmap.sweep.points import Place, parts_along

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

RUN = "propmap_run"  # attribute of the store with what its results depend on

SAME = {
    "kind": "kind of run",
    "propmap": "version of propmap",
    "model": "model",
    "points": "set of operating points",
    "accuracy": "accuracy",
    "quantities": "set of quantities",
    "chunk": "size of tasks",
}  # what must be the same for a run to go on, in words

NOT_DONE = 255  # status of points that have not been computed yet


@dataclass(frozen=True)
class Layout:
    """What a store holds."""

    sizes: Mapping[str, int]  # lengths of the dimensions
    chunk: tuple[int, ...]  # shape of the parts
    # Dimensions, values and attributes by name.
    coordinates: Mapping[str, tuple[tuple[str, ...], NDArray[Any], Mapping[str, Any]]]
    # Type and attributes by name; the last one is written last.
    quantities: Mapping[str, tuple[np.dtype[Any], Mapping[str, Any]]]
    attributes: Mapping[str, Any] = field(default_factory=dict)  # of the store, as JSON has them
    depends_on: Mapping[str, str] = field(default_factory=dict)  # the entries of ``SAME``

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return tuple(self.sizes.values())

    @property
    def bytes(self) -> int:
        """Size of the quantities before they are compressed."""
        return math.prod(self.shape) * sum(kind.itemsize for kind, _ in self.quantities.values())

    def dataset(self, values: Mapping[str, NDArray[Any]]) -> xarray.Dataset:
        """The ``values`` by quantity, of this shape or flat, as an xarray dataset."""
        import xarray

        variables = {
            name: (tuple(self.sizes), found.reshape(self.shape), dict(self.quantities[name][1]))
            for name, found in values.items()
        }
        coordinates = {name: (d, v, dict(a)) for name, (d, v, a) in self.coordinates.items()}
        return xarray.Dataset(variables, coordinates, dict(self.attributes))


@dataclass(frozen=True)
class Store:
    """A store on disk: its folder, and a ``run`` by which another machine knows it again."""

    path: Path
    run: str

    @classmethod
    def create(cls, path: Path, layout: Layout) -> Store:
        """Make a new store at a ``path`` where nothing is yet; it appears whole or not at all."""
        zarr = _zarr()
        part = path.with_name(f".{path.name}.part")
        shutil.rmtree(part, ignore_errors=True)
        run = uuid.uuid4().hex
        # What are coordinates though they are not named as a dimension, as CF has it.
        others = " ".join(name for name in layout.coordinates if name not in layout.sizes)
        about = {**layout.attributes, "coordinates": others}
        about[RUN] = {**layout.depends_on, "run": run}
        try:
            group = zarr.create_group(str(part), zarr_format=3, attributes=about)
            for name, (dims, values, attributes) in layout.coordinates.items():
                array = group.create_array(
                    name, data=np.asarray(values), dimension_names=dims, attributes=dict(attributes)
                )
            for name, (kind, attributes) in layout.quantities.items():
                array = group.create_array(
                    name,
                    shape=layout.shape,
                    chunks=layout.chunk,
                    dtype=kind,
                    fill_value=_unfilled(kind),
                    dimension_names=tuple(layout.sizes),
                    attributes={
                        key: value.tolist() if isinstance(value, np.ndarray) else value
                        for key, value in attributes.items()
                    },
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
        """Open the store of an earlier run without what it left half written; ``InputError`` where
        the folder is no store of propmap's, or results would differ."""
        before = begun(path)
        for name, words in SAME.items():
            if before.get(name) != layout.depends_on.get(name):
                was = before.get(name, "")
                version = f" ({was})" if was and len(was) <= len("0.10.2") else ""
                raise InputError(
                    f"it was begun with another {words}{version}",
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
        """File the ``values`` by quantity of the part at a ``place`` in the layout's order; an
        ``OSError``, as of a full disk, names the store."""
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
        """Which parts of the ``layout`` are filed, by place."""
        found = np.zeros(parts_along(layout.shape, layout.chunk), bool)
        top = self.path / list(layout.quantities)[-1] / "c"
        for folder, _, files in os.walk(top):
            before = Path(folder).relative_to(top).parts
            for name in files:
                if name.isdecimal():
                    found[(*map(int, before), int(name))] = True
        return found


class InMemory:
    """A store for results that fit in memory, in the place of a ``Store``."""

    here = False  # workers send their results

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.values: dict[str, NDArray[Any]] = {
            name: np.full(layout.shape, _unfilled(kind), kind)
            for name, (kind, _) in layout.quantities.items()
        }

    def __getstate__(self) -> dict[str, Any]:
        """Workers need nothing of it."""
        return {}

    def write(self, place: Place, values: Mapping[str, NDArray[Any]]) -> None:
        """Keep the ``values`` by quantity of the part at a ``place``."""
        for name, part in values.items():
            cut = tuple(
                slice(k * n, k * n + m)
                for k, n, m in zip(place, self.layout.chunk, part.shape, strict=True)
            )
            self.values[name][cut] = part

    def done(self, layout: Layout) -> NDArray[np.bool_]:
        """No part of the ``layout`` is filed yet."""
        return np.zeros(parts_along(layout.shape, layout.chunk), bool)

    def dataset(self) -> xarray.Dataset:
        """All results as an xarray dataset."""
        return self.layout.dataset(self.values)


Filed: TypeAlias = Store | InMemory


def begun(path: Path) -> dict[str, str]:
    """Read what the results of the store at ``path`` depend on, as ``Layout.depends_on``, and its
    run; ``InputError`` for another folder."""
    try:
        found = json.loads((path / "zarr.json").read_text(encoding="utf-8"))
        return dict(found["attributes"][RUN])
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError(
            "this is no store of propmap's", "choose another name", str(path)
        ) from None


def _unfilled(kind: np.dtype[Any]) -> float:
    return np.nan if kind.kind == "f" else NOT_DONE


def _zarr() -> Any:
    try:
        import zarr
    except ImportError:
        raise InputError(
            "this needs zarr", "pip install '.[cluster]' in propmap's checkout"
        ) from None
    return zarr
