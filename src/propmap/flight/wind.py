"""Wind over a flight: the velocity of the air, estimated from the forces on a fitted vehicle.

A Kalman smoother estimates the wind and the errors of the modeled force.  Its passes repeat until
convergence.  Each pass linearizes the force as a function of the wind, by a regression over the
band of the previous estimate.
Horizontal wind is a random walk; vertical wind varies about zero.  The error along each axis of the
vehicle is a first-order Markov process, as large as the error of the fit on held-out segments.
Errors of the parameters and differences between flights (trim of the attitude, thrust scale, clock)
are the same for all samples.  They widen the bands.  Only the prior of the mean vertical wind
reduces these common errors.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.fit.comparison import BAND, fitted_forces, force_errors
from propmap.fit.files import FitFile
from propmap.fit.flight import of_others
from propmap.fit.least_squares import rms
from propmap.typing import Floats
from propmap.vehicle.log import FlightLog, hub_flow
from propmap.vehicle.vehicle import Vehicle

COMPONENTS = ("east", "north", "up")
WELL = 2.0  # largest half width [m/s] of the 95 % bands of well-determined horizontal components

RATE = 5.0  # largest number of samples per second; closer samples have almost equal errors
FIRST = 20.0  # prior standard deviation of the horizontal wind at the start [m/s]
VERTICAL = 5.0  # correlation time of the vertical wind [s]: height of 25 m / wind of 5 m/s
UP = 0.2  # prior standard deviation of the mean vertical wind [m/s]: 5 m/s along a slope of 2 deg
USUAL, SPREAD = np.log([0.02, 0.3, 0.4, 0.4, 0.4]), np.array([2.0, 1.4, 1.0, 1.0, 1.0])
"""Prior means and standard deviations of the logarithms of five scales:

- intensity of the random walk of the horizontal wind [m^2/s^3]
- variance of the vertical wind [m^2/s^2]
- correlation times of the errors along x, y, z [s]

