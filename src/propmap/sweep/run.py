"""Loads at any number of operating points, in tasks: streamed into a Zarr store, or into memory."""

from __future__ import annotations

import hashlib
import json
import math
import os
import shutil
import time
import uuid
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

import propmap
from propmap.errors import InputError, require
from propmap.results import Loads
from propmap.rotor import Rotor
from propmap.sweep.points import (
    AXES,
    Part,
    Place,
    Points,
    attributes,
    chunk_shape,
    filed_as,
    parts_along,
    parts_count,
    quantities,
)
from propmap.tasks import InTurn, Workers
from propmap.typing import Floats

if TYPE_CHECKING:
    import xarray

POINTS_PER_TASK = 16_384  # some seconds of a core: long beside handing out, short beside a loss
SAMPLE = 2048  # operating points by which the time of a sweep is predicted
Values = dict[str, NDArray[Any]]  # arrays by quantity


class Evaluation(ABC):
    """Loads at many operating points, in tasks that follow from these alone and bring them along,
    whoever does them: ``Sweep`` of one rotor, ``propmap.study.run.Study`` of many designs."""

    kind: str
    rotor: Rotor
    bands: bool
    by_source: bool
    points_per_task: int

    @property
    @abstractmethod
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions."""

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""

    @abstractmethod
    def coordinates(self) -> dict[str, tuple[tuple[str, ...], Floats, dict[str, str]]]:
        """Dimensions, values and attributes of each coordinate."""

    @abstractmethod
    def part(self, place: Place, chunk: tuple[int, ...]) -> Any:
        """What is evaluated at this ``place``, where parts have the shape ``chunk``."""

    @abstractmethod
    def sample(self) -> tuple[Any, int]:
        """A part by which the time of all is predicted, and its number of points."""

    @abstractmethod
    def batches(self, part: Any) -> Iterable[tuple[Rotor, Part]]:
        """The rotors of a ``part``, each with the points at which its loads are asked for."""

    def described(self, command: str) -> dict[str, Any]:
        """Attributes of a file with the results, asked for by this ``command``."""
        return provenance(self.rotor, command)

    def evaluate(self, part: Any) -> Iterator[Loads]:
        """Loads of the batches of a ``part``, one after the other."""
        for rotor, points in self.batches(part):
            yield rotor.loads(*points.si)

    def in_turn(self) -> Iterator[Loads]:
        """Loads of all batches of all parts in C order, evaluated in this process."""
        chunk = chunk_shape(self.shape, self.points_per_task)
        for place in np.ndindex(*parts_along(self.shape, chunk)):
            yield from self.evaluate(self.part(place, chunk))

    def values(self, part: Any) -> Values:
        """What is filed of a ``part``, each quantity with the batches along the first axis."""
        each = [
            quantities(loads, bands=self.bands, by_source=self.by_source)
            for loads in self.evaluate(part)
        ]
        stacked = {name: np.stack([one[name] for one in each]) for name in each[0]}
        return {name: values.astype(filed_as(values.dtype)) for name, values in stacked.items()}

    def layout(self, command: str = "") -> Layout:
        """Describe the store of the results, asked for by this ``command``."""
        coordinates = self.coordinates()
        # Names and types, from hover at a tip speed of 100 m/s.
        probe = self.rotor.loads([100.0 / self.rotor.model.propeller.radius], 0.0, 0.0)
        filed = quantities(probe, bands=self.bands, by_source=self.by_source)
        kinds = {name: (filed_as(v.dtype), attributes(name)) for name, v in filed.items()}
        known = self.rotor.model.uncertainty if self.bands else None
        chunk = chunk_shape(self.shape, self.points_per_task)
        points = [part for name, (_, at, _) in coordinates.items() for part in (name, at.tobytes())]
        depends_on = {
            "kind": self.kind,
            "propmap": propmap.__version__,
            "model": _digest(
                self.rotor.model.fingerprint(), "" if known is None else repr(known.as_dict())
            ),
            "points": _digest(self.shape, *points),
            "accuracy": self.rotor.accuracy,
            "quantities": " ".join(kinds),
            "chunk": str(chunk),
        }
        sizes = dict(zip(self.dims, self.shape, strict=True))
        return Layout(sizes, chunk, coordinates, kinds, self.described(command), depends_on)

    def run(
        self,
        store: Filed,
        layout: Layout,
        workers: Workers | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        """Compute and file what a ``store`` lacks of a ``layout``, by ``workers`` or here;
        ``progress`` gets the number of tasks done, and that of all."""
        total = parts_count(layout.shape, layout.chunk)
        for done in stream(workers or InTurn(), self, store, layout):
            if progress is not None:
                progress(done, total)

    def seconds_per_point(self, workers: Workers) -> float:
        """Time that one of the ``workers`` takes for an operating point [s], from a sample."""
        part, count = self.sample()
        ((_, found),) = workers.results(_timed, self, [part])
        return found / count


def _timed(evaluation: Evaluation, part: Any) -> float:
    """Time of the second evaluation [s]: modules are loaded at the first one."""
    evaluation.values(part)
    start = time.perf_counter()
    evaluation.values(part)
    return time.perf_counter() - start


def stream(workers: Workers, evaluation: Evaluation, store: Filed, layout: Layout) -> Iterator[int]:
    """Compute and file all parts that are missing in a store; yield how many parts are done."""
    done = store.done(layout)
    count = int(done.sum())
    yield count
    missing = np.flatnonzero(~done)

    def place(which: int) -> Place:
        return tuple(int(k) for k in np.unravel_index(missing[which], done.shape))

    # Made one by one, as workers become free.
    at = map(place, range(missing.size))
    tasks = ((where, evaluation.part(where, layout.chunk)) for where in at)
    for which, values in workers.results(_file_part, (evaluation, store), tasks):
        if values is not None:
            store.write(place(which), values)
        count += 1
        yield count


def _file_part(common: tuple[Evaluation, Filed], task: tuple[Place, Any]) -> Values | None:
    """Compute and file a part; return its values where this process does not see the store."""
    (evaluation, store), (place, part) = common, task
    values = evaluation.values(part)
    if not store.here:
        return values
    store.write(place, values)
    return None


@dataclass(frozen=True, eq=False)
class Sweep(Evaluation):
    """Loads of a ``rotor`` at all ``points``, with standard deviations where any are known."""

    rotor: Rotor
    points: Points
    bands: bool = True
    by_source: bool = False
    points_per_task: int = POINTS_PER_TASK
    kind = "sweep"

    @property
    def dims(self) -> tuple[str, ...]:
        """As of ``points``."""
        return self.points.dims

    @property
    def shape(self) -> tuple[int, ...]:
        """As of ``points``."""
        return self.points.shape

    def coordinates(self) -> dict[str, tuple[tuple[str, ...], Floats, dict[str, str]]]:
        """Rotational speed, flight speed and angle."""
        dims = [(dim,) if dim in self.dims else self.dims for dim in AXES]
        return {
            name: (dim, getattr(self.points, name), {"units": unit, "long_name": meaning})
            for dim, (name, unit, meaning) in zip(dims, AXES.values(), strict=True)
        }

    def part(self, place: Place, chunk: tuple[int, ...]) -> Part:
        """Operating points at this ``place``, where parts have the shape ``chunk``."""
        return self.points.part(place, chunk)

    def sample(self) -> tuple[Part, int]:
        """Operating points spread over all."""
        count = math.prod(self.shape)
        some = np.unique(np.linspace(0, count - 1, min(count, SAMPLE)).astype(np.int64))
        at = np.unravel_index(some, self.shape)
        axes = self.coordinates().values()
        return Part(*(v[at[self.dims.index(dims[0])]] for dims, v, _ in axes)), some.size

    def batches(self, part: Part) -> Iterable[tuple[Rotor, Part]]:
        """All points of a ``part`` at once."""
        return [(self.rotor, part)]

    def values(self, part: Part) -> Values:
        """What is filed of a ``part``, of its shape."""
        return {name: stacked[0] for name, stacked in super().values(part).items()}

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "points": None}


def sweep_to_store(
    rotor: Rotor,
    points: Points,
    path: Path,
    *,
    workers: Workers | None = None,
    bands: bool = True,
    by_source: bool = False,
    points_per_task: int = POINTS_PER_TASK,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Loads at any number of operating points, in a Zarr store that ``xarray.open_zarr`` reads.

    Where the store is there, but for some of its tasks, these are done and the others are left: a
    run that was killed goes on when it is asked for again.  Memory does not grow with the points.

    Parameters
    ----------
    rotor : Rotor
        Whose loads.
    points : Grid or PointList
        Operating points, from ``propmap.sweep.points``.
    path : Path
        The store, a folder whose name ends with ".zarr".
    workers : Workers, optional
        Who computes: by default this process; ``propmap.cluster.DaskWorkers(client)``
        for a ``distributed.Client``.  Loads are the same to the last digit
        where they have the same build of the core.
    bands, by_source : bool
        Whether standard deviations are filed, if any are known, and by what they are from.
    points_per_task : int
        Operating points that are computed, and lost if a worker dies, together.
    progress : callable, optional
        Called with the number of tasks done, and that of all.

    Raises
    ------
    InputError
        Where the store was begun with another model, other points or another version.
    """
    path = Path(path)
    sweep = Sweep(rotor, points, bands, by_source, points_per_task)
    layout = sweep.layout("propmap.sweep.run.sweep_to_store")
    store = (Store.resume if path.exists() else Store.create)(path, layout)
    sweep.run(store, layout, workers, progress)


