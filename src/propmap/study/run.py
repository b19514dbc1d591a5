"""A study: designs made from a blade, and their loads, into a store or into memory."""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import propmap
from propmap.errors import InputError
from propmap.model.model import Propeller
from propmap.rotor import Rotor
from propmap.sweep.points import (
    AXES,
    Place,
    attributes,
    chunk_shape,
    filed_as,
    parts_along,
    quantities,
)
from propmap.sweep.run import Filing, Values, provenance, stream
from propmap.sweep.store import NOT_DONE, Layout, Store
from propmap.tasks import InTurn, Workers
from propmap.typing import Floats
from propmap.units import RPM

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray


# -------------------------------------------------------------------------------------------------
# The loads of a study's designs, into a store or into memory.

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


# -------------------------------------------------------------------------------------------------
# What a study varies: designs by a Latin hypercube or all combinations, and operating points.

GEOMETRY = {
    "diameter": ("m", "of the propeller"),
    "pitch": ("m", "of the blade at three quarters of the radius"),
    "chord_scale": ("1", "chords over those of the blade that the study begins with"),
    "twist_scale": ("1", "differences of twist over those of the blade that the study begins with"),
    "blades": ("1", "number of blades"),
}
"""What may vary of a propeller: unit and meaning."""

OPERATION = {name: (unit, meaning) for name, unit, meaning in AXES.values()}
"""The same of an operating point."""

VARIABLES = {**GEOMETRY, **OPERATION}

MOST_DESIGNS = 100_000_000


class Designs(NamedTuple):
    """The designs and operating points of one task.

    Attributes
    ----------
    rows : dict of str to ndarray, shape (n,)
        What varies, by name.
    axes : dict of str to ndarray
        Values of the operating point that every design is evaluated at, by name.
    """

    rows: dict[str, Floats]
    axes: dict[str, Floats]


@dataclass(frozen=True, eq=False)
class Study:
    """Which designs are evaluated at which operating points.

    Attributes
    ----------
    rotor : Rotor
        The design to begin with; all have its section law, air and corrections.
    varied : mapping of str to ndarray
        Values of what varies from design to design, by names of ``VARIABLES``: all levels of a
        full factorial; or least and largest of a Latin hypercube, but for ``blades``, of which
        it has all that are named.
    axes : mapping of str to ndarray
        Values of the rest of ``OPERATION``: every design is evaluated at all combinations.
    designs : int or None
        How many a Latin hypercube has; None for the full factorial.
    seed : int
        Of the Latin hypercube.

    Raises
    ------
    InputError
        Where these do not make a study, or a blade of it cannot be.
    """

    rotor: Rotor
    varied: Mapping[str, Floats]
    axes: Mapping[str, Floats]
    designs: int | None = None
    seed: int = 1

    def __post_init__(self) -> None:
        if not self.varied:
            raise InputError("nothing varies", f"give values of {', '.join(VARIABLES)}")
        for name in OPERATION:
            if (name in self.varied) == (name in self.axes):
                times = "twice" if name in self.axes else "nowhere"
                raise InputError(f"{name} is given {times}", "give it once, varied or as points")
        for name, values in [*self.varied.items(), *self.axes.items()]:
            _check_values(name, values)
            both = self.designs is not None and name in self.varied and name != "blades"
            if both and values.size != 2:
                raise InputError(
                    f"{name} has {values.size} values", "a Latin hypercube takes two, from and to"
                )
        if self.designs is not None and not 2 <= self.designs <= MOST_DESIGNS:
            raise InputError(f"designs is {self.designs}", f"give 2 to {MOST_DESIGNS}")
        if self.count > MOST_DESIGNS:
            raise InputError(
                f"all combinations are {self.count} designs", "give fewer values of each"
            )
        ends = {n: np.unique(v[[0, -1]]) for n, v in self.varied.items() if n in GEOMETRY}
        for corner in itertools.product(*ends.values()):
            self.design(dict(zip(ends, corner, strict=True)))

    @property
    def count(self) -> int:
        """Number of designs."""
        return self.designs or math.prod(values.size for values in self.varied.values())

    @cached_property
    def rows(self) -> dict[str, Floats]:
        """What varies, by name, each (n,)."""
        names = list(self.varied)
        if self.designs is None:
            mesh = np.meshgrid(*self.varied.values(), indexing="ij")
            return {name: axis.ravel() for name, axis in zip(names, mesh, strict=True)}
        from scipy.stats import qmc

        sampler = qmc.LatinHypercube(len(names), rng=np.random.default_rng(self.seed))
        unit = sampler.random(self.designs)
        found = {}
        for name, share in zip(names, unit.T, strict=True):
            values = self.varied[name]
            if name == "blades":
                found[name] = values[np.minimum((share * values.size).astype(int), values.size - 1)]
            else:
                found[name] = values[0] + share * (values[1] - values[0])
        return found

    @property
    def dims(self) -> tuple[str, ...]:
        """ "design", then those of the operating points that all designs share."""
        return ("design", *(dim for dim, (name, _, _) in AXES.items() if name in self.axes))

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return (self.count, *(self.axes[name].size for name in OPERATION if name in self.axes))

    def part(self, place: Place, chunk: tuple[int, ...]) -> Designs:
        """Designs and points of the task at this ``place``; tasks have the shape ``chunk``."""
        cuts = [slice(k * n, (k + 1) * n) for k, n in zip(place, chunk, strict=True)]
        rows = {name: values[cuts[0]] for name, values in self.rows.items()}
        names = [name for name in OPERATION if name in self.axes]
        axes = {name: self.axes[name][cut] for name, cut in zip(names, cuts[1:], strict=True)}
        return Designs(rows, axes)

    def design(self, values: Mapping[str, float]) -> Rotor:
        """The rotor of a design.

        Parameters
        ----------
        values : mapping of str to float
            What differs from the first one, by name; those of operating points do not matter.
        """
        from dataclasses import replace

        geometry: Any = {name: float(v) for name, v in values.items() if name in GEOMETRY}
        if "blades" in geometry:
            geometry["blades"] = round(geometry["blades"])
        model = self.rotor.model
        try:
            blade = changed_blade(model.propeller, **geometry)
            return self.rotor.with_model(replace(model, propeller=blade))
        except InputError as error:
            told = ", ".join(f"{name} {value:.4g}" for name, value in geometry.items())
            raise InputError(f"the design with {told}: {error}") from None

    def __getstate__(self) -> dict[str, Any]:
        """What workers need: each task brings its own designs."""
        return {key: value for key, value in vars(self).items() if key != "rows"}


