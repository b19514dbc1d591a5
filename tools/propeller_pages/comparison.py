"""Measured and modeled C_T and C_P of a propeller, and the parts of the error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.catalogue.identified import Identified
from propmap.catalogue.lookup import propeller
from propmap.model.model import Model
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.typing import Floats
from tools.catalogue.database import MeasuredPropeller
from tools.catalogue.verdict import SAME_RPM

Rows = NDArray[np.intp]

CURVE = 25
"""Points of a curve."""

REFERENCE = 0.75
"""Radius of the Reynolds number, over the tip radius."""


@dataclass(frozen=True, eq=False)
class Curve:
    """The model over J at one rotational speed, or at rest over the rotational speed; n points."""

    rpm: Floats  # (n,) [1/min]
    advance: Floats  # (n,): J [-]
    coefficients: Floats  # (2, n): C_T and C_P [-]; NaN where no inflow was found
    rows: Rows  # (m,): which measured rows belong to it


@dataclass(frozen=True, eq=False)
class Comparison:
    """A propeller with the measured rows and curves of its card."""

    entry: Identified
    blade: Propeller
    tested: MeasuredPropeller
    error: Floats  # (2, rows): C_T and C_P, model minus measurement [-]
    moving: list[Curve]  # one for each rotational speed in axial flow, slowest first
    still: Curve | None  # at rest; None without measurements at rest


def reynolds(entry: Identified, blade: Propeller) -> tuple[float, float]:
    """Return Re at 3/4 of the radius, without inflow, at the minimum and maximum rpm."""
    radius = REFERENCE * blade.radius
    chord = np.interp(radius, blade.station, blade.chord)
    air = Model(blade, entry.airfoil).air
    per_rpm = np.pi / 30.0 * radius * chord * air.density / air.viscosity
    return float(entry.rpm_low * per_rpm), float(entry.rpm_high * per_rpm)


def compare(entry: Identified, tested: MeasuredPropeller) -> Comparison:
    """Compare the model with the rows from which its constants were identified."""
    blade = propeller(entry.propeller, blades=entry.blades)
    asked = _asked(tested)
    # One batch for all curves, because small batches spend most of their time on overhead.
    found = coefficients(
        Rotor(Model(blade, entry.airfoil)),
        np.concatenate([*(rpm for rpm, _, _ in asked), tested.rpm]),
        np.concatenate([*(advance for _, advance, _ in asked), tested.advance]),
    )
    curves = [
        Curve(rpm, advance, found[:, k * CURVE : (k + 1) * CURVE], rows)
        for k, (rpm, advance, rows) in enumerate(asked)
    ]
    return Comparison(
        entry=entry,
        blade=blade,
        tested=tested,
        error=found[:, len(asked) * CURVE :] - np.stack([tested.thrust, tested.power]),
        moving=[curve for curve in curves if curve.advance.any()],
        still=next((curve for curve in curves if not curve.advance.any()), None),
    )


def coefficients(rotor: Rotor, rpm: Floats, advance: Floats) -> Floats:
    """Return C_T and C_P [-], (2, n), in axial flow at ``rpm`` [1/min] and J ``advance`` [-]."""
    turns = rpm / 60.0
    diameter = 2.0 * rotor.model.propeller.radius
    found = rotor.loads(2.0 * np.pi * turns, advance * turns * diameter, 0.0)
    force = rotor.model.air.density * turns**2 * diameter**4
    # P = 2 pi n tau.
    return np.stack([found.thrust / force, 2.0 * np.pi * found.torque / (force * diameter)])


def _asked(tested: MeasuredPropeller) -> list[tuple[Floats, Floats, Rows]]:
    """Return rpm and J of the curves, and the rows of each curve.

    Runs in axial flow at nearly the same rpm share a curve, up to their largest J.
    """
    runs = np.unique(tested.run[tested.advance > 0.0])
    means = sorted((float(tested.rpm[tested.run == run].mean()), run) for run in runs)
    groups: list[list[tuple[float, int]]] = []
    for mean, run in means:
        if groups and mean <= (1.0 + SAME_RPM) * groups[-1][0][0]:
            groups[-1].append((mean, run))
        else:
            groups.append([(mean, run)])
    found = []
    for group in groups:
        rows = np.flatnonzero(np.isin(tested.run, [run for _, run in group]))
        most = tested.advance[rows].max()
        found.append((np.full(CURVE, tested.rpm[rows].mean()), np.linspace(0.0, most, CURVE), rows))
    still = np.flatnonzero(tested.advance == 0.0)
    if still.size:
        ends = tested.rpm[still].min(), tested.rpm[still].max()
        found.append((np.linspace(*ends, CURVE), np.zeros(CURVE), still))
    return found


class ErrorParts(NamedTuple):
    """Fractions of the sum of squared errors [-]; the sum is 1."""

    rest: float  # rows at rest
    runs: float  # means of the runs in axial flow
    course: float  # straight lines over J about these means, one per run
    scatter: float  # remainder


def error_parts(tested: MeasuredPropeller, error: Floats) -> ErrorParts:
    """Divide the squared errors (n,) of one coefficient [-] into parts; NaN is ignored."""
    seen = np.isfinite(error)
    still = tested.advance == 0.0
    runs = course = 0.0
    for run in np.unique(tested.run[seen & ~still]):
        mine = seen & ~still & (tested.run == run)
        mean, along = error[mine].mean(), tested.advance[mine] - tested.advance[mine].mean()
        runs += mine.sum() * mean**2
        if along.any():
            course += (along @ error[mine]) ** 2 / (along @ along)
    rest = np.sum(error[seen & still] ** 2)
    rest, runs, course = (part / np.sum(error[seen] ** 2) for part in (rest, runs, course))
    return ErrorParts(float(rest), float(runs), float(course), float(1.0 - rest - runs - course))
