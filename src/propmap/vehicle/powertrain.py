"""Motors, speed controllers and battery: current, voltage and power for torque and speed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from propmap.errors import InputError
from propmap.typing import Floats
from propmap.units import RPM

# --- The powertrain from battery to shaft: motor, speed controller and battery -------------------

USUAL_TIP_SPEED = (60.0, 900.0)
"""Plausible tip speeds [m/s] with an unloaded motor at full charge.  If rad/s/V and rpm/V are
confused, Kv is wrong by a factor of ten."""


class ElectricState(NamedTuple):
    """Electrical quantities of n states of m motors; NaN if the required component is unknown."""

    motor_current: Floats  # (n, m) [A]
    controller_voltage: Floats  # least battery voltage for this motor state, (n, m) [V]
    power: Floats  # at the battery's terminals, (n,) [W]
    battery_current: Floats  # (n,) [A]
    battery_voltage: Floats  # (n,) [V]


@dataclass(frozen=True)
class Powertrain:
    """Motors, speed controllers and battery of a vehicle; None for unknown components.

    Attributes
    ----------
    motor : Motor or None
        Motor of every rotor.
    controller : SpeedController or None
        Controller of every motor; None for a controller without losses.
    battery : Battery or None
        Battery of all motors.

    Raises
    ------
    InputError
        For a battery or a controller without a motor.
    """

    motor: Motor | None = None
    controller: SpeedController | None = None
    battery: Battery | None = None

    def __post_init__(self) -> None:
        if self.motor is None and (self.battery or self.controller):
            has = "[battery]" if self.battery else "[esc]"
            remedy = f"add [motor], or remove {has}: without a motor only shaft power is known"
            raise InputError(f"the file has {has}, but no [motor]", remedy)

    def check_blade(self, radius: float) -> None:
        """Raise ``InputError`` for a Kv with an implausible tip speed at this ``radius`` [m]."""
        if self.motor is None or self.battery is None:
            return
        kv = self.motor.speed_constant
        full = float(self.battery.open_circuit_voltage(np.ones(())))
        tip = kv * full * radius
        low, high = USUAL_TIP_SPEED
        if not low <= tip <= high:
            unit = "in rad/s/V? multiply by 9.549" if tip < low else "of another motor?"
            raise InputError(
                f"kv_rpm_per_volt is {kv / RPM:g}: the no-load tip speed at {full:.1f} V would be "
                f"{tip:.0f} m/s",
                f"check kv ({unit}), cells, and the propeller's size",
            )

    def driven(self, torque: Floats, omega: Floats, charge: float) -> ElectricState:
        """Return currents, voltages and power for ``torque`` [N m] and ``omega`` [rad/s], (n, m).

        ``charge`` is the battery's state of charge, 0 to 1.  The sign of ``omega`` has no effect.
        """
        torque, omega = np.copysign(1.0, omega) * torque, np.abs(omega)
        nothing, unknown = np.full(torque.shape[:1], math.nan), np.full_like(torque, math.nan)
        if self.motor is None:
            return ElectricState(unknown, unknown, nothing, nothing, nothing)
        controller = self.controller or SpeedController()
        state = self.motor.driven(torque, omega)
        power = controller.power(state).sum(axis=1)
        voltage = controller.voltage(state)
        if self.battery is None:
            return ElectricState(state.current, voltage, power, nothing, nothing)
        power = power + self.battery.auxiliary_power
        full = np.full_like(power, charge)
        current = self.battery.current(power, full)
        return ElectricState(
            state.current, voltage, power, current, self.battery.voltage(power, full)
        )


# --- Model of a brushless motor: Kv, winding resistance and no-load current ----------------------

COPPER = 0.00393
"""Temperature coefficient of the resistance of copper at 20 degrees C [1/K]: IEC 60028."""

COLD = 20.0  # winding temperature of the resistance in data sheets [degrees C]


class MotorState(NamedTuple):
    """Current and voltage of a motor, in the shape of its load."""

    current: Floats  # [A]
    voltage: Floats  # [V]

    @property
    def power(self) -> Floats:
        """Electrical power of the motor [W]."""
        return self.current * self.voltage


@dataclass(frozen=True)
class Motor:
    """The equivalent circuit of a DC motor: a back-EMF behind a resistance.

    The equations are omega = Kv (v - i R) and Q = (i - i_0) / Kv, with Kv in rad/s/V.  The no-load
    current i_0(omega) represents iron losses and friction.  Source: M. Drela, First-Order DC
    Electric Motor Model, MIT Aero & Astro, 2007; for i_0 as a function of omega, Second-Order DC
    Electric Motor Model, 2006.

    Attributes
    ----------
    speed_constant : float
        Kv without load [rad/s/V].
    resistance : float
        Resistance of the winding at 20 degrees C [ohm].
    no_load_current : tuple of float
        i_0 [A], measured at one to three voltages.
    no_load_voltage : tuple of float
        Voltage of each no-load current [V].  It may be empty for a single current, which is then
        used at all speeds.
    maximum_current : float
        Maximum current [A]; infinite if unknown.
    maximum_speed : float
        Maximum speed [rad/s]; infinite if unknown.
    temperature : float
        Temperature of the winding in flight [degrees C].

    Raises
    ------
    InputError
        For impossible values.
    """

    speed_constant: float
    resistance: float
    no_load_current: tuple[float, ...]
    no_load_voltage: tuple[float, ...] = ()
    maximum_current: float = math.inf
    maximum_speed: float = math.inf
    temperature: float = COLD

    def __post_init__(self) -> None:
        for name, value, meaning in (
            ("kv", self.speed_constant, "the speed constant of the data sheet in rpm per volt"),
            ("resistance", self.resistance, "the ohms of the winding between two of three wires"),
            ("maximum_current", self.maximum_current, "amperes, or leave it out"),
            ("maximum_rpm", self.maximum_speed, "revolutions per minute, or leave it out"),
        ):
            if not value > 0.0:
                raise InputError(f"{name} is {value:g}", f"give {meaning}, above 0")
        currents, voltages = self.no_load_current, self.no_load_voltage
        if not currents or min(currents) < 0.0:
            raise InputError("no_load_current is negative or empty", "give amperes, 0 or more")
        if (len(currents) > 1 or voltages) and len(currents) != len(voltages):
            found = f"{len(currents)} no_load_current for {len(voltages)} no_load_voltage"
            raise InputError(found, "give one voltage for each current")
        if len(currents) > 3 or len(set(voltages)) != len(voltages):
            fault = f"no_load_voltage is {list(voltages)}"
            raise InputError(fault, "give one, two or three voltages, each once")
        if any(v <= i * self.resistance for i, v in zip(currents, voltages, strict=False)):
            found = "resistance times no_load_current exceeds the no_load_voltage"
            raise InputError(found, "give volts and amperes, and ohms, not milliohms")
        if not -60.0 <= self.temperature <= 250.0:
            found = f"temperature is {self.temperature:g} degrees C"
            raise InputError(found, "give the temperature of the winding in flight, -60 to 250")

    @property
    def hot_resistance(self) -> float:
        """Resistance of the winding at its temperature [ohm]."""
        return self.resistance * (1.0 + COPPER * (self.temperature - COLD))

    def idle_current(self, omega: Floats) -> Floats:
        """Return i_0 [A] at ``omega`` [rad/s], by a polynomial through the measured currents."""
        if len(self.no_load_current) == 1:
            return np.full_like(omega, self.no_load_current[0])
        i, v = np.array(self.no_load_current), np.array(self.no_load_voltage)
        speeds = self.speed_constant * (v - i * self.resistance)
        scale = speeds.max()
        fit = np.linalg.solve(np.vander(speeds / scale), i)
        # The polynomial may become negative at speeds outside the measured range.
        return np.asarray(np.maximum(np.polyval(fit, omega / scale), 0.0))

    def driven(self, torque: Floats, omega: Floats) -> MotorState:
        """Return current and voltage for a ``torque`` [N m] at ``omega`` [rad/s]."""
        current = self.speed_constant * torque + self.idle_current(omega)
        return MotorState(current, omega / self.speed_constant + current * self.hot_resistance)


# -------------------------------------------------------------------------------------------------
# Model of a lithium-polymer battery: open-circuit voltage, resistance, usable fraction of charge.

NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)  # for the integral over the charge
HALVINGS = 60


def cell_voltage(charge: Floats) -> Floats:
    """Return the open-circuit voltage [V] of a lithium-polymer cell at a ``charge`` of 0 to 1.

    Source: M. Chen, G. A. Rincon-Mora, Accurate Electrical Battery Model Capable of Predicting
    Runtime and I-V Performance, IEEE Trans.  Energy Conversion 21(2), 2006, doi
    10.1109/TEC.2006.874229; 4.10 V when full.
    """
    s = charge
    return np.asarray(
        -1.031 * np.exp(-35.0 * s) + 3.685 + 0.2156 * s - 0.1178 * s**2 + 0.3201 * s**3
    )


@dataclass(frozen=True)
class Battery:
    """Cells in series with a resistance.

    Attributes
    ----------
    cells : int
        Number of cells in series.
    capacity : float
        Capacity of the pack [A s].
    resistance : float
        Resistance of the pack [ohm].
    usable_share : float
        Fraction of the charge that a flight may use [-].
    maximum_current : float
        Maximum current [A]; infinite if unknown.
    auxiliary_power : float
        Power of all consumers except the motors [W].

    Raises
    ------
    InputError
        For impossible values.
    """

    cells: int
    capacity: float
    resistance: float = 0.0
    usable_share: float = 0.8
    maximum_current: float = math.inf
    auxiliary_power: float = 0.0

    def __post_init__(self) -> None:
        if type(self.cells) is not int or not 1 <= self.cells <= 200:
            found = f"cells is {self.cells!r}"
            raise InputError(found, "give the number in series, 1 to 200; 4 for a 4S pack")
        if not self.capacity > 0.0:
            raise InputError(f"capacity is {self.capacity / 3600.0:g} A h", "give A h above 0")
        if not self.resistance >= 0.0:
            raise InputError(f"resistance is {self.resistance:g} ohm", "give 0 or more")
        if not 0.0 < self.usable_share <= 1.0:
            found = f"usable_share is {self.usable_share:g}"
            raise InputError(found, "give a fraction such as 0.8, not percent")
        if not self.maximum_current > 0.0:
            found = f"maximum_current is {self.maximum_current:g} A"
            raise InputError(found, "give more than 0, or leave it out")
        if not self.auxiliary_power >= 0.0:
            raise InputError(f"auxiliary_power is {self.auxiliary_power:g} W", "give 0 or more")

    def open_circuit_voltage(self, charge: Floats) -> Floats:
        """Return the voltage of the pack [V] at a ``charge`` of 0 to 1."""
        return self.cells * cell_voltage(charge)

    def current(self, power: Floats, charge: Floats) -> Floats:
        """Return the current for a power; NaN if the battery cannot deliver the power.

        It is the smaller root of power = (V_oc - i R) i.

        Parameters
        ----------
        power : ndarray
            Power at the terminals [W].
        charge : ndarray
            State of charge, 0 to 1, of the same shape or a number.

        Returns
        -------
        ndarray
            Current [A].
        """
        voltage = self.open_circuit_voltage(charge)
        left = voltage**2 - 4.0 * self.resistance * power
        with np.errstate(invalid="ignore"):
            return 2.0 * power / (voltage + np.sqrt(np.where(left >= 0.0, left, np.nan)))

    def voltage(self, power: Floats, charge: Floats) -> Floats:
        """Return the terminal voltage [V] at this ``power`` [W] and ``charge``."""
        current = self.current(power, charge)
        return self.open_circuit_voltage(charge) - self.resistance * current

    def voltage_or_least(self, power: Floats, charge: Floats) -> Floats:
        """Return the terminal voltage [V] at ``charge`` and ``power`` [W], at most the maximum."""
        least = 0.5 * self.open_circuit_voltage(charge)
        return np.where(np.isnan(found := self.voltage(power, charge)), least, found)

    def share_used(self, power: Floats, charge: Floats) -> Floats:
        """Return the larger of ``power`` and current at ``charge`` as fractions of their limits."""
        voltage = self.open_circuit_voltage(charge)
        of_power = 4.0 * self.resistance * np.maximum(power, 0.0) / voltage**2
        current = np.nan_to_num(self.current(power, charge), nan=0.0)
        return np.maximum(of_power, current / self.maximum_current)

    def charge_after(self, power: Floats, duration: Floats, charge: Floats) -> Floats:
        """Return the charge after a ``duration`` [s] at constant ``power`` [W], from ``charge``.

        All arrays have one shape.  The result is NaN if the battery does not last this long.
        """
        low, high = np.zeros_like(charge), np.array(charge)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            later = self._time(power, charge, middle)
            late = ~(later <= duration)
            low, high = np.where(late, middle, low), np.where(late, high, middle)
        return np.where(self._time(power, charge, high) >= duration * (1.0 - 1e-9), high, np.nan)

    def endurance(self, power: Floats, voltage: Floats, charge: float = 1.0) -> Floats:
        """Return the flight time at constant power, until the usable charge is consumed.

        Parameters
        ----------
        power : ndarray
            Power at the terminals [W].
        voltage : ndarray
            Least voltage at which the motors turn fast enough [V]; the flight ends earlier if the
            voltage falls below it.
        charge : float
            State of charge at the start.

        Returns
        -------
        ndarray
            Flight time [s]; NaN if the flight cannot start, infinite without power.
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
        """Return the time from one state of charge to a lower one [s]."""
        half = 0.5 * (start - end)
        charges = end + half * (1.0 + NODES.reshape(-1, *np.ones_like(power.shape)))
        with np.errstate(divide="ignore"):
            rates = 1.0 / self.current(power, charges)
        return self.capacity * half * np.tensordot(WEIGHTS, rates, axes=(0, 0))


