"""A flight as arrays on one clock, in the vehicle's frame: x forward, y left, z up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.typing import Floats

GRAVITY = 9.80665
"""[m/s^2], the standard value."""


@dataclass(frozen=True, eq=False)
class FlightLog:
    """Samples of a flight, or operating points averaged from one; n of them.

    Attributes
    ----------
    source : str
        Where they come from, for messages and reports.
    time : ndarray, shape (n,)
        Rising [s].
    velocity : ndarray, shape (n, 3)
        Of the centre of mass through the air, in the vehicle's frame [m/s].
    rates : ndarray, shape (n, 3)
        Angular velocity in the vehicle's frame [rad/s].
    up : ndarray, shape (n, 3)
        Unit vector against gravity, in the vehicle's frame [-].
    specific_force : ndarray, shape (n, 3)
        What an accelerometer at the centre of mass reads, +g along ``up`` in hover [m/s^2]; NaN
        where it was not measured.
    rotor_speed : ndarray, shape (n, rotors)
        Rotational speeds [rad/s], >= 0.
    angular_acceleration : ndarray, shape (n, 3)
        Time derivative of ``rates`` [rad/s^2]; NaN where it is not known.
    specific_force_rate : ndarray, shape (n, 3)
        Time derivative of ``specific_force`` [m/s^3]; NaN where it is not known.
    rotor_acceleration : ndarray, shape (n, rotors)
        Time derivative of ``rotor_speed`` [rad/s^2]; NaN where it is not known.
    flight : ndarray, shape (n,)
        Number of the flight among several that were joined, from 0.
    flights : tuple of str
        Names of the flights, by number.
    """

    source: str
    time: Floats
    velocity: Floats
    rates: Floats
    up: Floats
    specific_force: Floats
    rotor_speed: Floats
    angular_acceleration: Floats = None  # type: ignore[assignment]
    specific_force_rate: Floats = None  # type: ignore[assignment]
    rotor_acceleration: Floats = None  # type: ignore[assignment]
    flight: Floats = None  # type: ignore[assignment]
    flights: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        unknown = np.full_like(self.rates, np.nan)
        for name in ("angular_acceleration", "specific_force_rate"):
            if getattr(self, name) is None:
                object.__setattr__(self, name, unknown)
        if self.rotor_acceleration is None:
            object.__setattr__(self, "rotor_acceleration", np.full_like(self.rotor_speed, np.nan))
        if self.flight is None:
            object.__setattr__(self, "flight", np.zeros_like(self.time))
        if not self.flights:
            count = int(self.flight.max(initial=0.0)) + 1
            object.__setattr__(self, "flights", tuple(str(k + 1) for k in range(count)))

    def __len__(self) -> int:
        return int(self.time.size)

    def picked(self, which: Any) -> FlightLog:
        """Some of the samples: ``which`` is a mask or indices."""
        return self.with_each(lambda array: array[which])

    def with_each(self, change: Callable[[Floats], Floats]) -> FlightLog:
        """The same log with a ``change`` to every array, which may alter the number of samples."""
        arrays: dict[str, Any] = {name: change(getattr(self, name)) for name in ARRAYS}
        return replace(self, **arrays)

    @property
    def speed(self) -> Floats:
        """Speed through the air [m/s]; (n,)."""
        return np.asarray(np.linalg.norm(self.velocity, axis=1))

    @property
    def since_start(self) -> Floats:
        """Time since the flight of each sample began [s]; (n,)."""
        numbers, place = np.unique(self.flight, return_inverse=True)
        first = np.array([self.time[self.flight == number].min() for number in numbers])
        return np.asarray(self.time - first[place])

    def stretches(self, seconds: float) -> NDArray[np.intp]:
        """Number of the stretch of so many ``seconds`` [s] in which each sample is; (n,).

        Stretches of different flights are different, whatever their clocks say.
        """
        of = np.stack([self.flight, self.since_start // seconds])
        return np.unique(of, axis=1, return_inverse=True)[1].ravel()

    @property
    def climb_rate(self) -> Floats:
        """Vertical velocity, up positive [m/s]; (n,)."""
        return np.asarray(np.sum(self.velocity * self.up, axis=1))


ARRAYS = tuple(f.name for f in fields(FlightLog) if f.name not in ("source", "flights"))
"""Fields that have a row for each sample."""


def joined(logs: list[FlightLog], names: tuple[str, ...] = ()) -> FlightLog:
    """Several logs of one vehicle as one, in the order given; their clocks are kept.

    The flights get these ``names``, or else are numbered.
    """
    logs = [replace(log, flight=np.full_like(log.time, k)) for k, log in enumerate(logs)]
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(log, name) for log in logs]) for name in ARRAYS
    }
    return FlightLog(source=", ".join(log.source for log in logs), **arrays, flights=names)


def in_vehicle_frame(
    forward: Floats | float, left: Floats | float, up: Floats | float, pitch: Floats, roll: Floats
) -> Floats:
    """Vectors with horizontal and vertical components, in the frame of a tilted vehicle; (..., 3).

    Components are (...) or numbers.  ``pitch`` (...) [rad] is about the left, positive where the
    top leans forward; ``roll`` (...) [rad] is about the vehicle's x axis, after the pitch, positive
    right side down.
    """
    # Pitch turns about y to the left, z towards x; roll then about x, y towards z.
    x = forward * np.cos(pitch) - up * np.sin(pitch)
    below = forward * np.sin(pitch) + up * np.cos(pitch)
    y, z = left * np.cos(roll) + below * np.sin(roll), below * np.cos(roll) - left * np.sin(roll)
    return np.stack([x, y, z], axis=-1)


def pitch_and_roll(up: Floats) -> tuple[Floats, Floats]:
    """Pitch and roll [rad] as in ``in_vehicle_frame``, (n,), where ``up`` (n, 3) is vertical."""
    return -np.arcsin(np.clip(up[:, 0], -1.0, 1.0)), np.arctan2(up[:, 1], up[:, 2])
