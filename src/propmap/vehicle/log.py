"""Flight logs: signals at common times in one frame, and their computation from recordings."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.files import VehicleFile
from propmap.vehicle.throttle import ThrottleCurve, lagged
from propmap.vehicle.vehicle import Vehicle
from propmap.vehicle.wakes import HubFlow, hub_flow_at

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


# --- A flight as arrays at common times, in the vehicle's frame: x forward, y left, z up ---------


@dataclass(frozen=True, eq=False)
class FlightLog:
    """A flight as n samples, or as n operating points averaged over segments.

    Attributes
    ----------
    source : str
        Origin of the data, for messages and reports.
    time : ndarray, shape (n,)
        Increasing times [s].
    velocity : ndarray, shape (n, 3)
        Velocity of the center of mass through the air, in the vehicle's frame [m/s].
    rates : ndarray, shape (n, 3)
        Angular velocity in the vehicle's frame [rad/s].
    up : ndarray, shape (n, 3)
        Unit vector against gravity, in the vehicle's frame [-].
    specific_force : ndarray, shape (n, 3)
        Reading of an accelerometer at the center of mass, +g along ``up`` in hover [m/s^2]; NaN if
        it was not measured.
    rotor_speed : ndarray, shape (n, rotors)
        Rotational speeds [rad/s], >= 0.
    east : ndarray, shape (n, 3)
        Unit vector along the first axis of the world frame, in the vehicle's frame [-]; NaN if
        unknown.
    angular_acceleration : ndarray, shape (n, 3)
        Time derivative of ``rates`` [rad/s^2]; NaN if unknown.
    specific_force_rate : ndarray, shape (n, 3)
        Time derivative of ``specific_force`` [m/s^3]; NaN if unknown.
    rotor_acceleration : ndarray, shape (n, rotors)
        Time derivative of ``rotor_speed`` [rad/s^2]; NaN if unknown.
    throttle : ndarray, shape (n, rotors)
        Motor commands as fractions of full throttle, delayed by the default motor lag [-]; NaN if
        rotor speeds were measured.  If the log contains the battery voltage or the hover throttle,
        the fraction is multiplied by this voltage [V] or divided by this throttle [-].  If rotor
        speeds were not measured, ``rotor_speed`` contains the same values until a throttle curve
        converts them to speeds.
    throttle_by_lag : ndarray, shape (n, rotors)
        Derivative of ``throttle`` with respect to the lag [1/s].
    air_speed : ndarray, shape (n,)
        Measured airspeed, for comparisons [m/s]; NaN if unknown.
    flight : ndarray, shape (n,)
        Number of the flight in a joined log, from 0.
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
    east: Floats = None  # type: ignore[assignment]
    angular_acceleration: Floats = None  # type: ignore[assignment]
    specific_force_rate: Floats = None  # type: ignore[assignment]
    rotor_acceleration: Floats = None  # type: ignore[assignment]
    throttle: Floats = None  # type: ignore[assignment]
    throttle_by_lag: Floats = None  # type: ignore[assignment]
    air_speed: Floats = None  # type: ignore[assignment]
    flight: Floats = None  # type: ignore[assignment]
    flights: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for known, names in UNKNOWN.items():
            unknown = np.full_like(getattr(self, known), np.nan)
            for name in names:
                if getattr(self, name) is None:
                    object.__setattr__(self, name, unknown)
        if self.flight is None:
            object.__setattr__(self, "flight", np.zeros_like(self.time))
        if not self.flights:
            count = int(self.flight.max(initial=0.0)) + 1
            object.__setattr__(self, "flights", tuple(str(k + 1) for k in range(count)))

    def __len__(self) -> int:
        return int(self.time.size)

    def picked(self, which: Any) -> FlightLog:
        """Return the selected samples: ``which`` is a mask, a slice or indices."""
        return self.with_each(lambda array: array[which])

    def with_each(self, change: Callable[[Floats], Floats]) -> FlightLog:
        """Return this log with ``change`` applied to all arrays; their common length may change."""
        arrays: dict[str, Any] = {name: change(getattr(self, name)) for name in ARRAYS}
        return replace(self, **arrays)

    @property
    def commanded(self) -> bool:
        """Whether the log has throttle instead of measured rotor speeds."""
        return bool(np.isfinite(self.throttle).any())

    def with_curve(self, curve: ThrottleCurve) -> FlightLog:
        """Return this log with the rotor speeds of a ``curve`` where they were not measured."""
        speeds, _ = curve.speeds(self.throttle, self.throttle_by_lag, self.rotor_speed)
        return replace(self, rotor_speed=speeds)

    @property
    def speed(self) -> Floats:
        """Airspeed [m/s]; (n,)."""
        return np.asarray(np.linalg.norm(self.velocity, axis=1))

    @property
    def since_start(self) -> Floats:
        """Time since the start of the flight of each sample [s]; (n,)."""
        numbers, place = np.unique(self.flight, return_inverse=True)
        first = np.array([self.time[self.flight == number].min() for number in numbers])
        return np.asarray(self.time - first[place])

    def segments(self, seconds: float) -> NDArray[np.intp]:
        """Divide the flights into segments of ``seconds`` [s]; return the number of each sample.

        The result has the shape (n,).  Segments of different flights have different numbers.
        """
        of = np.stack([self.flight, self.since_start // seconds])
        return np.unique(of, axis=1, return_inverse=True)[1].ravel()

    @property
    def climb_rate(self) -> Floats:
        """Vertical velocity, up positive [m/s]; (n,)."""
        return np.asarray(np.sum(self.velocity * self.up, axis=1))


UNKNOWN = {
    "time": ("air_speed",),
    "rates": ("east", "angular_acceleration", "specific_force_rate"),
    "rotor_speed": ("rotor_acceleration", "throttle", "throttle_by_lag"),
}
"""Optional arrays, NaN by default; each key is a required field of the same shape."""

ARRAYS = tuple(f.name for f in fields(FlightLog) if f.name not in ("source", "flights"))
"""Fields with one row for each sample."""


def joined(logs: list[FlightLog], names: tuple[str, ...] = ()) -> FlightLog:
    """Return the concatenated logs of one vehicle, with unchanged times.

    The flights have these ``names``, or numbers by default.
    """
    logs = [replace(log, flight=np.full_like(log.time, k)) for k, log in enumerate(logs)]
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(log, name) for log in logs]) for name in ARRAYS
    }
    return FlightLog(source=", ".join(log.source for log in logs), **arrays, flights=names)


