"""The envelope of the operating points of a fit, and the points beyond this envelope."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.typing import Floats
from propmap.units import RPM

Range = tuple[float, float]  # smallest and largest value

QUANTITIES = {
    "edgewise_ratio": "V sin(beta)/(Omega R)",
    "advance_ratio": "V/(Omega R)",
    "climb_ratio": "V cos(beta)/(Omega R)",
    "rpm": "rotor speed",
}  # quantities with a range in the envelope, with their names in messages

MARGIN = 0.01  # distance from the range at which a ratio still counts as inside [-]

RPM_MARGIN = 0.2  # margin as a share of the rotor speed, which only changes the Reynolds number
MAIN_PART = (1.0, 99.0)  # percentiles for flights, which exclude outliers


@dataclass(frozen=True)
class Envelope:
    """Ranges of the data of a fit, without rotors at rest.

    Attributes
    ----------
    percentiles : tuple of float
        Percentiles at which the ranges end: 0 and 100 for tunnel data, so that the ranges include
        all points.
    edgewise_ratio, advance_ratio, climb_ratio : tuple of float
        V sin(beta), V and V cos(beta) over the tip speed Omega R [-].
    rpm : tuple of float
        Rotor speed [1/min].
    """

    percentiles: Range
    edgewise_ratio: Range
    advance_ratio: Range
    climb_ratio: Range
    rpm: Range

    def __post_init__(self) -> None:
        for name in QUANTITIES:
            low, high = getattr(self, name)
            if not -math.inf < low <= high < math.inf:
                raise ValueError(f"{name} from {low} to {high} is not a range")

    @classmethod
    def of(
        cls,
        omega: Floats,
        axial: Floats,
        inplane: Floats,
        radius: float,
        percentiles: Range = (0.0, 100.0),
    ) -> Envelope:
        """Return the envelope of points ``omega``, ``axial``, ``inplane`` and ``radius``, as in
        ``beyond``, between these ``percentiles``."""
        turning = omega > 0.0
        found = _quantities(omega[turning], axial[turning], inplane[turning], radius)
        ends = {name: np.percentile(v, percentiles).tolist() for name, v in found.items()}
        return cls(percentiles, **{name: (low, high) for name, (low, high) in ends.items()})

    def beyond(self, omega: Floats, axial: Floats, inplane: Floats, radius: float) -> Beyond:
        """Return how far points lie outside the envelope, by quantity.

        Parameters
        ----------
        omega, axial, inplane : ndarray, shape (n,) or (n, k)
            Rotational speed [rad/s], V cos(beta) and V sin(beta) [m/s] of n points, or of k rotors
            in n samples.
        radius : float
            Rotor radius R [m].
        """
        found = _quantities(omega, axial, inplane, radius)
        excess = {}
        for name, values in found.items():
            low, high = getattr(self, name)
            margins = (RPM_MARGIN * low, RPM_MARGIN * high) if name == "rpm" else (MARGIN, MARGIN)
            off = np.where(values > high + margins[1], values - high, 0.0)
            excess[name] = np.where(values < low - margins[0], values - low, off)
        return Beyond(self, excess)


@dataclass(frozen=True, eq=False)
class Beyond:
    """Distances of points from an ``envelope``.

    ``excess`` contains an array by quantity, in the shape of the points: 0 inside, positive above
    the range, negative below the range.
    """

    envelope: Envelope
    excess: dict[str, Floats]

    @property
    def points(self) -> NDArray[np.bool_]:
        """Whether each point lies outside."""
        return np.any(np.stack(list(self.excess.values())) != 0.0, axis=0)

    @property
    def samples(self) -> NDArray[np.bool_]:
        """Whether at least one rotor of each sample lies outside, (n,).

        For points of shape (n,), the result is ``points``.
        """
        return _by_sample(self.points)

    @property
    def reach(self) -> Floats:
        """Largest V/(Omega R) of each sample (n,) over the maximum of the data, at least 1 [-]."""
        further = np.nan_to_num(self.excess["advance_ratio"])
        ratio = 1.0 + np.maximum(further, 0.0) / max(self.envelope.advance_ratio[1], MARGIN)
        return np.asarray(ratio.reshape(len(ratio), -1).max(axis=1))

    def sentences(self, what: str = "points") -> list[str]:
        """Return a list with one sentence on the samples outside; empty if there are none.

        The sentence states their share, the quantities and the ranges.  ``what`` is the name of the
        samples.
        """
        outside = self.samples
        if not outside.any():
            return []
        leaving = {n: _by_sample(excess != 0.0) for n, excess in self.excess.items()}
        parts = []
        for name in sorted(QUANTITIES, key=lambda name: -leaving[name].sum()):
            excess = self.excess[name]
            if not excess.any():
                continue
            furthest = float(excess.flat[np.argmax(np.abs(excess))])
            low, high = getattr(self.envelope, name)
            ends = (furthest + (high if furthest > 0.0 else low), low, high)
            reached, *data = (f"{v:.0f} rpm" if name == "rpm" else f"{v:.3g}" for v in ends)
            way = "up" if furthest > 0.0 else "down"
            share = f"; {leaving[name].mean():.1%} outside" if outside.size > 1 else ""
            parts.append(f"{QUANTITIES[name]} {way} to {reached} (data {' to '.join(data)}{share})")
        who = f"{outside.mean():.1%} of the {what} are" if outside.size > 1 else "the point is"
        return [f"{who} outside the fitted data: {'; '.join(parts)}"]


def _quantities(omega: Floats, axial: Floats, inplane: Floats, radius: float) -> dict[str, Floats]:
    """Return the quantities of points; ratios of stationary rotors are NaN."""
    tip = np.where(omega > 0.0, omega, np.nan) * radius
    ratios = (inplane / tip, np.hypot(axial, inplane) / tip, axial / tip)
    return dict(zip(QUANTITIES, (*ratios, omega / RPM), strict=True))


def _by_sample(points: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return whether any rotor of a sample is marked."""
    return np.asarray(points.reshape(points.shape[0] if points.ndim else 1, -1).any(axis=1))
