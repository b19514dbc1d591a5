"""A mission as `propmap trim` shows it: energy and state of charge, leg by leg and over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import typer

from propmap.cli.aircraft_options import digits, number_or_none, title
from propmap.cli.output import Format, emit, emit_rows, grid, json_text, show

if TYPE_CHECKING:
    from propmap.aircraft.mission import Flown, Mission
    from propmap.aircraft.trim import Aircraft


def fly_and_show(
    craft: Aircraft, legs: Mission, form: Format, output: Path | None, picture: Path | None
) -> None:
    """Fly the ``legs`` with the aircraft ``craft``.

    Rows in this ``form`` go to ``output``, and where it is wanted a ``picture`` of all over time.
    """
    from propmap.aircraft.mission import fly

    flown = fly(craft, legs)
    columns = {
        "time_s": flown.course.time[:, -1],
        "speed_mps": legs.speed,
        "climb_mps": legs.climb,
        "duration_s": legs.duration,
        "pitch_deg": np.degrees(flown.states.pitch),
        "power_W": flown.states.power,
        "energy_J": flown.energy,
        "charge": flown.charge,
        "voltage_V": flown.course.voltage[:, -1],
    }
    if form is Format.table:
        _show_table(craft, legs, flown, columns, output)
    else:
        names = [*columns, "status"]
        values = zip(*(v.tolist() for v in columns.values()), flown.status.tolist(), strict=True)
        listed = [
            dict(zip(names, [*(number_or_none(v) for v in row[:-1]), row[-1]], strict=True))
            for row in values
        ]
        if form is Format.csv:
            emit_rows(names, listed, form, output)
        else:
            whole = {"vehicle": craft.vehicle.name, "legs": listed, "over_time": _over_time(flown)}
            emit(json_text(whole), output)
    if picture is not None:
        from propmap.report.html import save
        from propmap.report.pictures import mission_course

        save(mission_course(title(craft), legs, flown), picture)
        typer.echo(f"wrote {picture}", err=True)


def _over_time(flown: Flown) -> dict[str, list[float | None]]:
    named = {"time_s": "time", "charge": "charge", "voltage_V": "voltage"}
    return {
        key: [number_or_none(v) for v in getattr(flown.course, name).ravel().tolist()]
        for key, name in named.items()
    }


def _show_table(
    craft: Aircraft, legs: Mission, flown: Flown, columns: dict[str, Any], output: Path | None
) -> None:
    cells = [[digits(v) for v in values] for values in columns.values()]
    heads = "until [s]|V [m/s]|climb [m/s]|time [s]|pitch [deg]|P [W]|energy [J]|charge|U [V]"
    body = grid(
        f"{heads}|<status",
        zip(*cells, flown.status.tolist(), strict=True),
        f"mission {legs.source}",
        "charge, U: state of charge (1 when full) and the battery's voltage at the end of the leg",
    )
    lost = ~flown.lasted
    told = f"{np.sum(flown.energy) / 3600.0:.4g} Wh in {legs.duration.sum() / 60.0:.4g} min"
    if lost.any():
        leg = int(np.argmax(lost))
        told = f"leg {leg + 1} cannot be flown to its end: {flown.told(leg)}"
    show(output, title(craft), body, told)
