"""Points of a table's envelope, and what a simpler model's errors at them are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.errors import InputError
from propmap.loads import LOADS, error_scales
from propmap.table.lookup import VORTEX_RING
from propmap.table.query import LoadTable

POINTS = 32_768

CLIMB = (-0.05, 0.2)
LARGEST_MU = 0.25
"""The advance ratios, along the axis and in the disk plane, for which the simple models are
meant: climb and slow descent.  In faster descent their errors triple."""

SIMPLE = f"lambda_c from {CLIMB[0]:g} to {CLIMB[1]:g}, mu up to {LARGEST_MU:g}, no vortex ring"


@dataclass(frozen=True)
class Samples:
    """A table's loads at n points that fill its envelope evenly.

    omega [rad/s], axial, inplane [m/s] : (n,).  loads, static : (n, 4), in the order of
    ``LOADS`` [N], [N m]; static : the static loads at the same omega that errors are shares
    of, thrust for thrust and drag, torque for torque, thrust times radius for the roll moment.
    climb, mu : advance ratios along the axis and in the disk plane [-] (n,).
    ring : where momentum theory does not hold, (n,).
    """

    omega: Floats
    axial: Floats
    inplane: Floats
    loads: Floats
    static: Floats
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
    """Of a model: shares of static loads, by load in the order of ``LOADS``.

    where : the points' range, in words.  points : how many.
    """

    where: str
    points: int
    rms: Floats
    worst: Floats


def sample(table: LoadTable) -> Samples:
    """Points of the envelope that have loads.

    Raises ``InputError`` for a table without hover, which has no static loads, and for one
    without points for simple models.
    """
    omega, speed, beta = _evenly(table)
    found = table.loads(omega, speed, beta)
    loads = np.stack([getattr(found, name) for name in LOADS], axis=-1)
    valid = np.isfinite(loads).all(axis=1)
    axial, inplane = speed * np.cos(beta), speed * np.sin(beta)
    tip = omega * table.content.radius
    static = static_loads(table, omega)
    samples = Samples(
        omega=omega[valid],
        axial=axial[valid],
        inplane=inplane[valid],
        loads=loads[valid],
        static=static[valid],
        climb=(axial / tip)[valid],
        mu=(inplane / tip)[valid],
        ring=np.asarray(found.code == VORTEX_RING)[valid],
    )
    if not samples.simple.any():
        raise InputError(
            f"the map has no points with {SIMPLE}", "build it over an envelope with slow flight"
        )
    return samples


def static_loads(table: LoadTable, omega: Floats) -> Floats:
    """What errors are shares of, (n, 4), at omega (n,); see ``Samples``."""
    still = table.loads(omega, 0.0, table.envelope["beta"][0])
    static = {name: np.asarray(getattr(still, name)) for name in LOADS}
    if not np.isfinite(static["thrust"]).all():
        least = table.envelope["speed"][0]
        raise InputError(
            f"the map has no loads at rest, its speed begins at {least:g} m/s",
            "this target's model needs hover: build the map with --speed 0:...",
        )
    return np.stack(list(error_scales(static, table.content.radius).values()), axis=-1)


def middle_omega(table: LoadTable) -> float:
    """Omega [rad/s] at which the Reynolds term is halfway between the envelope's ends."""
    return float(np.mean(table.content.omega**-0.5) ** -2.0)


def errors(samples: Samples, model: Floats) -> tuple[Errors, Errors]:
    """Of a model's loads (n, 4): where simple models are meant, and over the envelope."""
    share = (model - samples.loads) / samples.static
    return _sizes(SIMPLE, share[samples.simple]), _sizes("the map's whole envelope", share)


def _sizes(where: str, share: Floats) -> Errors:
    return Errors(where, len(share), np.sqrt((share**2).mean(axis=0)), abs(share).max(axis=0))


def _evenly(table: LoadTable) -> tuple[Floats, Floats, Floats]:
    # The additive recurrence of the root of x^4 = x + 1: even, and the same every time.
    root = 1.2207440846057596
    steps = root ** -np.arange(1.0, 4.0)
    unit = (0.5 + np.arange(1, POINTS + 1)[:, None] * steps) % 1.0
    low, high = np.array(list(table.envelope.values())).T
    omega, speed, beta = (low + (high - low) * unit).T
    return omega, speed, beta
