"""Building a table: knots, coefficients, a patrol for jumps, and the certificate."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import propmap
from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.table.certificate import POINTS, certify, unresolved_share
from propmap.table.content import UNRESOLVED, VORTEX_RING, TableContent, coefficient_scale
from propmap.table.jumps import exceeding, find_jumps, marked, with_marks_of
from propmap.table.model import Model, Progress
from propmap.table.query import LoadTable
from propmap.table.refine import CELL_SHARE, Refined, refine, starting_axes
from propmap.tasks import Workers
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.rotor import Rotor

Range = tuple[float, float]

MODEL_ERROR = {"standard": 0.001, "fine": 0.0001}
"""The model's own numerical error, by its accuracy; a tolerance below twice that means nothing."""

LARGEST_TOLERANCE = 0.1

MOST_UNRESOLVED = 0.05
"""Share of the envelope above which a table is refused."""

NARROW_ABOVE = 0.02
"""Share of the envelope above which unresolved cells are halved: a thin feature of the loads that
fell between the middles of wide cells takes little of the envelope once they are narrow."""

NARROWINGS = 6

ATTEMPTS = 8
REFINEMENTS = 3
"""How often a certificate is tried, and after how many failures cells in which the error is too
large are halved; later they are marked as unresolved."""

FIRST_SEED = 20_171


def build_table(
    rotor: Rotor,
    *,
    omega: Range,
    speed: Range,
    beta: Range,
    tolerance: float = 0.005,
    leave_out_vortex_ring: bool = False,
    certificate_points: int = POINTS,
    progress: Progress | None = None,
    workers: Workers | None = None,
) -> LoadTable:
    """A certified table of a rotor's loads.

    Where the model's loads jump no table can follow.  Such cells have the status "unresolved";
    the certificate counts and measures them apart.

    Parameters
    ----------
    rotor : Rotor
        The model.  How well it says it is known is filed, with what that means for the loads.
    omega, speed, beta : tuple of float
        Least and largest value of the envelope [rad/s], [m/s], [rad]; omega above 0, beta within
        0...pi.
    tolerance : float
        Largest error as a share of the static loads at the same omega.
    leave_out_vortex_ring : bool
        Whether loads in the vortex ring state are NaN; otherwise they have that status.
    certificate_points : int
        On how many points the errors are measured, a power of two.
    progress : function, optional
        Called with what is being done and the operating points evaluated so far.
    workers : Workers, optional
        Who evaluates the model; by default this process.  The table is the same.

    Raises
    ------
    InputError
        For an impossible envelope or tolerance, and where the tolerance is not met.
    """
    check_tolerance(tolerance, rotor.accuracy)
    ends = _envelope(omega, speed, beta)
    model = Model(
        rotor,
        ends[0],
        leave_out_vortex_ring=leave_out_vortex_ring,
        progress=progress,
        workers=workers,
    )
    radius = rotor.model.propeller.radius
    advance = (ends[1][0] / (ends[0][1] * radius), ends[1][1] / (ends[0][0] * radius))
    axes = starting_axes(model, advance, (float(ends[2][0]), float(ends[2][1])))
    info = _provenance(rotor, leave_out_vortex_ring)
    for _ in range(NARROWINGS):
        refined = refine(model, *axes, tolerance)
        content = _content(model, refined, ends, info)
        narrow = ~refined.advance.divisible[:, None] & ~refined.beta.divisible[None, :]
        content = find_jumps(content, model, CELL_SHARE * tolerance, narrow)
        if unresolved_share(LoadTable(content)) <= NARROW_ABOVE:
            break
        if not _halved((content.cells & UNRESOLVED) > 0, refined):
            break
    for attempt in range(1, ATTEMPTS + 1):
        table = LoadTable(content)
        certificate, found = certify(
            table, model, tolerance, points=certificate_points, seed=FIRST_SEED + attempt
        )
        if certificate.holds:
            break
        # Points that failed have been seen now: refine there, certify on others.
        too_large = exceeding(content, found, tolerance)
        if attempt <= REFINEMENTS and _halved(too_large, refined):
            refined = refine(model, *axes, tolerance)
            content = with_marks_of(content, _content(model, refined, ends, info))
        else:
            content = marked(content, found, CELL_SHARE * tolerance)
    unresolved = certificate.unresolved_volume
    if not certificate.holds or unresolved > MOST_UNRESOLVED:
        worst = max(certificate.max_error.values())
        raise InputError(
            f"the tolerance of {tolerance:.2%} is not met: errors up to {worst:.2%}, and "
            f"{unresolved:.1%} of the envelope unresolved",
            "allow more, or make the envelope smaller",
        )
    filed: dict[str, Any] = {"certificate": certificate.as_dict()}
    known, deviations = rotor.model.uncertainty, None
    if known is not None and known.covariance.determined.names:
        from propmap.table.parameter_uncertainty import parameter_uncertainty

        covariance = known.covariance
        filed["parameter_uncertainty"] = parameter_uncertainty(table, model, covariance)
    if known is not None:
        from propmap.table.deviations import deviation_coefficients

        model.stage = "standard deviations"
        deviations = deviation_coefficients(rotor, content)
    filed["model_evaluations"] = model.evaluations
    return LoadTable(replace(content, info={**info, **filed}, deviations=deviations))


