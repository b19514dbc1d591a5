"""Construction of a table: adaptive knots, coefficients, jumps of the loads, certificate."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

import propmap
from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.model.envelope import Range
from propmap.rotor import Rotor
from propmap.table import verification
from propmap.table.interpolation import (
    PARITY,
    UNRESOLVED_BIT,
    VORTEX_RING_BIT,
    TableContent,
    bilinear,
    coefficient_scale,
    interpolate,
    locate,
    on_planes,
    pad,
    points_at,
)
from propmap.table.query import LoadTable
from propmap.table.verification import CachedModel, Progress
from propmap.tasks import Workers
from propmap.typing import Floats
from propmap.units import RPM

MODEL_ERROR = {"standard": 0.001, "fine": 0.0001}  # by accuracy; half the least tolerance
LARGEST_TOLERANCE = 0.1

# Fractions of the envelope in unresolved cells.
MOST_UNRESOLVED = 0.05  # a table with more is refused
NARROW_ABOVE = 0.02  # unresolved cells are halved if there are more

NARROWINGS = 6  # largest number of halvings
WORTH = 0.9  # halving continues if it reduced the fraction to less than this multiple

ATTEMPTS = 8  # largest number of certifications
REFINEMENTS = 3  # cells that fail in these first attempts are halved; later ones are marked

FIRST_SEED = 20_171


def build_table(
    rotor: Rotor,
    *,
    omega: Range,
    speed: Range,
    beta: Range,
    tolerance: float = 0.005,
    leave_out_vortex_ring: bool = False,
    certificate_points: int = verification.POINTS,
    progress: Progress | None = None,
    workers: Workers | None = None,
) -> LoadTable:
    """Build a certified table of a rotor's loads.

    No table can follow the loads where the model's loads jump.  Cells with jumps have the status
    "unresolved"; the certificate counts them and states their errors separately.

    Parameters
    ----------
    rotor : Rotor
        Rotor to tabulate.  If its model has an uncertainty, the table contains the covariance of
        the section constants and the standard deviations of the loads.
    omega, speed, beta : tuple of float
        Least and largest value of the envelope [rad/s], [m/s], [rad]; beta within 0...pi.  All
        omegas are above 0, or below 0 for a propeller that turns backward.
    tolerance : float
        Largest error as a fraction of the static loads at the same omega.
    leave_out_vortex_ring : bool
        Whether loads in the vortex ring state are NaN.  By default they keep their values, with
        the status "vortex_ring".
    certificate_points : int
        Number of points for the certificate, a power of two.
    progress : function, optional
        Called with the name of the current stage and the number of operating points evaluated.
    workers : Workers, optional
        Workers that evaluate the model; default: this process.  They do not change the table.

    Raises
    ------
    InputError
        For an impossible envelope or tolerance, and if the table does not meet the tolerance.
    """
    check_tolerance(tolerance, rotor.accuracy)
    ends = _envelope(omega, speed, beta)
    model = CachedModel(
        rotor,
        ends[0],
        leave_out_vortex_ring=leave_out_vortex_ring,
        progress=progress,
        workers=workers,
    )
    slow, fast = np.sort(np.abs(ends[0])) * rotor.model.propeller.radius
    advance = ends[1][0] / fast, ends[1][1] / slow
    check_between_speeds(model, ends, tolerance)
    axes = starting_axes(model, advance, (float(ends[2][0]), float(ends[2][1])))
    info, left = _provenance(rotor, leave_out_vortex_ring), 1.0
    for narrowing in range(NARROWINGS + 1):
        refined = refine(model, *axes, tolerance)
        content = _content(model, refined, ends, info)
        narrow = ~refined.advance.divisible[:, None] & ~refined.beta.divisible[None, :]
        content = find_jumps(content, model, POINT_SHARE * tolerance, narrow)
        before, left = left, verification.unresolved_share(LoadTable(content))
        if left <= NARROW_ABOVE or left > WORTH * before or narrowing == NARROWINGS:
            break
        if not _halved((content.cells & UNRESOLVED_BIT) > 0, refined):
            break
    for attempt in range(1, ATTEMPTS + 1):
        table = LoadTable(content)
        proof, found = verification.certify(
            table, model, tolerance, points=certificate_points, seed=FIRST_SEED + attempt
        )
        if proof.holds:
            break
        # The table now changes at these points, so the next attempt certifies it at other points.
        too_large = exceeding(content, found, tolerance)
        if attempt <= REFINEMENTS and _halved(too_large, refined):
            refined = refine(model, *axes, tolerance)
            content = with_marks_of(content, _content(model, refined, ends, info))
        else:
            content = marked(content, found, CELL_SHARE * tolerance)
    unresolved = proof.unresolved_volume
    if not proof.holds or unresolved > MOST_UNRESOLVED:
        worst = max(proof.max_error.values())
        where = (content.cells & UNRESOLVED_BIT) > 0
        rows, columns = (k[:-1] + 0.5 * np.diff(k) for k in (content.advance, content.beta))
        place = _place(rows[np.nonzero(where)[0]], columns[np.nonzero(where)[1]])
        fault = f"the table does not meet the tolerance of {tolerance:.2%}: errors up to "
        fault += f"{worst:.2%}, and {unresolved:.1%} of the envelope unresolved{place}"
        raise InputError(fault, "use a larger tolerance or a smaller envelope")
    filed: dict[str, Any] = {"certificate": proof.as_dict()}
    known, deviations = rotor.model.uncertainty, None
    if known is not None:
        if known.covariance.determined.names:
            uncertainty = verification.parameter_uncertainty(table, model, known.covariance)
            filed["parameter_uncertainty"] = uncertainty
        model.stage = "standard deviations"
        deviations = deviation_coefficients(rotor, content)
    filed["model_evaluations"] = model.evaluations
    return LoadTable(replace(content, info={**info, **filed}, deviations=deviations))


def _halved(cells: NDArray[np.bool_], refined: Refined) -> bool:
    """Halve the divisible intervals of these cells; return whether there were any."""
    rows = cells.any(axis=1) & refined.advance.divisible
    columns = cells.any(axis=0) & refined.beta.divisible
    refined.advance.split(rows)
    refined.beta.split(columns)
    return bool(rows.any() or columns.any())


def check_tolerance(tolerance: float, accuracy: str) -> None:
    """Raise ``InputError`` for a tolerance outside the range for a rotor of this accuracy."""
    least = 2.0 * MODEL_ERROR[accuracy]
    if not least <= tolerance <= LARGEST_TOLERANCE:
        hint = " (0.02% with accuracy fine)" if accuracy == "standard" else ""
        found = f"the tolerance is {tolerance:.3g}; with accuracy {accuracy!r} it must be "
        found += f"between {least:.2%} and {LARGEST_TOLERANCE:.0%}{hint}"
        raise InputError(found, "choose another tolerance or accuracy")


def _envelope(*ranges: Range) -> tuple[Floats, Floats, Floats]:
    units = ("omega", "rad/s"), ("speed", "m/s"), ("beta", "rad")
    for (name, unit), (low, high) in zip(units, ranges, strict=True):
        if not (np.isfinite([low, high]).all() and low < high):
            found = f"the range of {name} is {low:g} to {high:g} {unit}"
            raise InputError(found, "give the smaller value first")
    (slowest, fastest), (least, _), (first, last) = ranges
    if slowest <= 0.0 <= fastest:
        found = f"omega ranges from {slowest:g} to {fastest:g} rad/s and includes 0, for which the "
        remedy = "start at the idle speed; build one table for each direction of rotation"
        raise InputError(f"{found}advance ratio is infinite", remedy)
    if least < 0.0 or first < 0.0 or last > np.pi + 1e-12:
        found = "speed must not be negative, and beta must be between 0 and 180 degrees"
        raise InputError(found, "for descent, give beta above 90 degrees (in Python: pi/2 to pi)")
    omega, speed, beta = (np.array(r, dtype=np.float64) for r in ranges)
    return omega, speed, np.minimum(beta, np.pi)


def _content(
    model: CachedModel, refined: Refined, ends: tuple[Floats, Floats, Floats], info: dict[str, Any]
) -> TableContent:
    rotor, omega = model.rotor, model.omega[:, None]
    scale = coefficient_scale(rotor.model.air.density, rotor.model.propeller.radius)
    relative = model.static / (scale * omega**2)
    coefficients = (refined.values * relative[:, None, None, :]).transpose(0, 3, 1, 2)
    ring = refined.ring
    any_ring = ring[:-1, :-1] | ring[1:, :-1] | ring[:-1, 1:] | ring[1:, 1:]
    cells = VORTEX_RING_BIT * any_ring + UNRESOLVED_BIT * refined.missed
    return TableContent(
        advance=refined.advance.knots,
        beta=refined.beta.knots,
        omega=ends[0],
        speed=ends[1],
        # Round as in the file, so that a table returns the same loads before and after saving.
        coefficients=coefficients.astype(np.float32).astype(np.float64),
        cells=cells.astype(np.uint8),
        info=info,
    )


def _provenance(rotor: Rotor, leave_out_vortex_ring: bool) -> dict[str, Any]:
    blade, section = rotor.model.propeller, rotor.model.airfoil
    known = rotor.model.uncertainty
    return {
        "title": f"Loads of {blade.name}",
        "propmap_version": propmap.__version__,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "method": "Gill & D'Andrea, Propeller Thrust and Drag in Forward Flight, CCTA 2017",
        "interpolation": "cubic Hermite in advance and beta, linear in omega^(-1/2)",
        "loads": list(LOADS),
        "units": {
            "omega": "rad/s",
            "speed": "m/s",
            "beta": "rad, 0 axial climb, pi axial descent",
            "advance": "1, speed / (omega radius)",
            "coefficients": "1, forces over rho pi R^4 omega^2, moments over rho pi R^5 omega^2",
            "cells": "bits: 1 vortex ring, 2 unresolved",
        },
        "propeller": {
            "name": blade.name,
            "source": blade.source,
            "citation": blade.citation,
            "blades": blade.blades,
            "radius_m": float(blade.radius),
            "root_m": float(blade.root),
            "geometry_sha256": blade.fingerprint(),
        },
        "airfoil": {**section.metadata(), "sha256": section.fingerprint()},
        "corrections": rotor.model.correction_texts,
        "model_sha256": rotor.model.fingerprint(),
        "airfoil_covariance": known.covariance.as_dict() if known else None,
        "air": {
            "density_kg_m3": float(rotor.model.air.density),
            "viscosity_Pa_s": float(rotor.model.air.viscosity),
        },
        "accuracy": rotor.accuracy,
        "vortex_ring": "left out" if leave_out_vortex_ring else "kept",
    }


# -------------------------------------------------------------------------------------------------
# Interpolation error in omega, which more knots cannot reduce: a table stores only the least and
# the largest omega, and interpolates linearly in omega^(-1/2) between them.

PROBED = verification.sobol(1024, 1).T  # points in the unit cube that spans the envelope
BETWEEN = np.array([0.25, 0.5, 0.75])  # tested positions between both ends of omega^(-1/2)
NARROWER = np.linspace(0.1, 0.9, 9)  # positions in log(omega) that are tried as a new least omega


def check_between_speeds(
    model: CachedModel, ends: tuple[Floats, Floats, Floats], tolerance: float
) -> None:
    """Raise ``InputError`` if the error of the interpolation in omega exceeds the tolerance.
    The Reynolds number then changes the loads too much between the least and the largest omega."""
    error, advance, beta = _errors_between(model, ends)
    limit, small = POINT_SHARE * tolerance, 0.5 * MOST_UNRESOLVED
    lost = error > limit
    if lost.mean() <= MOST_UNRESOLVED:
        return
    (slow, fast), remedies = np.sort(np.abs(ends[0])), []
    for share in NARROWER:
        least = np.ceil(slow ** (1.0 - share) * fast**share / RPM / 10.0) * 10.0 * RPM
        narrower = np.sort(np.sign(ends[0][0]) * np.array([least, fast]))
        if np.mean(_errors_between(model, (narrower, *ends[1:]))[0] > limit) <= small:
            remedies = ["{:.0f}:{:.0f} rpm".format(*(narrower / RPM))]
            break
    wider = float(np.quantile(error, 1.0 - small)) / POINT_SHARE
    if wider < LARGEST_TOLERANCE:
        remedies.append(f"a tolerance of {1.01 * wider:.2%}")
    raise InputError(
        f"from {ends[0][0] / RPM:.0f} to {ends[0][1] / RPM:.0f} rpm the loads change with the "
        "Reynolds number, and the error of interpolation between both ends exceeds "
        f"{tolerance:.2%} in {lost.mean():.0%} of the envelope{_place(advance[lost], beta[lost])}",
        f"use {' or '.join(remedies) or 'a smaller envelope'}",
    )


def _place(advance: Floats, beta: Floats) -> str:
    """Return a text with the ranges of beta and advance ratio of 90 % of the points (n,)."""
    if not advance.size:
        return ""
    (low, high), (first, last) = (np.quantile(x, [0.05, 0.95]) for x in (advance, beta))
    return (
        f", mostly at beta {np.degrees(first):.0f} to {np.degrees(last):.0f} deg and V/(Omega R) "
        f"{low:.2g} to {high:.2g}"
    )


def _errors_between(
    model: CachedModel, ends: tuple[Floats, Floats, Floats]
) -> tuple[Floats, Floats, Floats]:
    """Return the largest errors (n,) of the interpolation in omega, and their J and beta."""
    omega, speed, beta = (
        low + (high - low) * u for (low, high), u in zip(ends, PROBED, strict=True)
    )
    radius, roots = model.rotor.model.propeller.radius, np.abs(ends[0]) ** -0.5
    advance = speed / (np.abs(omega) * radius)
    share = np.concatenate([[0.0], BETWEEN, [1.0]])[:, None]
    turning = np.sign(ends[0][0]) * (roots[0] + share * (roots[1] - roots[0])) ** -2.0
    every, j, b = (x.ravel() for x in np.broadcast_arrays(turning, advance, beta))
    flown = j * np.abs(every) * radius
    values = model.loads(every, flown, b)[0].reshape(len(share), advance.size, -1)
    static = model.static_loads(turning[:, 0])[:, None]
    relative, square = values / turning[..., None] ** 2, turning[..., None] ** 2
    expected = relative[0] + share[..., None] * (relative[-1] - relative[0])
    error = np.abs(expected - relative) * square / static
    inside = flown.reshape(error.shape[:2]) <= ends[1][1]
    return _largest(np.where(inside[..., None], error, 0.0), (0, 2)), advance, beta


# --- Standard deviations of a table's loads, from the model at a subset of the knots -------------

MOST_DEVIATIONS = 20  # knots along each axis: standard deviations vary more slowly than loads


def deviation_coefficients(rotor: Rotor, content: TableContent) -> Floats:
    """Return the standard deviations of the loads at the knots for ``TableContent.deviations``."""

    def few(knots: Floats) -> Floats:
        count = min(knots.size, MOST_DEVIATIONS)
        chosen = np.linspace(0, knots.size - 1, count).round().astype(np.intp)
        return knots[np.unique(chosen)]

    advance, beta = few(content.advance), few(content.beta)
    omega, j, b = np.meshgrid(content.omega, advance, beta, indexing="ij")
    found = rotor.loads(omega.ravel(), (j * np.abs(omega) * content.radius).ravel(), b.ravel()).std
    values = np.stack([getattr(found, name) for name in LOADS])
    coarse = (values / content.scale[:, None] / omega.ravel() ** 2).reshape(-1, *omega.shape)
    between = bilinear(advance, beta, coarse, content.advance[:, None], content.beta)
    return np.asarray(between.transpose(1, 0, 2, 3))


# --- Placement of the knots: intervals are halved until the interpolation meets the tolerance ----

FIRST_KNOTS = 13  # initial number of knots along each axis

# Allowed errors as fractions of the tolerance.
LINE_SHARE = 0.35  # of the interpolation along one axis; the errors along both axes add
CELL_SHARE = 0.6  # at the center of a cell; the rest is for corners and the Reynolds term
POINT_SHARE = 0.9  # at random points of a cell, at all omegas; the rest is for missed points
FINEST_INFLOW = 300  # hover inflow ratio sqrt(C_T/2) over the least distance between knots of J
FINEST_ANGLE = np.pi / 512  # least distance between knots along beta [rad]
MOST_KNOTS = 400_000  # largest number of knots; 32 bytes each in the file, before compression
ROUNDS = 40


class Axis:
    """Knots of one axis, with a mark for untested intervals; intervals can be halved."""

    def __init__(
        self,
        knots: Floats,
        finest: float,
        parity: tuple[Floats | None, Floats | None] = (None, None),
    ) -> None:
        self.knots = knots  # (n,)
        self.finest = finest  # least distance between knots
        self.parity = parity  # at both ends, as for ``pad``
        self.untested = np.ones(knots.size - 1, bool)

    @property
    def middles(self) -> Floats:
        """Middles of the intervals (n - 1,)."""
        return np.asarray(0.5 * (self.knots[:-1] + self.knots[1:]))

    @property
    def divisible(self) -> NDArray[np.bool_]:
        """Intervals (n - 1,) whose halves would not be too narrow."""
        return np.asarray(np.diff(self.knots) >= 2.0 * self.finest)

    def padded(self, values: Floats) -> Floats:
        """Return values (n, ...) with ghost values at both ends."""
        return pad(self.knots, values, *self.parity)

    def split(self, intervals: NDArray[np.bool_]) -> None:
        """Halve these intervals; mark the halves and the adjacent intervals as untested."""
        fresh = intervals.copy()
        fresh[1:] |= intervals[:-1]
        fresh[:-1] |= intervals[1:]
        open_ = np.repeat(self.untested | fresh, np.where(intervals, 2, 1))
        self.knots = np.sort(np.concatenate([self.knots, self.middles[intervals]]))
        self.untested = open_


@dataclass(frozen=True)
class Refined:
    """Axes with the final knots, and the model's loads at the knots."""

    advance: Axis
    beta: Axis
    values: Floats  # loads over static loads (2, n, m, L)
    ring: NDArray[np.bool_]  # whether in the vortex ring state (n, m)
    missed: NDArray[np.bool_]  # cells where the tolerance is not met (n - 1, m - 1)


