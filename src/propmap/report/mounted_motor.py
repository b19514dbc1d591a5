"""By how much a motor in the slipstream raises the rotor drag of a model that has none."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from propmap.model.corrections import MOTOR_DIAMETER, MOTOR_HEIGHT, MountDrag
from propmap.results import Loads
from propmap.rotor import Rotor
from propmap.typing import Floats


def rise_by_motor(rotor: Rotor, loads: Loads, speed: ArrayLike, beta: ArrayLike) -> Floats:
    """The drag of a motor in proportion to the propeller, over the rotor drag [-].

    Parameters
    ----------
    rotor : Rotor
        Without anything mounted.
    loads : Loads
        Its loads at n operating points.
    speed, beta : array_like
        Of these points [m/s], [rad]; they broadcast to the shape of the loads.

    Returns
    -------
    ndarray
        Of the shape of the loads; NaN without an in-plane velocity, and where the drag is not
        positive.
    """
    velocity, angle = np.broadcast_arrays(np.asarray(speed, float), np.asarray(beta, float))
    along, across = velocity * np.cos(angle), velocity * np.abs(np.sin(angle))
    radius, density = rotor.model.propeller.radius, rotor.model.air.density
    drag = MountDrag().drag(radius, density, along, across, loads.mean_inflow)
    known = (across > 1e-9 * np.maximum(velocity, 1.0)) & (loads.drag > 0.0)
    return np.divide(drag, loads.drag, out=np.full(np.shape(loads.drag), np.nan), where=known)


def motor_note(rotor: Rotor, loads: Loads, speed: ArrayLike, beta: ArrayLike) -> str:
    """A sentence on ``rise_by_motor``; empty where something is mounted, or nothing can be said."""
    if rotor.model.correction_of(MountDrag) is not None:
        return ""
    rise = 100.0 * rise_by_motor(rotor, loads, speed, beta)
    if not np.isfinite(rise).any():
        return ""
    low, high = np.nanmin(rise), np.nanmax(rise)
    by = f"{high:.0f} %" if high - low < 1.0 else f"{low:.0f} to {high:.0f} %"
    size = 1e3 * rotor.model.propeller.radius
    motor = f"{size * MOTOR_DIAMETER:.0f} x {size * MOTOR_HEIGHT:.0f} mm"
    return (
        f"rotor drag is that of the blades alone; a motor of {motor} in the slipstream would "
        f"raise it by {by} (correction mount-drag, in fits mount_area)"
    )