Near the ground, the intensity is 0.001 to 1 m^2/s^3, and the variance is
0.05 to 2 m^2/s^2.  The correlation times of the residuals of flight fits are 0.1 to 2 s."""

WHITE = 0.1  # standard deviation of the white part of the error, divided by that of the whole error
GUESS = 0.3  # standard deviation of the wind for the first regression [m/s]
MOST_STEPS, LONGEST_STEP = 20, 3.0  # most regressions, largest wind change in each [m/s]
WHOLE_STEPS = 3  # regressions after which the steps become smaller
TUNED_STEPS, TUNED_SAMPLES = 6, 1500  # most regressions and samples that tune the five scales
SETTLED = 0.1  # largest last change of a converged wind, divided by its standard deviation [-]
MISFIT, UPDRAFT = 1.5, 2.0
"""Above these limits, a remark asks whether the vehicle is the vehicle of the fit.  The limits are
for residuals / their expected size [-], and for the mean vertical wind before the common errors
are corrected [m/s]."""


@dataclass(frozen=True, eq=False)
class WindEstimate:
    """Wind over a flight at n samples, in the world frame: east, north, up.

    Attributes
    ----------
    log : FlightLog
        Samples of the flight, with the velocity over the ground.
    wind, covariance : ndarray, shape (n, 3), (n, 3, 3)
        Velocity of the air over the ground [m/s], and covariance of its error [m^2/s^2]; NaN for
        the status "not_converged".
    mean, mean_covariance : ndarray, shape (3,), (3, 3)
        Mean wind [m/s], and covariance of its error [m^2/s^2]; NaN if fewer than half of the
        samples have a wind.
    gusts : ndarray, shape (3,)
        Standard deviation of each component of the wind over the flight [m/s].
    status : ndarray of str, shape (n,)
        "ok"; "extrapolated" outside the data of the fit; "weak" if the 95 % band of a horizontal
        component is wider than +-2 m/s; "not_converged".
    remarks : tuple of str
        Warnings about the estimate, one sentence each.
    """

    log: FlightLog
    wind: Floats
    covariance: Floats
    mean: Floats
    mean_covariance: Floats
    gusts: Floats
    status: NDArray[np.str_]
    remarks: tuple[str, ...]

    @property
    def mean_half_width(self) -> Floats:
        """Half widths of the 95 % bands of ``mean`` (3,) [m/s]."""
        return bands(self.mean_covariance)

    @property
    def well_determined(self) -> float:
        """Share of the samples with the status "ok" or "extrapolated" [-]."""
        return float(np.mean(np.isin(self.status, ("ok", "extrapolated"))))

    @property
    def ground_velocity(self) -> Floats:
        """Velocity over the ground in the world frame (n, 3) [m/s]."""
        return np.asarray(np.einsum("nwv,nv->nw", _world(self.log), self.log.velocity))

    @property
    def columns(self) -> dict[str, Floats]:
        """Time, wind, airspeed, ground speed and 95 % bands (n,), by column name with unit."""
        through = self.ground_velocity - self.wind
        airspeed = np.linalg.norm(through, axis=1)
        way = through / np.maximum(airspeed, 1e-9)[:, None]
        spread = np.einsum("ni,nij,nj->n", way, self.covariance, way)
        found = {"time_s": self.log.time}
        named = zip(COMPONENTS, self.wind.T, bands(self.covariance).T, strict=True)
        every = [(f"wind_{name}", value, half) for name, value, half in named]
        for name, value, half in (*every, ("airspeed", airspeed, BAND * np.sqrt(spread))):
            found |= {f"{name}_mps": value, f"{name}_low_95_mps": value - half}
            found |= {f"{name}_high_95_mps": value + half}
        found["measured_airspeed_mps"] = self.log.air_speed
        return found | {"ground_speed_mps": np.linalg.norm(self.ground_velocity, axis=1)}

    @property
    def source(self) -> tuple[float, float, float, float]:
        """Mean horizontal speed and half width of its 95 % band [m/s].  Direction from which the
        mean wind blows, clockwise from north, and half width of its 95 % band [rad].  The direction
        is NaN if the band of the speed contains zero."""
        speed = float(np.hypot(*self.mean[:2]))
        along = self.mean[:2] / speed if speed > 0.0 else np.array([1.0, 0.0])
        ways = np.stack([along, along[::-1] * [-1.0, 1.0]])
        along_band, across_band = bands(ways @ self.mean_covariance[:2, :2] @ ways.T).tolist()
        if not speed > along_band:
            return speed, along_band, math.nan, math.nan
        angle = math.atan2(-along[0], -along[1]) % (2.0 * math.pi)
        return speed, along_band, angle, math.atan(across_band / speed)

    @property
    def summary(self) -> str:
        """One line: mean wind, direction, gusts, share of well-determined samples, and errors of
        the airspeed if the log contains a measured airspeed."""
        seconds = self.log.time[-1] - self.log.time[0]
        text = f"well determined: {self.well_determined:.0%} of {seconds:.0f} s"
        if np.isnan(self.mean).any():
            return f"no mean wind: fewer than half of the samples have a wind; {text}"
        speed, half, angle, wide = self.source
        way = f"from {math.degrees(angle):.0f} +- {math.degrees(wide):.0f} deg"
        way = way if math.isfinite(angle) else "of undetermined direction"
        gusts = math.hypot(*self.gusts[:2]) / math.sqrt(2.0)
        text = f"mean wind {speed:.1f} +- {half:.1f} m/s {way}; gusts {gusts:.1f} m/s; {text}"
        found = self.columns
        off = found["airspeed_mps"] - found["measured_airspeed_mps"]
        known = np.isfinite(off)
        if known.any():
            inside = np.abs(off) <= found["airspeed_high_95_mps"] - found["airspeed_mps"]
            text += f"; airspeed minus measurement {off[known].mean():+.1f} m/s"
            text += f", rms {rms(off[known]):.1f} m/s, {inside[known].mean():.0%} in the 95 % band"
        return text


def bands(covariance: Floats) -> Floats:
    """Return half widths of 95 % bands (..., k) from covariances (..., k, k)."""
    return np.asarray(BAND * np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1)))


def estimate_wind(file: FitFile, vehicle: Vehicle, log: FlightLog) -> WindEstimate:
    """Estimate the wind over a flight from the forces on a fitted vehicle.

    Parameters
    ----------
    file : FitFile
        Fit to whole flights of the vehicle.
    vehicle : Vehicle
        The vehicle of the fit.
    log : FlightLog
        One flight with specific force and ``east``, low-passed at ``file.low_pass``.  Its
        ``velocity`` is the velocity over the ground.

    Raises
    ------
    InputError
        Unless the fit is to whole flights, and the log has specific force, heading and samples.
    """
    if file.record.kind != "flight":
        fault = f"the fit is a {file.record.kind} fit, which has no covariance of the side forces"
        raise InputError(fault, "fit whole flights with propmap fit flight --method balance")
    if len(log) < 2:
        remedy = "give a log with several seconds of flight"
        raise InputError(f"the log has {len(log)} samples in flight", remedy, log.source)
    if not np.isfinite(np.concatenate([log.specific_force, log.east])).all():
        remedy = "log accelerometer and attitude"
        raise InputError("some samples have no specific force or heading", remedy, log.source)
    every = max(1, round(1.0 / (RATE * float(np.median(np.diff(log.time))))))
    # Remove the name of the flight.  Otherwise a flight of the fit with the same name would supply
    # its thrust scale and clock offset.
    log = replace(log.picked(slice(None, None, every)), flights=("",))
    values, world = of_others(file.values), _world(log)
    wind, scales = np.zeros_like(log.velocity), USUAL
    spread = np.tile(GUESS**2 * np.eye(3), (len(log), 1, 1))

    def through(air: Floats) -> FlightLog:
        return replace(log, velocity=log.velocity - np.einsum("nwv,nw->nv", world, air))

    for step in range(MOST_STEPS):
        air = through(wind)
        errors = force_errors(file, vehicle, air, values)
        assert errors is not None  # the kind of the fit is "flight"
        force, by_wind, curved = _regression(
            lambda near: fitted_forces(file, vehicle, through(near), values).force, wind, spread
        )
        off = vehicle.mass * log.specific_force - force
        off += np.einsum("nfw,nw->nf", by_wind, wind)
        target = np.stack([off, *errors.slopes[..., :3]], axis=-1)
        size = np.sqrt(errors.left[:, :3] ** 2 + curved)[..., None]
        balance = _Balance.of(log.time, by_wind / size, target / size)
        if 0 < step < TUNED_STEPS:
            scales = balance.tuned(scales)
        found = balance.smoothed(scales, errors.covariance)
        move = found.wind - wind
        settled = np.all(BAND * np.abs(move) <= SETTLED * bands(found.covariance), axis=1)
        if step > 1 and settled.all():
            break
        # With steps of constant size, some estimates oscillate between two regressions.
        share = WHOLE_STEPS / max(step, WHOLE_STEPS)
        wind = wind + np.clip(share * move, -LONGEST_STEP, LONGEST_STEP)
        spread = spread + share * (found.covariance - spread)
    beyond = file.beyond(hub_flow(vehicle, air)[:3], vehicle.propeller.radius)
    band, half = bands(found.covariance), float(np.mean(settled)) >= 0.5
    status = np.full(len(log), "ok", dtype="<U13")
    status[False if beyond is None else beyond.samples] = "extrapolated"
    status[np.any(band[:, :2] > WELL, axis=1)] = "weak"
    status[~settled] = "not_converged"
    variance = np.var(found.wind, axis=0) + np.mean((band / BAND) ** 2, axis=0)
    variance -= np.diag(found.mean_covariance)
    remarks = [*(beyond.sentences("samples") if beyond else ()), *_doubts(found, settled)]
    if errors and errors.excluded:
        names = ", ".join(errors.excluded)
        remarks.append(f"the bands exclude {names}, which the data of the fit do not determine")
    return WindEstimate(
        log=log,
        wind=np.where(settled[:, None], found.wind, np.nan),
        covariance=np.where(settled[:, None, None], found.covariance, np.nan),
        mean=np.where(half, found.mean, np.nan),
        mean_covariance=np.where(half, found.mean_covariance, np.nan),
        gusts=np.where(half, np.sqrt(np.maximum(variance, 0.0)), np.nan),
        status=status,
        remarks=tuple(remarks),
    )


def _regression(
    force: Callable[[Floats], Floats], wind: Floats, spread: Floats
) -> tuple[Floats, Floats, Floats]:
    """Regress ``force`` linearly on a ``wind`` (n, 3) with covariance ``spread`` (n, 3, 3).
    Return mean (n, 3), slopes (n, 3, 3) and variances (n, 3) that the slopes do not explain.

    This is the posterior linearization of Garcia-Fernandez, Svensson and Sarkka (IEEE Transactions
    on Automatic Control 62, 2017, page 2056).
    """
    root, distance = np.linalg.cholesky(spread), math.sqrt(3.0)
    steps = distance * np.moveaxis(root, -1, 0)
    points = np.stack([force(wind + step) for step in (*steps, *-steps)], axis=-1)
    by_root = (points[..., :3] - points[..., 3:]) / (2.0 * distance)
    left = np.maximum(np.var(points, axis=-1) - np.sum(by_root**2, axis=-1), 0.0)
    return np.mean(points, axis=-1), by_root @ np.linalg.inv(root), left


def _doubts(found: _Smoothed, settled: NDArray[np.bool_]) -> list[str]:
    """Return remarks on samples that did not converge, and on signs of another vehicle."""
    texts, causes = [], "check mass, battery, and whether this is the vehicle of the fit"
    if not settled.all():
        texts.append(f"the wind did not converge at {np.mean(~settled):.0%} of the samples")
    if found.misfit > MISFIT:
        fault = f"the residuals are {found.misfit:.2g} times the residuals of the fit"
        texts.append(f"{fault}: {causes}")
    up = found.uncorrected_up
    if abs(up) > UPDRAFT:
        fault = f"the thrust of the fit requires a mean vertical wind of {up:.2g} m/s"
        texts.append(f"{fault}: {causes}")
    return texts


def _world(log: FlightLog) -> Floats:
    """Return the axes east, north and up in the vehicle's frame as rows, (n, 3, 3)."""
    return np.stack([log.east, np.cross(log.up, log.east), log.up], axis=1)


