"""The one number by which an autopilot describes a thrust curve, and how sure it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from propmap.aircraft.steady import Aircraft
from propmap.export.static_loads import StaticLoads
from propmap.export.thrust_curve import ThrustCurve, thrust_curve
from propmap.typing import Floats

DISCHARGED = 0.3
"""State of charge besides the given one at which factors are told."""

Shares = Callable[[Callable[[Floats], Floats]], Floats]
"""Makes of a curve, thrust by signal, its thrust over the largest at equally spaced x (n,)."""


@dataclass(frozen=True)
class CurveFactor:
    """A curve as f x^2 + (1 - f) x, thrust over the largest and x from 0 to 1.

    Attributes
    ----------
    factor : float
        f [-].
    worst : float
        Largest difference from the curve, over the largest thrust [-].
    std : float or None
        Standard deviation of f by that of the torque [-]; None where it is not known.
    charge : float
        State of charge of the battery.
    discharged : float
        f at the charge ``DISCHARGED``; NaN where there is no full throttle then.
    """

    factor: float
    worst: float
    std: float | None
    charge: float
    discharged: float

    @property
    def holds(self) -> str:
        """What it is good for, in words."""
        told = (
            f"At rest, battery at {self.charge:.0%}: within {self.worst:.1%} of the largest thrust."
        )
        if np.isfinite(self.discharged):
            return f"{told} At {DISCHARGED:.0%} it would be {self.discharged:.3f}."
        return f"{told} At {DISCHARGED:.0%} the battery does not deliver full throttle."


def curve_factor(
    aircraft: Aircraft,
    curve: ThrustCurve,
    still: StaticLoads,
    shares: Shares,
    limits: tuple[float, float],
) -> CurveFactor:
    """f of an aircraft's curve, by least squares.

    Parameters
    ----------
    aircraft, curve, still : Aircraft, ThrustCurve, StaticLoads
        Whose curve it is, and its loads at rest with their errors.
    shares : callable
        What the autopilot takes as x.
    limits : tuple of 2 float
        The least and largest f that the autopilot takes.
    """
    charge = aircraft.limits.charge

    def factor(found: ThrustCurve | None) -> float:
        return float("nan") if found is None else fitted_factor(shares(found.at), limits)

    here, share = factor(curve), shares(curve.at)
    spread = still.std_of(0.0, 1.0 / still.torque)
    more = None if spread is None else factor(thrust_curve(aircraft, charge, spread))
    x = np.linspace(0.0, 1.0, share.size)
    return CurveFactor(
        factor=here,
        worst=float(np.abs(x + here * (x**2 - x) - share).max()),
        std=None if more is None else abs(more - here),
        charge=charge,
        discharged=factor(thrust_curve(aircraft, DISCHARGED)),
    )


def fitted_factor(share: Floats, limits: tuple[float, float]) -> float:
    """f within its ``limits`` that is nearest to thrusts over the largest, ``share`` (n,)."""
    x = np.linspace(0.0, 1.0, share.size)
    bent = x**2 - x
    return float(np.clip(np.sum((share - x) * bent) / np.sum(bent**2), *limits))
