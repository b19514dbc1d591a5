"""How far a table is from the model, on points that its building did not use."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from propmap.loads import LOADS
from propmap.table.axis import locate
from propmap.table.comparison import Comparison, compare, quasi_random
from propmap.table.content import UNRESOLVED as UNRESOLVED_BIT
from propmap.table.largest_errors import largest_errors
from propmap.table.lookup import UNRESOLVED, VORTEX_RING
from propmap.typing import Floats

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

    The largest are searched for from these; see ``propmap.table.largest_errors``.  Errors are
    shares of the static loads at the same omega, by load; see ``loads.error_scales``.

    Attributes
    ----------
    tolerance : float
        What was asked for.
    points, seed : int
        How many, and of which scrambled Sobol sequence over (omega, speed, beta).
    max_error, rms_error : dict of str to float
        Over the points that have a value and are not "unresolved"; the largest also over those
        of the search.
    unresolved : int
        Points with that status, in cells where the model's loads jump or nearly so.
    unresolved_cells, unresolved_volume : int, float
        How many such cells there are, and their share of the envelope.
    unresolved_points : int
        Points inside them, spread evenly, of the next two.
    unresolved_max_error, unresolved_rms_error : dict of str to float
        Errors inside them; the largest also over the points of the search.
    vortex_ring, no_value : int
        Points with that status, which count in the errors; and points without loads.
    search_points : int
        How many the search for the largest errors took; 0 in tables of earlier versions, whose
        largest errors are of the sample alone.
    max_omega, max_speed, max_beta : dict of str to float
        Where ``max_error`` was met [rad/s], [m/s], [rad]; empty in tables of earlier versions.
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
    search_points: int = 0
    max_omega: dict[str, float] = field(default_factory=dict)
    max_speed: dict[str, float] = field(default_factory=dict)
    max_beta: dict[str, float] = field(default_factory=dict)

    @property
    def holds(self) -> bool:
        """Whether the largest error is within the tolerance, unresolved points aside."""
        return max(self.max_error.values()) <= self.tolerance

    def as_dict(self) -> dict[str, Any]:
        """Plain data, as filed; with ``holds``."""
        return {**asdict(self), "holds": self.holds}


def certify(
    table: LoadTable, model: Model, tolerance: float, *, points: int = POINTS, seed: int = 1
) -> tuple[Certificate, Comparison]:
    """Compare on fresh points, search for the worst: the certificate, and what it was drawn from.

    The latter are the points with loads outside unresolved cells.

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
    sample = compare(table, model, *quasi_random(table, points, seed))
    volume, inside = _unresolved(table, points, seed + 1)
    within = compare(table, model, *inside)
    model.stage = "looking for the largest errors"
    searched = largest_errors(table, model, sample.and_also(within), seed)
    sound, loose = _kinds(sample)
    known = sound.and_also(_kinds(searched)[0])
    most, (omega, speed, beta) = _largest(known)
    all_loose = loose.and_also(_kinds(within)[1])
    loose_most, _ = _largest(all_loose.and_also(_kinds(searched)[1]))
    certificate = Certificate(
        tolerance=tolerance,
        points=points,
        seed=seed,
        max_error=most,
        rms_error=_rms(sound.errors),
        unresolved=loose.omega.size,
        unresolved_cells=int(np.count_nonzero(table.content.cells & UNRESOLVED_BIT)),
        unresolved_volume=volume,
        unresolved_points=all_loose.omega.size,
        unresolved_max_error=loose_most,
        unresolved_rms_error=_rms(all_loose.errors),
        vortex_ring=int((sample.code == VORTEX_RING).sum()),
        no_value=int(sample.lost.sum()),
        search_points=searched.omega.size,
        max_omega=omega,
        max_speed=speed,
        max_beta=beta,
    )
    return certificate, known


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


def _kinds(found: Comparison) -> tuple[Comparison, Comparison]:
    """The points with loads in resolved cells, and those in the others."""
    loose = found.code == UNRESOLVED
    return found.where(~found.lost & ~loose), found.where(~found.lost & loose)


def _largest(found: Comparison) -> tuple[dict[str, float], list[dict[str, float]]]:
    """The largest error by load, and omega, speed and beta where it is; zeros without points."""
    if not found.omega.size:
        return dict.fromkeys(LOADS, 0.0), [{}, {}, {}]
    errors = np.abs(found.errors)
    at = errors.argmax(axis=0)
    places = [by_load(values[at]) for values in (found.omega, found.speed, found.beta)]
    return by_load(errors.max(axis=0)), places


def _rms(errors: Floats) -> dict[str, float]:
    """Root mean square by load; zeros where there are no points."""
    return by_load(np.sqrt((errors**2).sum(axis=0) / max(len(errors), 1)))


def by_load(values: Floats) -> dict[str, float]:
    """Values (L,) with the names of ``LOADS``."""
    return dict(zip(LOADS, values.tolist(), strict=True))
