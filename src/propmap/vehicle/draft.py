"""Draft of a vehicle file from the parameters of a PX4 log, with marks for missing entries."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from propmap.errors import InputError, require
from propmap.typing import Floats
from propmap.vehicle.allocation import Allocation
from propmap.vehicle.log_readers import COMMANDS, OUTPUTS, ROTORS, parsed_ulog

UP = (0.0, 0.0, -1.0)  # in FRD
FIELDS = {"PX": 0.0, "PY": 0.0, "PZ": 0.0, "AX": UP[0], "AY": UP[1], "AZ": UP[2], "KM": 0.05}
"""Parameters of a rotor after "CA_ROTORn_", with PX4's defaults, since logs may omit these."""

MASS = "WEIGHT_GROSS"  # [kg], -1 if it was not set
MISSING = "# MISSING: "


def draft_vehicle(path: Path) -> tuple[str, list[str]]:
    """Return the TOML text of a vehicle file drafted from a ULog file, and notes on it.

    Positions, axes and spins of the rotors come from CA_ROTORn_*, the mass from WEIGHT_GROSS.
    Entries that the log does not contain are comments that begin with "MISSING".  The notes list
    these entries, and axes that the rotor speeds do not command.  Raises ``InputError`` if the log
    has no rotor parameters.
    """
    if path.exists() and path.suffix.lower() != ".ulg":
        found = "only ULogs of PX4 contain rotor positions"
        remedy = "write mass, propeller, and [[rotors]] with position and spin by hand"
        raise InputError(found, remedy, str(path))
    if not path.is_file():
        raise InputError("no such file", "give the .ulg file of a flight", str(path))
    require("logs")
    log = parsed_ulog(path)
    stated: Mapping[str, float] = log.initial_parameters
    count = int(stated.get("CA_ROTOR_COUNT", 0))
    if count < 1:
        found = "the log has no rotor parameters: CA_ROTOR_COUNT is missing or 0"
        remedy = "give a log of PX4 1.14 or later with rotor positions, or write the file by hand"
        raise InputError(found, remedy, str(path))
    mass = float(stated.get(MASS, -1.0))
    rotors = [
        {name: float(stated.get(f"CA_ROTOR{k}_{name}", FIELDS[name])) for name in FIELDS}
        for k in range(count)
    ]
    places, axes = (
        np.array([[one[f"{kind}{letter}"] for letter in "XYZ"] for one in rotors]) for kind in "PA"
    )
    allocation = Allocation.of(places, axes, np.array([one["KM"] for one in rotors]))
    # PX4's generic airframes have coordinates of 0 or 1 m instead of measured positions.
    generic = bool(np.isin(np.abs(places), (0.0, 1.0)).all())
    lines = [
        f'# Drafted from {path.name} by "propmap vehicle from-log": fill in the MISSING entries.',
        "schema = 1",
        f'name = "{_plain(path.stem)}"',
        'frame = "frd"  # of the positions: x forward, y right, z down',
        f"mass = {mass:.6g}  # kg, {MASS}: check that it includes the battery"
        if mass > 0.0
        else f"{MISSING}mass = 1.0  # kg, including the battery",
        f'{MISSING}propeller = "apc-8x6e"  # a name of `propmap props` or a geometry file',
    ]
    for number, (one, place, axis) in enumerate(zip(rotors, places, axes, strict=True), start=1):
        where = f"position = {_numbers(place)}"
        length = float(np.linalg.norm(axis))
        lines += [
            "",
            f"[[rotors]]  # motor {number} of PX4",
            f"{MISSING}{where}  # m; PX4's generic position" if generic else where,
            f'spin = "{"ccw" if one["KM"] > 0.0 else "cw"}"',
        ]
        if length > 0.0 and not np.allclose(axis / length, UP, atol=1e-3):
            lines.append(f"axis = {_numbers(axis / length)}")
    lines += ["", "[log]", _rotor_unit({data.name for data in log.data_list}), ""]
    missing = dict.fromkeys(line.split()[2] for line in lines if line.startswith(MISSING))
    note = f"fill in the values that the log does not contain: {', '.join(missing)}"
    return "\n".join(lines), [note, *allocation.notes]


def _rotor_unit(topics: set[str]) -> str:
    """Return the [log] line for the rotor speeds, or the commands, of a log with these topics."""
    unit = 'rotor_unit = "rpm"  # for electrical speeds: "erpm", and add pole_pairs'
    if ROTORS in topics:
        return unit
    commands = [name for name in (COMMANDS, OUTPUTS) if name in topics]
    if commands:
        return f"# no {ROTORS} in the log: `propmap fit flight` uses the throttle of {commands[0]}"
    return f"{MISSING}{unit}; no {ROTORS}, {COMMANDS} or {OUTPUTS} in the log"


def _numbers(values: Floats) -> str:
    """Return the values, which PX4 stores as 32-bit floats, as a TOML list."""
    return f"[{', '.join(str(float(f'{value:.6g}') + 0.0) for value in values)}]"


def _plain(text: str) -> str:
    """Return a text without characters that a TOML string must escape."""
    return "".join(c if c.isprintable() and c not in '"\\' else "_" for c in text)
