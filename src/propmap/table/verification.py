"""Comparison of a table with its model at points that were not used to build it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.loads import LOADS, error_scales
from propmap.model.airfoil import SectionCovariance
from propmap.rotor import Rotor
from propmap.table import interpolation
from propmap.table.certificate import Certificate
from propmap.table.query import LoadTable
from propmap.tasks import InTurn, Workers
from propmap.typing import Floats

POINTS = 32_768  # points of a certificate; Sobol's sequence requires a power of two
CANDIDATES = 32  # candidates per point of a certificate in the search for unresolved cells
MOST_INSIDE = 4  # points of a certificate / largest number of points in unresolved cells


# --- The model that a table is built from and compared with; each coefficient is computed once ---

Progress = Callable[[str, int], None]  # called with the current stage and the points evaluated
BATCH = 4096  # operating points between two calls of progress: some tenths of a second


class CachedModel:
    """Loads of a rotor, absolute and relative to its static loads at two rotational speeds (2,)
    [rad/s]; raises ``InputError`` unless the static loads are positive."""

    def __init__(
        self,
        rotor: Rotor,
        omega: Floats,
        *,
        leave_out_vortex_ring: bool = False,
        progress: Progress | None = None,
        workers: Workers | None = None,
    ) -> None:
        self.rotor, self.omega = rotor, omega
        self._workers = workers or InTurn()
        self.leave_out_vortex_ring = leave_out_vortex_ring
        self.evaluations = 0
        self.stage = "static loads"
        self._progress = progress
        self._known: list[dict[tuple[float, float], Floats]] = [{}, {}]
        self.static = self.static_loads(omega)

    def static_loads(self, omega: Floats) -> Floats:
        """Return the reference loads of errors (n, L), see ``loads.error_scales``."""
        loads, _ = self._evaluate(omega, np.zeros_like(omega), np.zeros_like(omega))
        static = dict(zip(LOADS, np.sign(omega) * loads.T, strict=True))
        scales = np.array(list(error_scales(static, self.rotor.model.propeller.radius).values())).T
        if not (scales > 0.0).all():
            found = "the static thrust and torque of this rotor, the reference for the errors of a "
            found += "table, are not positive"
            raise InputError(found, "check the propeller's pitch and the section law")
        return scales

    def loads(self, omega: Floats, speed: Floats, beta: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """Return loads (n, L) in the order of ``LOADS``, and a mask of the vortex ring state."""
        values, ring = self._evaluate(omega, speed, beta)
        if self.leave_out_vortex_ring:
            values[ring] = np.nan
        return values, ring

    def relative(self, node: int, advance: Floats, beta: Floats) -> tuple[Floats, Floats]:
        """Return loads / static loads at one omega (n, m, L), and 1 in vortex ring (n, m)."""
        known = self._known[node]
        grid = [(j, b) for j in advance.tolist() for b in beta.tolist()]
        new = [point for point in grid if point not in known]
        if new:
            j, b = np.array(new).T
            omega = np.full(j.size, self.omega[node])
            values, ring = self.loads(
                omega, j * np.abs(omega) * self.rotor.model.propeller.radius, b
            )
            rows = np.concatenate([values / self.static[node], ring[:, None]], axis=1)
            known.update(zip(new, rows, strict=True))
        found = np.array([known[point] for point in grid]).reshape(advance.size, beta.size, -1)
        return found[..., :-1], found[..., -1]

    def _evaluate(
        self, omega: Floats, speed: Floats, beta: Floats
    ) -> tuple[Floats, NDArray[np.bool_]]:
        values, ring = np.empty((omega.size, len(LOADS))), np.empty(omega.size, bool)
        cuts = [slice(start, start + BATCH) for start in range(0, omega.size, BATCH)]
        batches = ((omega[cut], speed[cut], beta[cut]) for cut in cuts)
        for which, found in self._workers.results(_loads_of, self.rotor, batches):
            values[cuts[which]], ring[cuts[which]] = found
            self.evaluations += found[1].size
            if self._progress:
                self._progress(self.stage, self.evaluations)
        return values, ring


def _loads_of(
    rotor: Rotor, batch: tuple[Floats, Floats, Floats]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return loads (n, L) of a batch, and a mask of the vortex ring state (n,)."""
    found = rotor.loads(*batch)
    values = np.stack([getattr(found, name) for name in LOADS], axis=-1)
    return values, found.status == "vortex_ring"