def in_vehicle_frame(
    forward: Floats | float, left: Floats | float, up: Floats | float, pitch: Floats, roll: Floats
) -> Floats:
    """Return vectors (..., 3) in a tilted vehicle's frame from components (...) along level axes.

    ``pitch`` (...) [rad] is a rotation about the left axis, positive for a forward lean; ``roll``
    (...) [rad] is a rotation about the vehicle's x axis after the pitch, positive right side down.
    """
    # Pitch rotates about y (left), from z to x; roll then rotates about x, from y to z.
    x = forward * np.cos(pitch) - up * np.sin(pitch)
    below = forward * np.sin(pitch) + up * np.cos(pitch)
    y, z = left * np.cos(roll) + below * np.sin(roll), below * np.cos(roll) - left * np.sin(roll)
    return np.stack([x, y, z], axis=-1)


def hub_flow(vehicle: Vehicle, log: FlightLog) -> HubFlow:
    """Return the flow at each rotor's hub in a log, V_i = V_vehicle + omega x r_i.

    Parameters
    ----------
    vehicle : Vehicle
        Vehicle with m rotors.
    log : FlightLog
        n samples of its motion.

    Returns
    -------
    HubFlow
        ``omega`` [rad/s], ``axial`` and ``inplane`` velocity [m/s], shape (n, m), and the
        directions of thrust and rotor drag.
    """
    return hub_flow_at(vehicle, log.rotor_speed, log.velocity, log.rates)


def pitch_and_roll(up: Floats) -> tuple[Floats, Floats]:
    """Return pitch and roll [rad], (n,), as in ``in_vehicle_frame``, from ``up`` (n, 3)."""
    return -np.arcsin(np.clip(up[:, 0], -1.0, 1.0)), np.arctan2(up[:, 1], up[:, 2])


