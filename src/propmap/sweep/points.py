"""Operating points of a sweep, the parts that tasks evaluate, and what is filed of each point."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.model.airfoil import SOURCES
from propmap.results import STATUSES
from propmap.typing import Floats
from propmap.units import RPM

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from propmap.results import Loads


# -------------------------------------------------------------------------------------------------
# Operating points of a sweep, and the parts that tasks evaluate.

Place = tuple[int, ...]
"""Of a part: its number along each dimension."""


class Part(NamedTuple):
    """The operating points of one task: rpm [1/min], speed [m/s] and beta [degree].

    They broadcast to the shape of the part.
    """

    place: Place
    rpm: Floats
    speed_mps: Floats
    beta_deg: Floats

    @property
    def si(self) -> tuple[Floats, Floats, Floats]:
        """Omega [rad/s], V [m/s] and beta [rad]."""
        return self.rpm * RPM, self.speed_mps, np.radians(self.beta_deg)


class Points(Protocol):
    """Operating points of any number, as ``Grid`` and ``PointList`` have them."""

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        ...

    @property
    def shape(self) -> tuple[int, ...]:
        """Their lengths."""
        ...

    def coordinates(self) -> dict[str, tuple[tuple[str, ...], Floats]]:
        """Dimensions and values of each coordinate of ``AXES``."""
        ...

    def part(self, place: Place, chunk: tuple[int, ...]) -> Part:
        """The part at a place, where parts have the shape ``chunk`` but for the last."""
        ...


@dataclass(frozen=True, eq=False)
class Grid:
    """All combinations of rotational speeds, flight speeds and angles.

    Attributes
    ----------
    rpm, speed_mps, beta_deg : ndarray, shape (n,) each
        [1/min], [m/s], [degree].
    """

    rpm: Floats
    speed_mps: Floats
    beta_deg: Floats

    def __post_init__(self) -> None:
        _check(self)

    @property
    def dims(self) -> tuple[str, ...]:
        """ "rpm", "speed" and "beta"."""
        return tuple(AXES)

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of rotational speeds, flight speeds and angles."""
        return self.rpm.size, self.speed_mps.size, self.beta_deg.size

    def coordinates(self) -> dict[str, tuple[tuple[str, ...], Floats]]:
        """As ``Points.coordinates``."""
        return {name: ((dim,), getattr(self, name)) for dim, (name, _, _) in AXES.items()}

    def part(self, place: Place, chunk: tuple[int, ...]) -> Part:
        """As ``Points.part``: at this ``place``, parts being of the shape ``chunk``."""
        w, v, b = (
            getattr(self, name)[k * n : (k + 1) * n]
            for k, n, (name, _, _) in zip(place, chunk, AXES.values(), strict=True)
        )
        return Part(place, w[:, None, None], v[:, None], b)


