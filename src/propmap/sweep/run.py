"""Loads of a rotor at any number of operating points, streamed into one Zarr store."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

import propmap
from propmap.sweep.points import (
    AXES,
    Part,
    Place,
    Points,
    attributes,
    chunk_shape,
    filed_as,
    parts_along,
    quantities,
    size,
)
from propmap.sweep.store import Layout, Store
from propmap.tasks import InTurn, Workers

if TYPE_CHECKING:
    from propmap.rotor import Rotor


# -------------------------------------------------------------------------------------------------
# Loads of a rotor at any number of operating points, in one Zarr store.

POINTS_PER_TASK = 16_384
"""One to some seconds of one core: long beside what it costs to hand out a task, short beside what
a worker may lose when it dies."""

SAMPLE = 2048
"""Operating points by which the time of a sweep is foretold."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """What is to be swept; tasks follow from it alone, whoever does them.

    Attributes
    ----------
    rotor : Rotor
        Whose loads.
    points : Grid or PointList
        Where.
    bands, by_source : bool
        Whether standard deviations are filed, if any are known, and by what they are from.
    points_per_task : int
        At most.
    """

    rotor: Rotor
    points: Points
    bands: bool = True
    by_source: bool = False
    points_per_task: int = POINTS_PER_TASK

    def layout(self, command: str = "") -> Layout:
        """What the store holds.

        Parameters
        ----------
        command : str
            What was asked for, for the store's attributes.
        """
        shape = self.points.shape
        texts = {name: (unit, meaning) for name, unit, meaning in AXES.values()}
        coordinates = {
            name: (dims, values, dict(zip(("units", "long_name"), texts[name], strict=True)))
            for name, (dims, values) in self.points.coordinates().items()
        }
        chunk = chunk_shape(shape, self.points_per_task)
        described = self._described()
        told = provenance(self.rotor, command)
        depends_on = {
            "kind": "sweep",
            "propmap": propmap.__version__,
            "model": _digest(told["model_sha256"], self._known()),
            "points": _digest(*(values.tobytes() for _, values, _ in coordinates.values()), *shape),
            "accuracy": self.rotor.accuracy,
            "quantities": " ".join(described),
            "chunk": str(chunk),
        }
        sizes = dict(zip(self.points.dims, shape, strict=True))
        return Layout(sizes, chunk, coordinates, described, told, depends_on)

    def seconds_per_point(self, workers: Workers) -> float:
        """Time that a worker takes for an operating point [s], from a sample of them.

        Parameters
        ----------
        workers : Workers
            Of whom one is asked.
        """
        count = size(self.points)
        some = np.unique(np.linspace(0, count - 1, min(count, SAMPLE)).astype(np.int64))
        at = np.unravel_index(some, self.points.shape)
        values = [
            axis[at[self.points.dims.index(dims[0])]]
            for dims, axis in self.points.coordinates().values()
        ]
        return seconds(workers, loads_of_part, self, Part((), *values)) / some.size

    def run(
        self,
        store: Store,
        layout: Layout,
        workers: Workers | None = None,
        progress: Callable[[int], None] | None = None,
    ) -> None:
        """Compute and file what is missing in a store.

        Parameters
        ----------
        store : Store
            From ``Store.create`` or ``Store.resume``.
        layout : Layout
            Of ``self.layout``.
        workers : Workers, optional
            Who computes; by default this process.
        progress : callable, optional
            Told how many tasks are done.
        """
        filing = Filing(loads_of_part, self, store)
        for done in stream(workers or InTurn(), filing, layout, self.points.part):
            if progress is not None:
                progress(done)

    def __getstate__(self) -> dict[str, Any]:
        """What workers need: each task brings its own points."""
        return {**vars(self), "points": None}

    def _described(self) -> dict[str, Any]:
        """Type and attributes of each quantity, from one point."""
        # In hover at a tip speed of 100 m/s.
        loads = self.rotor.loads([100.0 / self.rotor.model.propeller.radius], 0.0, 0.0)
        found = quantities(loads, bands=self.bands, by_source=self.by_source)
        if not self.bands:
            found = {name: values for name, values in found.items() if "_std" not in name}
        return {name: (filed_as(values.dtype), attributes(name)) for name, values in found.items()}

    def _known(self) -> str:
        """All that deviations depend on but the model."""
        known = self.rotor.model.uncertainty if self.bands else None
        return repr(known.as_dict()) if known is not None else ""


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
        Who computes: by default this process; ``propmap.cluster.workers.DaskWorkers(client)``
        for a ``distributed.Client``.  Loads are the same to the last digit
        where they have the same build of the core.
    bands, by_source : bool
        Whether standard deviations are filed, if any are known, and by what they are from.
    points_per_task : int
        Operating points that are computed, and lost if a worker dies, together.
    progress : callable, optional
        Told how many tasks are done, and of how many.

    Raises
    ------
    InputError
        Where the store was begun with another model, other points or another version.
    """
    path = Path(path)
    sweep = Sweep(rotor, points, bands, by_source, points_per_task)
    layout = sweep.layout("propmap.sweep.run.sweep_to_store")
    store = (Store.resume if path.exists() else Store.create)(path, layout)
    total = int(np.prod(parts_along(layout.shape, layout.chunk)))

    def tell(done: int) -> None:
        if progress is not None:
            progress(done, total)

    sweep.run(store, layout, workers, tell)


