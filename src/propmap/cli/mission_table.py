"""A mission as `propmap trim` shows it: energy and state of charge, leg by leg."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from propmap.cli.aircraft_options import digits, number_or_none, title
from propmap.cli.output import Format, emit_rows, grid, show

if TYPE_CHECKING:
    from propmap.aircraft.mission import Mission
    from propmap.aircraft.steady import Aircraft


def fly_and_show(craft: Aircraft, legs: Mission, form: Format, output: Path | None) -> None:
    """Fly the ``legs`` with the aircraft ``craft``; rows in this ``form`` to ``output``."""
    from propmap.aircraft.mission import fly

    flown = fly(craft, legs)
    columns = {
        "speed_mps": legs.speed,
        "climb_mps": legs.climb,
        "duration_s": legs.duration,
        "pitch_deg": np.degrees(flown.states.pitch),
        "power_W": flown.states.power,
        "energy_J": flown.energy,
        "charge": flown.charge,
    }
    names = [*columns, "status"]
    if form is not Format.table:
        values = zip(*(v.tolist() for v in columns.values()), flown.status.tolist(), strict=True)
        listed = [
            dict(zip(names, [*(number_or_none(v) for v in row[:-1]), row[-1]], strict=True))
            for row in values
        ]
        emit_rows(names, listed, form, output)
        return
    cells = [[digits(v) for v in values] for values in columns.values()]
    body = grid(
        "V [m/s]|climb [m/s]|time [s]|pitch [deg]|P [W]|energy [J]|charge|<status",
        zip(*cells, flown.status.tolist(), strict=True),
        f"mission {legs.source}",
        "charge: at the end of the leg, 1 when full",
    )
    total, lost = float(np.sum(flown.energy)), ~np.isfinite(flown.energy)
    told = f"{total / 3600.0:.4g} Wh in {legs.duration.sum() / 60.0:.4g} min"
    if lost.any():
        told = f"leg {int(np.argmax(lost)) + 1} cannot be flown"
    elif (flown.status == "battery_empty").any():
        told += (
            f"; the battery is empty in leg {int(np.argmax(flown.status == 'battery_empty')) + 1}"
        )
    show(output, title(craft), body, told)
