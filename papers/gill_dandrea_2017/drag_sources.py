"""Rotor drag by source, in figures that propellers share: what is computed here, and what others
found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.baselines.fin_analogy import side_force
from propmap.papers.gill_dandrea_2017.blades import blade
from propmap.papers.gill_dandrea_2017.identified import OBLIQUE_LABEL
from propmap.papers.gill_dandrea_2017.rotor_drag import INCIDENCE
from propmap.papers.gill_dandrea_2017.tunnel import OTHER_LABEL, RECOMMENDED_LABEL, Compared
from propmap.typing import Floats

Mask = NDArray[np.bool_]

CRUISE = 10.0
"""[m/s] from which the fin analogy is compared: below, the disk is heavily loaded."""

LITERATURE = (
    (
        "unsteady free-wake lifting line, same section law, at equal thrust",
        "0.88 to 1.19 times the theory's drag",
        "bare blades",
    ),
    (
        "polynomial of a lift rotor computed by another agency (NASA GUAM, Simmons 2021)",
        "H/T = 0.49 μ; this theory 0.57 μ",
        "bare blades",
    ),
    (
        "quadcopter with 15 in rotors in a tunnel",
        "somewhat less than four rotors of this theory",
        "whole vehicle",
    ),
    ("Crazyflie 2.0 in flight (Förster 2015)", "H/T = 0.74 μ", "whole vehicle"),
    ("Parrot Bebop in flight", "H/T = 1.2 to 1.4 μ", "whole vehicle"),
)
"""Source, finding, and what was looked at; not computed here."""


@dataclass(frozen=True)
class Source:
    """Rotor drag H of the APC 8x6E by one source; NaN where it says nothing.

    With H' = H/(rho/2 A (Omega R)^2) and mu = V sin(beta)/(Omega R).

    Attributes
    ----------
    label : str
        Of the source.
    incidence : float
        H'/mu at 15 degrees and ``CRUISE`` or more [-].
    edgewise, edgewise_by_thrust : float
        H'/mu and H/(T mu) in edgewise flow [-].
    """

    label: str
    incidence: float
    edgewise: float
    edgewise_by_thrust: float


def sources(one: Compared) -> list[Source]:
    """Theory with both inflows, the fin with both side areas, both forms of the data."""
    data, laws = one.data, one.laws
    theory, recommended, other = (
        one.predicted[label] for label in (OBLIQUE_LABEL, RECOMMENDED_LABEL, OTHER_LABEL)
    )
    found = [
        _source(one, "this theory, the paper's inflow", theory["drag"], theory["thrust"]),
        _source(one, "this theory, recommended inflow", recommended["drag"], recommended["thrust"]),
    ]
    slanted, _ = _points(one)
    zero_lift = laws[OBLIQUE_LABEL].zero_lift_angle
    for line, angle in (("chord line", 0.0), ("zero-lift line", zero_lift)):
        drag = np.full_like(data.speed, np.nan)
        drag[slanted] = side_force(
            blade(data.propeller),
            _axial_thrust(one, theory["thrust"])[slanted],
            data.speed[slanted],
            INCIDENCE,
            data.air_density,
            zero_lift_angle=angle,
        )
        found.append(_source(one, f"Ribner's fin, side area by the {line}", drag, None))
    return [
        *found,
        _source(one, "2019, polynomials", data.loads["drag"], data.loads["thrust"]),
        _source(one, "2019, blade-element model", other["drag"], other["thrust"]),
    ]


def _points(one: Compared) -> tuple[Mask, Mask]:
    """Which rows (n,) are at 15 degrees in cruise, and which edgewise, as booleans."""
    data = one.data
    near = [np.abs(data.beta - angle) < np.radians(0.5) for angle in (INCIDENCE, 0.5 * np.pi)]
    return near[0] & (data.speed >= CRUISE), near[1] & (data.speed > 0.0)


def _axial_thrust(one: Compared, thrust: Floats) -> Floats:
    """Thrust (n,) [N] at the same rotational and flight speed without incidence."""
    data, axial = one.data, np.flatnonzero(one.data.beta == 0.0)
    same = np.isclose(data.omega[:, None], data.omega[axial]) & np.isclose(
        data.speed[:, None], data.speed[axial]
    )
    return np.where(same.any(axis=1), thrust[axial[same.argmax(axis=1)]], np.nan)


def _source(one: Compared, label: str, drag: Floats, thrust: Floats | None) -> Source:
    data, radius = one.data, blade(one.data.propeller).radius
    tip_speed = data.omega * radius
    advance = data.speed * np.sin(data.beta) / tip_speed
    share = drag / (0.5 * data.air_density * np.pi * radius**2 * tip_speed**2)
    slanted, edgewise = _points(one)

    def slope(at: Mask) -> float:
        return float(share[at] @ advance[at] / (advance[at] @ advance[at]))

    by_thrust = np.nan
    if thrust is not None:
        by_thrust = float(drag[edgewise].sum() / (thrust * advance)[edgewise].sum())
    return Source(label, slope(slanted), slope(edgewise), by_thrust)