@dataclass(frozen=True, eq=False)
class PointList:
    """Operating points one by one.

    Attributes
    ----------
    rpm, speed_mps, beta_deg : ndarray, shape (n,)
        [1/min], [m/s], [degree].
    """

    rpm: Floats
    speed_mps: Floats
    beta_deg: Floats

    def __post_init__(self) -> None:
        _check(self)
        if len({getattr(self, name).size for name, _, _ in AXES.values()}) > 1:
            raise InputError("rpm, speed and beta differ in length", "give a value of each")

    @property
    def dims(self) -> tuple[str, ...]:
        """ "point"."""
        return ("point",)

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of points."""
        return (self.rpm.size,)

    def coordinates(self) -> dict[str, tuple[tuple[str, ...], Floats]]:
        """As ``Points.coordinates``."""
        return {name: (("point",), getattr(self, name)) for name, _, _ in AXES.values()}

    def part(self, place: Place, chunk: tuple[int, ...]) -> Part:
        """As ``Points.part``: at this ``place``, parts being of the shape ``chunk``."""
        cut = slice(place[0] * chunk[0], (place[0] + 1) * chunk[0])
        return Part(place, self.rpm[cut], self.speed_mps[cut], self.beta_deg[cut])


def chunk_shape(shape: Sequence[int], most: int) -> tuple[int, ...]:
    """The shape of parts of ``most`` points at most, as equal as may be, the last axis whole first.

    It follows from the points alone, so that tasks, and with them loads to the last digit, do not
    depend on who does them.

    Parameters
    ----------
    shape : sequence of int
        Of all points.
    most : int
        Points of a part.
    """
    left, chunk = most, []
    for length in reversed(shape):
        parts = -(-length // max(left, 1))
        chunk.append(-(-length // parts))
        left //= chunk[-1]
    return tuple(reversed(chunk))


def parts_along(shape: Sequence[int], chunk: Sequence[int]) -> tuple[int, ...]:
    """How many parts there are along each axis.

    Parameters
    ----------
    shape, chunk : sequence of int
        Of all points, and of a part.
    """
    return tuple(-(-length // size) for length, size in zip(shape, chunk, strict=True))


def size(points: Points) -> int:
    """How many ``points`` there are."""
    return math.prod(points.shape)


def _check(points: Any) -> None:
    for name, unit, _ in AXES.values():
        values = np.asarray(getattr(points, name), np.float64)
        object.__setattr__(points, name, values)
        if values.ndim != 1 or not values.size or not np.isfinite(values).all():
            raise InputError(f"{name} is no list of finite numbers [{unit}]", "give at least one")
        if name != "beta_deg" and (values < 0.0).any():
            raise InputError(f"{name} is negative", "give 0 or more")


# -------------------------------------------------------------------------------------------------
# What a sweep files of each operating point: names, units and meanings.

AXES = {
    "rpm": ("rpm", "1/min", "rotational speed"),
    "speed": ("speed_mps", "m/s", "speed of the hub through the air"),
    "beta": ("beta_deg", "degree", "angle from the axis to the velocity, 0 in axial climb"),
}
"""Of each dimension of a grid: its coordinate, unit and meaning."""

LOAD_TEXTS = {
    **{name: (load.unit, load.meaning) for name, load in LOADS.items()},
    "power": ("W", "shaft power"),
}

TEXTS = {
    **LOAD_TEXTS,
    "mean_inflow": ("m/s", "induced velocity averaged over the disk"),
    "reverse_flow": ("1", "share of the blades' disk that the air meets from behind"),
    "roots": ("1", "largest number of solutions of the inflow equation along the blade"),
}
"""Unit and meaning of each quantity that is no deviation."""

STATUS_ATTRIBUTES: dict[str, Any] = {
    "long_name": "whether the loads can be trusted",
    "flag_values": np.arange(len(STATUSES), dtype=np.uint8),
    "flag_meanings": " ".join(STATUSES),
}


def quantities(loads: Loads, *, bands: bool, by_source: bool) -> dict[str, NDArray[Any]]:
    """Arrays to file, by name, "thrust_std" and "thrust_std_tunnel" included; the status last.

    Parameters
    ----------
    loads : Loads
        Of any shape, which the arrays have too.
    bands, by_source : bool
        Whether standard deviations are among them, where the loads have any, and whether also by
        what they are from.
    """
    found: dict[str, NDArray[Any]] = {name: getattr(loads, name) for name in TEXTS}
    if bands and loads.std_by_source:
        told = {"std": loads.std}
        if by_source:
            told |= {f"std_{source}": one for source, one in loads.std_by_source.items()}
        for what, values in told.items():
            found |= {f"{name}_{what}": getattr(values, name) for name in LOAD_TEXTS}
    codes = [STATUSES.index(status) for status in loads.status.ravel().tolist()]
    found["status"] = np.array(codes, np.uint8).reshape(loads.status.shape)
    return found


def attributes(name: str) -> dict[str, Any]:
    """Unit and meaning of a quantity of ``quantities`` by its ``name``."""
    if name == "status":
        return dict(STATUS_ATTRIBUTES)
    load, _, source = name.partition("_std")
    unit, meaning = TEXTS[load]
    if load != name:
        meaning = f"standard deviation of: {meaning}"
    if source:
        meaning += f", by {source.removeprefix('_')} alone"
    assert source.removeprefix("_") in ("", *SOURCES)
    return {"units": unit, "long_name": meaning}


def filed_as(kind: np.dtype[Any]) -> np.dtype[Any]:
    """The type in which values of a ``kind`` are filed: numbers of solutions are small."""
    return np.dtype(np.uint8) if kind.kind in "iu" else kind
