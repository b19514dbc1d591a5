"""The note that goes with the export of a whole vehicle."""

from __future__ import annotations

import textwrap
from typing import Any

from propmap.export.provenance import provenance
from propmap.export.template import rendered
from propmap.table.query import LoadTable
from propmap.vehicle.vehicle import Vehicle


def vehicle_note(vehicle: Vehicle, table: LoadTable, target: str, **values: Any) -> str:
    """The text of a note.

    Parameters
    ----------
    vehicle, table : Vehicle, LoadTable
        What is exported.
    target : str
        Names the template, ``README-vehicle-<target>.txt.j2``.
    **values
        For the template.
    """
    text = rendered(f"README-vehicle-{target}.txt", table, vehicle=vehicle, **values)
    parts = [f"propmap export: {target}, {vehicle.name}"]
    parts += [
        textwrap.fill(part, 88, break_on_hyphens=False, break_long_words=False)
        for part in text.strip().split("\n\n")
    ]
    return "\n\n".join([*parts, "\n".join(provenance(table))]) + "\n"