def _digest(*parts: object) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part if isinstance(part, bytes) else repr(part).encode())
    return digest.hexdigest()


def provenance(rotor: Rotor, command: str) -> dict[str, Any]:
    """Texts and numbers that files of a ``rotor``'s loads carry, asked for by this ``command``."""
    model, blade = rotor.model, rotor.model.propeller
    return {
        "title": f"Loads of {blade.name}",
        "propmap_version": propmap.__version__,
        "method": "Gill & D'Andrea, Propeller Thrust and Drag in Forward Flight, CCTA 2017",
        "propeller": blade.name,
        "propeller_source": blade.source,
        "propeller_citation": blade.citation,
        "blades": blade.blades,
        "radius_m": blade.radius,
        "root_m": blade.root,
        "geometry_sha256": blade.fingerprint(),
        **{f"airfoil_{key}": value for key, value in model.airfoil.metadata().items()},
        "corrections": ", ".join(model.correction_texts) or "none",
        "air_density_kg_m3": model.air.density,
        "air_viscosity_Pa_s": model.air.viscosity,
        "model_sha256": model.fingerprint(),
        "accuracy": rotor.accuracy,
        "command": command,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }


# -------------------------------------------------------------------------------------------------
# Results of tasks, in one Zarr store that a killed run leaves fit to go on, or in memory.
#
# A part of the results is a file per quantity, written under another name and then renamed, and the
# part counts as done once its last file is there.  So a killed process or a full disk costs the
# parts under way, no more; to write a part again changes nothing.  Any number of processes may
# write, each its own parts.

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
        require("netcdf")
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
        run = uuid.uuid4().hex
        part = path.with_name(f".{run}.part")
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
            try:
                part.replace(path)
            except OSError as error:
                if not path.exists():
                    raise
                found = f"another run has made it meanwhile ({error.strerror})"
                raise InputError(found, "choose another name", str(path)) from None
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
                found = f"it was begun with another {words}{version}"
                remedy = "choose another name, or pass --force to begin anew"
                raise InputError(found, remedy, str(path))
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
        fault = "this is no store of propmap's"
        raise InputError(fault, "choose another name", str(path)) from None


def _unfilled(kind: np.dtype[Any]) -> float:
    return np.nan if kind.kind == "f" else NOT_DONE


def _zarr() -> Any:
    require("cluster")
    import zarr

    return zarr
