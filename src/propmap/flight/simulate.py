"""Simulated flights: trimmed steady circles, logs with noise, and expected results of a fit."""

from __future__ import annotations

import io
import json
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.aircraft.trim import solve
from propmap.errors import InputError
from propmap.fit.flight import ForceModel, level_rows, wing_values
from propmap.fit.least_squares import NOISE_FLOOR, Minimum
from propmap.fit.parameters import EVERY, FIRST_GUESS, MOUNT, SECTION, Choice, constants_of
from propmap.fit.uncertainty import AT_BOUND, Uncertainty, uncertainty
from propmap.hover import REFERENCE_TIP_SPEED
from propmap.model.airfoil import PAPER_FOUR, Airfoil
from propmap.model.corrections import Installed
from propmap.model.model import Model
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.files import STATED, LogMap
from propmap.vehicle.log import FlightLog, in_vehicle_frame, pitch_and_roll
from propmap.vehicle.vehicle import Vehicle

# --- Logs of operating points flown one after the other, with sensor noise -----------------------

HARDEST = 2.0  # largest acceleration from one speed to the next [m/s^2]
SHORTEST = 0.5  # least duration of a change of speed [s]
MOST_SAMPLES = 2_000_000

VECTORS = {
    "velocity": ("vx_mps", "vy_mps", "vz_mps"),
    "rates": ("p_radps", "q_radps", "r_radps"),
    "specific_force": ("ax_mps2", "ay_mps2", "az_mps2"),
}
ANGLES = ("roll", "pitch", "yaw")


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of the noise of one sample; the noise is white."""

    rotor_speed: float = 0.005  # share of the rotor speed [-]
    velocity: float = 0.05  # for each component [m/s]
    attitude: float = 0.005  # for pitch and roll [rad]
    specific_force: float = 0.3  # for each component [m/s^2]


NOISELESS = SensorNoise(0.0, 0.0, 0.0, 0.0)


def check_sampling(dwell: float, rate: float) -> None:
    """Raise an ``InputError`` for a ``dwell`` [s] or a ``rate`` [1/s] outside its range."""
    if not 1.0 <= dwell <= 3600.0:
        raise InputError(f"each speed lasts {dwell:g} s", "give from 1 to 3600 s")
    if not 4.0 <= rate <= 10_000.0:
        raise InputError(f"the rate is {rate:g} samples per second", "give from 4 to 10000")


def fly(
    points: FlightLog,
    *,
    dwell: float = 6.0,
    rate: float = 100.0,
    noise: SensorNoise = NOISELESS,
    seed: int = 0,
) -> FlightLog:
    """Return a log of level circles, each flown for ``dwell`` [s] and sampled at ``rate`` [1/s].

    ``points`` come from ``trim`` and are flown in order.  Between two speeds, additional
    pitch and thrust produce the acceleration; changes of the other forces are neglected.  A search
    for steady segments excludes accelerated samples, as in a real log.
    """
    check_sampling(dwell, rate)
    speed, (pitch, roll) = points.speed, pitch_and_roll(points.up)
    turn = np.sum(points.rates * points.up, axis=1)
    # The largest acceleration of a smooth change of speed is twice the mean acceleration.
    lasts = np.maximum(2.0 * np.abs(np.diff(speed)) / HARDEST, SHORTEST)
    begins = dwell * np.arange(1, speed.size) + np.concatenate([[0.0], np.cumsum(lasts)])[:-1]
    count = int((dwell * speed.size + lasts.sum()) * rate)
    if count > MOST_SAMPLES:
        raise InputError(f"the log would have {count} samples", "lower the rate or the dwell")
    time = np.arange(count) / rate
    share = np.clip((time[:, None] - begins) / lasts, 0.0, 1.0)
    done = share - np.sin(2.0 * np.pi * share) / (2.0 * np.pi)

    def course(values: Floats) -> Floats:
        return values[0] + done @ np.diff(values, axis=0)

    push = (1.0 - np.cos(2.0 * np.pi * share)) @ (np.diff(speed) / lasts)
    speed, turn = course(speed), course(turn)
    pitch, roll = course(pitch) + np.arctan(push / GRAVITY), course(roll)
    harder = (1.0 + (push / GRAVITY) ** 2) ** 0.25
    up = in_vehicle_frame(0.0, 0.0, 1.0, pitch, roll)
    roll_rate, pitch_rate = (np.gradient(angle, 1.0 / rate) for angle in (roll, pitch))
    tilting = [roll_rate, np.cos(roll) * pitch_rate, -np.sin(roll) * pitch_rate]
    log = FlightLog(
        source="simulated flight",
        time=time,
        velocity=in_vehicle_frame(speed, 0.0, 0.0, pitch, roll),
        rates=turn[:, None] * up + np.stack(tilting, axis=1),
        up=up,
        specific_force=in_vehicle_frame(push, speed * turn, GRAVITY, pitch, roll),
        rotor_speed=course(points.rotor_speed) * harder[:, None],
    )
    rng = np.random.default_rng(seed)

    def noisy(values: Floats, size: float) -> Floats:
        return values + size * rng.standard_normal(values.shape)

    pitch, roll = noisy(pitch, noise.attitude), noisy(roll, noise.attitude)
    even = np.ones_like(log.rotor_speed)
    return replace(
        log,
        velocity=noisy(log.velocity, noise.velocity),
        up=in_vehicle_frame(0.0, 0.0, 1.0, pitch, roll),
        specific_force=noisy(log.specific_force, noise.specific_force),
        rotor_speed=np.abs(log.rotor_speed * noisy(even, noise.rotor_speed)),
    )


def log_map(rotors: int) -> LogMap:
    """Return the columns, frames and units of files from ``log_csv``."""
    columns = {"time": ("time_s",), **VECTORS, **{name: (f"{name}_rad",) for name in ANGLES}}
    columns["rotor_speed"] = tuple(f"rotor_{k}_radps" for k in range(1, rotors + 1))
    return LogMap("flu", "enu", "body", "rad/s", columns=columns)


def log_table(rotors: int) -> str:
    """Return the table ``[log]`` of a vehicle file for logs from ``log_csv``, as TOML."""
    how, several = log_map(rotors), (*VECTORS, "rotor_speed")
    stated = {key: how.stated(key) for key in STATED}
    columns = {key: names if key in several else names[0] for key, names in how.columns.items()}
    # Strings and lists of strings have the same form in JSON and in TOML.
    tables = [
        [heading, *(f"{key} = {json.dumps(value)}" for key, value in table.items())]
        for heading, table in (("[log]", stated), ("[log.columns]", columns))
    ]
    return "\n\n".join("\n".join(lines) for lines in tables) + "\n"


def log_csv(log: FlightLog) -> str:
    """Return the log as CSV, with a heading from the integral of the yaw rate."""
    pitch, roll = pitch_and_roll(log.up)
    turn = np.sum(log.rates * log.up, axis=1)
    steps = 0.5 * (turn[1:] + turn[:-1]) * np.diff(log.time)
    yaw = np.concatenate([[0.0], np.cumsum(steps)])
    vectors = np.concatenate([getattr(log, name) for name in VECTORS], axis=1)
    angles = np.stack([roll, pitch, yaw], axis=1)
    names = [name for part in log_map(log.rotor_speed.shape[1]).columns.values() for name in part]
    text = io.StringIO()
    table = np.column_stack([log.time, vectors, angles, log.rotor_speed])
    np.savetxt(text, table, "%.9g", delimiter=",", header=",".join(names), comments="")
    return text.getvalue()


# --- Steady level circles of a vehicle with a known section law: the experiment of the paper -----

PAPER_RADIUS = 1.7  # length of the tether [m]
CHANGE = 1e-5  # step of difference quotients; the error of the forces is about 1e-12
LONGEST_STEPS = (0.3, 0.2, 0.2)
"""Largest step of the logarithm of the rotor speed [-], of pitch and of roll [rad]."""

STEEPEST = 1.4  # largest pitch and roll [rad]
EXACT, ACCEPTED = 1e-9, 1e-4
"""Largest unbalanced force / weight at which a search ends, and largest accepted one.  The limits
differ because the forces jump where the number of azimuths changes with the speed."""


def true_values(vehicle: Vehicle, airfoil: Airfoil) -> dict[str, float]:
    """Return the true values of all parameters of a fit by name.

    A fit adds areas to the body of the vehicle file, so their true values are zero.  The drag of
    mounts is not a parameter if the vehicle file contains it.
    """
    law = constants_of(airfoil)
    section = {name: getattr(law, name) for name in SECTION}
    own_mounts = any(mount.drag is not None for mount in vehicle.mounts)
    mounted = Model(vehicle.propeller, law, vehicle.air).correction_of(Installed)
    area = None if own_mounts or mounted is None else mounted.area(vehicle.propeller.radius)
    mount = {} if area is None else {"mount_area": area}
    return FIRST_GUESS | section | mount | wing_values(vehicle)


def trim(
    vehicle: Vehicle,
    airfoil: Airfoil,
    speeds: Floats,
    *,
    radius: float = PAPER_RADIUS,
    tether: bool = True,
    disturbance: Floats | None = None,
) -> FlightLog:
    """Return operating points of level circles to the left, nose first, at ``speeds`` (n,) [m/s].

    All rotors have the same speed: the differences that balance the moments are small, and are
    ignored.  The forces are computed as in a fit.  The circles have a ``radius`` [m], infinite for
    straight flight.  A horizontal ``tether`` provides the centripetal force, as in the paper;
    without a tether, the vehicle banks.  A ``disturbance`` (n,) is an additional downward force on
    the vehicle, as a share of the weight.  A fit to the points treats this force as a measurement
    error.  ``specific_force`` includes the force of the tether, but not the disturbance.  Raise an
    ``InputError`` for speeds that cannot be flown.
    """
    flown = np.asarray(speeds, dtype=np.float64)
    if flown.ndim != 1 or flown.size == 0 or not (np.isfinite(flown) & (flown >= 0.0)).all():
        raise InputError("speeds must be one or more numbers", "give 0 or more m/s")
    if not radius > 0.0:
        raise InputError(f"the radius of the circle is {radius:g} m", "give meters, above 0")
    problem = _Problem(vehicle, airfoil, flown, radius, tether, disturbance)
    functions = problem.linearized, problem.residual, problem.bounded
    unknowns = solve(*functions, problem.first, flown, EXACT)
    left_over = np.abs(problem.residual(unknowns, np.arange(flown.size))).max(axis=1)
    lost = ~(left_over < ACCEPTED)
    if lost.any():
        first = float(flown[lost].min())
        slower = flown[~lost & (flown < first)]
        remedy = f"{slower.max():.4g} m/s is possible" if slower.size else "give lower speeds"
        if not tether and math.isfinite(radius):
            remedy += ", or fly wider circles"
        found = f"{first:.4g} m/s cannot be flown: no rotor speed and attitude balance the forces"
        raise InputError(found, f"{remedy}; check mass, propeller and body of the vehicle")
    return problem.log(unknowns)


class _Problem:
    """Force balances of n circles; unknowns (n, k): logarithm of the rotor speed, pitch, roll."""

    def __init__(
        self,
        vehicle: Vehicle,
        airfoil: Airfoil,
        speeds: Floats,
        radius: float,
        tether: bool,
        disturbance: Floats | None,
    ) -> None:
        self.vehicle, self.airfoil, self.speeds, self.radius = vehicle, airfoil, speeds, radius
        self.values = true_values(vehicle, airfoil)
        self.count = 2 if tether else 3
        nothing = np.zeros_like(speeds)
        lift = 1.0 + (nothing if disturbance is None else disturbance)
        aside = speeds**2 / (radius * GRAVITY)
        self.wanted = np.stack([nothing, lift, aside], axis=1)[:, : self.count]
        bank = -np.arctan(aside)
        rate = np.full_like(speeds, np.log(REFERENCE_TIP_SPEED / vehicle.propeller.radius))
        self.first = np.stack([rate, nothing, bank], axis=1)[:, : self.count]
        # Thrust is proportional to the square of the rotor speed.
        everyone = np.arange(speeds.size)
        carried = np.nan_to_num(self.residual(self.first, everyone)[:, 1] + lift, nan=1.0)
        self.first[:, 0] -= 0.5 * np.log(np.clip(carried / lift, 0.05, 20.0))

    def log(self, unknowns: Floats, which: Any = slice(None)) -> FlightLog:
        """Return the circles, or those with the indices ``which``, as operating points."""
        speeds, pitch = self.speeds[which], unknowns[:, 1]
        roll = unknowns[:, 2] if self.count == 3 else np.zeros_like(pitch)
        up, turn = in_vehicle_frame(0.0, 0.0, 1.0, pitch, roll), speeds / self.radius
        pull = in_vehicle_frame(0.0, speeds * turn, GRAVITY, pitch, roll)
        rotor_speed = np.exp(unknowns[:, :1])
        return FlightLog(
            source="simulated level circles",
            time=np.arange(pitch.size, dtype=np.float64),
            velocity=in_vehicle_frame(speeds, 0.0, 0.0, pitch, roll),
            rates=turn[:, None] * up,
            up=up,
            specific_force=pull,
            rotor_speed=np.repeat(rotor_speed, len(self.vehicle.mounts), axis=1),
        )

    def residual(self, unknowns: Floats, which: NDArray[np.intp]) -> Floats:
        """Return the unbalanced forces forward, up and left, divided by the weight; (m, k)."""
        log = self.log(unknowns, which)
        force = ForceModel(self.vehicle, log, self.airfoil).at(self.values, ()).force
        across = np.cross(log.up, np.array([1.0, 0.0, 0.0]))
        left = across / np.linalg.norm(across, axis=1, keepdims=True)
        parts = np.stack([np.cross(left, log.up), log.up, left], axis=1)[:, : self.count]
        weight = self.vehicle.mass * GRAVITY
        return np.asarray(np.einsum("nki,ni->nk", parts, force) / weight - self.wanted[which])

    def linearized(self, unknowns: Floats, which: NDArray[np.intp]) -> tuple[Floats, Floats]:
        """Return residuals (m, k) and their derivatives (m, k, k)."""
        residual = self.residual(unknowns, which)
        changes = [
            self.residual(unknowns + CHANGE * direction, which) - residual
            for direction in np.eye(self.count)
        ]
        return residual, np.stack(changes, axis=-1) / CHANGE

    def bounded(self, unknowns: Floats, step: Floats) -> Floats:
        """Return the step, limited in length and to the largest pitch and roll."""
        longest = np.array(LONGEST_STEPS[: self.count])
        step = np.clip(step, -longest, longest)
        angles = unknowns[:, 1:]
        step[:, 1:] = np.clip(angles + step[:, 1:], -STEEPEST, STEEPEST) - angles
        return step


# --- Expected uncertainty of the parameters from a planned flight --------------------------------


@dataclass(frozen=True)
class Expectation:
    """Expected result of a fit of planned flights with P free parameters."""

    choice: Choice  # parameters of the fit
    truth: Floats  # true values of the free parameters, (P,)
    uncertainty: Uncertainty  # intervals about the true values
    error: float  # standard deviation of the vertical forces, as a share of the weight


def expectation(
    vehicle: Vehicle,
    airfoil: Airfoil,
    points: FlightLog,
    *,
    free: tuple[str, ...] = PAPER_FOUR,
    error: float = 0.01,
) -> Expectation:
    """Return the Gauss-Newton intervals of a fit of level flights, eq. (18), at the true values.

    ``error`` is the standard deviation of the vertical force of a flight, as a share of the weight.
    The numerical error of the loads replaces a smaller ``error``.  Raise an ``InputError`` for a
    true value outside the bounds of a fit.
    """
    truth = {name: EVERY[name].start for name in free if name in MOUNT}
    truth |= true_values(vehicle, airfoil)
    for name in EVERY.keys() & set(free):
        low, high = EVERY[name].lower, EVERY[name].upper
        if not low <= truth[name] <= high:
            fault = f"{name} is {truth[name]:g}, outside the bounds of a fit, {low:g} to {high:g}"
            raise InputError(fault, f"simulate another airfoil, or do not free {name}")
    choice = Choice(free, start={name: truth[name] for name in free if name in EVERY})
    rows = level_rows(ForceModel(vehicle, points, airfoil), choice)
    _, slopes = rows.model(truth, free)
    x, error = choice.first, max(error, NOISE_FLOOR)
    # The sum of squares of ``residual`` divided by the degrees of freedom is ``error`` squared.
    margin = AT_BOUND * choice.column("spread")
    inside = np.minimum(x - choice.column("lower"), choice.column("upper") - x) >= margin
    discount = max(len(rows.measured) - int(inside.sum()), 1) / len(rows.measured)
    residual = np.full(len(rows.measured), error * math.sqrt(discount))
    found = Minimum(x, residual, slopes / rows.scale[:, None], (), 0)
    return Expectation(choice, x, uncertainty(rows, choice, found), error)