# --- The certificate: errors at independent points, and a search for the largest errors ----------


def certify(
    table: LoadTable, model: CachedModel, tolerance: float, *, points: int = POINTS, seed: int = 1
) -> tuple[Certificate, TableErrors]:
    """Compare a table with its model at independent points, and search for the largest errors.

    Return the certificate, and the points with loads outside unresolved cells.  The tolerance does
    not apply inside unresolved cells, whose errors are computed separately at additional points.

    Parameters
    ----------
    table, model : LoadTable, CachedModel
        Table to certify, and the model that it was built from.
    tolerance : float
        Largest error as a fraction of the static loads.
    points, seed : int
        Number of points, a power of two, and the seed of their Sobol sequence.
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
        unresolved_cells=int(np.count_nonzero(table.content.cells & interpolation.UNRESOLVED_BIT)),
        unresolved_volume=volume,
        unresolved_points=all_loose.omega.size,
        unresolved_max_error=loose_most,
        unresolved_rms_error=_rms(all_loose.errors),
        vortex_ring=int((sample.code == interpolation.VORTEX_RING).sum()),
        no_value=int(sample.lost.sum()),
        search_points=searched.omega.size,
        max_omega=omega,
        max_speed=speed,
        max_beta=beta,
    )
    return certificate, known


def unresolved_share(table: LoadTable) -> float:
    """Estimate the fraction of the envelope in unresolved cells."""
    return _unresolved(table, POINTS // CANDIDATES, seed=1)[0]


def _unresolved(
    table: LoadTable, points: int, seed: int
) -> tuple[float, tuple[Floats, Floats, Floats]]:
    """Return the fraction of the envelope in unresolved cells, and points inside them (n,)."""
    content = table.content
    if not (content.cells & interpolation.UNRESOLVED_BIT).any():
        none = np.empty(0)
        return 0.0, (none, none, none)
    omega, speed, beta = quasi_random(table, CANDIDATES * points, seed)
    row = interpolation.locate(content.advance, speed / (np.abs(omega) * content.radius))[0]
    inside = (
        content.cells[row, interpolation.locate(content.beta, beta)[0]]
        & interpolation.UNRESOLVED_BIT
    ) > 0
    kept = np.flatnonzero(inside)[: points // MOST_INSIDE]
    return float(inside.mean()), (omega[kept], speed[kept], beta[kept])


def _kinds(found: TableErrors) -> tuple[TableErrors, TableErrors]:
    """Split the points with loads into points in resolved cells and points in unresolved cells."""
    loose = found.code == interpolation.UNRESOLVED
    return found.where(~found.lost & ~loose), found.where(~found.lost & loose)


def _largest(found: TableErrors) -> tuple[dict[str, float], list[dict[str, float]]]:
    """Return the largest error by load, and its operating point; zeros without points."""
    if not found.omega.size:
        return dict.fromkeys(LOADS, 0.0), [{}, {}, {}]
    errors = np.abs(found.errors)
    at = errors.argmax(axis=0)
    places = [by_load(values[at]) for values in (found.omega, found.speed, found.beta)]
    return by_load(errors.max(axis=0)), places


def _rms(errors: Floats) -> dict[str, float]:
    """Return the root mean square by load; zeros without points."""
    return by_load(np.sqrt((errors**2).sum(axis=0) / max(len(errors), 1)))


def by_load(values: Floats) -> dict[str, float]:
    """Return values (L,) by the names of ``LOADS``."""
    return dict(zip(LOADS, values.tolist(), strict=True))


# --- Errors of a table at points of its envelope -------------------------------------------------


@dataclass(frozen=True)
class TableErrors:
    """Errors of a table at n operating points."""

    errors: Floats  # fractions of the static loads at the same omega (n, L); NaN without loads
    code: NDArray[np.uint8]  # status of the table, an index into ``STATUSES``
    omega: Floats  # [rad/s]
    speed: Floats  # [m/s]
    beta: Floats  # [rad]
    advance: Floats  # V/(Omega R) [-]

    @property
    def lost(self) -> NDArray[np.bool_]:
        """Points (n,) at which the table or the model has no loads."""
        return np.asarray(np.isnan(self.errors).any(axis=1) | (self.code == interpolation.NO_VALUE))

    def where(self, chosen: NDArray[np.bool_]) -> Self:
        """Return the points ``chosen`` (n,)."""
        return type(self)(*(getattr(self, f.name)[chosen] for f in fields(self)))

    def and_also(self, other: Self) -> Self:
        """Return these points followed by the points of the ``other``."""
        both = ((getattr(self, f.name), getattr(other, f.name)) for f in fields(self))
        return type(self)(*map(np.concatenate, both))


def compare(
    table: LoadTable, model: CachedModel, omega: Floats, speed: Floats, beta: Floats
) -> TableErrors:
    """Compute the table's errors at n points of its envelope, (n,) each."""
    expected, _ = model.loads(omega, speed, beta)
    found = table.loads(omega, speed, beta)
    values = np.stack(found[: len(LOADS)], axis=-1)
    errors = (values - expected) / static_loads(model, omega)
    advance = speed / (np.abs(omega) * table.content.radius)
    return TableErrors(errors, found.code, omega, speed, beta, advance)


