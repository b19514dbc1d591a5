"""Loads of a vehicle's rotors from what gives them: a rotor, a table or the hover model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.results import STATUSES
from propmap.typing import Floats
from propmap.vehicle.hub_flow import HubFlow

if TYPE_CHECKING:
    from propmap.vehicle.vehicle import Vehicle

SEVERITY = (
    *STATUSES[:-1],
    "unresolved",
    "clamped",
    STATUSES[-1],
    "no_value",
    "outside",
)
"""Statuses of rotors and of tables, from harmless to fatal."""


@runtime_checkable
class LoadSource(Protocol):
    """What gives loads for a velocity in the rotor frame, as ``Rotor`` and ``LoadTable`` do."""

    def loads_at_velocity(self, omega: Any, velocity: Any) -> Any:
        """Loads with a ``status``."""
        ...


Sources = list[tuple[LoadSource, NDArray[np.intp]]]
"""What gives the loads of which rotors."""


def loads_at_hubs(sources: Sources, flow: HubFlow) -> tuple[Floats, NDArray[np.str_]]:
    """Loads (L, n, k) of the ``sources`` in the ``flow`` at the hubs, and their status (n, k)."""
    loads = np.empty((len(LOADS), *flow.omega.shape))
    status = np.empty(flow.omega.shape, dtype="<U16")
    for source, mine in sources:
        parts = [values[:, mine] for values in (flow.omega, flow.inplane, flow.axial)]
        if not parts[0].size:
            continue
        # Half the rotors of a symmetric vehicle see what the other half sees.
        once, where = _apart(np.stack(parts, axis=-1).reshape(-1, 3))
        where = where.reshape(parts[0].shape)
        omega, across, along = once.T
        velocity = np.stack([across, np.zeros_like(across), along], axis=1)
        found = source.loads_at_velocity(omega, velocity)
        for rows, name in zip(loads, LOADS, strict=True):
            rows[:, mine] = np.asarray(getattr(found, name))[where]
        status[:, mine] = np.asarray(found.status)[where]
    return loads, status


def worst(status: NDArray[np.str_]) -> NDArray[np.str_]:
    """The worst ``status`` (..., k) of all rotors, (...)."""
    names = np.array(SEVERITY)
    order = np.argsort(names)
    rank = order[np.searchsorted(names, status, sorter=order)]
    return np.asarray(names[rank.max(axis=-1)])


def _apart(points: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """The distinct rows of points (n, 3), but for rounding, and which of them each one is."""
    size = np.maximum(np.abs(points).max(axis=0, initial=0.0), 1e-30)
    rounded = np.round(points / size, 11) + 0.0
    order = np.lexsort(rounded.T)
    ranked = rounded[order]
    new = np.append(True, (ranked[1:] != ranked[:-1]).any(axis=1))
    where = np.empty(len(points), np.intp)
    where[order] = np.cumsum(new) - 1
    return points[order[new]], where


def check_table(vehicle: Vehicle, table: Any) -> None:
    """Raise ``InputError`` for a ``table``, or what else has loads, of another rotor or air."""
    if any(mount.drag is not None for mount in vehicle.mounts):
        raise InputError(
            "the vehicle file has [mount], of which a table knows nothing",
            "leave out [mount] and build the table with --correction mount-drag:area_m2=...",
        )
    described = getattr(table, "info", {}).get("propeller")
    if described is None:
        return
    if described.get("geometry_sha256") != vehicle.propeller.fingerprint():
        raise InputError(
            f"the table is of {described.get('name')!r}, the vehicle has "
            f"{vehicle.propeller.name!r}, or the same with another geometry",
            "build a table for this propeller",
        )
    if abs(table.content.density - vehicle.air.density) > 1e-6 * vehicle.air.density:
        raise InputError(
            f"the table holds for {table.content.density:g} kg/m^3, the vehicle flies in "
            f"{vehicle.air.density:g}",
            "build a table with --rho, or change [air]",
        )
