"""Loads at any number of operating points, computed in tasks, in a Zarr store or in memory."""

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
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

import propmap
from propmap.errors import InputError, require
from propmap.io.csv import OperatingPoints
from propmap.rotor import Rotor
from propmap.sweep.points import (
    AXES,
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

# Some seconds.  Fewer points add overhead; with more points, a worker that dies loses more work.
POINTS_PER_TASK = 16_384
SAMPLE = 2048  # operating points whose evaluation is timed to predict the time of a sweep
Values = dict[str, NDArray[Any]]  # arrays by quantity


class Evaluation(ABC):
    """Loads at many operating points, divided into tasks that contain their own points.

    The division does not depend on the workers.  ``Sweep`` evaluates one rotor,
    ``propmap.study.run.Study`` many designs.
    """

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
        """Return dimensions, values and attributes of each coordinate."""

    @abstractmethod
    def part(self, place: Place, chunk: tuple[int, ...]) -> Any:
        """Return the part to evaluate at this ``place``; parts have the shape ``chunk``."""

    @abstractmethod
    def sample(self) -> tuple[Any, int]:
        """Return a part that is timed to predict the total time, and its number of points."""

    @abstractmethod
    def batches(self, part: Any) -> Iterable[tuple[Rotor, OperatingPoints]]:
        """Return the rotors of a ``part``, each with its operating points."""

    def described(self, command: str) -> dict[str, Any]:
        """Return the attributes of a file with the results of this ``command``."""
        return provenance(self.rotor, command)

    def values(self, part: Any) -> Values:
        """Return the quantities to store for a ``part``, with the batches along the first axis."""
        each = [
            quantities(points.loads(rotor), bands=self.bands, by_source=self.by_source)
            for rotor, points in self.batches(part)
        ]
        stacked = {name: np.stack([one[name] for one in each]) for name in each[0]}
        return {name: values.astype(filed_as(values.dtype)) for name, values in stacked.items()}

    def layout(self, command: str = "") -> Layout:
        """Return the layout of the result store; ``command`` is the command line to record."""
        coordinates = self.coordinates()
        # Hover at a tip speed of 100 m/s gives the names and types of the quantities.
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
        """Compute and store the missing parts of a ``layout`` with ``workers`` or in this process;
        call ``progress`` with the number of finished tasks and of all tasks."""
        total = parts_count(layout.shape, layout.chunk)
        with store.alone() if isinstance(store, Store) else nullcontext():
            for done in stream(workers or InTurn(), self, store, layout):
                if progress is not None:
                    progress(done, total)

    def seconds_per_point(self, workers: Workers) -> float:
        """Return the time of one of the ``workers`` for one operating point [s], from a sample."""
        part, count = self.sample()
        ((_, found),) = workers.results(_timed, self, [part])
        return found / count


def _timed(evaluation: Evaluation, part: Any) -> float:
    """Return the time of the second evaluation [s], since the first one also imports modules."""
    evaluation.values(part)
    start = time.perf_counter()
    evaluation.values(part)
    return time.perf_counter() - start


def stream(workers: Workers, evaluation: Evaluation, store: Filed, layout: Layout) -> Iterator[int]:
    """Compute and store all missing parts; yield the number of finished parts after each."""
    done = store.done(layout)
    count = int(done.sum())
    yield count
    missing = np.flatnonzero(~done)

    def place(which: int) -> Place:
        return tuple(int(k) for k in np.unravel_index(missing[which], done.shape))

    # A generator, so that tasks are created only when workers are free.
    at = map(place, range(missing.size))
    tasks = ((where, evaluation.part(where, layout.chunk)) for where in at)
    for which, values in workers.results(_file_part, (evaluation, store), tasks):
        if values is not None:
            store.write(place(which), values)
        count += 1
        yield count


def _file_part(common: tuple[Evaluation, Filed], task: tuple[Place, Any]) -> Values | None:
    """Compute and store a part; return its values if this process cannot access the store."""
    (evaluation, store), (place, part) = common, task
    values = evaluation.values(part)
    if not store.here:
        return values
    store.write(place, values)
    return None


@dataclass(frozen=True, eq=False)
class Sweep(Evaluation):
    """Loads of a ``rotor`` at all ``points``, with standard deviations if the model has any."""

    rotor: Rotor
    points: Points
    bands: bool = True
    by_source: bool = False
    points_per_task: int = POINTS_PER_TASK
    kind = "sweep"

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions of ``points``."""
        return self.points.dims

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions of ``points``."""
        return self.points.shape

    def coordinates(self) -> dict[str, tuple[tuple[str, ...], Floats, dict[str, str]]]:
        """Return rotational speed, airspeed and angle beta."""
        dims = [(dim,) if dim in self.dims else self.dims for dim in AXES]
        return {
            name: (dim, getattr(self.points, name), {"units": unit, "long_name": meaning})
            for dim, (name, unit, meaning) in zip(dims, AXES.values(), strict=True)
        }

    def part(self, place: Place, chunk: tuple[int, ...]) -> OperatingPoints:
        """Return the operating points at this ``place``; parts have the shape ``chunk``."""
        return self.points.part(place, chunk)

    def sample(self) -> tuple[OperatingPoints, int]:
        """Return evenly chosen operating points, and their number."""
        count = math.prod(self.shape)
        some = np.unique(np.linspace(0, count - 1, min(count, SAMPLE)).astype(np.int64))
        at = np.unravel_index(some, self.shape)
        axes = self.coordinates().values()
        w, v, b = (values[at[self.dims.index(dims[0])]] for dims, values, _ in axes)
        return OperatingPoints(w, v, b), some.size

    def batches(self, part: OperatingPoints) -> Iterable[tuple[Rotor, OperatingPoints]]:
        """Return all points of a ``part`` as one batch."""
        return [(self.rotor, part)]

    def values(self, part: OperatingPoints) -> Values:
        """Return the quantities to store for a ``part``, in its shape."""
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
    """Write the loads at any number of operating points to a store for ``xarray.open_zarr``.

    If the store exists, only its missing tasks are computed: call the function again to resume a
    run that was killed.  The memory use does not depend on the number of points.

    Parameters
    ----------
    rotor : Rotor
        Rotor to evaluate.
    points : Grid or PointList
        Operating points, from ``propmap.sweep.points``.
    path : Path
        Folder of the store; its name ends with ".zarr".
    workers : Workers, optional
        Workers that evaluate the tasks (default: this process), for example
        ``propmap.cluster.DaskWorkers(client)`` for a ``distributed.Client``.  All digits of the
        loads agree if the workers have the same build of the core.
    bands, by_source : bool
        Whether to store the standard deviations of the loads, if any, and those of each source.
    points_per_task : int
        Number of operating points per task; a worker that dies loses one task.
    progress : callable, optional
        Called with the number of finished tasks and the number of all tasks.

    Raises
    ------
    InputError
        If the store belongs to another model, other points or another version, or if another run
        is writing to it.
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
    """Return the provenance stored in files with a ``rotor``'s loads from this ``command``."""
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
# Results of tasks, in one Zarr store from which a killed run can resume, or in memory.
#
# Each part of the results has one file per quantity.  The file is written under a temporary name
# and then renamed.  A part is finished when its last file exists.  A killed process or a full disk
# therefore loses only unfinished parts, and writing a part twice has no effect.  Any number of
# workers of one run may write at once, because each worker writes other parts.

RUN = "propmap_run"  # attribute of the store with the conditions of its results, see ``SAME``

SAME = {
    "kind": "kind of run",
    "propmap": "version of propmap",
    "model": "model",
    "points": "set of operating points",
    "accuracy": "accuracy",
    "quantities": "set of quantities",
    "chunk": "size of tasks",
}  # conditions that must agree for a run to resume, with their names in messages

NOT_DONE = 255  # status of points that have not been computed


@dataclass(frozen=True)
class Layout:
    """Dimensions, coordinates, quantities and attributes of a store."""

    sizes: Mapping[str, int]  # lengths of the dimensions
    chunk: tuple[int, ...]  # shape of the parts
    # Dimensions, values and attributes by name.
    coordinates: Mapping[str, tuple[tuple[str, ...], NDArray[Any], Mapping[str, Any]]]
    # Type and attributes by name; the last one is written last.
    quantities: Mapping[str, tuple[np.dtype[Any], Mapping[str, Any]]]
    attributes: Mapping[str, Any] = field(default_factory=dict)  # of the store, as JSON types
    depends_on: Mapping[str, str] = field(default_factory=dict)  # the entries of ``SAME``

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return tuple(self.sizes.values())

    @property
    def bytes(self) -> int:
        """Size of the quantities before compression [bytes]."""
        return math.prod(self.shape) * sum(kind.itemsize for kind, _ in self.quantities.values())

    def dataset(self, values: Mapping[str, NDArray[Any]]) -> xarray.Dataset:
        """Return ``values`` by quantity, of this shape or flat, as an xarray dataset."""
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
    """A store on disk: its folder, and the ``run`` that identifies it on other computers."""

    path: Path
    run: str

    @classmethod
    def create(cls, path: Path, layout: Layout) -> Store:
        """Create a new store at a free ``path`` atomically."""
        zarr = _zarr()
        run = uuid.uuid4().hex
        part = path.with_name(f".{run}.part")
        # By the CF conventions, this attribute lists the coordinates that are not dimensions.
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
                # Readers warn if consolidated metadata is missing, and zarr warns if it is created.
                warnings.filterwarnings("ignore", "Consolidated metadata is currently not part")
                zarr.consolidate_metadata(str(part))
            try:
                part.replace(path)
            except OSError as error:
                if not path.exists():
                    raise
                found = f"another run has created this store in the meantime ({error.strerror})"
                raise InputError(found, "choose another name", str(path)) from None
        except BaseException:
            shutil.rmtree(part, ignore_errors=True)
            raise
        return cls(path, run)

    @classmethod
    def resume(cls, path: Path, layout: Layout) -> Store:
        """Open the store of an earlier run.  Raise ``InputError`` if the folder is not a store of
        propmap, or if this run would compute other results."""
        before = begun(path)
        for name, words in SAME.items():
            if before.get(name) != layout.depends_on.get(name):
                was = before.get(name, "")
                version = f" ({was})" if was and len(was) <= len("0.10.2") else ""
                found = f"the store was created with another {words}{version}"
                remedy = "choose another name, or pass --force to start again"
                raise InputError(found, remedy, str(path))
        return cls(path, before["run"])

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Exclude other runs from the store in a block, and delete partial files of earlier runs;
        raise ``InputError`` if another run uses the store.  The lock ends with the process."""
        with (self.path / "zarr.json").open() as file:
            try:
                import fcntl

                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                found = "another run is writing to this store"
                remedy = "wait until it has ended, or choose another name"
                raise InputError(found, remedy, str(self.path)) from None
            except (ImportError, OSError):
                pass  # Windows and some network disks have no such locks.
            for left in self.path.rglob("*.partial"):
                left.unlink(missing_ok=True)
            yield

    @property
    def here(self) -> bool:
        """Whether this process can access the store."""
        try:
            return begun(self.path).get("run") == self.run
        except InputError:
            return False

    def write(self, place: Place, values: Mapping[str, NDArray[Any]]) -> None:
        """Write the ``values`` by quantity of the part at a ``place``, in the layout's order; an
        ``OSError``, such as a full disk, contains the name of the store."""
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
        """Return a mask of the finished parts of the ``layout``, by place."""
        found = np.zeros(parts_along(layout.shape, layout.chunk), bool)
        top = self.path / list(layout.quantities)[-1] / "c"
        for folder, _, files in os.walk(top):
            before = Path(folder).relative_to(top).parts
            for name in files:
                if name.isdecimal():
                    found[(*map(int, before), int(name))] = True
        return found


class InMemory:
    """Results in memory, with the interface of a ``Store``."""

    here = False  # workers have no access, so they send their results

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.values: dict[str, NDArray[Any]] = {
            name: np.full(layout.shape, _unfilled(kind), kind)
            for name, (kind, _) in layout.quantities.items()
        }

    def __getstate__(self) -> dict[str, Any]:
        """Return nothing, since workers need no data of the store."""
        return {}

    def write(self, place: Place, values: Mapping[str, NDArray[Any]]) -> None:
        """Store the ``values`` by quantity of the part at a ``place``."""
        for name, part in values.items():
            cut = tuple(
                slice(k * n, k * n + m)
                for k, n, m in zip(place, self.layout.chunk, part.shape, strict=True)
            )
            self.values[name][cut] = part

    def done(self, layout: Layout) -> NDArray[np.bool_]:
        """Return a mask without finished parts of the ``layout``."""
        return np.zeros(parts_along(layout.shape, layout.chunk), bool)

    def dataset(self) -> xarray.Dataset:
        """Return all results as an xarray dataset."""
        return self.layout.dataset(self.values)


Filed: TypeAlias = Store | InMemory


def begun(path: Path) -> dict[str, str]:
    """Read the conditions of the store at ``path``, as in ``Layout.depends_on``, and its run; raise
    ``InputError`` if it is not a store of propmap."""
    try:
        found = json.loads((path / "zarr.json").read_text(encoding="utf-8"))
        return dict(found["attributes"][RUN])
    except (OSError, ValueError, KeyError, TypeError):
        fault = "this folder is not a store of propmap"
        raise InputError(fault, "choose another name", str(path)) from None


def _unfilled(kind: np.dtype[Any]) -> float:
    return np.nan if kind.kind == "f" else NOT_DONE


def _zarr() -> Any:
    require("cluster")
    import zarr

    return zarr