# -------------------------------------------------------------------------------------------------
# Low-pass filter and time derivatives of a log, required for a balance of forces.
#
# Accelerometer, gyro and motor controllers filter their measurements differently, but a balance
# compares them.  All signals therefore pass the same filter here, without delay.

DERIVATIVE_CUTOFF = 6.0
"""Default cut-off [Hz]: vehicles of up to some kilograms turn within 0.2 s, and rotor speeds of
motor controllers are noisy at higher frequencies."""

FEWEST_PER_PERIOD = 3.0  # logs with fewer samples per period of the cut-off are not filtered


def low_passed(log: FlightLog, cutoff: float = DERIVATIVE_CUTOFF) -> FlightLog:
    """Low-pass all signals of a log with one filter, and differentiate them.

    Rotor speeds are filtered as squares, since forces are proportional to the squares.  Segments
    between gaps are filtered separately.  Logs with fewer than three samples per period of the
    cut-off are not filtered.

    Parameters
    ----------
    log : FlightLog
        n samples of one flight in order of time.
    cutoff : float
        Cut-off frequency [Hz]; 0 for no filter.

    Returns
    -------
    FlightLog
        Log with ``angular_acceleration``, ``specific_force_rate`` and ``rotor_acceleration``.

    Raises
    ------
    InputError
        For a cut-off that is negative or not finite.
    """
    if not (np.isfinite(cutoff) and cutoff >= 0.0):
        found = f"the cut-off of the low-pass is {cutoff:g} Hz"
        raise InputError(found, "give a positive frequency, or 0 for no filter")
    steps = np.diff(log.time)
    ends = [0, *(np.flatnonzero(steps > LONGEST_GAP) + 1), len(log)]
    parts = [
        _filtered(log.picked(slice(first, last)), cutoff)
        for first, last in itertools.pairwise(ends)
    ]
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in ARRAYS
    }
    return replace(log, **arrays)


def _filtered(part: FlightLog, cutoff: float) -> FlightLog:
    """Filter and differentiate one segment without gaps."""

    def unit(vectors: Floats) -> Floats:
        return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)

    def smooth(signal: Floats) -> Floats:
        return low_pass(signal, 2.0 * cutoff * step, round(2.0 / (cutoff * step)))

    step = float(np.median(np.diff(part.time))) if len(part) > 1 else np.inf
    if cutoff > 0.0 and FEWEST_PER_PERIOD * cutoff * step <= 1.0:
        up, east = unit(smooth(part.up)), smooth(part.east)
        part = replace(
            part,
            velocity=smooth(part.velocity),
            rates=smooth(part.rates),
            up=up,
            east=unit(east - np.sum(east * up, axis=1, keepdims=True) * up),
            specific_force=smooth(part.specific_force),
            rotor_speed=np.sqrt(np.maximum(smooth(np.square(part.rotor_speed)), 0.0)),
            throttle=smooth(part.throttle),
            throttle_by_lag=smooth(part.throttle_by_lag),
        )

    def slope(signal: Floats) -> Floats:
        if len(part) < 2:
            return np.zeros_like(signal)
        return np.asarray(np.gradient(signal, part.time, axis=0))

    return replace(
        part,
        angular_acceleration=slope(part.rates),
        specific_force_rate=slope(part.specific_force),
        rotor_acceleration=slope(part.rotor_speed),
    )


def low_pass(signal: Floats, relative: float, padding: int, order: int = 2) -> Floats:
    """Return columns (n, k) filtered forwards and backwards, without delay.

    ``relative`` is the cut-off divided by half the sampling rate.  ``order`` is the order of the
    Butterworth filter.  The signal is extended by ``padding`` samples at each end.
    """
    from scipy.signal import butter, sosfiltfilt

    sections = butter(order, relative, output="sos")
    beyond = min(signal.shape[0] - 1, padding)
    return np.asarray(sosfiltfilt(sections, signal, axis=0, padlen=beyond))


# --- Short names of flights from their file names ------------------------------------------------

TIME_OF_DAY = 6  # digits at the end of a stamp such as 20210218171908


