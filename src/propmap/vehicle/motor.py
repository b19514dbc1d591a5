"""A brushless motor by its Kv, winding resistance and no-load current."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from propmap.errors import InputError
from propmap.typing import Floats

RPM = math.pi / 30.0
"""One revolution per minute [rad/s]."""

COPPER = 0.00393
"""[1/K] by which the resistance of copper grows, from that at 20 degrees C: IEC 60028."""

COLD = 20.0
"""[degrees C] at which the resistance of a data sheet holds."""


class MotorState(NamedTuple):
    """What goes into a motor: ``current`` [A] and ``voltage`` [V], of the shape of its load."""

    current: Floats
    voltage: Floats

    @property
    def power(self) -> Floats:
        """Into the motor's terminals [W]."""
        return self.current * self.voltage


@dataclass(frozen=True)
class Motor:
    """The equivalent circuit of a DC motor: a back-EMF behind a resistance.

    With omega = Kv (v - i R) and Q = (i - i_0) / Kv, Kv in rad/s/V; i_0(omega) covers iron and
    friction.  Source: M. Drela, First-Order DC Electric Motor Model, MIT Aero & Astro, 2007, and
    Second-Order DC Electric Motor Model, 2006, for an i_0 that depends on omega.

    Attributes
    ----------
    speed_constant : float
        Kv [rad/s/V], without load.
    resistance : float
        Of the winding, at 20 degrees C [ohm].
    no_load_current : tuple of float
        i_0 [A]; more than one where it was measured at several voltages.
    no_load_voltage : tuple of float
        At which these were measured [V], one for each; may be empty for one current, which then
        holds at any speed.
    maximum_current : float
        [A], infinite where none is known.
    maximum_speed : float
        [rad/s], infinite where none is known.
    temperature : float
        Of the winding in flight [degrees C].

    Raises
    ------
    InputError
        For values that no motor has.
    """

    speed_constant: float
    resistance: float
    no_load_current: tuple[float, ...]
    no_load_voltage: tuple[float, ...] = ()
    maximum_current: float = math.inf
    maximum_speed: float = math.inf
    temperature: float = COLD

    def __post_init__(self) -> None:
        for name, value, told in (
            ("kv", self.speed_constant, "revolutions per minute and volt, as the data sheet does"),
            ("resistance", self.resistance, "the winding's ohms, between two of the three wires"),
            ("maximum_current", self.maximum_current, "amperes, or leave it out"),
            ("maximum_rpm", self.maximum_speed, "revolutions per minute, or leave it out"),
        ):
            if not value > 0.0:
                raise InputError(f"{name} is {value:g}", f"give {told}, above 0")
        if not self.no_load_current or min(self.no_load_current) < 0.0:
            raise InputError("no_load_current is negative or empty", "give amperes, 0 or more")
        currents, voltages = len(self.no_load_current), len(self.no_load_voltage)
        if (currents > 1 or voltages) and currents != voltages:
            raise InputError(
                f"{currents} no_load_current for {voltages} no_load_voltage",
                "give the voltage of each current",
            )
        if currents > 3 or len(set(self.no_load_voltage)) != voltages:
            raise InputError(
                f"no_load_voltage is {list(self.no_load_voltage)}",
                "give one, two or three voltages, each once",
            )
        if any(
            v <= i * self.resistance
            for i, v in zip(self.no_load_current, self.no_load_voltage, strict=False)
        ):
            raise InputError(
                "the winding alone takes more than the no_load_voltage",
                "give volts, and the resistance in ohms, not milliohms",
            )
        if not -60.0 <= self.temperature <= 250.0:
            raise InputError(
                f"temperature is {self.temperature:g} degrees C",
                "give that of the winding in flight, -60 to 250",
            )

    @property
    def hot_resistance(self) -> float:
        """Of the winding at its temperature [ohm]."""
        return self.resistance * (1.0 + COPPER * (self.temperature - COLD))

    def idle_current(self, omega: Floats) -> Floats:
        """i_0 [A] at ``omega`` [rad/s]: the polynomial through what was measured."""
        if len(self.no_load_current) == 1:
            return np.full_like(omega, self.no_load_current[0])
        i, v = np.array(self.no_load_current), np.array(self.no_load_voltage)
        speeds = self.speed_constant * (v - i * self.resistance)
        scale = speeds.max()
        fit = np.linalg.solve(np.vander(speeds / scale), i)
        # A parabola through three points must not turn back beyond them.
        return np.asarray(np.maximum(np.polyval(fit, omega / scale), 0.0))

    def driven(self, torque: Floats, omega: Floats) -> MotorState:
        """Current and voltage that turn a shaft.

        Parameters
        ----------
        torque, omega : ndarray
            Of the shaft [N m], [rad/s].
        """
        current = self.speed_constant * torque + self.idle_current(omega)
        return MotorState(current, omega / self.speed_constant + current * self.hot_resistance)
