"""Steady states in the units of files and pictures: m/s, degrees, rpm, N, W, A, V."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from propmap.aircraft.deviations import Spread
from propmap.aircraft.steady_states import SteadyStates
from propmap.typing import Floats

RPM, DEGREES = 30.0 / math.pi, 180.0 / math.pi


class Column(NamedTuple):
    """A quantity of n states: ``values`` (n,) or, of k rotors, (n, k); unit and meaning."""

    values: Floats
    unit: str
    meaning: str


def columns(states: SteadyStates, sure: Spread | None = None) -> dict[str, Column]:
    """All quantities by their names in files.

    Parameters
    ----------
    states : SteadyStates
        Of n.
    sure : Spread, optional
        Their standard deviations, which have columns too.
    """
    return _of_states(states) | ({} if sure is None else _deviations(sure))


def _deviations(sure: Spread) -> dict[str, Column]:
    std = "standard deviation of the "
    return {
        "pitch_std_deg": Column(sure.pitch * DEGREES, "degree", std + "pitch"),
        "rpm_std": Column(sure.rotor_speed * RPM, "1/min", std + "rotational speed"),
        "shaft_power_std_W": Column(sure.shaft_power, "W", std + "shaft power"),
        "electrical_power_std_W": Column(sure.electrical_power, "W", std + "electrical power"),
    }


def _of_states(states: SteadyStates) -> dict[str, Column]:
    return {
        "speed_mps": Column(states.speed, "m/s", "horizontal speed through the air"),
        "climb_mps": Column(states.climb, "m/s", "climb rate"),
        "bank_deg": Column(states.bank * DEGREES, "degree", "bank of the turn, to the right"),
        "pitch_deg": Column(states.pitch * DEGREES, "degree", "pitch, positive nose down"),
        "roll_deg": Column(states.roll * DEGREES, "degree", "roll, positive right side down"),
        "rpm": Column(states.rotor_speed * RPM, "1/min", "rotational speed"),
        "thrust_N": Column(states.thrust, "N", "thrust"),
        "torque_Nm": Column(states.torque, "N m", "shaft torque"),
        "shaft_power_W": Column(states.shaft_power, "W", "power of all shafts"),
        "electrical_power_W": Column(states.electrical_power, "W", "power from the battery"),
        "motor_current_A": Column(states.motor_current, "A", "current of a motor"),
        "throttle": Column(states.throttle, "1", "share of the battery's voltage"),
        "battery_current_A": Column(states.battery_current, "A", "current of the battery"),
        "battery_voltage_V": Column(states.battery_voltage, "V", "voltage under load"),
        "thrust_margin": Column(
            states.thrust_margin, "1", "thrust at the first limit over that which is needed"
        ),
        "residual": Column(states.residual, "1", "unbalanced share of the weight"),
    }


def rows(states: SteadyStates, sure: Spread | None = None) -> list[dict[str, Any]]:
    """One mapping per state, a number per rotor as rpm_1, rpm_2 ...; None for NaN.

    ``states`` and ``sure`` are those of ``columns``.
    """
    flat: dict[str, list[float]] = {}
    for name, column in columns(states, sure).items():
        if column.values.ndim == 1:
            flat[name] = column.values.tolist()
            continue
        # thrust_N of the first rotor is thrust_1_N.
        head, _, unit = name.rpartition("_") if "_" in name else (name, "", "")
        for k, values in enumerate(column.values.T, start=1):
            flat["_".join(filter(None, (head, str(k), unit)))] = values.tolist()
    return [
        dict(zip(flat, (v if np.isfinite(v) else None for v in row), strict=True))
        | {"status": status}
        for row, status in zip(
            zip(*flat.values(), strict=True), states.status.tolist(), strict=True
        )
    ]