def flight_names(sources: Sequence[str]) -> tuple[str, ...]:
    """Return the shortest distinct endings of the file names, or numbers if names are equal."""
    parts = [_words(PurePath(source).stem) for source in sources]
    for count in range(1, max(map(len, parts), default=1) + 1):
        names = tuple("-".join(words[-count:]) for words in parts)
        if len(set(names)) == len(names):
            return names
    return tuple(str(k + 1) for k in range(len(parts)))


def _words(stem: str) -> list[str]:
    words = re.findall(r"[^\W_]+", stem) or ["flight"]
    stamp = re.fullmatch(rf"\d{{8}}(\d{{{TIME_OF_DAY}}})", words[-1])
    return [*words[:-1], words[-1][:8], stamp[1]] if stamp else words


# --- Conversion from the frames of a log to FLU (forward, left, up) and ENU (east, north, up) ----


def body_to_flu(vectors: Floats, frame: str) -> Floats:
    """Return vectors (n, 3) of the body frame "flu" or "frd" in FLU."""
    return vectors if frame == "flu" else vectors * np.array([1.0, -1.0, -1.0])


def world_to_enu(vectors: Floats, frame: str) -> Floats:
    """Return vectors (n, 3) of the world frame "enu" or "ned" in ENU."""
    return vectors if frame == "enu" else vectors[:, [1, 0, 2]] * np.array([1.0, 1.0, -1.0])


def attitude_to_flu_enu(quaternions: Floats, body_frame: str, world_frame: str) -> Rotation:
    """Return rotations from FLU to ENU for quaternions w, x, y, z (n, 4) of the given frames."""
    from scipy.spatial.transform import Rotation

    attitude = Rotation.from_quat(quaternions, scalar_first=True)
    if body_frame == "frd":  # half a turn about x from FLU
        attitude = attitude * Rotation.from_quat([0.0, 1.0, 0.0, 0.0], scalar_first=True)
    if world_frame == "ned":  # half a turn about the north-east axis from ENU
        attitude = Rotation.from_quat([0.0, 1.0, 1.0, 0.0], scalar_first=True) * attitude
    return attitude


def quaternion_of_angles(roll: Floats, pitch: Floats, yaw: Floats) -> Floats:
    """Return quaternions (n, 4) of yaw about z, then pitch about y, then roll about x [rad], (n,).

    The angles refer to the axes of the log's frames: positive pitch is nose down in FLU, nose up in
    FRD.
    """
    from scipy.spatial.transform import Rotation

    angles = np.stack([yaw, pitch, roll], axis=1)
    return np.asarray(Rotation.from_euler("ZYX", angles).as_quat(scalar_first=True))


def continuous(quaternions: Floats) -> Floats:
    """Return unit quaternions (n, 4) with signs for which consecutive quaternions are close."""
    unit = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    same = np.sum(unit[1:] * unit[:-1], axis=1) >= 0.0
    return unit * np.concatenate([[1.0], np.cumprod(np.where(same, 1.0, -1.0))])[:, None]


# -------------------------------------------------------------------------------------------------
# The recording of a log, with separate times for each signal, and the removal of invalid samples.

FEWEST_SAMPLES = 10
MOST_DROPPED = 0.05  # largest accepted fraction of invalid samples of a signal


@dataclass(frozen=True, eq=False)
class Signal:
    """Values (n, k) at n times [s], and a name for messages."""

    name: str
    time: Floats
    values: Floats


@dataclass(frozen=True, eq=False)
class Recording:
    """The signals of a log in the frames of the log."""

    source: str
    body_frame: str  # "flu" or "frd"
    world_frame: str  # "enu" or "ned"
    velocity_in: str  # "body" or "world"
    attitude: Signal  # unit quaternions w, x, y, z (n, 4) from body to world axes
    velocity: Signal  # over the ground, (n, 3) [m/s]
    rates: Signal  # along body axes, (n, 3) [rad/s]
    rotor_speed: Signal  # in the order of the log, (n, rotors) [rad/s]
    specific_force: Signal | None  # along body axes, (n, 3) [m/s^2]
    # If ``commanded`` is true, ``rotor_speed`` contains motor commands: fractions of full throttle.
    # ``supply`` is their scale (n, 1): a voltage [V] or the inverse of the throttle in hover [-].
    commanded: bool = False
    supply: Signal | None = None
    air_speed: Signal | None = None  # measured, (n, 1) [m/s]
    notes: tuple[str, ...] = ()  # remarks of the reader on data that it left out

    def signals(self) -> dict[str, Signal]:
        """Return the available signals by the name of their field."""
        return {name: value for name, value in vars(self).items() if isinstance(value, Signal)}

    def from_start(self) -> Recording:
        """Return this recording with times since its first sample."""
        signals = self.signals()
        first = min(signal.time[0] for signal in signals.values())
        moved: Any = {name: replace(s, time=s.time - first) for name, s in signals.items()}
        return replace(self, **moved)