def starting_axes(
    model: CachedModel, advance: tuple[float, float], beta: tuple[float, float]
) -> tuple[Axis, Axis]:
    """Return axes with few knots; the knots of the advance ratio are denser near zero."""
    blade, air = model.rotor.model.propeller, model.rotor.model.air
    force = air.density * np.pi * blade.radius**4 * model.omega[1] ** 2
    inflow = float(np.sqrt(0.5 * model.static[1, 0] / force))
    share = np.linspace(0.0, 1.0, FIRST_KNOTS)
    low, high = advance
    first, last = (PARITY if on else None for on in on_planes(np.array(beta)))
    return (
        Axis(low + (high - low) * share**1.5, inflow / FINEST_INFLOW),
        Axis(np.linspace(*beta, FIRST_KNOTS), FINEST_ANGLE, (first, last)),
    )


def refine(model: CachedModel, advance: Axis, beta: Axis, tolerance: float) -> Refined:
    """Insert knots until the middles of intervals and cells are within the tolerance; mark other
    cells of the finest size.  Raise ``InputError`` for more than ``MOST_KNOTS``."""
    model.stage = "placing knots"
    for _ in range(ROUNDS):
        _refine_lines(model, advance, beta, tolerance)
        bad = _center_errors(model, advance, beta) > CELL_SHARE * tolerance
        split_advance = np.any(bad & advance.divisible[:, None], axis=1)
        split_beta = np.any(bad & beta.divisible[None, :], axis=0)
        if not (split_advance.any() or split_beta.any()):
            break
        advance.split(split_advance)
        beta.split(split_beta)
    nodes = [model.relative(node, advance.knots, beta.knots) for node in (0, 1)]
    ring = (nodes[0][1] > 0.0) | (nodes[1][1] > 0.0)
    return Refined(advance, beta, np.stack([n[0] for n in nodes]), ring, spread(bad))


