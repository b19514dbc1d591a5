"""Loads of the fitted propeller over speed, with what the parameters' uncertainty does to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.baselines.hover import HoverModel
from propmap.engine.evaluation import prepare
from propmap.engine.gradients import load_gradients
from propmap.engine.plan import accuracy
from propmap.fit.coverage import CoveredAngle
from propmap.fit.fit_record import FitRecord
from propmap.fit.result_file import FitFile
from propmap.loads import LOADS
from propmap.report.fit_page.parameter_draws import drawn_changes
from propmap.rotor import Rotor

RPM = 30.0 / np.pi
SPEEDS = 26
MOST_ANGLES = 4
BEYOND = 1.25
"""How far the curves go, in units of the data's largest advance ratio."""

UNTESTED = 0.25
"""Advance ratio to which they go where all data are from rest."""

APART = 22.5
"""[deg], closer than which two angles are one."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Loads at one angle.

    beta [rad].  covered : ends of the speeds that the data cover at this angle, at these rotational
    speeds' advance ratios [m/s]; None where there were none.
    loads, low, high, hover : by load, (n,), low and high None without a band.
    valid : (n,), where momentum theory holds.
    """

    beta: float
    covered: tuple[float, float] | None
    loads: dict[str, Floats]
    low: dict[str, Floats] | None
    high: dict[str, Floats] | None
    hover: dict[str, Floats]
    valid: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Curves:
    """All angles at one omega [rad/s].  speed : (n,) [m/s].  draws : how many make the bands."""

    omega: float
    radius: float
    speed: Floats
    curves: Sequence[Curve]
    draws: int


def load_curves(file: FitFile, fit: FitRecord) -> Curves:
    """The fitted rotor at the data's typical rotational speed, past the speeds of the data."""
    omega = fit.covered.typical_rpm / RPM
    tip = omega * file.model.propeller.radius
    top = max([one.advance[1] for one in fit.covered.main_angles], default=UNTESTED / BEYOND)
    speed = np.linspace(0.0, BEYOND * top * tip, SPEEDS)
    angles = _angles(fit)
    betas = np.radians([beta for beta, _ in angles])

    rotor = Rotor(file.model)
    found = rotor.loads(omega, speed, betas[:, None])
    values, status = np.stack([getattr(found, name) for name in LOADS]), found.status
    names, changes = drawn_changes(fit)
    ends = None
    if len(changes):
        slopes = _slopes(rotor, names, omega, speed, betas)
        moved = np.tensordot(changes, slopes, 1) + values
        ends = np.percentile(moved, [2.5, 97.5], axis=0)
        # The fit may sit in a corner of the bounds, with all draws on one side of it.
        ends = np.stack([np.minimum(ends[0], values), np.maximum(ends[1], values)])
    still = HoverModel.of(rotor).loads(omega)
    curves = []
    for k, (beta, data) in enumerate(angles):
        band = None if ends is None else [_named(e[:, k]) for e in ends]
        curves.append(
            Curve(
                beta=float(np.radians(beta)),
                covered=_covered(fit, data, tip),
                loads=_named(values[:, k]),
                low=band[0] if band else None,
                high=band[1] if band else None,
                hover={n: np.full(SPEEDS, float(value)) for n, value in still.items()},
                valid=status[k] != "vortex_ring",
            )
        )
    return Curves(omega, file.model.propeller.radius, speed, curves, len(changes))


def _slopes(
    rotor: Rotor, names: tuple[str, ...], omega: float, speed: Floats, betas: Floats
) -> Floats:
    """Derivatives (P, L, angles, n) of the loads by the parameters named."""
    v, b = (a.ravel() for a in np.broadcast_arrays(speed, betas[:, None]))
    flow = (np.full(v.size, omega), v * np.cos(b), v * np.abs(np.sin(b)))
    found = load_gradients(prepare(rotor.arrays), accuracy(rotor.accuracy), names, *flow)
    shape = (len(names), len(LOADS), betas.size, speed.size)
    return found.slopes.transpose(1, 0, 2).reshape(shape)


def _angles(fit: FitRecord) -> list[tuple[float, CoveredAngle | None]]:
    """Up to four angles [deg] with the data's points about them, and edgewise or axial flow where
    there were points at one angle at most."""
    betas = np.array([one.typical_beta for one in fit.covered.main_angles])
    wanted = np.linspace(betas[0], betas[-1], MOST_ANGLES) if betas.size else betas
    nearest = dict.fromkeys(int(np.argmin(np.abs(betas - beta))) for beta in wanted)
    found: list[tuple[float, CoveredAngle | None]] = [
        (fit.covered.main_angles[k].typical_beta, fit.covered.main_angles[k]) for k in nearest
    ]
    for other in (0.0, 90.0):
        if all(abs(other - beta) > APART for beta, _ in found) and len(found) < MOST_ANGLES:
            found.append((other, None))
    return sorted(found, key=lambda pair: pair[0])


def _covered(fit: FitRecord, data: CoveredAngle | None, tip: float) -> tuple[float, float] | None:
    if data is None:
        return None
    low = 0.0 if fit.covered.at_rest is not None else data.advance[0]
    return low * tip, data.advance[1] * tip


def _named(values: Floats) -> dict[str, Floats]:
    return dict(zip(LOADS, values, strict=True))
