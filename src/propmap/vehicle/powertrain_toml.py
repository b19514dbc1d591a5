"""The tables ``[motor]``, ``[esc]`` and ``[battery]`` of a vehicle file."""

from __future__ import annotations

import math
from typing import Any

from propmap.errors import InputError, quoted
from propmap.io.toml_table import TomlTable
from propmap.vehicle.battery import Battery
from propmap.vehicle.motor import COLD, RPM, Motor
from propmap.vehicle.powertrain import Powertrain
from propmap.vehicle.speed_controller import SpeedController

MOTOR_KEYS = (
    "kv_rpm_per_volt",
    "resistance",
    "no_load_current",
    "no_load_voltage",
    "maximum_current",
    "maximum_rpm",
    "winding_temperature",
)
ESC_KEYS = ("resistance", "efficiency")
BATTERY_KEYS = (
    "cells",
    "capacity_mAh",
    "resistance",
    "usable_share",
    "maximum_current",
    "auxiliary_power",
)
KEYS = ("motor", "esc", "battery")


def read_powertrain(top: TomlTable, radius: float) -> Powertrain:
    """The powertrain of a vehicle file.

    ``[motor]`` ``kv_rpm_per_volt``, ``resistance`` [ohm], ``no_load_current`` [A] and, optional,
    ``no_load_voltage`` [V] at which that was measured (either may be a list of up to three),
    ``maximum_current`` [A], ``maximum_rpm``, ``winding_temperature`` [degrees C];
    ``[esc]`` ``resistance`` [ohm] or ``efficiency``; ``[battery]`` ``cells``, ``capacity_mAh``,
    and, optional, ``resistance`` [ohm] of the pack, ``usable_share``, ``maximum_current`` [A],
    ``auxiliary_power`` [W].

    Parameters
    ----------
    top : TomlTable
        The whole file.
    radius : float
        Of the rotors [m].

    Raises
    ------
    InputError
        Naming the table and the key.
    """
    made = Powertrain(
        motor=_motor(top) if "motor" in top else None,
        controller=_controller(top) if "esc" in top else None,
        battery=_battery(top) if "battery" in top else None,
    )
    made.check_blade(radius)
    return made


def _located(table: TomlTable, kind: Any, *values: Any) -> Any:
    try:
        return kind(*values)
    except InputError as error:
        raise InputError(error.found, error.remedy, table.where) from None


def _motor(top: TomlTable) -> Motor:
    table = top.table("motor", MOTOR_KEYS)
    kv = table.number("kv_rpm_per_volt", "920, revolutions per minute and volt")
    resistance = table.number("resistance", "0.1, the winding's ohms")
    if resistance > 10.0:
        raise InputError(
            f"resistance is {resistance:g} ohm", "give ohms, not milliohms", table.where
        )
    found: Motor = _located(
        table,
        Motor,
        kv * RPM,
        resistance,
        _one_or_more(table, "no_load_current", "0.6, amperes"),
        _one_or_more(table, "no_load_voltage", "10, volts") if "no_load_voltage" in table else (),
        _or_infinite(table, "maximum_current", "20, amperes"),
        _or_infinite(table, "maximum_rpm", "12000") * RPM,
        table.number("winding_temperature", "80, degrees C", COLD),
    )
    return found


def _controller(top: TomlTable) -> SpeedController:
    table = top.table("esc", ESC_KEYS)
    if len(table.entries) != 1:
        raise InputError(
            f"{len(table.entries)} keys in [esc]", "give resistance or efficiency", table.where
        )
    found: SpeedController = _located(
        table,
        SpeedController,
        table.number("resistance", "0.01, ohms", 0.0),
        table.number("efficiency", "0.95, a share", 1.0),
    )
    if found.resistance > 1.0:
        raise InputError(
            f"resistance is {found.resistance:g} ohm", "give ohms, not milliohms", table.where
        )
    return found


def _battery(top: TomlTable) -> Battery:
    table = top.table("battery", BATTERY_KEYS)
    cells = table.need("cells", "4, those in series")
    capacity = table.number("capacity_mAh", "5000")
    if 0.0 < capacity < 50.0:
        raise InputError(
            f"capacity_mAh is {capacity:g}",
            f"give milliampere hours: {1000.0 * capacity:g}, if this is A h",
            table.where,
        )
    resistance = table.number("resistance", "0.02, ohms of the pack", 0.0)
    if resistance > 2.0:
        raise InputError(
            f"resistance is {resistance:g} ohm", "give ohms, not milliohms", table.where
        )
    found: Battery = _located(
        table,
        Battery,
        cells,
        capacity * 3.6,
        resistance,
        table.number("usable_share", "0.8", Battery.usable_share),
        _or_infinite(table, "maximum_current", "60, amperes"),
        table.number("auxiliary_power", "5, watts", Battery.auxiliary_power),
    )
    return found


def _one_or_more(table: TomlTable, key: str, example: str) -> tuple[float, ...]:
    if isinstance(table.need(key, example), list):
        found = tuple(table.numbers(key).tolist())
        if not all(map(math.isfinite, found)):
            raise InputError(f"{key} is {quoted(list(found))}", f"give {example}", table.where)
        return found
    return (table.number(key, example),)


def _or_infinite(table: TomlTable, key: str, example: str) -> float:
    return table.number(key, example) if key in table else math.inf
