"""``propmap export VEHICLE.toml --table MAP.npz --to c|rotorpy``: force and moment on a vehicle."""

from __future__ import annotations

from pathlib import Path

import typer

from propmap.cli.aircraft_options import vehicle_of
from propmap.errors import InputError


def is_vehicle(path: Path) -> bool:
    """Whether the file at ``path`` is a vehicle's: TOML with a table ``[[rotors]]``."""
    import tomllib

    if path.suffix.lower() != ".toml":
        return False
    try:
        return "rotors" in tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False


def export_wrench(
    source: Path, to: str, output: Path, *, table: Path | None, no_wakes: bool, replace: bool
) -> None:
    """Write force and moment on the vehicle file ``source`` for the target ``to``."""
    from propmap.export import VEHICLE_TARGETS, check_folder, export_vehicle
    from propmap.table import LoadTable

    if to not in VEHICLE_TARGETS:
        raise InputError(
            f"this is a vehicle file, and {to} is written of a map alone",
            f"give the map, or --to {', '.join(VEHICLE_TARGETS)}, px4 or ardupilot",
            str(source),
        )
    if table is None:
        raise InputError(
            "this is a vehicle file, and the loads of its rotors are not given",
            "build a map with propmap table and give it as --table MAP.npz",
            str(source),
        )
    check_folder(output)
    vehicle, loads = vehicle_of(source, no_wakes=no_wakes), LoadTable.load(table)
    try:
        paths = export_vehicle(vehicle, loads, to, output, replace=replace)
    except InputError as error:
        raise InputError(error.found, error.remedy, error.where or str(source)) from None
    for path in paths:
        typer.echo(f"wrote {path}")
