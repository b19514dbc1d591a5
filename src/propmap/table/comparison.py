"""A table beside the model, at points of its envelope."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from propmap.loads import LOADS
from propmap.table.lookup import NO_VALUE
from propmap.table.sobol import sobol
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.table.model import Model
    from propmap.table.query import LoadTable


@dataclass(frozen=True)
class Comparison:
    """Errors of a table at n operating points.

    Attributes
    ----------
    errors : ndarray, shape (n, L)
        As shares of the static loads at the same omega; NaN where there are no loads.
    code : ndarray of uint8, shape (n,)
        The table's, an index into ``STATUSES``.
    omega, speed, beta, advance : ndarray, shape (n,)
        Where [rad/s], [m/s], [rad], V/(Omega R) [-].
    """

    errors: Floats
    code: NDArray[np.uint8]
    omega: Floats
    speed: Floats
    beta: Floats
    advance: Floats

    @property
    def lost(self) -> NDArray[np.bool_]:
        """Where there are no loads, of the table or of the model (n,)."""
        return np.asarray(np.isnan(self.errors).any(axis=1) | (self.code == NO_VALUE))

    def where(self, chosen: NDArray[np.bool_]) -> Self:
        """The points chosen (n,)."""
        return type(self)(*(getattr(self, f.name)[chosen] for f in fields(self)))

    def and_also(self, other: Self) -> Self:
        """These points and those of the ``other``."""
        both = ((getattr(self, f.name), getattr(other, f.name)) for f in fields(self))
        return type(self)(*map(np.concatenate, both))


def compare(
    table: LoadTable, model: Model, omega: Floats, speed: Floats, beta: Floats
) -> Comparison:
    """The table's errors at n points of its envelope, (n,) each."""
    expected, _ = model.loads(omega, speed, beta)
    found = table.loads(omega, speed, beta)
    values = np.stack(found[: len(LOADS)], axis=-1)
    errors = (values - expected) / static_loads(model, omega)
    advance = speed / (omega * table.content.radius)
    return Comparison(errors, found.code, omega, speed, beta, advance)


def quasi_random(table: LoadTable, points: int, seed: int) -> tuple[Floats, Floats, Floats]:
    """omega, speed and beta of points that fill the envelope evenly, (n,) each."""
    low, high = np.array(list(table.envelope.values())).T
    omega, speed, beta = (low + (high - low) * sobol(points, seed)).T
    return omega, speed, beta


def static_loads(model: Model, omega: Floats) -> Floats:
    """Static loads (n, L) at omega (n,).

    Over Omega^2 they are linear in Omega^(-1/2), between the ends of the envelope to 1e-5, as
    the model's friction is.
    """
    roots, ends = omega**-0.5, model.omega**-0.5
    share = ((roots - ends[0]) / (ends[1] - ends[0]))[:, None]
    low, high = model.static / (model.omega**2)[:, None]
    return np.asarray((low + share * (high - low)) * (omega**2)[:, None])