def _halved(cells: NDArray[np.bool_], refined: Refined) -> bool:
    """Halve the intervals of these cells where they may be; whether there were any such."""
    rows = cells.any(axis=1) & refined.advance.divisible
    columns = cells.any(axis=0) & refined.beta.divisible
    refined.advance.split(rows)
    refined.beta.split(columns)
    return bool(rows.any() or columns.any())


def check_tolerance(tolerance: float, accuracy: str) -> None:
    """Raise ``InputError`` for a tolerance that a table of a rotor so accurate cannot have."""
    least = 2.0 * MODEL_ERROR[accuracy]
    if not least <= tolerance <= LARGEST_TOLERANCE:
        hint = " (0.02% with accuracy fine)" if accuracy == "standard" else ""
        raise InputError(
            f"the tolerance is {tolerance:.3g}, with the model's accuracy {accuracy!r} it must "
            f"lie between {least:.2%} and {LARGEST_TOLERANCE:.0%}{hint}",
            "choose another tolerance or accuracy",
        )


def _envelope(*ranges: Range) -> tuple[Floats, Floats, Floats]:
    units = ("omega", "rad/s"), ("speed", "m/s"), ("beta", "rad")
    for (name, unit), (low, high) in zip(units, ranges, strict=True):
        if not (np.isfinite([low, high]).all() and low < high):
            raise InputError(
                f"{name} goes from {low:g} to {high:g} {unit}", "give a range that rises"
            )
    (slowest, _), (least, _), (first, last) = ranges
    if slowest <= 0.0:
        raise InputError(
            f"omega begins at {slowest:g} rad/s, where the advance ratio is infinite",
            "begin at the idle speed",
        )
    if least < 0.0 or first < 0.0 or last > np.pi + 1e-12:
        raise InputError(
            "speed must not be negative, and beta must lie between 0 and pi",
            "descent is beta above pi/2",
        )
    omega, speed, beta = (np.array(r, dtype=np.float64) for r in ranges)
    return omega, speed, np.minimum(beta, np.pi)


def _content(
    model: Model, refined: Refined, ends: tuple[Floats, Floats, Floats], info: dict[str, Any]
) -> TableContent:
    rotor, omega = model.rotor, model.omega[:, None]
    scale = coefficient_scale(rotor.model.air.density, rotor.model.propeller.radius)
    relative = model.static / (scale * omega**2)
    coefficients = (refined.values * relative[:, None, None, :]).transpose(0, 3, 1, 2)
    ring = refined.ring
    any_ring = ring[:-1, :-1] | ring[1:, :-1] | ring[:-1, 1:] | ring[1:, 1:]
    cells = VORTEX_RING * any_ring.astype(np.uint8) + UNRESOLVED * refined.missed.astype(np.uint8)
    return TableContent(
        advance=refined.advance.knots,
        beta=refined.beta.knots,
        omega=ends[0],
        speed=ends[1],
        # As filed, so that a table answers alike before and after.
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
