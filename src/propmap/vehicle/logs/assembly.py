"""A recording becomes a flight log: one clock, FLU, rotors in the vehicle's order."""

from __future__ import annotations

import numpy as np

from propmap.arrays.types import Floats
from propmap.errors import InputError
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.logs import frames
from propmap.vehicle.logs.recording import Recording, Signal, cleaned
from propmap.vehicle.logs.resampling import common_clock, interpolated
from propmap.vehicle.vehicle_toml import VehicleFile


def flight_log(
    recording: Recording, vehicle_file: VehicleFile, rate: float | None = None
) -> FlightLog:
    """The log in the vehicle's frame.

    rate : [1/s], else the sample times of the slowest of attitude, velocity and rotor speed.
    The sign that some logs give to the spin of a rotor is dropped.  Raises ``InputError``, also
    where the accelerometer says that the frames or its unit cannot be as stated.
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
    attitude = _attitude(recording, time)
    up = frames.world_to_body(attitude, np.tile([0.0, 0.0, 1.0], (time.size, 1)))
    result = FlightLog(
        source=recording.source,
        time=time,
        velocity=_air_velocity(recording, vehicle_file, time, attitude),
        rates=_in_body(recording, recording.rates, time),
        up=up,
        specific_force=_in_body(recording, recording.specific_force, time),
        rotor_speed=_rotor_speed(recording, vehicle_file, time),
    )
    _check_frames(result, vehicle_file)
    return result


def _attitude(recording: Recording, time: Floats) -> Floats:
    """Unit quaternions from FLU to ENU; (n, 4)."""
    signal = recording.attitude
    steady = Signal(signal.name, signal.time, frames.continuous(signal.values))
    return frames.attitude_to_flu_enu(
        frames.continuous(interpolated(steady, time)), recording.body_frame, recording.world_frame
    )


def _air_velocity(
    recording: Recording, vehicle_file: VehicleFile, time: Floats, attitude: Floats
) -> Floats:
    """Velocity through the air in FLU [m/s]; (n, 3)."""
    log = vehicle_file.log
    frame = log.world_frame or recording.world_frame
    wind = frames.world_to_enu(np.tile(np.array(log.wind), (time.size, 1)), frame)
    velocity = interpolated(recording.velocity, time)
    if recording.velocity_in == "world":
        over_ground = frames.world_to_enu(velocity, recording.world_frame)
        return frames.world_to_body(attitude, over_ground - wind)
    over_ground = frames.body_to_flu(velocity, recording.body_frame)
    return over_ground - frames.world_to_body(attitude, wind)


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
    raise InputError(
        f"the specific force along the vertical averages {mean:.3g} m/s^2, expected about "
        f"{GRAVITY:.3g}",
        remedy,
        log.source,
    )