# -------------------------------------------------------------------------------------------------
# Kalman filter and smoother.
#
# The state contains three parts:
#   - the wind;
#   - the errors along the axes of the vehicle, divided by their standard deviations;
#   - the time integral of the wind so far, divided by the duration of the flight.
# The first column of the mean of the state is the estimate.  The other columns are the derivatives
# of the estimate with respect to the common parameters, which are the same for all samples.

WIND, ERROR, MEAN = slice(0, 3), slice(3, 6), slice(6, 9)


class _Smoothed(NamedTuple):
    """Wind (n, 3) [m/s] and mean wind (3,) with covariances, and relative residuals."""

    wind: Floats
    covariance: Floats
    mean: Floats
    mean_covariance: Floats
    uncorrected_up: float  # mean vertical wind before the common errors are corrected [m/s]
    misfit: float  # rms of the residuals, divided by their expected size [-]


class _Balance(NamedTuple):
    """Linear force balances at n samples, divided by the standard deviations of the errors."""

    time: Floats  # [s], (n,)
    slopes: Floats  # derivatives with respect to the state, (n, 3, 9); zero for NaN loads
    target: Floats  # measured - modeled force in calm air, derivatives by parameters, (n, 3, 1 + P)

    @classmethod
    def of(cls, time: Floats, by_wind: Floats, target: Floats) -> _Balance:
        """Return the balances; rows of zeros exclude samples with NaN rotor loads."""
        both = np.concatenate([by_wind, target], axis=-1)
        kept = np.isfinite(both).all(axis=(1, 2), keepdims=True)
        slopes = np.zeros((time.size, 3, 9))
        slopes[..., WIND], slopes[..., ERROR] = by_wind, math.sqrt(1.0 - WHITE**2) * np.eye(3)
        return cls(time, np.where(kept, slopes, 0.0), np.where(kept, target, 0.0))

    def tuned(self, scales: Floats) -> Floats:
        """Return the most probable scales (5,), logarithms in the order of ``USUAL``; the search
        starts at ``scales``."""
        from scipy.optimize import minimize

        first = max(0, (self.time.size - TUNED_SAMPLES) // 2)
        time, slopes, target = (each[first : first + TUNED_SAMPLES] for each in self)
        part, h = _Balance(time, slopes, target[..., :1]), 1e-3
        steps = np.concatenate([np.zeros((1, USUAL.size)), h * np.eye(USUAL.size)])

        def loss(at: Floats) -> tuple[float, Floats]:
            near = at + steps
            each = 0.5 * np.sum(((near - USUAL) / SPREAD) ** 2, axis=1) - part.filtered(near)[1]
            return float(each[0]), (each[1:] - each[0]) / h

        bounds = list(zip(USUAL - 4.0 * SPREAD, USUAL + 4.0 * SPREAD, strict=True))
        found = minimize(loss, scales, jac=True, bounds=bounds, options={"ftol": 1e-5})
        return np.asarray(found.x)

    def moves(self, scales: Floats) -> tuple[Floats, Floats]:
        """Return the transition matrices to each sample (n, m, 9, 9) and the variances of the noise
        (n, m, 9), for ``scales`` (m, 5)."""
        steps = np.maximum(np.diff(self.time, prepend=self.time[0]), 0.0)[:, None, None]
        kept = np.exp(-steps / np.exp(scales[:, 2:]))
        move = np.zeros((*kept.shape[:2], 9, 9)) + np.eye(9)
        for k in range(3):
            move[..., 3 + k, 3 + k] = kept[..., k]
            move[..., 6 + k, k] = steps[..., 0] / steps.sum()
        move[..., 2, 2] = np.exp(-steps[..., 0] / VERTICAL)
        noise = np.zeros((*kept.shape[:2], 9))
        noise[..., :2] = steps * np.exp(scales[:, :1])
        noise[..., 2] = (1.0 - move[..., 2, 2] ** 2) * np.exp(scales[:, 1])
        noise[..., ERROR] = 1.0 - kept**2
        return move, noise

    def filtered(self, scales: Floats) -> tuple[list[tuple[Floats, ...]], Floats]:
        """Return mean, covariance, gain, innovation and inverse of its covariance at each sample,
        and the logarithms of the likelihoods (m,), for ``scales`` (m, 5)."""
        count, place = len(scales), np.arange(9)
        mean = np.zeros((count, 9, self.target.shape[-1]))
        covariance = np.tile(
            np.diag([FIRST, FIRST, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]) ** 2, (count, 1, 1)
        )
        covariance[:, 2, 2] = np.exp(scales[:, 1])
        found, likelihood = list[tuple[Floats, ...]](), np.zeros(count)
        every = zip(self.slopes, self.target, *self.moves(scales), strict=True)
        for slopes, target, move, noise in every:
            mean = move @ mean
            covariance = move @ covariance @ move.swapaxes(1, 2)
            covariance[:, place, place] += noise
            seen = covariance @ slopes.T
            spread = slopes @ seen + WHITE**2 * np.eye(3)
            inverse = np.linalg.inv(spread)
            gain, innovation = seen @ inverse, target - slopes @ mean
            mean = mean + gain @ innovation
            covariance = covariance - gain @ seen.swapaxes(1, 2)
            covariance = 0.5 * (covariance + covariance.swapaxes(1, 2))
            squares = np.einsum("mi,mij,mj->m", innovation[..., 0], inverse, innovation[..., 0])
            likelihood -= 0.5 * (squares + np.log(np.linalg.det(spread)))
            found.append((mean, covariance, gain, innovation, inverse))
        return found, likelihood

    def smoothed(self, scales: Floats, common: Floats) -> _Smoothed:
        """Return the smoothed wind; ``common`` (P, P) is the covariance of the common parameters.

        The recursion (Bierman, Int. J. Control 18, 1973, page 65) inverts no covariance of states.
        """
        found, move = self.filtered(scales[None])[0], self.moves(scales[None])[0][:, 0]

        last, its_spread = found[-1][0][0, MEAN], found[-1][1][0, MEAN, MEAN]
        # Without an update of ``common``, thrust errors would appear as a lasting vertical wind.
        up, seconds = last[2, 1:], self.time[-1] - self.time[0]
        prior = UP**2 + np.exp(scales[1]) * min(1.0, 2.0 * VERTICAL / seconds)
        share = common @ up / (up @ common @ up + prior - its_spread[2, 2])
        common = common - np.outer(share, up @ common)
        errors = np.concatenate([[1.0], -share * last[2, 0]])

        def widened(covariance: Floats, columns: Floats) -> Floats:
            return np.asarray(covariance + columns[:, 1:] @ common @ columns[:, 1:].T)

        wind, spread = np.empty((len(found), 3)), np.empty((len(found), 3, 3))
        adjoint, curvature, squares = np.zeros((9, self.target.shape[-1])), np.zeros((9, 9)), 0.0
        for k in range(len(found) - 1, -1, -1):
            mean, covariance, gain, innovation, inverse = (each[0] for each in found[k])
            rows = covariance[WIND]
            columns = mean[WIND] - rows @ adjoint
            wind[k] = columns @ errors
            spread[k] = widened(rows[:, WIND] - rows @ curvature @ rows.T, columns)
            weighted = self.slopes[k].T @ inverse
            kept = np.eye(9) - gain @ self.slopes[k]
            adjoint = move[k].T @ (kept.T @ adjoint - weighted @ innovation)
            curvature = kept.T @ curvature @ kept + weighted @ self.slopes[k]
            curvature = move[k].T @ curvature @ move[k]
            squares += float(innovation[:, 0] @ inverse @ innovation[:, 0])
        misfit = math.sqrt(squares / self.target[..., 0].size)
        mean = last @ errors
        return _Smoothed(wind, spread, mean, widened(its_spread, last), float(last[2, 0]), misfit)
