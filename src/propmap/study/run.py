"""The loads of a study's designs, into a store or into memory."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

import propmap
from propmap.study.plan import GEOMETRY, OPERATION, VARIABLES, Designs, Study
from propmap.sweep.points import RPM, Place, chunk_shape, parts_along
from propmap.sweep.provenance import provenance
from propmap.sweep.quantities import attributes, filed_as, quantities
from propmap.sweep.store import NOT_DONE, Layout, Store
from propmap.sweep.stream import Filing, Values, stream
from propmap.tasks import InTurn, Workers

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

POINTS_PER_TASK = 8192
"""Operating points of a task, of all its designs: one to some seconds of one core."""


class InMemory:
    """A store for studies that fit in memory; takes the place of a ``Store``.

    Parameters
    ----------
    layout : Layout
        What it is to hold.
    """

    here = False  # workers send their results

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.values: dict[str, NDArray[Any]] = {
            name: np.full(layout.shape, np.nan if kind.kind == "f" else NOT_DONE, kind)
            for name, (kind, _) in layout.quantities.items()
        }

    def __getstate__(self) -> dict[str, Any]:
        """Workers need nothing of it."""
        return {}

    def write(self, place: Place, values: Mapping[str, NDArray[Any]]) -> None:
        """Keep the ``values`` of the part at a ``place``, by quantity."""
        for name, part in values.items():
            cut = tuple(
                slice(k * n, k * n + m)
                for k, n, m in zip(place, self.layout.chunk, part.shape, strict=True)
            )
            self.values[name][cut] = part

    def done(self, layout: Layout) -> NDArray[np.bool_]:
        """No part of the ``layout`` is."""
        return np.zeros(parts_along(layout.shape, layout.chunk), bool)

    def dataset(self) -> xarray.Dataset:
        """All as an xarray dataset."""
        import xarray

        dims = tuple(self.layout.sizes)
        variables = {
            name: (dims, values, dict(self.layout.quantities[name][1]))
            for name, values in self.values.items()
        }
        coordinates = {
            name: (dims, values, dict(told))
            for name, (dims, values, told) in self.layout.coordinates.items()
        }
        return xarray.Dataset(variables, coordinates, dict(self.layout.attributes))


def study_layout(study: Study, command: str = "", points_per_task: int = POINTS_PER_TASK) -> Layout:
    """What the store of a study holds.

    Parameters
    ----------
    study : Study
        Designs and operating points.
    command : str
        What was asked for, for the attributes.
    points_per_task : int
        At most.
    """
    coordinates: dict[str, Any] = {}
    for name, values in study.rows.items():
        coordinates[name] = (("design",), values, _texts(name))
    shared = [name for name in OPERATION if name in study.axes]
    for dim, name in zip(study.dims[1:], shared, strict=True):
        coordinates[name] = ((dim,), study.axes[name], _texts(name))
    probe = study.design({name: float(values[0]) for name, values in study.rows.items()})
    found = quantities(probe.loads([300.0], 0.0, 0.0), bands=False, by_source=False)
    kinds = {name: (filed_as(values.dtype), attributes(name)) for name, values in found.items()}
    chunk = chunk_shape(study.shape, points_per_task)
    told = {**provenance(study.rotor, command)}
    told["title"] = f"Designs made from {study.rotor.model.propeller.name}"
    told["sampling"] = (
        "full factorial" if study.designs is None else f"Latin hypercube, seed {study.seed}"
    )
    digest = hashlib.sha256(repr(study.shape).encode())
    for name, (_, values, _) in coordinates.items():
        digest.update(name.encode() + np.asarray(values).tobytes())
    depends_on = {
        "kind": "study",
        "propmap": propmap.__version__,
        "model": str(told["model_sha256"]),
        "points": digest.hexdigest(),
        "accuracy": study.rotor.accuracy,
        "quantities": " ".join(kinds),
        "chunk": str(chunk),
    }
    sizes = dict(zip(study.dims, study.shape, strict=True))
    return Layout(sizes, chunk, coordinates, kinds, told, depends_on)


def run_study(
    study: Study,
    store: Store | InMemory,
    layout: Layout,
    workers: Workers | None = None,
    progress: Callable[[int], None] | None = None,
) -> None:
    """Compute and file what is missing.

    Parameters
    ----------
    study : Study
        Designs and operating points.
    store : Store or InMemory
        Where to.
    layout : Layout
        From ``study_layout``.
    workers : Workers, optional
        Who computes; by default this process.
    progress : callable, optional
        Told how many tasks are done.
    """
    filing = Filing(loads_of_designs, study, store)
    for done in stream(workers or InTurn(), filing, layout, study.part):
        if progress is not None:
            progress(done)


def loads_of_designs(study: Study, part: Designs) -> Values:
    """Quantities of some designs at some operating points.

    Parameters
    ----------
    study : Study
        The design to begin with.
    part : Designs
        What differs, and where.
    """
    names = list(part.rows)
    every = []
    for row in zip(*part.rows.values(), strict=True):
        values = dict(zip(names, map(float, row), strict=True))
        point = [part.axes.get(name, np.array([values.get(name, 0.0)])) for name in OPERATION]
        rpm, speed, beta = np.meshgrid(*point, indexing="ij")
        loads = study.design(values).loads(rpm * RPM, speed, np.radians(beta))
        every.append(quantities(loads, bands=False, by_source=False))
    lengths = [part.axes[name].size for name in OPERATION if name in part.axes]
    return {
        name: np.stack([one[name].reshape(lengths) for one in every]).astype(
            filed_as(every[0][name].dtype)
        )
        for name in every[0]
    }


def _texts(name: str) -> dict[str, str]:
    unit, meaning = VARIABLES[name]
    return {"units": unit, "long_name": f"{name} {meaning}" if name in GEOMETRY else meaning}
