"""What the figures of an aircraft rest on, in words beside them and in JSON."""

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
    """Return what to say beside figures of flight where the drag of a body is not known, or ""."""
    return "" if any(vehicle.body.drag_area) else ", without body drag"


def assumptions(
    vehicle: Vehicle, loads: Rotor | LoadTable | None, corrections: Sequence[str] = ()
) -> dict[str, str]:
    """Say in words what figures of an aircraft rest on.

    Parameters
    ----------
    vehicle : Vehicle
        What flies.
    loads : Rotor, LoadTable or None
        Gives the loads of its rotors; None where each propeller has its own.
    corrections : sequence of str
        Those of its rotors, where ``loads`` is None.

    Returns
    -------
    dict of str to str
        By ``body_drag``, ``power``, ``rotors``, ``propeller``, ``air``, ``constants``, ``wakes``.
    """
    if isinstance(loads, Rotor):
        law, corrections = loads.model.airfoil, loads.model.correction_texts
        constants = ", ".join(filter(None, (law.name, getattr(law, "source", ""))))
    elif loads is None:
        constants = "each propeller's own"
    else:
        section, corrections = loads.info.get("airfoil") or {}, loads.info.get("corrections") or ()
        constants = f"of the table, {section.get('name', 'not stated')}"
    return {
        "body_drag": _body_drag(vehicle),
        "power": _power(vehicle),
        "rotors": _rotors(vehicle, corrections),
        "propeller": "each propeller as named" if loads is None else vehicle.propeller.summary,
        "air": f"{vehicle.air.density:.4g} kg/m^3",
        "constants": constants,
        "wakes": _wakes(vehicle),
    }


def assumption_lines(found: dict[str, str]) -> list[str]:
    """Write ``assumptions`` in two lines."""
    constants = textwrap.shorten(found["constants"], 40, placeholder=" ...")
    return [
        f"assumed: {'; '.join(found[name] for name in ('body_drag', 'power', 'rotors'))}",
        f"{found['propeller']}; air {found['air']}; constants: {constants}; {found['wakes']}",
    ]


def _body_drag(vehicle: Vehicle) -> str:
    if without_body_drag(vehicle):
        return "no body drag (no [body] drag_area): too little power at speed, top speed too fast"
    ahead, _, above = vehicle.body.drag_area
    return f"body drag {ahead:g} m^2 ahead, {above:g} m^2 above, as given"


def _power(vehicle: Vehicle) -> str:
    power = vehicle.powertrain
    if power.motor is None:
        return "shaft power (no [motor])"
    lossless = power.controller is None
    found = "electrical power" + ", lossless speed controllers (no [esc])" * lossless
    return found + ", no times, no voltage limit (no [battery])" * (power.battery is None)


def _rotors(vehicle: Vehicle, corrections: Sequence[str]) -> str:
    if any(mount.drag is not None for mount in vehicle.mounts):
        return "rotors with the drag of [mount]"
    mounted = [text for text in corrections if text.startswith(INSTALLED)]
    if not mounted:
        return "bare rotors, with half the drag"
    return "installed rotors" + f" ({mounted[0]})" * (mounted[0] != INSTALLED)


def _wakes(vehicle: Vehicle) -> str:
    count = int(above_each_other(vehicle).any(axis=1).sum())
    if vehicle.wakes is not None and not vehicle.wakes.slipstreams_alone:
        words = "rotors in each other's wakes"
    elif vehicle.wakes is not None and count:
        words = f"{count} rotors above each other: lower ones in slipstreams"
    else:
        words = f"wakes left out of {count} rotors above each other" if count else "no wakes"
    return words + ", overlap in one plane not modelled" * _meshing(vehicle)


def hub_distances(vehicle: Vehicle) -> tuple[Floats, Floats]:
    """Return distances (k, k) between hubs along the axis of the second, and across it [m]."""
    offset = vehicle.hub_positions[:, None] - vehicle.hub_positions
    height = np.abs(np.sum(offset * vehicle.rotor_axes, axis=-1))
    return height, np.sqrt(np.maximum(np.sum(offset**2, axis=-1) - height**2, 0.0))


def _meshing(vehicle: Vehicle) -> bool:
    """Say whether disks overlap in one plane."""
    height, across = hub_distances(vehicle)
    radius = vehicle.propeller.radius
    near = (across < 2.0 * radius * (1.0 - 1e-9)) & (height < IN_ONE_PLANE * radius)
    return bool(near.sum() > len(near))
