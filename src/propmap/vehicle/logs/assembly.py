"""A recording becomes a flight log: one clock, FLU, rotors in the vehicle's order."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.typing import Floats
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.logs import frames
from propmap.vehicle.logs.recording import FEWEST_SAMPLES, Recording, Signal, cleaned
from propmap.vehicle.vehicle_toml import VehicleFile

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

LONGEST_GAP = 0.25
"""Time [s] between two samples of a signal that are still interpolated."""

FASTER = 1.5
"""Samples of a signal per time of the common clock from which it is low-passed first."""

CUTOFF, ORDER = 0.4, 4
"""Of that low-pass, per sample of the common clock, and of the Butterworth filter, applied twice:
what the clock can show passes, vibrations that it would show as something slower do not."""


def flight_log(
    recording: Recording, vehicle_file: VehicleFile, rate: float | None = None
) -> FlightLog:
    """The log in the vehicle's frame, ``rate`` [1/s] times a second.

    Without a rate, at the sample times of the slowest of attitude, velocity and rotor speed.  The
    sign that some logs give to the spin of a rotor is dropped.  Raises ``InputError``, also where
    the accelerometer says that the frames or its unit cannot be as stated.
    """
    logged, rotors = recording.rotor_speed.values.shape[1], len(vehicle_file.vehicle.mounts)
    if logged != rotors:
        raise InputError(
            f"the log has {logged} rotor speeds, the vehicle has {rotors} rotors",
            "give a [[rotors]] table per rotor, or the log of this vehicle",
            recording.source,
        )
    recording = cleaned(recording)
    leading = [recording.attitude, recording.velocity, recording.rotor_speed]
    following = [recording.rates]
    if recording.specific_force is not None:
        following.append(recording.specific_force)
    time = common_clock(leading, following, recording.source, rate)
    signal = recording.attitude
    smooth = Signal(signal.name, signal.time, frames.continuous(signal.values))
    attitude = frames.attitude_to_flu_enu(
        interpolated(smooth, time), recording.body_frame, recording.world_frame
    )
    result = FlightLog(
        source=recording.source,
        time=time,
        velocity=_air_velocity(recording, vehicle_file, time, attitude),
        rates=_in_body(recording, recording.rates, time),
        up=_in_flu(attitude, np.tile([0.0, 0.0, 1.0], (time.size, 1))),
        specific_force=_in_body(recording, recording.specific_force, time),
        rotor_speed=_rotor_speed(recording, vehicle_file, time),
    )
    _check_frames(result, vehicle_file)
    return result


def common_clock(
    leading: Sequence[Signal],
    following: Sequence[Signal],
    source: str,
    rate: float | None = None,
) -> Floats:
    """Times [s] at which all signals are known; (n,), rising.

    Without a ``rate`` [1/s], the sample times of the slowest of the ``leading`` signals.
    Times inside a gap of any signal longer than 0.25 s are left out: gaps are cut, not bridged.
    Raises ``InputError`` where nothing is left.
    """
    signals = [*leading, *following]
    for signal in signals:
        step = float(np.median(np.diff(signal.time)))
        if step > LONGEST_GAP:
            raise InputError(
                f"{signal.name} comes every {step:.3g} s, expected every {LONGEST_GAP:g} s or less",
                "log it at a higher rate, and give times in seconds",
                source,
            )
    last_to_start = max(signals, key=lambda signal: signal.time[0])
    first_to_end = min(signals, key=lambda signal: signal.time[-1])
    start, end = last_to_start.time[0], first_to_end.time[-1]
    if rate is None:
        slowest = max(leading, key=lambda signal: float(np.median(np.diff(signal.time))))
        time = slowest.time[(slowest.time >= start) & (slowest.time <= end)]
    else:
        if not 0.1 <= rate <= 10000.0:
            raise InputError(f"the rate is {rate} 1/s", "give samples per second, such as 50")
        time = np.arange(start, end, 1.0 / rate)
    known = np.ones(time.size, dtype=np.bool_)
    for signal in signals:
        known &= ~_in_gap(signal, time)
    if int(known.sum()) < FEWEST_SAMPLES:
        raise InputError(
            f"all signals together are known at {int(known.sum())} times: {first_to_end.name} "
            f"ends at {end:.6g} s, {last_to_start.name} begins at {start:.6g} s",
            "log all of them at once, with the stamps of one clock",
            source,
        )
    return time[known]


def interpolated(signal: Signal, time: Floats) -> Floats:
    """Values of a signal at the times (n,) [s], linearly between its samples; (n, k).

    A signal with many more samples is low-passed first, without a shift in time: a vibration must
    not appear as a slow motion.
    """
    values = _slowed(signal, float(np.median(np.diff(time))))
    columns = [np.interp(time, signal.time, column) for column in values.T]
    return np.stack(columns, axis=1)


def _slowed(signal: Signal, step: float) -> Floats:
    """Values (m, k) without what a clock of this ``step`` [s] cannot show."""
    own = float(np.median(np.diff(signal.time)))
    if step < FASTER * own:
        return signal.values
    from scipy.signal import butter, sosfiltfilt

    sections = butter(ORDER, 2.0 * CUTOFF * own / step, output="sos")
    beyond = 2 * round(step / own)
    breaks = np.flatnonzero(np.diff(signal.time) > LONGEST_GAP) + 1
    parts = [
        sosfiltfilt(sections, part, axis=0, padlen=beyond) if len(part) > 2 * beyond else part
        for part in np.split(signal.values, breaks)
    ]
    return np.concatenate(parts)


def _in_gap(signal: Signal, time: Floats) -> NDArray[np.bool_]:
    """Which times lie between two samples that are too far apart, none of them at either."""
    after = np.clip(np.searchsorted(signal.time, time), 1, signal.time.size - 1)
    wide = signal.time[after] - signal.time[after - 1] > LONGEST_GAP
    at_sample = (time == signal.time[after]) | (time == signal.time[after - 1])
    return np.asarray(wide & ~at_sample)


def _in_flu(attitude: Rotation, vectors: Floats) -> Floats:
    """World vectors (n, 3) in ENU, in FLU."""
    return np.asarray(attitude.apply(vectors, inverse=True))


def _air_velocity(
    recording: Recording, vehicle_file: VehicleFile, time: Floats, attitude: Rotation
) -> Floats:
    """Velocity through the air in FLU [m/s]; (n, 3)."""
    log = vehicle_file.log
    frame = log.world_frame or recording.world_frame
    wind = frames.world_to_enu(np.tile(np.array(log.wind), (time.size, 1)), frame)
    velocity = interpolated(recording.velocity, time)
    if recording.velocity_in == "world":
        return _in_flu(attitude, frames.world_to_enu(velocity, recording.world_frame) - wind)
    return frames.body_to_flu(velocity, recording.body_frame) - _in_flu(attitude, wind)


def _in_body(recording: Recording, signal: Signal | None, time: Floats) -> Floats:
    """A vector signal in FLU; (n, 3), NaN where there is none."""
    if signal is None:
        return np.full((time.size, 3), np.nan)
    return frames.body_to_flu(interpolated(signal, time), recording.body_frame)


def _rotor_speed(recording: Recording, vehicle_file: VehicleFile, time: Floats) -> Floats:
    """[rad/s], in the order of the vehicle's rotors; (n, rotors)."""
    logged = np.abs(interpolated(recording.rotor_speed, time))
    order = vehicle_file.log.rotor_order or range(1, logged.shape[1] + 1)
    speeds = np.empty_like(logged)
    speeds[:, [number - 1 for number in order]] = logged
    return speeds


def _check_frames(log: FlightLog, vehicle_file: VehicleFile) -> None:
    """Over a flight the rotors point up, and the specific force along ``up`` averages near g."""
    remedy = f"check body_frame, world_frame and the attitude ({vehicle_file.log.where})"
    axes = np.array([mount.axis for mount in vehicle_file.vehicle.mounts])
    if float(np.mean(log.up @ axes.T)) < 0.0:
        raise InputError("on average the rotors point down", remedy, log.source)
    if np.isnan(log.specific_force).any():
        return
    mean = float(np.mean(np.sum(log.specific_force * log.up, axis=1)))
    if 0.5 * GRAVITY < mean < 1.5 * GRAVITY:
        return
    if 0.5 < mean < 1.5:
        remedy = "give it in m/s^2, not in units of g"
    elif abs(mean) < 0.5:
        remedy = "gravity was taken off: give what the accelerometer reads, +g upwards in hover"
    elif abs(mean + GRAVITY) < 0.5:
        remedy = f"it points down: change its sign, or {remedy}"
    raise InputError(
        f"the specific force along the vertical averages {mean:.3g} m/s^2, expected about "
        f"{GRAVITY:.3g}",
        remedy,
        log.source,
    )