def quasi_random(table: LoadTable, points: int, seed: int) -> tuple[Floats, Floats, Floats]:
    """Return omega, speed and beta (n,) of points that fill the envelope evenly."""
    low, high = np.array(list(table.envelope.values())).T
    omega, speed, beta = (low + (high - low) * sobol(points, seed)).T
    return omega, speed, beta


def static_loads(model: CachedModel, omega: Floats) -> Floats:
    """Interpolate the static loads (n, L) at omega (n,), with a relative error of 1e-5."""
    # Static loads / Omega^2 are linear in Omega^(-1/2), like the model's friction.
    roots, ends = np.abs(omega) ** -0.5, np.abs(model.omega) ** -0.5
    share = ((roots - ends[0]) / (ends[1] - ends[0]))[:, None]
    low, high = model.static / (model.omega**2)[:, None]
    return np.asarray((low + share * (high - low)) * (omega**2)[:, None])


# -------------------------------------------------------------------------------------------------
# The search for a table's largest errors, which evenly spread points alone would miss.
#
# Evenly spread points seldom hit a peak of the error that fills one ten-thousandth of the envelope,
# but they usually hit its slopes.  The search therefore samples every cell of the table, including
# the smallest ones.  It starts climbs from the worst points of each load, at most one per cell.  A
# climb tries random steps, which grow after a success and shrink after a failure.  At intervals the
# search drops the worse half of the climbs, and the remaining climbs try more steps.

OVERHANG = np.array([0.5, 0.5, 0.25])  # samples lie up to this far beyond the edges before clipping
CLIMBS = 32  # most initial climbs per goal for 32768 sampled points, proportional to their number
FEWEST_CLIMBS = 8

TRIES = 4  # steps that each climb tries per round, until the first halving
HALVINGS, ROUNDS = 4, 5  # halvings of the number of climbs, and rounds before each halving
STEP = np.array([0.5, 0.5, 0.25])  # largest step of the first round, in positions
GROWTH, SHRINKAGE = 1.5, 0.6

