"""Points of a table's envelope, and what a simpler model's errors at them are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.loads import LOADS, error_scales
from propmap.table.interpolation import VORTEX_RING
from propmap.table.query import LoadTable
from propmap.typing import Floats

POINTS = 32_768

CLIMB = (-0.05, 0.2)
LARGEST_MU = 0.25
"""The advance ratios, along the axis and in the disk plane, for which the simple models are
meant: climb and slow descent.  In faster descent their errors triple."""

SIMPLE = f"lambda_c from {CLIMB[0]:g} to {CLIMB[1]:g}, mu up to {LARGEST_MU:g}, no vortex ring"


@dataclass(frozen=True)
class Samples:
    """A table's loads at n points that fill its envelope evenly; arrays (n,).

    Attributes
    ----------
    omega, axial, inplane : ndarray
        Rotational speed [rad/s], velocity along the axis and in the disk plane [m/s].
    loads, static : mapping of str to ndarray
        Every load [N], [N m], and what its errors are shares of, see ``loads.error_scales``.
    climb, mu : ndarray
        Advance ratios along the axis and in the disk plane [-].
    ring : ndarray of bool
        Where momentum theory does not hold.
    """

    omega: Floats
    axial: Floats
    inplane: Floats
    loads: Mapping[str, Floats]
    static: Mapping[str, Floats]
    climb: Floats
    mu: Floats
    ring: NDArray[np.bool_]

    @property
    def simple(self) -> NDArray[np.bool_]:
        """Where the simple models are fitted: small advance ratios, no vortex ring; (n,)."""
        climbs = (self.climb >= CLIMB[0]) & (self.climb <= CLIMB[1])
        return climbs & (self.mu <= LARGEST_MU) & ~self.ring


@dataclass(frozen=True)
class Errors:
    """Errors of a model as shares of static loads.

    Attributes
    ----------
    where : str
        The points' range, in words.
    points : int
        How many.
    rms, worst : ndarray, shape (L,)
        In the order of ``LOADS`` [-].
    """

    where: str
    points: int
    rms: Floats
    worst: Floats


def sample(table: LoadTable) -> Samples:
    """Points of the envelope that have loads.

    Raises
    ------
    InputError
        For a table without hover, which has no static loads, and for one without points for
        simple models.
    """
    omega, speed, beta = evenly(table, POINTS)
    found = table.loads(omega, speed, beta)
    loads = {name: getattr(found, name) for name in LOADS}
    valid = np.isfinite(list(loads.values())).all(axis=0)
    axial, inplane = speed * np.cos(beta), speed * np.sin(beta)
    tip = omega * table.content.radius
    static = static_loads(table, omega)
    samples = Samples(
        omega=omega[valid],
        axial=axial[valid],
        inplane=inplane[valid],
        loads={name: values[valid] for name, values in loads.items()},
        static={name: values[valid] for name, values in static.items()},
        climb=(axial / tip)[valid],
        mu=(inplane / tip)[valid],
        ring=np.asarray(found.code == VORTEX_RING)[valid],
    )
    if not samples.simple.any():
        raise InputError(
            f"the map has no points with {SIMPLE}", "build it over an envelope with slow flight"
        )
    return samples


def static_loads(table: LoadTable, omega: Floats) -> dict[str, Floats]:
    """What errors are shares of at omega (n,), by load; see ``Samples``."""
    still = table.loads(omega, 0.0, table.envelope["beta"][0])
    static = {name: np.asarray(getattr(still, name)) for name in LOADS}
    if not np.isfinite(static["thrust"]).all():
        least = table.envelope["speed"][0]
        raise InputError(
            f"the map has no loads at rest, its speed begins at {least:g} m/s",
            "this target's model needs hover: build the map with --speed 0:...",
        )
    return error_scales(static, table.content.radius)


def slope(samples: Samples, load: str) -> float:
    """A ``load`` over Omega times the in-plane speed, for simple models, by least squares of the
    ``samples``' shares of static loads [N s^2/m], [N s^2]."""
    chosen = samples.simple
    scale = samples.static[load][chosen]
    x = (samples.omega * samples.inplane)[chosen] / scale
    return float(x @ (samples.loads[load][chosen] / scale) / (x @ x))


def middle_omega(table: LoadTable) -> float:
    """Omega [rad/s] at which the Reynolds term is halfway between the envelope's ends."""
    return float(np.mean(table.content.omega**-0.5) ** -2.0)


def errors(samples: Samples, model: Mapping[str, Floats]) -> tuple[Errors, Errors]:
    """Errors of a model where simple models are meant, and over the envelope.

    A load (n,) that ``model`` lacks it takes to be zero.
    """
    share = np.stack(
        [
            (model.get(name, 0.0) - load) / samples.static[name]
            for name, load in samples.loads.items()
        ],
        axis=-1,
    )
    return _sizes(SIMPLE, share[samples.simple]), _sizes("the map's whole envelope", share)


def _sizes(where: str, share: Floats) -> Errors:
    return Errors(where, len(share), np.sqrt((share**2).mean(axis=0)), abs(share).max(axis=0))


def evenly(table: LoadTable, count: int) -> tuple[Floats, Floats, Floats]:
    """omega, speed and beta of points that fill a table's envelope evenly, (count,) each.

    By the additive recurrence of the root of x^4 = x + 1; SciPy has better sequences, but a
    table's user need not have SciPy.
    """
    root = 1.2207440846057596
    steps = root ** -np.arange(1.0, 4.0)
    unit = (0.5 + np.arange(1, count + 1)[:, None] * steps) % 1.0
    low, high = np.array(list(table.envelope.values())).T
    omega, speed, beta = (low + (high - low) * unit).T
    return omega, speed, beta