def _check_values(name: str, values: Floats) -> None:
    if name not in VARIABLES:
        raise InputError(f"{name} cannot vary", f"known are {', '.join(VARIABLES)}")
    if values.ndim != 1 or not values.size or not np.isfinite(values).all():
        raise InputError(f"{name} is no list of numbers", "give one or more")
    if (np.diff(values) <= 0.0).any():
        raise InputError(f"the values of {name} do not rise", "write each once, rising")
    if name == "blades" and (values != np.round(values)).any():
        raise InputError("blades are whole numbers", "give them as 2, 3, 4")
    if name != "beta_deg" and values[0] < 0.0:
        raise InputError(f"{name} is negative", "give 0 or more")


# -------------------------------------------------------------------------------------------------
# Blades made from another: of another size, pitch, width or twist.

PITCH_AT = 0.75
"""Share of the radius at which a blade's pitch is told."""


def pitch_of(blade: Propeller) -> float:
    """The pitch of a ``blade`` at three quarters of the radius, 2 pi r tan(theta) [m]."""
    radius = PITCH_AT * blade.radius
    return 2.0 * math.pi * radius * float(np.interp(radius, blade.station, np.tan(blade.twist)))


def changed_blade(
    blade: Propeller,
    *,
    diameter: float | None = None,
    pitch: float | None = None,
    chord_scale: float = 1.0,
    twist_scale: float = 1.0,
    blades: int | None = None,
) -> Propeller:
    """A propeller made from another.

    Parameters
    ----------
    blade : Propeller
        The one to begin with.
    diameter : float, optional
        [m]; radii and chords grow alike.
    pitch : float, optional
        At three quarters of the radius [m]; the tangents of all twists change by one factor, so
        that the pitch of each station does. By default it grows with the diameter.
    chord_scale : float
        Of all chords, after the diameter [-].
    twist_scale : float
        Of what the twist differs by from that at three quarters of the radius [-]: 0 is a blade
        without twist, 1 leaves it.
    blades : int, optional
        How many.

    Raises
    ------
    InputError
        For a blade that cannot be.
    """
    for name, value in (("diameter", diameter), ("pitch", pitch), ("chord_scale", chord_scale)):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} is {value}", "give a number above 0")
    size = 1.0 if diameter is None else diameter / blade.diameter
    station, twist = size * blade.station, blade.twist
    if pitch is not None:
        own = size * pitch_of(blade)
        if own <= 0.0:
            raise InputError(f"the pitch of {blade.name} is {own:g} m", "begin with another blade")
        twist = np.arctan(np.tan(twist) * (pitch / own))
    middle = np.arctan(np.interp(PITCH_AT * station[-1], station, np.tan(twist)))
    return replace(
        blade,
        blades=blade.blades if blades is None else blades,
        station=station,
        chord=size * chord_scale * blade.chord,
        twist=middle + twist_scale * (twist - middle),
        root_cutout=None if blade.root_cutout is None else size * blade.root_cutout,
    )
