"""Assumptions behind the figures of an aircraft, as texts for output and JSON."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np

from propmap.model.corrections import INSTALLED
from propmap.rotor import Rotor
from propmap.table.query import LoadTable
from propmap.typing import Floats
from propmap.vehicle.vehicle import Vehicle
from propmap.vehicle.wakes import IN_ONE_PLANE, above_each_other


def without_body_drag(vehicle: Vehicle) -> str:
    """Return a remark for the figures of an aircraft without body drag; "" with body drag."""
    return "" if any(vehicle.body.drag_area) else ", without body drag"


def assumptions(
    vehicle: Vehicle, loads: Rotor | LoadTable | None, corrections: Sequence[str] = ()
) -> dict[str, str]:
    """Return the assumptions behind the computed performance of an aircraft.

    Parameters
    ----------
    vehicle : Vehicle
        Vehicle of the aircraft.
    loads : Rotor, LoadTable or None
        Source of the loads of the rotors; None for several propellers, each with its own loads.
    corrections : sequence of str
        Corrections of the rotors, if ``loads`` is None.

    Returns
    -------
    dict of str to str
        Texts by ``body_drag``, ``power``, ``rotors``, ``propeller``, ``air``, ``constants``,
        ``wakes``.
    """
    if isinstance(loads, Rotor):
        law, corrections = loads.model.airfoil, loads.model.correction_texts
        constants = ", ".join(filter(None, (law.name, getattr(law, "source", ""))))
    elif loads is None:
        constants = "different for each propeller"
    else:
        section, corrections = loads.info.get("airfoil") or {}, loads.info.get("corrections") or ()
        constants = f"from the table, {section.get('name', 'not stated')}"
    backward = ", turning backward (not measured)" if getattr(loads, "backward", False) else ""
    return {
        "body_drag": _body_drag(vehicle),
        "power": _power(vehicle),
        "rotors": _rotors(vehicle, corrections) + backward,
        "propeller": "each propeller as listed" if loads is None else vehicle.propeller.summary,
        "air": f"{vehicle.air.density:.4g} kg/m^3",
        "constants": constants,
        "wakes": _wakes(vehicle),
    }


def assumption_lines(found: dict[str, str]) -> list[str]:
    """Return the texts of ``assumptions`` in two lines."""
    constants = textwrap.shorten(found["constants"], 100, placeholder=" ...")
    return [
        f"assumed: {'; '.join(found[name] for name in ('body_drag', 'power', 'rotors'))}",
        f"{found['propeller']}; air {found['air']}; constants: {constants}; {found['wakes']}",
    ]


def _body_drag(vehicle: Vehicle) -> str:
    if without_body_drag(vehicle):
        return "no body drag (no [body] drag_area): power at speed too low, top speed too high"
    ahead, _, above = vehicle.body.drag_area
    return f"body drag area {ahead:g} m^2 along x, {above:g} m^2 along z"


def _power(vehicle: Vehicle) -> str:
    power = vehicle.powertrain
    if power.motor is None:
        return "shaft power (no [motor])"
    lossless = power.controller is None
    found = "electrical power" + ", lossless speed controllers (no [esc])" * lossless
    return found + ", no flight times, no voltage limit (no [battery])" * (power.battery is None)


def _rotors(vehicle: Vehicle, corrections: Sequence[str]) -> str:
    if any(mount.drag is not None for mount in vehicle.mounts):
        return "rotors with the drag of [mount]"
    mounted = [text for text in corrections if text.startswith(INSTALLED)]
    if not mounted:
        return "bare rotors, with half the drag of installed rotors"
    return "installed rotors" + f" ({mounted[0]})" * (mounted[0] != INSTALLED)


def _wakes(vehicle: Vehicle) -> str:
    count = int(above_each_other(vehicle).any(axis=1).sum())
    if vehicle.wakes is not None and not vehicle.wakes.slipstreams_alone:
        words = "rotors in each other's wakes"
    elif vehicle.wakes is not None and count:
        words = f"{count} rotors above each other: lower rotors in slipstreams"
    else:
        words = f"wakes of {count} rotors above each other ignored" if count else "no wakes"
    return words + ", overlap in one plane not modeled" * _meshing(vehicle)


def hub_distances(vehicle: Vehicle) -> tuple[Floats, Floats]:
    """Return distances (k, k) between hubs along and across the axis of the second hub [m]."""
    offset = vehicle.hub_positions[:, None] - vehicle.hub_positions
    height = np.abs(np.sum(offset * vehicle.rotor_axes, axis=-1))
    return height, np.sqrt(np.maximum(np.sum(offset**2, axis=-1) - height**2, 0.0))


def _meshing(vehicle: Vehicle) -> bool:
    """Return whether disks overlap in one plane."""
    height, across = hub_distances(vehicle)
    radius = vehicle.propeller.radius
    near = (across < 2.0 * radius * (1.0 - 1e-9)) & (height < IN_ONE_PLANE * radius)
    return bool(near.sum() > len(near))
