"""Rotor drag, on which published sources differ: theory, the fit of 2019, Ribner's fin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.arrays.types import Floats
from propmap.baselines.fin_analogy import inflow_factor, side_force
from propmap.catalogue.measurements import measurement
from propmap.model.air import Air
from propmap.model.airfoil import Airfoil, parameter_set
from propmap.model.model import Model
from propmap.papers.gill_dandrea_2017.blades import TUNNEL_PROPELLER, blade
from propmap.papers.gill_dandrea_2017.identified import OBLIQUE
from propmap.papers.gill_dandrea_2017.level_circles import SPEEDS as CIRCLE_SPEEDS
from propmap.papers.gill_dandrea_2017.level_circles import Circles, circles, quadrotor
from propmap.rotor import Rotor

PROPELLERS = ("apc-8x6e", "apc-9x6e", "apc-11x7e", "apc-8x4.5mr", "apc-8x6sf")
INCIDENCE = np.radians(15.0)
"""Of the comparison with the fin: the smallest at which the 2019 fit was evaluated."""

TIP_SPEED = 70.0
"""[m/s] of all propellers, that of the APC 8x6E at 6579 rpm, at which the fit was evaluated."""

SPEEDS = np.arange(2.0, 15.0, 2.0)
"""[m/s]."""

LIGHTLY_LOADED = 0.3
"""Inflow over flight speed up to which the disk counts as lightly loaded, as in cruise, where the
fin analogy was verified."""


@dataclass(frozen=True, eq=False)
class SmallIncidence:
    """One propeller at 15 degrees; (n,) each, forces in [N].

    inflow : a, over the flight speed [-].  fin_low, fin_high : with the side area by the chord
    line's and by the zero-lift line's pitch.  published : None where there is none.
    """

    propeller: str
    omega: float
    speed: Floats
    inflow: Floats
    theory: Floats
    fin_low: Floats
    fin_high: Floats
    published: Floats | None


@dataclass(frozen=True, eq=False)
class Ratio:
    """Published over theoretical drag of the APC 8x6E at one angle; both rms over the points."""

    beta: float
    points: int
    ratio: float
    lowest: float
    highest: float


@dataclass(frozen=True, eq=False)
class Consequence:
    """What the dispute means in flight: circles with the theory's drag and with the published.

    factor : published drag over the theory's [-].
    """

    name: str
    factor: float
    theory: Circles
    published: Circles


def small_incidence(law: Airfoil) -> list[SmallIncidence]:
    """The theory, the fin and, for the 8x6E, the published fit, for several propellers.

    law : identified from thrust and torque of the APC 8x6E; the sections of the others are
    taken to be alike.
    """
    return [_small_incidence(name, law) for name in PROPELLERS]


def ratios(law: Airfoil) -> list[Ratio]:
    """Published over theoretical drag by angle, all speeds above zero."""
    data = measurement(OBLIQUE)
    rotor = Rotor(Model(blade(TUNNEL_PROPELLER), law, Air(density=data.air_density)))
    theory = rotor.loads(data.omega, data.speed, data.beta).drag
    found = []
    for degrees in np.unique(np.round(np.degrees(data.beta))):
        mine = (np.round(np.degrees(data.beta)) == degrees) & (data.speed > 0.0)
        if degrees == 0.0:
            continue
        published, mean = data.loads["drag"][mine], theory[mine]
        each = published / mean
        overall = float(np.sqrt(np.sum(published**2) / np.sum(mean**2)))
        found.append(
            Ratio(float(degrees), int(mine.sum()), overall, float(each.min()), float(each.max()))
        )
    return found


def consequence(name: str, factor: float) -> Consequence:
    """The tethered quadrotor with a set of Table I, its rotor drag as it is and multiplied."""
    law, vehicle = parameter_set(name), quadrotor()
    more = law.with_parameters(drag_factor=factor)
    return Consequence(
        name,
        factor,
        circles(vehicle, law, CIRCLE_SPEEDS),
        circles(vehicle, more, CIRCLE_SPEEDS),
    )


def _small_incidence(name: str, law: Airfoil) -> SmallIncidence:
    shape, air = blade(name), Air()
    omega = TIP_SPEED / shape.radius
    data = measurement(OBLIQUE)
    published = None
    if name == data.propeller:
        # The rows have a rotational speed of their own, the nearest one.
        omega = float(data.omega[np.argmin(np.abs(data.omega - omega))])
        at = (data.omega == omega) & (np.abs(data.beta - INCIDENCE) < np.radians(0.5))
        published = np.interp(SPEEDS, data.speed[at], data.loads["drag"][at], np.nan, np.nan)
    rotor = Rotor(Model(shape, law, air))
    beta = np.concatenate([np.zeros_like(SPEEDS), np.full_like(SPEEDS, INCIDENCE)])
    loads = rotor.loads(omega, np.concatenate([SPEEDS, SPEEDS]), beta)
    thrust, drag = loads.thrust[: SPEEDS.size], loads.drag[SPEEDS.size :]
    angles = (0.0, law.zero_lift_angle)
    low, high = (
        side_force(shape, thrust, SPEEDS, INCIDENCE, air.density, zero_lift_angle=angle)
        for angle in angles
    )
    inflow = inflow_factor(thrust, SPEEDS, shape.radius, air.density)
    return SmallIncidence(name, omega, SPEEDS, inflow, drag, low, high, published)
