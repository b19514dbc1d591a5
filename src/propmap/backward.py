"""Loads of a rotor that turns backward: the blades meet the air with their trailing edges.

Half a turn about the in-plane velocity turns such a rotor upside down.  It then turns forward, with
a twist larger by pi, in an axial flow of opposite sign.  The core solves it like any other rotor.

A section law describes flow from the trailing edge as separated flow around a flat plate along the
zero-lift line.  At small angles of attack this is wrong for cambered sections: by thin-airfoil
theory (Katz and Plotkin, Low-Speed Aerodynamics, 2001, section 5.3), the zero-lift angle of a
circular arc has the same sign in flow from both ends.  Therefore ``solve`` combines two rotors,
with and without this camber.  The camber has the weight (Omega R)^2/((Omega R)^2 + V^2), because
the loads must be continuous where the rotation reverses in wind.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil
from propmap.model.model import Model
from propmap.results import STATUSES
from propmap.tasks import cores
from propmap.typing import CoreRotor, Floats

SIGNS = np.array([1.0 if name in ("drag", "roll_moment") else -1.0 for name in LOADS])[:, None]
"""Loads of the rotor over those of the rotor upside down."""

SHARE = 0.15
"""Standard deviation of a load because of the section law, over the load: an assumption, because no
measurement of a propeller that turns backward was found."""


class Backward(NamedTuple):
    """Solution at N operating points."""

    loads: Floats  # in the order of ``LOADS`` (L, N) [N], [N m]
    found: Floats  # status code, roots, vortex ring, mean inflow, reverse flow (5, N)
    deviations: Floats  # standard deviations of the loads (L, N) [N], [N m]


def more_twist(model: Model) -> tuple[float, float]:
    """Return the additional twist [rad] of the blades upside down, with and without camber."""
    # Tables of a section contain the flow from the trailing edge.
    law: Any = model.airfoil
    camber = 2.0 * law.zero_lift_angle if isinstance(law, Airfoil) else 0.0
    return np.pi + camber, np.pi


def solve(rotors: tuple[CoreRotor, CoreRotor], tip: float, rows: Floats) -> Backward:
    """Solve operating points (F, N), the rows of ``FlowPoints``, with negative omega.

    Parameters
    ----------
    rotors : tuple of CoreRotor
        Rotors upside down, with and without camber: with ``more_twist``.
    tip : float
        Tip radius [m].
    rows : ndarray, shape (F, N)
        Omega < 0 [rad/s], axial and in-plane velocity [m/s], distances of ground and ceiling [m].
    """
    omega, v_axial, v_inplane, height, ceiling = rows
    turned = np.ascontiguousarray([-omega, -v_axial, v_inplane, ceiling, height])
    (cambered, found), (plate, other) = (one.loads(turned, cores()) for one in rotors)
    rotation = (omega * tip) ** 2
    weight = rotation / (rotation + v_axial**2 + v_inplane**2)
    loads = weight * cambered + (1.0 - weight) * plate
    deviations = np.hypot(0.5 * (cambered - plate), SHARE * loads)
    ring, inflow, reverse = weight * found[2:] + (1.0 - weight) * other[2:]
    status, roots = np.maximum(found[:2], other[:2])
    status = np.maximum(status, STATUSES.index("reversed"))
    more = np.stack([status, roots, ring, -inflow, 1.0 - reverse])
    return Backward(SIGNS * loads, more, deviations)
