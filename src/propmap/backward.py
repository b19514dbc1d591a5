"""Loads of a rotor that turns backward: the trailing edges of the blades meet the air first.

Half a turn about the in-plane velocity maps such a rotor to an upside-down rotor that turns
forward.  The core solves this rotor, with a twist larger by pi, in an axial flow of opposite sign.

A section law describes flow from the trailing edge as separated flow around a flat plate along the
zero-lift line.  At small angles of attack, this description is wrong for cambered sections.  By
thin-airfoil theory (Katz and Plotkin, Low-Speed Aerodynamics, 2001, section 5.3), a circular arc
has the same zero-lift angle, in size and sign, in flow from both ends.  Therefore ``solve``
averages the loads of blades with this zero-lift angle and of flat plates.  The cambered blades have
the weight (Omega R)^2/((Omega R)^2 + V^2), so the loads are continuous at Omega = 0 in wind.
"""

from __future__ import annotations

import numpy as np

from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil, SectionTable
from propmap.model.corrections import StallDelay
from propmap.model.model import Model
from propmap.results import STATUSES
from propmap.tasks import cores
from propmap.typing import CoreRotor, Floats

SIGNS = np.array([1.0 if name in ("drag", "roll_moment") else -1.0 for name in LOADS])[:, None]
"""Ratio of each load of the rotor to the same load of the upside-down rotor."""

SHARE = 0.15
"""Standard deviation of a load due to the section law, divided by the load.  The value is an
assumption, because no measurement of a propeller that turns backward was found."""


def more_twist(model: Model) -> tuple[float, float]:
    """Return the additional twist [rad] of the upside-down blades, with and without camber.

    If the section law has a period of pi, an additional twist of pi has no effect and is omitted.
    The core then uses the same nodes in both directions.  The loads are equal except for rounding.
    """
    law, half = model.airfoil, np.pi
    if isinstance(law, Airfoil):
        half = 0.0 if law.lift_law == "simplified" else np.pi
        return half + 2.0 * law.zero_lift_angle, half
    # A section table contains the lift in flow from the trailing edge.
    if isinstance(law, SectionTable) and model.correction_of(StallDelay) is None:
        opposite, rows = np.mod(law.angle, 2.0 * np.pi) - np.pi, (*law.lift, *law.drag)
        there = (np.interp(opposite, law.angle, row) for row in rows)
        half = 0.0 if np.allclose(list(there), rows, rtol=0.0, atol=1e-12) else np.pi
    return half, half


def solve(
    rotors: tuple[CoreRotor, CoreRotor], tip: float, rows: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return the results at operating points (F, N), the rows of ``FlowPoints``, with omega < 0.

    Parameters
    ----------
    rotors : tuple of CoreRotor
        Upside-down rotors with and without camber; ``more_twist`` is part of their twist.
    tip : float
        Tip radius [m].
    rows : ndarray, shape (F, N)
        Omega < 0 [rad/s], axial and in-plane velocity [m/s], distances of ground and ceiling [m].

    Returns
    -------
    loads, found, deviations : ndarray, shape (L, N), (5, N), (L, N)
        Loads in the order of ``LOADS``; status code, roots, vortex ring, mean inflow and reverse
        flow; standard deviations of the loads.
    """
    omega, v_axial, v_inplane, height, ceiling = rows
    turned = np.ascontiguousarray([-omega, -v_axial, v_inplane, ceiling, height])
    every = (one.loads(turned, (), cores())[0] for one in rotors)
    (cambered, found), (plate, other) = (np.split(values, [len(LOADS)]) for values in every)
    rotation = (omega * tip) ** 2
    weight = rotation / (rotation + v_axial**2 + v_inplane**2)
    loads = weight * cambered + (1.0 - weight) * plate
    deviations = np.hypot(0.5 * (cambered - plate), SHARE * loads)
    ring, inflow, reverse = weight * found[2:] + (1.0 - weight) * other[2:]
    status, roots = np.maximum(found[:2], other[:2])
    status = np.maximum(status, STATUSES.index("reversed"))
    more = np.stack([status, roots, ring, -inflow, 1.0 - reverse])
    return SIGNS * loads, more, deviations
