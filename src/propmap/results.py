"""What a rotor answers: loads with a status, and vectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.errors import InputError

STATUSES = ("ok", "multiple_roots", "windmill", "coarse", "vortex_ring", "not_converged")
"""From harmless to fatal; where several apply, the last is given."""


@dataclass(frozen=True)
class Loads:
    """Loads of a rotor; every field has the broadcast shape of the operating points.

    Attributes
    ----------
    thrust : ndarray
        Along the axis [N].
    drag : ndarray
        In the disk plane, against the in-plane velocity [N].
    torque : ndarray
        What turns the shaft [N m]; negative where the air drives the propeller.
    roll_moment : ndarray
        About the direction of the in-plane velocity [N m], positive where the advancing side is
        lifted, before the sign of the spin is applied.
    side_force : ndarray
        In the disk plane across the in-plane velocity [N], positive towards the retreating side.
        Zero, like the pitching moment, where the inflow does not vary around the disk.
    pitch_moment : ndarray
        About the axis across the in-plane velocity [N m], positive where the front is lifted.
    power : ndarray
        Torque times omega [W].
    status : ndarray of str
        Of ``STATUSES``.  "multiple_roots": near stall the inflow has several solutions, the largest
        is used.  "windmill": descent so fast that the wake is above the disk.  "vortex_ring":
        momentum theory does not hold and a measured inflow is blended in; not to be trusted.
        "coarse": loads vary so sharply along the blade that their error may exceed what the
        accuracy promises.  "not_converged": the loads are NaN.
    roots : ndarray of int
        Largest number of solutions of eq. (11) along the blade.
    reverse_flow : ndarray
        Share of the blades' disk that the air meets from behind [-].
    vortex_ring : ndarray
        Share of the measured vortex-ring inflow in the inflow used [-].
    mean_inflow : ndarray
        v_i averaged over the disk [m/s].
    """

    thrust: Floats
    drag: Floats
    torque: Floats
    roll_moment: Floats
    side_force: Floats
    pitch_moment: Floats
    power: Floats
    status: NDArray[np.str_]
    roots: NDArray[np.int64]
    reverse_flow: Floats
    vortex_ring: Floats
    mean_inflow: Floats


@dataclass(frozen=True)
class Wrench:
    """Force and moment on the vehicle at the hub, in the rotor frame.

    Attributes
    ----------
    force, moment : ndarray, shape (..., 3)
        [N], and about the hub [N m].
    """

    force: Floats
    moment: Floats


def spin_sign(spin: str) -> float:
    """1 for a ``spin`` "ccw", -1 for "cw"; ``InputError`` for another."""
    if spin not in ("ccw", "cw"):
        raise InputError(f"spin is {spin!r}: it must be 'ccw' or 'cw', seen from above")
    return 1.0 if spin == "ccw" else -1.0


def hub_wrench(loads: Loads, direction: Floats, sign: float) -> Wrench:
    """Loads as vectors in the right-handed rotor frame with z along the thrust.

    Parameters
    ----------
    loads : Loads
        Of shape (...).
    direction : ndarray, shape (..., 3)
        Unit vector of the in-plane velocity.
    sign : float
        That of the spin, see ``spin_sign``.
    """
    # Counter-clockwise, the advancing side is on the right: lifting it rolls about -x.
    z = np.array([0.0, 0.0, 1.0])
    left = np.cross(z, direction)
    side, pitch = sign * loads.side_force[..., None], loads.pitch_moment[..., None]
    force = loads.thrust[..., None] * z - loads.drag[..., None] * direction + side * left
    moment = -sign * (loads.torque[..., None] * z + loads.roll_moment[..., None] * direction)
    return Wrench(force, moment - pitch * left)


def statuses(found: Any, v_axial: Floats, coarse: NDArray[np.bool_]) -> NDArray[np.str_]:
    """The worst of ``STATUSES`` that applies at each point; ``v_axial`` is V cos(beta) [m/s]."""
    windmill = (v_axial < 0.0) & (v_axial + 2.0 * found.mean_inflow <= 0.0)
    ring = (found.ring > 0.0) | found.mirrored
    lost = ~np.isfinite(found.loads.thrust)
    cases = [lost, ring, coarse, windmill, found.roots > 1]
    return np.asarray(np.select(cases, STATUSES[:0:-1], STATUSES[0]))
