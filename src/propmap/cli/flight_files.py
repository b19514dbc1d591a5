"""LOG arguments of flight fits and checks, as samples or as operating points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from propmap.errors import InputError
from propmap.flight.checks import check_rotor_order, check_rotor_speed, mixed_vehicles
from propmap.flight.steady import (
    airborne,
    is_level_table,
    operating_points,
    read_level_table,
    steady_stretches,
)
from propmap.vehicle.files import VehicleFile
from propmap.vehicle.log import (
    FEWEST_PER_PERIOD,
    FlightLog,
    flight_log,
    flight_names,
    joined,
    low_passed,
)
from propmap.vehicle.log_checks import check_recording
from propmap.vehicle.log_readers import read_recording

if TYPE_CHECKING:
    from propmap.rotor import Rotor

ENOUGH_STRETCHES = 4


@dataclass(frozen=True, eq=False)
class Flights:
    """A log, whether it holds steady operating points alone, and remarks for the report."""

    level: bool
    log: FlightLog
    remarks: tuple[str, ...]


def read_flights(
    paths: Sequence[Path],
    file: VehicleFile,
    method: str,
    *,
    seconds: float,
    samples: int,
    low_pass: float = 0.0,
    picture: Path | None = None,
) -> Flights:
    """Read logs, or tables of operating points, for the method "level", "balance" or "auto".

    Parameters
    ----------
    paths, file : sequence of Path, VehicleFile
        What was flown, and by what.
    method : str
        As in ``propmap fit flight``.
    seconds : float
        Shortest steady stretch [s].
    samples : int
        Of whole flights, at most; more would be no more information, as neighbours err alike.
    low_pass : float
        Cut-off for all signals of whole flights [Hz], 0 for none.
    picture : Path, optional
        Of the steady stretches.
    """
    names = flight_names([str(path) for path in paths])
    if all_level_tables(paths):
        if method == "balance":
            raise InputError(
                "a level-flight table has no accelerations", "fit it with --method level"
            )
        tables = [read_level_table(path, file.vehicle) for path in paths]
        found = [text for table in tables for text in _table_remarks(table, file)]
        return Flights(True, joined(tables, names), tuple(found))
    logs, remarks = _recorded(paths, file)
    if method != "balance":
        points = _points(logs, seconds, picture, needed=method == "level")
        if points is not None:
            return Flights(True, points, tuple(remarks))
        remarks.append(
            f"fewer than {ENOUGH_STRETCHES} steady stretches of {seconds:g} s: the balance of all "
            "forces at all times is fitted instead"
        )
    remarks += [text for log in logs for text in _too_slow_to_filter(log, low_pass)]
    logs = [low_passed(log, low_pass) for log in logs]
    flying = joined([log.picked(airborne(log)) for log in logs], names)
    picked = np.unique(np.linspace(0, len(flying) - 1, min(samples, len(flying))).astype(int))
    return Flights(False, flying.picked(picked), tuple(remarks))


def _recorded(paths: Sequence[Path], file: VehicleFile) -> tuple[list[FlightLog], list[str]]:
    """Logs, and warnings on what they may not be."""
    logs, remarks = [], []
    for path in paths:
        recording = read_recording(path, file)
        remarks += check_recording(recording)
        logs.append(flight_log(recording, file))
        if logs[-1].source != recording.source:
            remarks.append(logs[-1].source)
        remarks += _rpm_remarks(logs[-1], file)
        check_rotor_order(logs[-1], file.vehicle)
    return logs, [*remarks, *mixed_vehicles(logs, file.vehicle)]


def _too_slow_to_filter(log: FlightLog, low_pass: float) -> list[str]:
    rate = 1.0 / float(np.median(np.diff(log.time)))
    needed = FEWEST_PER_PERIOD * low_pass
    if rate >= needed:
        return []
    return [
        f"{log.source}: {rate:.3g} samples per second are too few for a low-pass at {low_pass:g} "
        f"Hz, which takes {needed:g}, and are fitted as they are: log the slowest signal faster, "
        f"or lower --low-pass to {rate / FEWEST_PER_PERIOD:.2g}"
    ]


def _points(
    logs: list[FlightLog], seconds: float, picture: Path | None, *, needed: bool
) -> FlightLog | None:
    found = []
    for log in logs:
        try:
            stretches = steady_stretches(log, seconds=seconds)
        except InputError:
            if needed and len(logs) == 1:
                raise
            continue
        if picture is not None:
            from propmap.report.fit_curves import steady_parts
            from propmap.report.html import save

            save(steady_parts(log, stretches), picture)
        found.append(operating_points(log, stretches))
    if not found or (not needed and sum(len(p) for p in found) < ENOUGH_STRETCHES):
        if needed:
            raise InputError(
                f"no log has a steady stretch of {seconds:g} s",
                "lower --seconds, or use --method balance",
            )
        return None
    return joined(found)


def _table_remarks(table: FlightLog, file: VehicleFile) -> list[str]:
    try:
        return check_rotor_speed(table, _nominal_rotor(file), file.vehicle, "rpm")
    except InputError as error:
        remedy = "give rpm_1, rpm_2 ... in revolutions per minute of the propeller"
        raise InputError(error.found, remedy, table.source) from None


def _rpm_remarks(log: FlightLog, file: VehicleFile) -> list[str]:
    unit = file.log.rotor_unit or ("rpm" if log.source.endswith(".ulg") else None)
    return check_rotor_speed(log, _nominal_rotor(file), file.vehicle, unit)


def _nominal_rotor(file: VehicleFile) -> Rotor:
    from propmap.model.airfoil import parameter_set
    from propmap.model.model import Model
    from propmap.rotor import Rotor

    model = Model(file.vehicle.propeller, parameter_set("paper-apc"), file.vehicle.air)
    return Rotor(model)


def all_level_tables(paths: Sequence[Path]) -> bool:
    """Whether all files are tables of operating points."""
    return all(is_level_table(path) for path in paths)