def cleaned(recording: Recording) -> Recording:
    """Drop invalid samples, and append their number to ``source``.

    Samples are invalid if they are not finite, if their quaternion is not of length 1, or if a
    previous sample has the same or a later time.  Raises ``InputError`` if more than 5 % of a
    signal are invalid, or if fewer than 10 samples remain.
    """
    dropped: dict[str, int] = {}
    parts: dict[str, Any] = {}
    for name, signal in recording.signals().items():
        _check_count(signal, signal.time.size, recording.source)
        finite = np.isfinite(signal.time) & np.all(np.isfinite(signal.values), axis=1)
        reasons = [("not finite", "export the log again or remove the column", finite)]
        if name == "attitude":
            with np.errstate(over="ignore"):
                length = np.linalg.norm(np.nan_to_num(signal.values, nan=1.0), axis=1)
            unit = np.abs(length - 1.0) < 0.05
            remedy = "check which of its columns or fields are qw, qx, qy, qz"
            reasons.append(("without a unit quaternion", remedy, unit | ~finite))
        usable = np.all([good for _, _, good in reasons], axis=0)
        times, rising = signal.time[usable], ~usable
        before = np.concatenate([[-np.inf], np.maximum.accumulate(times)[:-1]])
        rising[usable] = times > before
        reasons.append(("out of time order", "sort by time or cut the log", rising))
        for reason, remedy, good in reasons:
            lost = int(np.sum(~good))
            if lost > MOST_DROPPED * good.size:
                found = f"{lost} of {good.size} samples of {signal.name} are {reason}"
                raise InputError(found, remedy, recording.source)
            if lost:
                # Signals of one table lose the same rows, which must be counted once.
                dropped[reason] = max(dropped.get(reason, 0), lost)
        good = usable & rising
        _check_count(signal, int(good.sum()), recording.source)
        parts[name] = Signal(signal.name, signal.time[good], signal.values[good])
    remark = ", ".join(f"{count} samples {reason}" for reason, count in dropped.items())
    source = f"{recording.source} (dropped: {remark})" if remark else recording.source
    return replace(recording, source=source, **parts)


def _check_count(signal: Signal, count: int, source: str) -> None:
    """Raise ``InputError`` for a signal with fewer than ``FEWEST_SAMPLES`` samples."""
    if count < FEWEST_SAMPLES:
        found = f"{signal.name} has {count} samples, expected at least {FEWEST_SAMPLES}"
        raise InputError(found, "give a log with several seconds of flight", source)


def motor_slots(functions: list[int], motors: dict[int, int]) -> list[int] | None:
    """Return the indices of motors 1, 2, ... among outputs with these ``functions``.

    ``motors`` contains motor numbers by function.  The result is None unless the outputs with a
    motor are motors 1 to n, each once.
    """
    place = {motors[f]: k for k, f in enumerate(functions) if f in motors}
    turning = sum(function in motors for function in functions)
    if not turning or sorted(place) != [*range(1, turning + 1)]:
        return None
    return [place[number] for number in sorted(place)]


# -------------------------------------------------------------------------------------------------
# Conversion of a recording to a flight log: common times, FLU, rotors in the vehicle's order.

LONGEST_GAP = 0.25  # longest time [s] between two samples across which a signal is interpolated
FASTER = 1.5  # signals with at least this many samples per common interval are low-passed
CLOCK_CUTOFF, CLOCK_ORDER = 0.4, 4
"""Cut-off in cycles per interval of the common times, and order, of this low-pass: a Butterworth
filter, applied twice.  It removes vibrations that sampling at the common times would alias."""


