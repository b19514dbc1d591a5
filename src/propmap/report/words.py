"""Findings in words: a table's certificate, and what a motor in the slipstream would add."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from propmap.loads import LOADS
from propmap.typing import Floats
from propmap.units import DEGREE, RPM

if TYPE_CHECKING:
    from propmap.results import Loads
    from propmap.rotor import Rotor

# -------------------------------------------------------------------------------------------------
# A table's certificate in words.

TITLES = {name: load.share for name, load in LOADS.items()}  # what errors are shares of
PLACE = {"rpm": "1/min", "speed": "m/s", "beta": "deg"}  # coordinates in the envelope, with units


def largest_at(found: Mapping[str, Any]) -> dict[str, list[float] | None]:
    """Find the place in the envelope, as in ``PLACE``, of a certificate's largest errors, by load.

    Empty for a certificate of earlier versions, which does not say; None for a load without errors.
    """
    if not found.get("max_omega"):
        return {}
    units = {"max_omega": 1.0 / RPM, "max_speed": 1.0, "max_beta": 1.0 / DEGREE}
    places = {
        load: [factor * found[name][load] for name, factor in units.items()] for load in LOADS
    }
    return {load: place if found["max_error"][load] else None for load, place in places.items()}


def claims(found: Mapping[str, Any]) -> Iterator[str]:
    """Say what a table's certificate claims, a sentence each."""
    cells = int(found["unresolved_cells"])
    outside = ", outside unresolved cells" if cells else ""
    yield (
        f"tolerance {found['tolerance']:.2%} holds on {found['points']} points that the table was "
        f"not built from{outside}"
    )
    if found.get("search_points"):
        yield (
            f"the largest errors were searched for, on {found['search_points']} points more: in "
            "each cell of the table, and uphill from its worst points"
        )
    if cells:
        worst = max(found["unresolved_max_error"].values())
        yield (
            f"unresolved: {cells} cells, {found['unresolved_volume']:.2%} of the envelope, "
            f"where the loads change too steeply for a table; there errors reach {worst:.2%} on "
            f"{found['unresolved_points']} points"
        )
    yield (
        f"of the {found['points']} points, {found['vortex_ring']} are vortex ring and "
        f"{found['no_value']} without loads"
    )


def parameter_claims(found: Mapping[str, Any]) -> Iterator[str]:
    """Say from what the uncertainty of the section law's parameters was computed."""
    yield (
        "parameters: standard deviation of the loads by the fit's covariance of "
        f"{', '.join(found['parameters'])}, on {found['points']} points"
    )
    if found["not_counted"]:
        names = ", ".join(found["not_counted"])
        yield f"not counted, as the fit's data do not determine them: {names}"


# -------------------------------------------------------------------------------------------------
# By how much a motor in the slipstream raises the rotor drag of a model that has none.


def rise_by_motor(rotor: Rotor, loads: Loads, speed: ArrayLike, beta: ArrayLike) -> Floats:
    """Compute the drag of a motor in proportion to the propeller, over the rotor drag [-].

    The rotor has nothing mounted; speed [m/s] and beta [rad] broadcast to the shape of the loads.
    NaN without an in-plane velocity, and where the drag is not positive.
    """
    from propmap.model.corrections import MountDrag

    velocity, angle = np.broadcast_arrays(np.asarray(speed, float), np.asarray(beta, float))
    along, across = velocity * np.cos(angle), velocity * np.abs(np.sin(angle))
    radius, density = rotor.model.propeller.radius, rotor.model.air.density
    drag = MountDrag().drag(radius, density, along, across, loads.mean_inflow)
    known = (across > 1e-9 * np.maximum(velocity, 1.0)) & (loads.drag > 0.0)
    return np.divide(drag, loads.drag, out=np.full(np.shape(loads.drag), np.nan), where=known)


def motor_note(rotor: Rotor, loads: Loads, speed: ArrayLike, beta: ArrayLike) -> str:
    """Say what ``rise_by_motor`` gives; "" where something is mounted, or nothing can be said."""
    from propmap.model.corrections import MOTOR_DIAMETER, MOTOR_HEIGHT, MountDrag

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