def spread(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return these cells and their neighbors, whose interpolation uses values across a jump."""
    around = np.lib.stride_tricks.sliding_window_view(np.pad(cells, 1), (3, 3))
    return np.asarray(around.any(axis=(2, 3)))


def _refine_lines(model: CachedModel, advance: Axis, beta: Axis, tolerance: float) -> None:
    """Test the untested intervals of both axes in turn until none is left."""
    while advance.untested.any() or beta.untested.any():
        for axis, other, along in ((advance, beta, 0), (beta, advance, 1)):
            tested = axis.untested & axis.divisible
            axis.untested[:] = False
            if not tested.any():
                continue
            if (axis.knots.size + tested.sum()) * other.knots.size > MOST_KNOTS:
                raise InputError(
                    f"the tolerance of {tolerance:.2%} needs more than {MOST_KNOTS} knots",
                    "use a larger tolerance or a smaller envelope, first of all a larger least "
                    "omega",
                )
            known, _ = model.relative(0, advance.knots, beta.knots)
            middles = axis.middles[tested]
            if along == 0:
                found, _ = model.relative(0, middles, other.knots)
                expected = interpolate(axis.knots, axis.padded(known), middles)
            else:
                found = model.relative(0, other.knots, middles)[0].transpose(1, 0, 2)
                expected = interpolate(axis.knots, axis.padded(known.transpose(1, 0, 2)), middles)
            missed = _largest(found - expected, (1, 2)) > LINE_SHARE * tolerance
            split = np.zeros(axis.knots.size - 1, bool)
            split[np.flatnonzero(tested)[missed]] = True
            axis.split(split)


def _center_errors(model: CachedModel, advance: Axis, beta: Axis) -> Floats:
    """Return the largest error of the loads at the center of each cell, (n - 1, m - 1)."""
    known, _ = model.relative(0, advance.knots, beta.knots)
    across = interpolate(advance.knots, advance.padded(known), advance.middles)
    expected = interpolate(beta.knots, beta.padded(across.transpose(1, 0, 2)), beta.middles)
    found, _ = model.relative(0, advance.middles, beta.middles)
    return _largest(found - expected.transpose(1, 0, 2), (2,))


def _largest(error: Floats, axes: tuple[int, ...]) -> Floats:
    """Return the largest magnitude along the axes; NaN counts as no error."""
    return np.asarray(np.max(np.nan_to_num(np.abs(error), nan=0.0), axis=axes))


# -------------------------------------------------------------------------------------------------
# Search for cells in which the model's loads jump or are very steep; they are marked as unresolved.

PATROL_POINTS = 8192  # points over the whole envelope, for jumps that miss the middles of all cells
PATROL_ROUNDS = 4

REACH = 3  # distance in cells from a jump within which further jumps are searched
TRIES = 12  # random points per cell in this neighborhood
GLANCES = 4  # random points per cell of the finest size; such cells occur where the loads jump


def find_jumps(
    content: TableContent, model: CachedModel, limit: float, suspects: NDArray[np.bool_]
) -> TableContent:
    """Mark cells in which the error at random points exceeds ``limit``.  The points are in the
    envelope, in the ``suspects`` (n - 1, m - 1), and in cells around marked ones."""
    model.stage = "looking for jumps"
    rng, table = np.random.default_rng(PATROL_POINTS), LoadTable(content)
    points = verification.quasi_random(table, PATROL_POINTS, seed=PATROL_POINTS)
    content = marked(content, verification.compare(table, model, *points), limit)
    content = _searched(content, model, limit, suspects, GLANCES, rng)
    done: NDArray[np.bool_] = np.zeros(content.cells.shape, bool)
    for _ in range(PATROL_ROUNDS):
        near = (content.cells & UNRESOLVED_BIT) > 0
        for _ in range(REACH):
            near = spread(near)
        near = near & ~done
        content = _searched(content, model, limit, near, TRIES, rng)
        done |= near
    return content


def _searched(
    content: TableContent,
    model: CachedModel,
    limit: float,
    cells: NDArray[np.bool_],
    tries: int,
    rng: np.random.Generator,
) -> TableContent:
    """Mark cells by ``tries`` random points in each of ``cells``, at omegas of the envelope."""
    cells = cells & ((content.cells & UNRESOLVED_BIT) == 0)
    if not cells.any():
        return content
    i, j = (np.repeat(index, tries) for index in np.nonzero(cells))
    points = points_at(content, np.stack([i, j, 0 * i], axis=1) + rng.random((3, i.size)).T)
    return marked(content, verification.compare(LoadTable(content), model, *points), limit)


def marked(content: TableContent, found: verification.TableErrors, limit: float) -> TableContent:
    """Mark the cells in which an error exceeds the limit, and the cells around them."""
    cells = exceeding(content, found, limit)
    unresolved = spread(cells) | ((content.cells & UNRESOLVED_BIT) > 0)
    unresolved = ~spread(~spread(unresolved))  # closes gaps of at most two cells
    flags = (unresolved * UNRESOLVED_BIT).astype(np.uint8)
    return replace(content, cells=content.cells | flags)


def exceeding(
    content: TableContent, found: verification.TableErrors, limit: float
) -> NDArray[np.bool_]:
    """Return the cells (n - 1, m - 1) in which an error exceeds the limit."""
    bad = (np.abs(found.errors) > limit).any(axis=1)
    cells: NDArray[np.bool_] = np.zeros(content.cells.shape, bool)
    cells[
        locate(content.advance, found.advance[bad])[0], locate(content.beta, found.beta[bad])[0]
    ] = True
    return cells


def with_marks_of(old: TableContent, new: TableContent) -> TableContent:
    """Mark the cells of the ``new`` table whose middles are in marked cells of the ``old`` one."""
    middles = (0.5 * (k[:-1] + k[1:]) for k in (new.advance, new.beta))
    row, column = (locate(k, x)[0] for k, x in zip((old.advance, old.beta), middles, strict=True))
    return replace(
        new, cells=new.cells | (old.cells[np.ix_(row, column)] & np.uint8(UNRESOLVED_BIT))
    )