# --- Model of the losses in an electronic speed controller ---------------------------------------


@dataclass(frozen=True)
class SpeedController:
    """A speed controller with a resistance in series with the motor, or with an efficiency.

    The controller is a chopper: it draws the motor's power from the battery at the battery's
    voltage.  The lower efficiency at part throttle is not modeled: see C. R. Green, R. A. McDonald,
    Modeling and Test of the Efficiency of Electronic Speed Controllers for Brushless DC Motors,
    AIAA 2015-3191, doi 10.2514/6.2015-3191.

    Attributes
    ----------
    resistance : float
        Resistance at full throttle [ohm].
    efficiency : float
        Motor power over battery power, without the losses in the resistance [-].

    Raises
    ------
    InputError
        For a negative resistance, or an efficiency outside 0.5 to 1.
    """

    resistance: float = 0.0
    efficiency: float = 1.0

    def __post_init__(self) -> None:
        if not self.resistance >= 0.0:
            raise InputError(f"resistance is {self.resistance:g} ohm", "give 0 or more")
        if not 0.5 <= self.efficiency <= 1.0:
            found = f"efficiency is {self.efficiency:g}"
            raise InputError(found, "give a fraction from 0.5 to 1, such as 0.95")

    def power(self, motor: MotorState) -> Floats:
        """Return the power drawn from the battery for a ``motor`` in this state [W]."""
        return (motor.power + self.resistance * motor.current**2) / self.efficiency

    def voltage(self, motor: MotorState) -> Floats:
        """Return the battery voltage [V] for a ``motor`` in this state at full throttle."""
        return motor.voltage + self.resistance * motor.current