def flight_log(
    recording: Recording, vehicle_file: VehicleFile, rate: float | None = None
) -> FlightLog:
    """Convert a recording to a log in the vehicle's frame, with ``rate`` samples per second.

    Without a rate, the log has the sample times of the slowest of attitude, velocity and rotor
    speed.  Negative rotor speeds, which some logs use for one spin, become positive.  Raises
    ``InputError`` for another number of rotors, unusable signals, and implausible frames or units.
    """
    logged, rotors = recording.rotor_speed.values.shape[1], len(vehicle_file.vehicle.mounts)
    if logged != rotors:
        turn = np.flatnonzero(np.nanmax(np.abs(recording.rotor_speed.values), axis=0, initial=0.0))
        which = ", ".join(str(k + 1) for k in turn) or "none"
        what = "motor commands" if recording.commanded else "rotor speeds"
        raise InputError(
            f"the log has {logged} {what}, of which {which} are not always zero; the vehicle has "
            f"{rotors} rotors",
            "give one [[rotors]] table per rotor, or the log of this vehicle; or configure the "
            "autopilot's motor outputs, or save as CSV and name the columns of the motors",
            recording.source,
        )
    recording = cleaned(recording)
    by_lag = None
    if recording.commanded:
        recording, by_lag = _driven(recording)
    leading = [recording.attitude, recording.velocity, recording.rotor_speed]
    following = [recording.rates]
    if recording.specific_force is not None:
        following.append(recording.specific_force)
    time = common_clock(leading, following, recording.source, rate)
    signal = recording.attitude
    smooth = Signal(signal.name, signal.time, continuous(signal.values))
    attitude = attitude_to_flu_enu(
        interpolated(smooth, time), recording.body_frame, recording.world_frame
    )

    def in_flu(of_the_world: Floats) -> Floats:
        return np.asarray(attitude.apply(of_the_world, inverse=True))

    def body_signal(signal: Signal) -> Floats:
        return body_to_flu(interpolated(signal, time), recording.body_frame)

    stated = vehicle_file.log
    wind = np.tile(np.array(stated.wind), (time.size, 1))
    wind = world_to_enu(wind, stated.world_frame or recording.world_frame)
    if recording.velocity_in == "world":
        over_ground = interpolated(recording.velocity, time)
        velocity = in_flu(world_to_enu(over_ground, recording.world_frame) - wind)
    else:
        velocity = body_signal(recording.velocity) - in_flu(wind)
    force = recording.specific_force
    place = np.argsort(stated.rotor_order or range(logged))

    def by_rotor(signal: Signal) -> Floats:
        return interpolated(signal, time)[:, place]

    rotor_speed = np.abs(by_rotor(recording.rotor_speed))
    more: Any = {}
    if (measured := recording.air_speed) is not None:
        known = known_at(time, measured.time)
        more["air_speed"] = np.where(known, interpolated(measured, time)[:, 0], np.nan)
    if by_lag is not None:
        more |= {"throttle": rotor_speed, "throttle_by_lag": by_rotor(by_lag)}
    result = FlightLog(
        source=recording.source,
        time=time,
        velocity=velocity,
        rates=body_signal(recording.rates),
        up=in_flu(np.tile([0.0, 0.0, 1.0], (time.size, 1))),
        east=in_flu(np.tile([1.0, 0.0, 0.0], (time.size, 1))),
        specific_force=np.full((time.size, 3), np.nan) if force is None else body_signal(force),
        rotor_speed=rotor_speed,
        **more,
    )
    _check_frames(result, vehicle_file)
    return result


def _driven(recording: Recording) -> tuple[Recording, Signal]:
    """Return a recording whose ``rotor_speed`` is the command times the supply, after the default
    lag, and the derivatives of this product with respect to the lag."""
    signal, supply = recording.rotor_speed, recording.supply
    drive = signal.values
    if supply is not None:
        drive = drive * np.interp(signal.time, supply.time, supply.values[:, 0])[:, None]
    breaks = np.flatnonzero(np.diff(signal.time) > LONGEST_GAP) + 1
    step = float(np.median(np.diff(signal.time)))
    parts = [lagged(part, step) for part in np.split(drive, breaks)]
    once, by_lag = (np.concatenate(each) for each in zip(*parts, strict=True))
    return replace(recording, rotor_speed=replace(signal, values=once)), replace(
        signal, values=by_lag
    )


