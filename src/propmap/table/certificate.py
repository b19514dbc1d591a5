"""How far a table is from the model, on points that its building did not use."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.loads import LOADS
from propmap.table.axis import locate
from propmap.table.content import UNRESOLVED as UNRESOLVED_BIT
from propmap.table.lookup import NO_VALUE, UNRESOLVED, VORTEX_RING

if TYPE_CHECKING:
    from propmap.table.model import Model
    from propmap.table.query import LoadTable

POINTS = 32_768
"""Of a certificate; a power of two, as Sobol's sequence wants."""

CANDIDATES = 32
"""Points of the envelope, per point of a certificate, among which those in unresolved cells are
looked for."""

MOST_INSIDE = 4
"""One part in so many of a certificate's points is the most that is evaluated of these."""


@dataclass(frozen=True)
class Certificate:
    """Errors of a table against the model on quasi-random points of its envelope.

    Errors are shares of the static loads at the same omega, by load; see ``loads.error_scales``.

    Attributes
    ----------
    tolerance : float
        What was asked for.
    points, seed : int
        How many, and of which scrambled Sobol sequence over (omega, speed, beta).
    max_error, rms_error : dict of str to float
        Over the points that have a value and are not "unresolved".
    unresolved : int
        Points with that status, in cells where the model's loads jump or nearly so.
    unresolved_cells, unresolved_volume : int, float
        How many such cells there are, and their share of the envelope.
    unresolved_points : int
        Points inside them, spread evenly, of the next two.
    unresolved_max_error, unresolved_rms_error : dict of str to float
        Errors inside them.
    vortex_ring, no_value : int
        Points with that status, which count in the errors; and points without loads.
    """

    tolerance: float
    points: int
    seed: int
    max_error: dict[str, float]
    rms_error: dict[str, float]
    unresolved: int
    unresolved_cells: int
    unresolved_volume: float
    unresolved_points: int
    unresolved_max_error: dict[str, float]
    unresolved_rms_error: dict[str, float]
    vortex_ring: int
    no_value: int

    @property
    def holds(self) -> bool:
        """Whether the largest error is within the tolerance, unresolved points aside."""
        return max(self.max_error.values()) <= self.tolerance

    def as_dict(self) -> dict[str, Any]:
        """Plain data, as filed; with ``holds``."""
        return {**asdict(self), "holds": self.holds}


@dataclass(frozen=True)
class Comparison:
    """Errors (n, L) as shares of static loads, codes (n,), advance ratios and angles (n,)."""

    errors: Floats
    code: NDArray[np.uint8]
    advance: Floats
    beta: Floats


def quasi_random(table: LoadTable, points: int, seed: int) -> tuple[Floats, Floats, Floats]:
    """omega, speed and beta of points that fill the envelope evenly, (n,) each."""
    from scipy.stats import qmc

    unit = qmc.Sobol(3, seed=seed).random(points)
    low, high = np.array(list(table.envelope.values())).T
    omega, speed, beta = (low + (high - low) * unit).T
    return omega, speed, beta


def compare(
    table: LoadTable, model: Model, omega: Floats, speed: Floats, beta: Floats
) -> Comparison:
    """The table's errors at n points of its envelope, (n,) each."""
    expected, _ = model.loads(omega, speed, beta)
    found = table.loads(omega, speed, beta)
    values = np.stack(found[: len(LOADS)], axis=-1)
    errors = (values - expected) / static_loads(model, omega)
    return Comparison(errors, found.code, speed / (omega * table.content.radius), beta)


def certify(
    table: LoadTable, model: Model, tolerance: float, *, points: int = POINTS, seed: int = 1
) -> tuple[Certificate, Comparison]:
    """Compare on fresh points; the certificate, and what it was drawn from.

    Points in unresolved cells do not count in the claim that the tolerance holds.  They are few,
    so that more are taken for the bound that is stated for these cells.

    Parameters
    ----------
    table, model : LoadTable, Model
        To be certified, and what it was built from.
    tolerance : float
        Largest error as a share of static loads.
    points, seed : int
        How many, a power of two, and the seed of their Sobol sequence.
    """
    model.stage = "certifying"
    found = compare(table, model, *quasi_random(table, points, seed))
    lost = np.isnan(found.errors).any(axis=1) | (found.code == NO_VALUE)
    loose = ~lost & (found.code == UNRESOLVED)
    most, rms = _sizes(found.errors[~lost & ~loose])
    volume, inside = _unresolved(table, points, seed + 1)
    errors = np.concatenate([found.errors[loose], compare(table, model, *inside).errors])
    errors = errors[np.isfinite(errors).all(axis=1)]
    loose_most, loose_rms = _sizes(errors)
    certificate = Certificate(
        tolerance=tolerance,
        points=points,
        seed=seed,
        max_error=most,
        rms_error=rms,
        unresolved=int(loose.sum()),
        unresolved_cells=int(np.count_nonzero(table.content.cells & UNRESOLVED_BIT)),
        unresolved_volume=volume,
        unresolved_points=len(errors),
        unresolved_max_error=loose_most,
        unresolved_rms_error=loose_rms,
        vortex_ring=int((found.code == VORTEX_RING).sum()),
        no_value=int(lost.sum()),
    )
    return certificate, found


def unresolved_share(table: LoadTable) -> float:
    """Share of the envelope that unresolved cells take."""
    return _unresolved(table, POINTS // CANDIDATES, seed=1)[0]


def _unresolved(
    table: LoadTable, points: int, seed: int
) -> tuple[float, tuple[Floats, Floats, Floats]]:
    """Share of the envelope that unresolved cells take, and points inside them, (n,) each."""
    content = table.content
    if not (content.cells & UNRESOLVED_BIT).any():
        none = np.empty(0)
        return 0.0, (none, none, none)
    omega, speed, beta = quasi_random(table, CANDIDATES * points, seed)
    row = locate(content.advance, speed / (omega * content.radius))[0]
    inside = (content.cells[row, locate(content.beta, beta)[0]] & UNRESOLVED_BIT) > 0
    kept = np.flatnonzero(inside)[: points // MOST_INSIDE]
    return float(inside.mean()), (omega[kept], speed[kept], beta[kept])


def static_loads(model: Model, omega: Floats) -> Floats:
    """Static loads (n, L) at omega (n,).

    Over Omega^2 they are linear in Omega^(-1/2), between the ends of the envelope to 1e-5, as
    the model's friction is.
    """
    roots, ends = omega**-0.5, model.omega**-0.5
    share = ((roots - ends[0]) / (ends[1] - ends[0]))[:, None]
    low, high = model.static / (model.omega**2)[:, None]
    return np.asarray((low + share * (high - low)) * (omega**2)[:, None])


def _sizes(errors: Floats) -> tuple[dict[str, float], dict[str, float]]:
    """Largest and root mean square by load; zeros where there are no points."""
    if not errors.size:
        errors = np.zeros((1, len(LOADS)))
    most, rms = np.abs(errors).max(axis=0), np.sqrt((errors**2).mean(axis=0))
    return by_load(most), by_load(rms)


def by_load(values: Floats) -> dict[str, float]:
    """Values (L,) with the names of ``LOADS``."""
    return dict(zip(LOADS, values.tolist(), strict=True))