def loads_of_part(sweep: Sweep, part: Part) -> Values:
    """Quantities at the points of a part, of its shape.

    Parameters
    ----------
    sweep : Sweep
        The rotor and what is wanted of it.
    part : Part
        Operating points.
    """
    loads = sweep.rotor.loads(*part.si)
    found = quantities(loads, bands=sweep.bands, by_source=sweep.by_source)
    return {name: values.astype(filed_as(values.dtype)) for name, values in found.items()}


def _digest(*parts: object) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part if isinstance(part, bytes) else repr(part).encode())
    return digest.hexdigest()


# -------------------------------------------------------------------------------------------------
# Streaming: parts are computed by workers and filed, by them where they see the store.

Values = dict[str, Any]
"""Arrays by quantity."""


class Filed(Protocol):
    """Where parts go: a ``Store``, or what takes its place."""

    @property
    def here(self) -> bool:
        """Whether this process can write to it."""
        ...

    def write(self, place: Place, values: Mapping[str, NDArray[Any]]) -> None:
        """File the ``values`` of the part at a ``place``, by quantity."""
        ...

    def done(self, layout: Layout) -> NDArray[np.bool_]:
        """Which parts of the ``layout`` are filed, by place."""
        ...


@dataclass(frozen=True)
class Filing:
    """What all tasks of a run share.

    Attributes
    ----------
    work : callable
        Gives the values of a part, called as ``work(common, part)``.
    common : object
        What it needs for all parts.
    store : Filed
        Where they go.
    """

    work: Callable[[Any, Any], Values]
    common: Any
    store: Filed


def file_part(filing: Filing, task: tuple[Place, Any]) -> Values | None:
    """Compute and file a part; its values, to be filed by the caller, where the store is not seen.

    Parameters
    ----------
    filing : Filing
        How, and where to.
    task : tuple
        The place of the part and the part.
    """
    place, part = task
    values = filing.work(filing.common, part)
    if not filing.store.here:
        return values
    filing.store.write(place, values)
    return None


def stream(
    workers: Workers,
    filing: Filing,
    layout: Layout,
    part: Callable[[Place, tuple[int, ...]], Any],
) -> Iterator[int]:
    """Compute and file all parts that are missing; yields how many parts are done.

    Parameters
    ----------
    workers : Workers
        Who computes.
    filing : Filing
        How, and where to.
    layout : Layout
        Of the store.
    part : callable
        The part at a place, called with the place and the shape of parts.
    """
    done = filing.store.done(layout)
    count = int(done.sum())
    yield count
    missing = np.flatnonzero(~done)

    def place(which: int) -> Place:
        return tuple(int(k) for k in np.unravel_index(missing[which], done.shape))

    # Made one by one, as workers become free.
    at = map(place, range(missing.size))
    tasks = ((where, part(where, layout.chunk)) for where in at)
    for which, values in workers.results(file_part, filing, tasks):
        if values is not None:
            filing.store.write(place(which), values)
        count += 1
        yield count


def seconds(workers: Workers, work: Callable[[Any, Any], Values], common: Any, part: Any) -> float:
    """Time that a worker takes for a part [s].

    Parameters
    ----------
    workers : Workers
        Of whom one is asked.
    work, common : callable, object
        As in ``Filing``.
    part : object
        The part.
    """
    ((_, found),) = workers.results(_timed, (work, common), [part])
    return found


def _timed(asked: tuple[Callable[[Any, Any], Values], Any], part: Any) -> float:
    """Of the second time: at the first one modules are loaded."""
    work, common = asked
    work(common, part)
    start = time.perf_counter()
    work(common, part)
    return time.perf_counter() - start


# -------------------------------------------------------------------------------------------------
# Where the figures of a sweep come from.


def provenance(rotor: Rotor, command: str) -> dict[str, Any]:
    """Texts and numbers that files of loads carry.

    Parameters
    ----------
    rotor : Rotor
        Whose loads they are.
    command : str
        What was asked for.
    """
    blade = rotor.model.propeller
    section = {f"airfoil_{key}": value for key, value in rotor.model.airfoil.metadata().items()}
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
        **section,
        "corrections": ", ".join(rotor.model.correction_texts) or "none",
        "air_density_kg_m3": rotor.model.air.density,
        "air_viscosity_Pa_s": rotor.model.air.viscosity,
        "model_sha256": rotor.model.fingerprint(),
        "accuracy": rotor.accuracy,
        "command": command,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
