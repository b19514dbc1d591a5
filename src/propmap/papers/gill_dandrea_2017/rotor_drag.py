"""Rotor drag, on which published sources differ: theory, the campaign of 2019, Ribner's fin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.baselines.fin_analogy import inflow_factor, side_force
from propmap.catalogue.lookup import measurement
from propmap.errors import drag_factor_accepted
from propmap.fit.least_squares import rms
from propmap.model.airfoil import Airfoil, parameter_set
from propmap.model.model import Air, Model
from propmap.papers.gill_dandrea_2017.blades import blade
from propmap.papers.gill_dandrea_2017.identified import OBLIQUE, OBLIQUE_LABEL, OTHER_FORM
from propmap.papers.gill_dandrea_2017.level_circles import SPEEDS as CIRCLE_SPEEDS
from propmap.papers.gill_dandrea_2017.level_circles import Circles, circles, quadrotor
from propmap.papers.gill_dandrea_2017.tunnel import OTHER_LABEL, RECOMMENDED_LABEL, Compared
from propmap.rotor import Rotor
from propmap.typing import Floats

PROPELLERS = ("apc-8x6e", "apc-9x6e", "apc-11x7e", "apc-8x4.5mr", "apc-8x6sf")
INCIDENCE = np.radians(15.0)
"""Of the comparison with the fin: the smallest of the 2019 data."""

TIP_SPEED = 70.0
"""[m/s] of all propellers, that of the APC 8x6E at 6579 rpm, of which there are data."""

SPEEDS = np.arange(2.0, 15.0, 2.0)
"""[m/s]."""

LIGHTLY_LOADED = 0.3
"""Inflow over flight speed up to which the disk counts as lightly loaded, as in cruise, where the
fin analogy was verified."""


@dataclass(frozen=True, eq=False)
class SmallIncidence:
    """One propeller at 15 degrees; every array is (n,).

    Attributes
    ----------
    omega, speed : float, ndarray
        Rotational speed [rad/s], flight speeds [m/s].
    inflow : ndarray
        a, the inflow over the flight speed [-].
    theory, published, other : ndarray
        Rotor drag [N] by this theory, by the polynomials of 2019 and by the blade-element model of
        the same campaign; both None where there are none.
    fin_low, fin_high : ndarray
        Side force [N] with the side area by the chord line's and by the zero-lift line's pitch.
    """

    propeller: str
    omega: float
    speed: Floats
    inflow: Floats
    theory: Floats
    fin_low: Floats
    fin_high: Floats
    published: Floats | None
    other: Floats | None

    @property
    def theory_over_fin(self) -> Floats:
        """With the mean of both side areas [-]."""
        return self.theory / (0.5 * (self.fin_low + self.fin_high))


@dataclass(frozen=True)
class Ratio:
    """Published over theoretical drag of the APC 8x6E at one angle [deg].

    Attributes
    ----------
    beta, points : float, int
        Angle [deg], and number of points at it.
    ratio, lowest, highest : float
        Of the polynomials to this theory: root mean squares, single points.
    recommended : float
        Of the polynomials to this theory with the recommended inflow.
    other : float
        Of the campaign's blade-element model to this theory.
    """

    beta: float
    points: int
    ratio: float
    lowest: float
    highest: float
    recommended: float
    other: float


@dataclass(frozen=True, eq=False)
class Consequence:
    """What the dispute means in flight: circles with the theory's drag, and ``factor`` times it."""

    name: str
    factor: float
    theory: Circles
    published: Circles


def small_incidence(law: Airfoil) -> list[SmallIncidence]:
    """The theory, the fin and, for the 8x6E, both forms of 2019, for several propellers.

    ``law`` is identified from thrust and torque of the APC 8x6E; the sections of the others are
    taken to be alike.
    """
    return [_small_incidence(name, law) for name in PROPELLERS]


def ratios(one: Compared) -> list[Ratio]:
    """Published over theoretical drag by angle, all speeds above zero."""
    data = one.data
    drag = {label: loads["drag"] for label, loads in one.predicted.items()}
    angle, found = np.round(np.degrees(data.beta)), []
    for degrees in np.unique(angle[angle > 0.0]).tolist():
        mine = (angle == degrees) & (data.speed > 0.0)
        published, mean = data.loads["drag"][mine], drag[OBLIQUE_LABEL][mine]
        each = published / mean
        found.append(
            Ratio(
                beta=degrees,
                points=published.size,
                ratio=rms(published) / rms(mean),
                lowest=float(each.min()),
                highest=float(each.max()),
                recommended=rms(published) / rms(drag[RECOMMENDED_LABEL][mine]),
                other=rms(drag[OTHER_LABEL][mine]) / rms(mean),
            )
        )
    return found


def consequence(name: str, factor: float) -> Consequence:
    """The tethered quadrotor with a set of Table I, its rotor drag as it is and multiplied."""
    law, vehicle = parameter_set(name), quadrotor()
    with drag_factor_accepted():  # the ratio of the two published forms, not a model of either
        more = law.with_parameters(drag_factor=factor)
    pair = (circles(vehicle, one, CIRCLE_SPEEDS) for one in (law, more))
    return Consequence(name, factor, *pair)


def _small_incidence(name: str, law: Airfoil) -> SmallIncidence:
    shape, air = blade(name), Air()
    omega = TIP_SPEED / shape.radius
    data, form = measurement(OBLIQUE), measurement(OTHER_FORM)
    published = other = None
    if name == data.propeller:
        # The rows have a rotational speed of their own, the nearest one.
        omega = float(data.omega[np.argmin(np.abs(data.omega - omega))])
        at = (data.omega == omega) & (np.abs(data.beta - INCIDENCE) < np.radians(0.5))
        published, other = (
            np.interp(SPEEDS, data.speed[at], drag[at], np.nan, np.nan)
            for drag in (data.loads["drag"], form.loads["drag"])
        )
    rotor = Rotor(Model(shape, law, air))
    beta = np.concatenate([np.zeros_like(SPEEDS), np.full_like(SPEEDS, INCIDENCE)])
    loads = rotor.loads(omega, np.concatenate([SPEEDS, SPEEDS]), beta)
    thrust, drag = loads.thrust[: SPEEDS.size], loads.drag[SPEEDS.size :]
    low, high = (
        side_force(shape, thrust, SPEEDS, INCIDENCE, air.density, zero_lift_angle=angle)
        for angle in (0.0, law.zero_lift_angle)
    )
    inflow = inflow_factor(thrust, SPEEDS, shape.radius, air.density)
    return SmallIncidence(name, omega, SPEEDS, inflow, drag, low, high, published, other)