def common_clock(
    leading: Sequence[Signal], following: Sequence[Signal], source: str, rate: float | None = None
) -> Floats:
    """Return the times [s] at which all signals are known; (n,), increasing.

    Without a ``rate`` [1/s], they are the sample times of the slowest of the ``leading`` signals.
    Times in a gap of any signal longer than 0.25 s are left out.  Raises ``InputError`` if too few
    times remain.
    """
    signals = [*leading, *following]
    for signal in signals:
        step = float(np.median(np.diff(signal.time)))
        if step > LONGEST_GAP:
            raise InputError(
                f"the samples of {signal.name} are {step:.3g} s apart, expected {LONGEST_GAP:g} s "
                "or less",
                "log this signal at a higher rate, and give times in seconds",
                source,
            )
    first = min(signal.time[0] for signal in signals)
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
        known &= known_at(time, signal.time)
    if int(known.sum()) < FEWEST_SAMPLES:
        raise InputError(
            f"only {int(known.sum())} times have all signals: {first_to_end.name} "
            f"ends at {end - first:.6g} s, {last_to_start.name} begins at {start - first:.6g} s",
            "log all signals at the same time, with time stamps of one clock",
            source,
        )
    return time[known]


def known_at(time: Floats, own: Floats) -> NDArray[np.bool_]:
    """Return which times (n,) [s] are not in a gap of a signal with samples at ``own`` times."""
    # A time is in a gap if it is strictly between two samples that are too far apart.
    after = np.clip(np.searchsorted(own, time), 1, own.size - 1)
    wide = own[after] - own[after - 1] > LONGEST_GAP
    return np.asarray((time == own[after]) | (time == own[after - 1]) | ~wide)


def interpolated(signal: Signal, time: Floats) -> Floats:
    """Return a signal interpolated linearly to times (n,) [s]; (n, k).

    A signal with many more samples is low-passed first, without delay, so that vibrations are not
    aliased to slow motions.
    """
    values = _slowed(signal, float(np.median(np.diff(time))))
    columns = [np.interp(time, signal.time, column) for column in values.T]
    return np.stack(columns, axis=1)


def _slowed(signal: Signal, step: float) -> Floats:
    """Return values (m, k) without frequencies too high for a sampling time ``step`` [s]."""
    own = float(np.median(np.diff(signal.time)))
    if step < FASTER * own:
        return signal.values
    relative, beyond = 2.0 * CLOCK_CUTOFF * own / step, 2 * round(step / own)
    breaks = np.flatnonzero(np.diff(signal.time) > LONGEST_GAP) + 1
    parts = [
        low_pass(part, relative, beyond, CLOCK_ORDER) if len(part) > 2 * beyond else part
        for part in np.split(signal.values, breaks)
    ]
    return np.concatenate(parts)


def _check_frames(log: FlightLog, vehicle_file: VehicleFile) -> None:
    """Check that the rotors point up, and that the mean specific force along ``up`` is near g."""
    remedy = f"check body_frame, world_frame and the attitude ({vehicle_file.log.where})"
    if float(np.mean(log.up @ vehicle_file.vehicle.rotor_axes.T)) < 0.0:
        raise InputError("the rotors point down on average", remedy, log.source)
    if np.isnan(log.specific_force).any():
        return
    mean = float(np.mean(np.sum(log.specific_force * log.up, axis=1)))
    if 0.5 * GRAVITY < mean < 1.5 * GRAVITY:
        return
    if 0.5 < mean < 1.5:
        remedy = "give the specific force in m/s^2, not in units of g"
    elif abs(mean) < 0.5:
        remedy = "gravity was subtracted: give the accelerometer's reading, +g upwards in hover"
    elif abs(mean + GRAVITY) < 0.5:
        remedy = f"the specific force points down: change its sign, or {remedy}"
    found = f"the mean specific force along the vertical is {mean:.3g} m/s^2, expected about "
    found += f"{GRAVITY:.3g}"
    raise InputError(found, remedy, log.source)
