"""Operating points of a sweep, their division into tasks, and the quantities stored for them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.io.csv import OperatingPoints
from propmap.loads import LOADS
from propmap.results import STATUSES, Loads
from propmap.typing import Floats

Place = tuple[int, ...]  # index of a task along each dimension

AXES = {
    "rpm": ("rpm", "1/min", "rotational speed"),
    "speed": ("speed_mps", "m/s", "speed of the hub through the air"),
    "beta": ("beta_deg", "degree", "angle between rotor axis and velocity, 0 in axial climb"),
}  # coordinate, unit and meaning by dimension of a grid


@dataclass(frozen=True, eq=False)
class _Values:
    """Checked rotational speeds, airspeeds and angles."""

    rpm: Floats
    speed_mps: Floats
    beta_deg: Floats

    def __post_init__(self) -> None:
        for name, unit, _ in AXES.values():
            values = np.asarray(getattr(self, name), np.float64)
            object.__setattr__(self, name, values)
            if values.ndim != 1 or not values.size or not np.isfinite(values).all():
                found = f"{name} is not a list of finite numbers [{unit}]"
                raise InputError(found, "give at least one number")
            if name == "speed_mps" and (values < 0.0).any():
                raise InputError(f"{name} is negative", "give 0 or more")


class Grid(_Values):
    """All combinations of rotational speeds, airspeeds and angles.

    Attributes
    ----------
    rpm, speed_mps, beta_deg : ndarray, shape (n,) each
        [1/min], [m/s], [degree].
    """

    @property
    def dims(self) -> tuple[str, ...]:
        """ "rpm", "speed" and "beta"."""
        return tuple(AXES)

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of rotational speeds, airspeeds and angles."""
        return self.rpm.size, self.speed_mps.size, self.beta_deg.size

    def part(self, place: Place, chunk: tuple[int, ...]) -> OperatingPoints:
        """Return points that broadcast to the shape of the part at this ``place``; all parts except
        the last have shape ``chunk``."""
        w, v, b = (
            getattr(self, name)[k * n : (k + 1) * n]
            for k, n, (name, _, _) in zip(place, chunk, AXES.values(), strict=True)
        )
        return OperatingPoints(w[:, None, None], v[:, None], b)


class PointList(_Values):
    """A list of operating points.

    Attributes
    ----------
    rpm, speed_mps, beta_deg : ndarray, shape (n,)
        [1/min], [m/s], [degree].
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        if len({getattr(self, name).size for name, _, _ in AXES.values()}) > 1:
            fault = "rpm, speed and beta differ in length"
            raise InputError(fault, "give a value of each for every point")

    @property
    def dims(self) -> tuple[str, ...]:
        """ "point"."""
        return ("point",)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points."""
        return (self.rpm.size,)

    def part(self, place: Place, chunk: tuple[int, ...]) -> OperatingPoints:
        """Return the part at this ``place``; all parts except the last have shape ``chunk``."""
        cut = slice(place[0] * chunk[0], (place[0] + 1) * chunk[0])
        return OperatingPoints(self.rpm[cut], self.speed_mps[cut], self.beta_deg[cut])


Points: TypeAlias = Grid | PointList


def chunk_shape(shape: Sequence[int], most: int) -> tuple[int, ...]:
    """Return the shape of nearly equal parts of at most ``most`` points in C order; it does not
    depend on the workers, so that all digits of the loads are reproducible."""
    left, chunk = most, []
    for length in reversed(shape):
        parts = -(-length // max(left, 1))
        chunk.append(-(-length // parts))
        left //= chunk[-1]
    return tuple(reversed(chunk))


def parts_along(shape: Sequence[int], chunk: Sequence[int]) -> tuple[int, ...]:
    """Return the number of parts of shape ``chunk`` along each axis of a ``shape``."""
    return tuple(-(-length // size) for length, size in zip(shape, chunk, strict=True))


def parts_count(shape: Sequence[int], chunk: Sequence[int]) -> int:
    """Return the number of parts of shape ``chunk`` in a ``shape``."""
    return math.prod(parts_along(shape, chunk))


# --- Quantities stored for each operating point: names, units and meanings -----------------------

LOAD_TEXTS = {
    **{name: (load.unit, load.meaning) for name, load in LOADS.items()},
    "power": ("W", "shaft power"),
}

TEXTS = {
    **LOAD_TEXTS,
    "mean_inflow": ("m/s", "induced velocity averaged over the disk"),
    "reverse_flow": ("1", "fraction of the blades' disk with reverse flow"),
    "roots": ("1", "largest number of solutions of the inflow equation along the blade"),
}  # unit and meaning of each quantity except standard deviations


def quantities(loads: Loads, *, bands: bool, by_source: bool) -> dict[str, NDArray[Any]]:
    """Return the arrays to store by name; the status is last.

    ``bands`` adds standard deviations, such as "thrust_std", if the loads have them.  ``by_source``
    adds those by source, such as "thrust_std_tunnel".
    """
    found: dict[str, NDArray[Any]] = {name: getattr(loads, name) for name in TEXTS}
    if bands and loads.std_by_source:
        deviations = {"std": loads.std}
        if by_source:
            deviations |= {f"std_{source}": one for source, one in loads.std_by_source.items()}
        for what, values in deviations.items():
            found |= {f"{name}_{what}": getattr(values, name) for name in LOAD_TEXTS}
    codes = [STATUSES.index(status) for status in loads.status.ravel().tolist()]
    found["status"] = np.array(codes, np.uint8).reshape(loads.status.shape)
    return found


def attributes(name: str) -> dict[str, Any]:
    """Return unit and meaning of a quantity of ``quantities`` as attributes of its array."""
    if name == "status":
        return {
            "long_name": "validity of the loads",
            "flag_values": np.arange(len(STATUSES), dtype=np.uint8),
            "flag_meanings": " ".join(STATUSES),
        }
    load, _, source = name.partition("_std")
    unit, meaning = TEXTS[load]
    if load != name:
        meaning = f"standard deviation of: {meaning}"
    if source:
        meaning += f", from {source.removeprefix('_')} only"
    return {"units": unit, "long_name": meaning}


def column_of(name: str) -> str:
    """Return the column in CSV files of a standard deviation: "thrust_std_N" for "thrust_std"."""
    unit, _ = LOAD_TEXTS[name.partition("_std")[0]]
    return f"{name}_{unit.replace(' ', '')}"


def filed_as(kind: np.dtype[Any]) -> np.dtype[Any]:
    """Return the type in which values of a ``kind`` are stored; integers are counts below 256."""
    return np.dtype(np.uint8) if kind.kind in "iu" else kind