GOALS = 2 * len(LOADS)  # each load in resolved cells, then each load in unresolved cells


def largest_errors(
    table: LoadTable, model: CachedModel, sampled: TableErrors, seed: int
) -> TableErrors:
    """Search for the largest errors by load from points ``sampled``, separately inside unresolved
    cells, with random steps of this ``seed``; return all points evaluated."""
    rng = np.random.default_rng(seed)
    content = table.content
    points = sampled.omega.size
    most = interpolation.most_position(content)
    unit = sobol(2 ** int(np.log2(max(points // 2, 1))), seed)
    over_cells = np.clip(unit * (most + 2.0 * OVERHANG) - OVERHANG, 0.0, most)
    found = compare(table, model, *interpolation.points_at(content, over_cells))
    known = sampled.and_also(found)
    climbs = _Climbs(content, known, max(FEWEST_CLIMBS, CLIMBS * points // 32_768))
    for halving in range(HALVINGS):
        for _ in range(ROUNDS):
            position = climbs.steps(TRIES * 2**halving, rng, most)
            tried = compare(table, model, *interpolation.points_at(content, position))
            found = found.and_also(tried)
            climbs.take(position, tried)
        climbs.halve()
    return found


class _Climbs:
    """Climbs to larger errors from the worst ``most`` points of each goal, at most one per cell."""

    def __init__(self, content: interpolation.TableContent, known: TableErrors, most: int) -> None:
        position = interpolation.positions_of(content, known.omega, known.advance, known.beta)
        cell = np.floor(position[:, 0]) * content.beta.size + np.floor(position[:, 1])
        sizes = _sizes(known)
        starts, goals = [], []
        for goal, size in enumerate(sizes.T):
            order = np.argsort(-size)[: np.count_nonzero(size > 0.0)]
            first = np.sort(np.unique(cell[order], return_index=True)[1])[:most]
            starts.append(order[first])
            goals.append(np.full(first.size, goal))
        start, goal_of = np.concatenate(starts), np.concatenate(goals)
        self.position = position[start]  # (k, 3)
        self.error = sizes[start, goal_of]  # the largest found so far (k,)
        self.goal = goal_of  # load and kind of cell (k,)
        self.length = np.ones(goal_of.size)  # length of the steps as a multiple of ``STEP`` (k,)

    def steps(self, tries: int, rng: np.random.Generator, most: Floats) -> Floats:
        """Return positions (k tries, 3) to try, starting with those of the first climb."""
        share = rng.uniform(-1.0, 1.0, (self.goal.size, tries, 3))
        step = share * STEP * self.length[:, None, None]
        return np.clip(self.position[:, None] + step, 0.0, most).reshape(-1, 3)

    def take(self, position: Floats, tried: TableErrors) -> None:
        """Move each climb to the best position tried, if its error is larger."""
        count = self.goal.size
        if not count:
            return
        size = _sizes(tried).reshape(count, -1, GOALS)
        every = np.arange(count)
        size = size[every, :, self.goal]
        best = size.argmax(axis=1)
        better = size[every, best] > self.error
        self.position[better] = position.reshape(count, -1, 3)[every, best][better]
        self.error[better] = size[every, best][better]
        self.length *= np.where(better, GROWTH, SHRINKAGE)

    def halve(self) -> None:
        """Drop the worse half of each goal's climbs."""
        order = np.lexsort((-self.error, self.goal))
        rank = np.arange(order.size) - np.searchsorted(self.goal[order], self.goal[order])
        count = np.bincount(self.goal, minlength=GOALS)[self.goal[order]]
        kept = order[2 * rank < count]
        for name in ("position", "error", "goal", "length"):
            setattr(self, name, getattr(self, name)[kept])


def _sizes(found: TableErrors) -> Floats:
    """Return the magnitudes (n, ``GOALS``) of the errors; zero in cells of the other kind."""
    size = np.where(found.lost[:, None], 0.0, np.abs(found.errors))
    loose = (found.code == interpolation.UNRESOLVED)[:, None]
    return np.concatenate([np.where(loose, 0.0, size), np.where(loose, size, 0.0)], axis=1)


# --- Standard deviations of a table's loads due to the section constants -------------------------

UNCERTAINTY_POINTS = 1024  # points of the envelope; a power of two
SEED = 20_170


def parameter_uncertainty(
    table: LoadTable, model: CachedModel, covariance: SectionCovariance
) -> dict[str, Any]:
    """Return percentiles over the envelope of the loads' standard deviations due to the covariance,
    to first order, as fractions of the static loads; plain data."""
    model.stage = "uncertainty of the parameters"
    known = covariance.determined
    omega, speed, beta = quasi_random(table, UNCERTAINTY_POINTS, SEED)
    shares = load_deviations(model.rotor, known, omega, speed, beta) / static_loads(model, omega)
    shares = shares[np.isfinite(shares).all(axis=1)]
    median, high = np.percentile(shares, [50.0, 95.0], axis=0)
    return {
        "parameters": list(known.names),
        "not_counted": list(covariance.unknown),  # constants that the data do not determine
        "points": len(shares),
        "median": by_load(median),
        "percentile_95": by_load(high),
    }


def load_deviations(
    rotor: Rotor, covariance: SectionCovariance, omega: Floats, speed: Floats, beta: Floats
) -> Floats:
    """Return standard deviations (n, L) of loads: sqrt(g' S g), derivatives g, covariance S."""
    turned = np.sign(omega)  # derivatives of the loads at omega > 0, as in ``Rotor.loads``
    flow = turned * omega, turned * speed * np.cos(beta), np.abs(speed * np.sin(beta))
    found = rotor.gradients(covariance.names, *flow)
    variance = np.einsum("lpn,pq,lqn->nl", found.slopes, covariance.matrix, found.slopes)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))


# --- Evenly spread points: the scrambled Sobol sequence in three dimensions ----------------------

BITS = 30  # bits of each coordinate


def sobol(count: int, seed: int) -> Floats:
    """Return the first points (n, 3) of the sequence in the unit cube, scrambled by ``seed``.

    The points equal those of ``scipy.stats.qmc.Sobol``: direction numbers by Joe and Kuo, scrambled
    by a lower triangular matrix and a shift.  SciPy takes too long to import.
    """
    rng = np.random.default_rng(seed)
    place = np.arange(BITS, dtype=np.uint32)
    shift = rng.integers(2, size=(3, BITS), dtype=np.uint32) @ (np.uint32(1) << place)
    mixing = np.tril(rng.integers(2, size=(3, BITS, BITS), dtype=np.uint32), -1)
    mixing += np.eye(BITS, dtype=np.uint32)
    # The highest bit first.
    bits = (_directions()[:, None] >> place[::-1, None]) & 1
    directions = (np.uint32(1) << place[::-1]) @ (mixing @ bits % 2)
    found = shift[None]
    for direction in directions.T:
        if len(found) >= count:
            break
        # In Gray code, a new bit repeats the earlier numbers in reverse order, with this bit set.
        found = np.concatenate([found, found[::-1] ^ direction])
    return found[:count] / 2.0**BITS


def _directions() -> NDArray[np.uint32]:
    """Return direction numbers (3, ``BITS``) for no polynomial, x + 1 and x^2 + x + 1."""
    found = np.ones((3, BITS), np.uint32)
    found[2, 1] = 3
    for k in range(1, BITS):
        found[1, k] = 2 * found[1, k - 1] ^ found[1, k - 1]
    for k in range(2, BITS):
        found[2, k] = 2 * found[2, k - 1] ^ 4 * found[2, k - 2] ^ found[2, k - 2]
    return found << np.arange(BITS, dtype=np.uint32)[::-1]
