"""A lithium-polymer battery: open-circuit voltage by charge, a resistance, a usable share."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from propmap.errors import InputError
from propmap.typing import Floats

NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)
"""Of the integral over charge."""

HALVINGS = 60


def cell_voltage(charge: Floats) -> Floats:
    """Open-circuit voltage [V] of a lithium-polymer cell whose state of ``charge`` is 0 to 1.

    Source: M. Chen, G. A. Rincon-Mora, Accurate Electrical Battery Model Capable of Predicting
    Runtime and I-V Performance, IEEE Trans. Energy Conversion 21(2), 2006, doi
    10.1109/TEC.2006.874229; 4.10 V when full.
    """
    s = charge
    return np.asarray(
        -1.031 * np.exp(-35.0 * s) + 3.685 + 0.2156 * s - 0.1178 * s**2 + 0.3201 * s**3
    )


@dataclass(frozen=True)
class Battery:
    """Cells in series behind a resistance.

    Attributes
    ----------
    cells : int
        In series.
    capacity : float
        Of the pack [A s].
    resistance : float
        Of the pack [ohm].
    usable_share : float
        Of the charge that a flight uses [-].
    maximum_current : float
        [A], infinite where none is known.
    auxiliary_power : float
        What is not for the motors [W].

    Raises
    ------
    InputError
        For values that no battery has.
    """

    cells: int
    capacity: float
    resistance: float = 0.0
    usable_share: float = 0.8
    maximum_current: float = math.inf
    auxiliary_power: float = 0.0

    def __post_init__(self) -> None:
        if type(self.cells) is not int or not 1 <= self.cells <= 200:
            raise InputError(
                f"cells is {self.cells!r}", "give how many are in series, 1 to 200, 4 for a 4S pack"
            )
        if not self.capacity > 0.0:
            raise InputError(f"capacity is {self.capacity / 3600.0:g} A h", "give it, above 0")
        if not self.resistance >= 0.0:
            raise InputError(f"resistance is {self.resistance:g} ohm", "give 0 or more")
        if not 0.0 < self.usable_share <= 1.0:
            raise InputError(
                f"usable_share is {self.usable_share:g}", "give a share such as 0.8, not percent"
            )
        if not self.maximum_current > 0.0:
            raise InputError(
                f"maximum_current is {self.maximum_current:g} A", "give it, or leave it out"
            )
        if not self.auxiliary_power >= 0.0:
            raise InputError(f"auxiliary_power is {self.auxiliary_power:g} W", "give 0 or more")

    def open_circuit_voltage(self, charge: Floats) -> Floats:
        """Of the pack [V] at a state of ``charge`` of 0 to 1."""
        return self.cells * cell_voltage(charge)

    def current(self, power: Floats, charge: Floats) -> Floats:
        """What delivers a power; NaN where the battery cannot.

        The smaller root of power = (V_oc - i R) i.

        Parameters
        ----------
        power : ndarray
            At the terminals [W].
        charge : ndarray
            State of charge, 0 to 1, of the same shape or a number.

        Returns
        -------
        ndarray
            [A].
        """
        voltage = self.open_circuit_voltage(charge)
        left = voltage**2 - 4.0 * self.resistance * power
        with np.errstate(invalid="ignore"):
            return 2.0 * power / (voltage + np.sqrt(np.where(left >= 0.0, left, np.nan)))

    def voltage(self, power: Floats, charge: Floats) -> Floats:
        """At the terminals [V] while it delivers ``power`` [W] at this ``charge``."""
        current = self.current(power, charge)
        return self.open_circuit_voltage(charge) - self.resistance * current

    def voltage_or_least(self, power: Floats, charge: Floats) -> Floats:
        """As ``voltage``, of ``power`` and ``charge``, but that at the largest power beyond it."""
        least = 0.5 * self.open_circuit_voltage(charge)
        return np.where(np.isnan(found := self.voltage(power, charge)), least, found)

    def share_used(self, power: Floats, charge: Floats) -> Floats:
        """Share of the largest power or current that ``power`` at this ``charge`` takes."""
        voltage = self.open_circuit_voltage(charge)
        of_power = 4.0 * self.resistance * np.maximum(power, 0.0) / voltage**2
        current = np.nan_to_num(self.current(power, charge), nan=0.0)
        return np.maximum(of_power, current / self.maximum_current)

    def charge_after(self, power: Floats, duration: float, charge: Floats) -> Floats:
        """State of charge after a time at constant power; NaN where it does not last so long.

        Parameters
        ----------
        power : ndarray
            At the terminals [W].
        duration : float
            [s].
        charge : ndarray
            State of charge at the beginning, 0 to 1.
        """
        low, high = np.zeros_like(charge), np.array(charge)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            later = self._time(power, charge, middle)
            late = ~(later <= duration)
            low, high = np.where(late, middle, low), np.where(late, high, middle)
        return np.where(self._time(power, charge, high) >= duration * (1.0 - 1e-9), high, np.nan)

    def charges(self, power: float, times: Floats, charge: float) -> Floats:
        """States of charge along a time at constant power; NaN from where it does not last.

        Parameters
        ----------
        power : float
            At the terminals [W].
        times : ndarray, shape (m,)
            Rising [s].
        charge : float
            State of charge at time 0.

        Returns
        -------
        ndarray, shape (m,)
            States of charge.
        """
        found, before = [], 0.0
        for time in times.tolist():
            now = np.array(charge)
            charge = float(self.charge_after(np.array(power), time - before, now))
            found.append(charge)
            before = time
        return np.array(found)

    def endurance(self, power: Floats, voltage: Floats, charge: float = 1.0) -> Floats:
        """Time of flight at constant power, until the usable share is used up.

        Parameters
        ----------
        power : ndarray
            At the terminals [W].
        voltage : ndarray
            Below which the motors do not turn fast enough [V]; the flight ends there if it comes
            first.
        charge : float
            State of charge at the beginning.

        Returns
        -------
        ndarray
            [s]; NaN where the flight cannot begin, infinite without power.
        """
        power = np.asarray(power, dtype=np.float64)
        low = np.full_like(power, max(charge - self.usable_share, 0.0))
        high = np.full_like(power, charge)
        begins = self.voltage(power, high) >= voltage
        lasts = self.voltage(power, low) >= voltage
        end = np.array(low)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            enough = self.voltage(power, middle) >= voltage
            low, high = np.where(enough, low, middle), np.where(enough, middle, high)
        end = np.where(lasts, end, high)
        return np.where(begins, self._time(power, np.full_like(power, charge), end), np.nan)

    def _time(self, power: Floats, start: Floats, end: Floats) -> Floats:
        """From one state of charge to a lower one [s]."""
        half = 0.5 * (start - end)
        charges = end + half * (1.0 + NODES.reshape(-1, *np.ones_like(power.shape)))
        with np.errstate(divide="ignore"):
            rates = 1.0 / self.current(power, charges)
        return self.capacity * half * np.tensordot(WEIGHTS, rates, axes=(0, 0))
