"""Parameters against measurements, beside the hover model, and verdicts on what is left over."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from propmap.catalogue.identified import PARAMETERS
from propmap.errors import InputError
from propmap.fit import flight, parameters
from propmap.fit.files import DataSource, FitFile
from propmap.fit.fit import Fitted, Settings, fit
from propmap.fit.least_squares import (
    FlightErrors,
    ResidualErrors,
    Rows,
    by_band,
    errors,
    rms,
    rms_known,
    search,
)
from propmap.fit.moments import measured_moment
from propmap.fit.tunnel import TunnelData, model_with, rotor_with
from propmap.fit.uncertainty import uncertainty
from propmap.hover import HoverModel
from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil, SectionCovariance
from propmap.model.envelope import Beyond
from propmap.model.model import Model, Section
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.log import FlightLog, flight_names, hub_flow, joined
from propmap.vehicle.vehicle import Vehicle
from propmap.vehicle.vehicle_forces import mounted_rotors
from propmap.vehicle.wakes import in_wakes


@dataclass(frozen=True)
class SpeedErrors:
    """Errors of a load over all rows, in and outside the fit's envelope, and in bands of speed."""

    all: ResidualErrors
    by_speed: Mapping[str, ResidualErrors]
    # By ``INSIDE`` and ``OUTSIDE``, where there are rows; empty where no envelope is known.
    by_envelope: Mapping[str, ResidualErrors] = field(default_factory=dict)
    in_band: float = np.nan  # share of the rows in the 95 % band; NaN where none is known

    @property
    def bands(self) -> dict[str, ResidualErrors]:
        """All of them by name."""
        return {"all": self.all, **self.by_envelope, **self.by_speed}


INSIDE, OUTSIDE = "inside the training's envelope", "outside"


def compare_tunnel(
    model: Model, data: TunnelData, beyond: Beyond | None = None
) -> dict[str, SpeedErrors]:
    """Errors of a model on loads measured in a tunnel or on a bench.

    Parameters
    ----------
    model : Model
        The section law to judge, with the propeller and the air of the test.
    data : TunnelData
        What was measured.
    beyond : Beyond, optional
        How far the rows leave the envelope of what the model was fitted to.

    Returns
    -------
    dict of str to SpeedErrors
        Every measured load by its name with unit.  The hover model beside it has thrust and
        torque alone.
    """
    rotor = Rotor(model)
    loads = rotor.loads(data.omega, data.speed, data.beta)
    hovers = HoverModel.of(rotor).loads(data.omega)
    return {
        LOADS[name].column: compared(
            getattr(loads, name), measured, data.speed, hovers[name], beyond
        )
        for name, measured in data.loads.items()
    }


@dataclass(frozen=True, eq=False)
class FlightForces:
    """All forces but gravity on a vehicle at n samples, felt where the accelerometer sits [N], and
    moments about the centre of mass [N m], in the vehicle's frame."""

    model: Floats  # (n, 6)
    hover: Floats  # (n, 6)


def flight_forces(
    vehicle: Vehicle, log: FlightLog, law: Section, values: Mapping[str, float]
) -> FlightForces:
    """All forces but gravity on a vehicle, by a section law and what a fit found besides.

    Parameters
    ----------
    vehicle, log : Vehicle, FlightLog
        What flew, and how.
    law : Airfoil or SectionTable
        The section law to judge.
    values : mapping of str to float
        All parameters but the rotor's by name; first guesses, or the vehicle file's, where it has
        none.
    """
    model = Model(vehicle.propeller, law, vehicle.air)
    logged = hub_flow(vehicle, log)
    flow = logged._replace(omega=values.get(parameters.ROTOR_SPEED, 1.0) * logged.omega)
    wakes = flight.wakes_with(vehicle, values)
    near = flow if wakes is None else in_wakes(vehicle, wakes, model, flow)
    velocity = np.stack([near.inplane, np.zeros_like(near.inplane), near.axial], axis=-1)
    loads = np.empty((len(LOADS), *near.omega.shape))
    for mounted, mine in mounted_rotors(vehicle, model):
        found = Rotor(mounted).loads_at_velocity(near.omega[:, mine], velocity[:, mine])
        loads[..., mine] = [getattr(found, name) for name in LOADS]
    none = np.zeros((0, len(log), 6))
    rotors = flight.six_loads(flow, loads)
    whole = flight.on_vehicle(
        vehicle, log, logged, rotors, none, {**parameters.FIRST_GUESS, **values}, ()
    )
    return FlightForces(whole.loads, flight.hover_loads(HoverModel.of(Rotor(model)), logged))


PER_FLIGHT_DEVIATION = {
    "thrust_scale": flight.OVER_FLIGHTS,
    flight.CLOCK: flight.CLOCK_DEVIATION,
    **dict.fromkeys(
        flight.TILT, 0.01
    ),  # [rad], as attitudes are trimmed, and frames of markers set
}  # standard deviations of what flights have of their own, before one of them is known

BAND = 1.96  # half the width of a band that holds 95 %, in standard deviations


def force_deviations(
    file: FitFile, vehicle: Vehicle, log: FlightLog, values: Mapping[str, float]
) -> Floats | None:
    """Standard deviations (n, 6) of forces [N] and moments [N m] by a fit of whole flights.

    They are from the joint covariance of all that was free, throttle and drag among it, from what
    differs from flight to flight, and from what the fit left on rows that it had not seen: that
    grows with the force on the vehicle, as errors of loads do, or with V/(Omega R) beyond the data
    of the fit, whichever is more. NaN where a load was not fitted; None for a fit of other data.
    """
    record = file.record
    if record.kind != "flight":
        return None
    known = SectionCovariance(tuple(record.free), record.covariance).determined
    known = known.of(
        [name for name in known.names if parameters.general(name) not in parameters.PER_FLIGHT]
    )
    law = parameters.constants_of(file.airfoil)
    found = {p.name: p.value for p in record.parameters}
    own = {name: getattr(law, name) for name in parameters.SECTION}
    whole = {**parameters.FIRST_GUESS, **own, **record.fixed, **found, **values}
    names = tuple(dict.fromkeys((*known.names, *PER_FLIGHT_DEVIATION)))
    loads, derivatives = flight.ForceModel(vehicle, log, law).at(whole, names)
    slopes = dict(zip(names, derivatives, strict=True))
    by_known = np.stack([slopes[name] for name in known.names])
    variance = np.einsum("pnl,pq,qnl->nl", by_known, known.matrix, by_known)
    for name, deviation in PER_FLIGHT_DEVIATION.items():
        variance += (deviation * slopes[name]) ** 2
    beyond = file.beyond(hub_flow(vehicle, log)[:3], vehicle.propeller.radius)
    fitted = {one.name: one for one in record.loads}
    trained = sum(fitted[name].measured_rms ** 2 for name in flight.AXES)
    growth = np.sum(loads[:, :3] ** 2, axis=1) / trained
    growth = np.maximum(growth, 1.0 if beyond is None else beyond.reach**2)
    for k, name in enumerate((*flight.AXES, *flight.MOMENTS)):
        left = np.nan
        if name in fitted:
            left = fitted[name].cross_validated
            left = left if np.isfinite(left) else fitted[name].rms
        variance[:, k] += growth * left**2
    return np.asarray(np.sqrt(variance))


def compare_forces(
    vehicle: Vehicle,
    log: FlightLog,
    forces: FlightForces,
    beyond: Beyond | None = None,
    deviations: Floats | None = None,
) -> dict[str, SpeedErrors]:
    """Errors of forces against mass times specific force, and of moments against what turns the
    vehicle where its inertia is known, by name with unit.

    ``beyond`` says how far samples leave the fit's envelope, ``deviations`` (n, 6) how far forces
    and moments may err. ``InputError`` without specific force.
    """
    measured = np.concatenate(
        [vehicle.mass * log.specific_force, measured_moment(vehicle, log)], axis=1
    )
    if not np.isfinite(measured[:, :3]).any():
        raise InputError("there is no specific force to compare with", "log it", log.source)
    names = (*flight.AXES, *flight.MOMENTS) if np.isfinite(measured[:, 3:]).any() else flight.AXES
    found = {}
    for k, name in enumerate(names):
        both = forces.model[:, k], measured[:, k]
        one = compared(*both, log.speed, forces.hover[:, k], beyond)
        if deviations is not None:
            off = np.abs(both[0] - both[1])
            known = np.isfinite(off) & np.isfinite(deviations[:, k])
            if known.any():
                inside = (off <= BAND * deviations[:, k])[known]
                one = replace(one, in_band=float(np.mean(inside)))
        found[f"{name}_{flight.UNITS[name].replace(' ', '')}"] = one
    return found


def useless(load: str, share: float) -> list[str]:
    """Say so where a moment's error is as large a ``share`` of what was measured as that of none.

    Forces next to nothing across a flight are no fault of a model; moments are all of that size.
    """
    if load not in flight.MOMENTS or not share >= 1.0:
        return []
    return [
        f"{load}: the error is {100.0 * share:.0f} % of what was measured, no better than "
        "predicting none: do not use it"
    ]


def force_trends(vehicle: Vehicle, log: FlightLog, forces: FlightForces) -> list[list[Trend]]:
    """Find what the error of each force depends on, the strongest first; see ``compare_forces``."""
    off = forces.model[:, :3] - vehicle.mass * log.specific_force
    block = log.stretches(flight.CORRELATED)
    return [trends(log, name, "N", off[:, k], block) for k, name in enumerate(flight.AXES)]


def compare_flight(
    vehicle: Vehicle, log: FlightLog, law: Section, values: Mapping[str, float]
) -> dict[str, SpeedErrors]:
    """``compare_forces`` of ``flight_forces`` with ``vehicle``, ``log``, ``law`` and ``values``."""
    return compare_forces(vehicle, log, flight_forces(vehicle, log, law, values))


def compare_level(
    vehicle: Vehicle,
    log: FlightLog,
    law: Section,
    values: Mapping[str, float],
    beyond: Beyond | None = None,
) -> dict[str, SpeedErrors]:
    """Errors of the vertical force of steady level flights against the weight, eqs. (16)(17),
    arguments as of ``flight_forces`` and ``compare_forces``."""
    model, hover = level_forces(vehicle, log, law, values)
    weight = np.full(len(log), vehicle.mass * GRAVITY)
    return {"vertical_force_N": compared(model, weight, log.speed, hover, beyond)}


def level_forces(
    vehicle: Vehicle, log: FlightLog, law: Section, values: Mapping[str, float]
) -> tuple[Floats, Floats]:
    """Vertical forces [N] (n,) of model and hover model, wherever the accelerometer sits."""
    values = {
        name: value
        for name, value in values.items()
        if parameters.general(name) not in parameters.SENSOR
    }
    here = replace(vehicle, sensor=(0.0, 0.0, 0.0))
    found = flight_forces(here, log, law, values)
    model, hover = (np.sum(one[:, :3] * log.up, axis=1) for one in (found.model, found.hover))
    return model, hover


def compared(
    model: Floats, measured: Floats, speed: Floats, hover: Floats, beyond: Beyond | None
) -> SpeedErrors:
    """Errors of a ``model`` and of the ``hover`` model on what was ``measured``; (n,) each."""
    parts = {} if beyond is None else {INSIDE: ~beyond.samples, OUTSIDE: beyond.samples}
    by_envelope = {
        name: errors(model[mine], measured[mine], hover[mine])
        for name, mine in parts.items()
        if mine.any()
    }
    by_speed = by_band(model, measured, speed, hover)
    return SpeedErrors(errors(model, measured, hover), by_speed, by_envelope)


# -------------------------------------------------------------------------------------------------
# How far forward flight is known: relative uncertainty of thrust and torque, before and after.

ADVANCE = (0.0, 0.2, 0.4, 0.6, 0.2, 0.4, 0.6)  # J = V / (n D) of the points looked at [-]
BETA = np.radians([0.0, 0.0, 0.0, 0.0, 90.0, 90.0, 90.0])  # their angles to the axis [rad]

JUDGED = ("thrust", "torque")

MODEL_ERROR = 0.03
"""Error of the model with the best constants, as a share of the load at rest; so much makes
the intervals hold after a fit to static rows: ``python -m tools.after_static``."""

SMALL = 0.1  # share of the load at rest below which a relative uncertainty of a load means nothing


@dataclass(frozen=True, eq=False)
class ForwardTrust:
    """Thrust and torque at m points, and how uncertain they are before and after a fit."""

    omega: float  # rotational speed of all points [rad/s]
    advance: Floats  # V / (n D) [-], (m,)
    beta: Floats  # angle to the axis [rad], (m,)
    load: Floats  # thrust [N] and torque [N m] after the fit, (m, 2)
    # Standard deviations over the loads [-], (m, 2); NaN where a load is hardly there, and infinite
    # where nothing was known.
    before: Floats
    after: Floats


def forward_trust(model: Model, fitted: Fitted, omega: float, setting: str) -> ForwardTrust:
    """Uncertainty that a fit of a ``model`` leaves at rest, in axial and in edgewise flow: to first
    order sqrt(g' S g) by the free constants, before and after, and ``MODEL_ERROR`` beside it."""
    choice = fitted.choice
    by_prior = choice.prior_residuals(choice.first)[1]
    before = np.asarray(np.linalg.pinv(by_prior.T @ by_prior), np.float64)
    unknown = [k for k, name in enumerate(choice.free) if choice.prior_of(name) is None]
    speed = np.array(ADVANCE) * omega / (2.0 * np.pi) * model.propeller.diameter
    flow = np.full(speed.size, omega), speed * np.cos(BETA), speed * np.sin(BETA)
    rows = [list(LOADS).index(name) for name in JUDGED]

    def loads(x: Floats, covariance: Floats) -> tuple[Floats, Floats]:
        rotor = rotor_with(model, choice.values(x), setting)
        names = tuple(name for name in choice.free if name in parameters.ROTOR)
        found = rotor.gradients(names, *flow)
        mine = [choice.free.index(name) for name in names]
        part = covariance[np.ix_(mine, mine)]
        variance = np.einsum("lpm,pq,lqm->ml", found.slopes[rows], part, found.slopes[rows])
        load = found.loads[rows].T
        relative = np.sqrt(variance + (MODEL_ERROR * load[0]) ** 2) / np.abs(load)
        return load, np.where(load < SMALL * load[0], np.nan, relative)

    _, was = loads(choice.first, before)
    if unknown:
        was = np.where(np.isfinite(was), np.inf, was)
    load, now = loads(fitted.x, fitted.uncertainty.covariance)
    return ForwardTrust(omega, np.array(ADVANCE), BETA, load, was, now)


FAR = 2.5  # z-score among propellers from which a constant is worth a remark


def unlikely_constants(fitted: Fitted) -> list[str]:
    """Name in a sentence a fit's constants far from other propellers'; none without a prior."""
    expected = fitted.choice.expected
    if expected is None:
        return []
    away = np.abs(expected.z_scores(fitted.values)[0])
    own = {**fitted.choice.fixed, **fitted.choice.priors}
    far = [
        f"{name} is {fitted.values[name]:.3g}, {away[k]:.1f} standard deviations from the "
        "mean of propellers"
        for k, name in enumerate(PARAMETERS)
        if away[k] > FAR and name not in own
    ]
    if not far:
        return []
    return [f"{'; '.join(far)}: check the blade's twist, the radius, the units and the density"]


# -------------------------------------------------------------------------------------------------
# What one more free parameter changes in a fit: assumptions that fail, terms of the body.

REMARKABLE = 0.7  # share of the residuals' size below which an assumption is worth a remark
POOR = 0.03  # relative residual from which a fit is looked into

ASSUMPTIONS = {
    "zero_lift_angle": "C_L(0) = 0, an uncambered section",
    "c_d0": "c_d0 = 0.01, the constant drag",
    "mount_area": "the rotor drag without more in the slipstream",
}  # what holds as long as the parameter is not free

BODY_TERMS = ("lift_area", "drag_area_x")

LEAST_FALL = 0.05  # share by which a term of the body has to lower the residuals to pay


def failing_assumptions(fitted: Fitted, rows_for: Callable[[parameters.Choice], Rows]) -> list[str]:
    """Name the assumptions of the section law that lower the residuals of a poor fit by 30 % or
    more when given up; ``rows_for`` gives its data as rows for another choice."""
    size = rms(fitted.minimum.residual)
    if size < POOR:
        return []
    sentences = []
    for name, assumption in ASSUMPTIONS.items():
        acts = name not in parameters.MOUNT or "drag" in fitted.rows.names
        if name in fitted.choice.free or not acts:
            continue
        choice, begin = _with(fitted, name)
        again = search(rows_for(choice), choice, [choice.first, begin], error=fitted.error)
        left = rms(again.residual) / size
        if left < REMARKABLE:
            sentences.append(
                f"{assumption}, does not hold: with {name} free ({again.x[-1]:.3g} "
                f"{parameters.described(name).unit}) the residuals fall to {100.0 * left:.0f} %"
            )
    return sentences


def body_terms_verdict(fitted: Fitted, rows_for: Callable[[parameters.Choice], Rows]) -> list[str]:
    """Say whether lift and drag of the body pay in a flight fit without them (section III.A): by an
    interval without zero and a fall of the residuals; ``rows_for`` gives its data for another
    choice."""
    sentences = []
    size = rms(fitted.minimum.residual)
    for name in BODY_TERMS:
        if name in fitted.choice.free:
            continue
        choice, begin = _with(fitted, name)
        rows = rows_for(choice)
        again = search(rows, choice, [begin], error=fitted.error)
        sure = uncertainty(rows, choice, again, fitted.error)
        fall = 1.0 - rms(again.residual) / size if size > 0.0 else 0.0
        shift = np.max(np.abs(again.x[:-1] - fitted.x) / fitted.choice.column("spread"))
        nonzero = sure.low[-1] > 0.0 or sure.high[-1] < 0.0
        pays = "pays" if nonzero and fall > LEAST_FALL else "does not pay"
        sentences.append(
            f"{name} {pays}: {again.x[-1]:.4g} m^2 ({sure.low[-1]:.2g} to {sure.high[-1]:.2g}), "
            f"residuals {-100.0 * fall:+.1f} %, the other parameters move by at most "
            f"{shift:.2f} of their spread"
        )
    return sentences


def _with(fitted: Fitted, name: str) -> tuple[parameters.Choice, Floats]:
    """The choice of a fit with one more free parameter, the last, and where to begin."""
    fixed = {k: v for k, v in fitted.choice.fixed.items() if k != name}
    choice = replace(fitted.choice, free=(*fitted.choice.free, name), fixed=fixed)
    return choice, np.append(fitted.x, fitted.values.get(name, parameters.described(name).start))


# -------------------------------------------------------------------------------------------------
# Which variables the residuals of a flight fit still depend on, in words.

LEAST_SHARE = 0.05  # share of the residuals' variance from which a variable is worth a sentence
CERTAIN = 3.0  # slope over its block-wise standard error from which it is significant
MOST = 2  # sentences per load


def candidates(log: FlightLog) -> dict[str, Floats]:
    """Variables (n,) of a log that residuals may depend on, by their names with units."""
    forward, left, up = log.velocity.T
    roll, pitch, yaw = log.rates.T
    rotor = np.sqrt(np.mean(np.square(log.rotor_speed), axis=1))
    return {
        "speed [m/s]": log.speed,
        "forward velocity [m/s]": forward,
        "sideways velocity to the left [m/s]": left,
        "velocity along the body's z axis [m/s]": up,
        "square of the forward velocity [m^2/s^2]": forward**2,
        "square of the sideways velocity [m^2/s^2]": left**2,
        "climb rate [m/s]": log.climb_rate,
        "speed of descent along z [m/s]": np.maximum(-up, 0.0),
        "roll rate [rad/s]": roll,
        "pitch rate [rad/s]": pitch,
        "yaw rate [rad/s]": yaw,
        "square of the roll rate [rad^2/s^2]": roll**2,
        "square of the pitch rate [rad^2/s^2]": pitch**2,
        "rotor speed [rad/s]": rotor,
        "time since the flight's start [s]": log.since_start,
    }


@dataclass(frozen=True, eq=False)
class Trend:
    """Dependence of the residual of one load on one variable, over n samples."""

    load: str
    unit: str
    variable: str  # with its unit
    at: Floats  # the variable, (n,)
    residual: Floats  # model minus measurement, (n,)
    block: NDArray[np.intp]  # stretches within which errors may be correlated, (n,)
    slope: float  # by least squares
    error: float  # its block-wise standard error
    share: float  # of the residual's variance that the slope explains [-]

    @property
    def sure(self) -> bool:
        """Whether it is significant and large enough for a sentence."""
        return self.share >= LEAST_SHARE and abs(self.slope) >= CERTAIN * self.error

    @property
    def sentence(self) -> str:
        """Say how the residual changes with the variable."""
        way, per = "grows" if self.slope > 0.0 else "falls", self.variable.partition(" [")
        return (
            f"the error of {self.load} {way} with {per[0]}: {self.slope:+.2g} {self.unit} per "
            f"{per[2].rstrip(']')}, {100.0 * self.share:.0f} % of its variance"
        )


def trends(
    log: FlightLog, load: str, unit: str, residual: Floats, block: NDArray[np.intp]
) -> list[Trend]:
    """Fit the ``residual`` (n,) of a load, model minus measurement, to every candidate, the
    strongest first; errors may be correlated within a ``block`` (n,)."""
    known = np.isfinite(residual)
    off, stretch, found = residual[known], block[known], []
    for name, variable in candidates(log).items():
        at = variable[known]
        found.append(Trend(load, unit, name, at, off, stretch, *_slope(at, off, stretch)))
    return sorted(found, key=lambda trend: -trend.share)


def residual_trends(fitted: Fitted, log: FlightLog) -> list[str]:
    """Say what the residuals of a fit to the samples of ``log`` still depend on, the strongest
    first, two sentences per load at most."""
    rows, sentences = fitted.rows, []
    if rows.group is None:
        return []
    for k, (load, unit) in enumerate(zip(rows.names, rows.units, strict=True)):
        mine = rows.of_load(k)
        residual, block = np.full(len(log), np.nan), np.zeros(len(log), dtype=np.intp)
        residual[rows.point[mine]] = fitted.residual[mine]
        block[rows.point[mine]] = rows.group[mine]
        sure = [one for one in trends(log, load, unit, residual, block) if one.sure]
        sentences += [one.sentence for one in sure[:MOST]]
    return sentences


def _slope(
    variable: Floats, residual: Floats, block: NDArray[np.intp]
) -> tuple[float, float, float]:
    """Slope of the residual, its block-wise standard error, and the share of its variance."""
    x, y = variable - variable.mean(), residual - residual.mean()
    size, spread = float(x @ x), float(y @ y)
    if size <= 1e-12 * max(float(variable @ variable), 1e-300) or spread == 0.0:
        return 0.0, np.inf, 0.0
    slope = float(x @ y) / size
    _, index = np.unique(block, return_inverse=True)
    scores = np.bincount(index, weights=x * (y - slope * x))
    return slope, float(np.sqrt(scores @ scores)) / size, slope**2 * size / spread


# -------------------------------------------------------------------------------------------------
# What each term of a whole-flight fit is worth, on flights that the fit has not seen.

SURE = 2.0  # standard errors by which a term has to change the mean square error to be said to pay


@dataclass(frozen=True, eq=False)
class RecordedFlight:
    """One flight, its signals low-passed and as recorded, with another's prediction of its forces
    [N], (n, 3) at the samples of either, where there is one."""

    name: str
    passed: FlightLog  # low-passed
    raw: FlightLog  # not low-passed
    prediction: Floats | None = None
    raw_prediction: Floats | None = None


@dataclass(frozen=True)
class Step:
    """A model with one term more than the one before it."""

    name: str  # of what is added
    choice: parameters.Choice  # what is free
    vertical: bool = False  # whether the vertical forces alone are fitted


@dataclass(frozen=True, eq=False)
class AxisErrors:
    """Errors of forces on one flight along x, y and z, model minus measurement [N]."""

    passed: Floats  # of low-passed signals, (n, 3)
    raw: Floats  # of signals as they were recorded, (m, 3)

    @property
    def rms(self) -> Floats:
        """Root mean squares of the low-passed errors, (3,)."""
        return np.asarray(np.sqrt(np.nanmean(self.passed**2, axis=0)))

    @property
    def raw_rms(self) -> Floats:
        """Root mean squares of the errors as recorded, (3,)."""
        return np.asarray(np.sqrt(np.nanmean(self.raw**2, axis=0)))


@dataclass(frozen=True, eq=False)
class FittedStep:
    """One step fitted to all flights but one, or to a single flight."""

    step: str  # its name
    left_out: int | None  # number of the flight that was not fitted to; None for a single flight
    values: dict[str, float]  # the free parameters
    off: tuple[AxisErrors, ...]  # errors of this model, one per flight
    hover: tuple[AxisErrors, ...]  # errors of the hover model with its blade


def fit_terms(
    vehicle: Vehicle,
    flights: Sequence[RecordedFlight],
    steps: Sequence[Step],
    law: Airfoil,
    *,
    samples: int,
    tell: Callable[[str], None] | None = None,
) -> list[FittedStep]:
    """Fit all steps, each flight in turn left out and at most ``samples`` of the others, with the
    ``law`` for what no step frees, in the order of steps, then flights left out; ``tell`` gets a
    line after each."""
    found = []
    for step in steps:
        for left_out in range(len(flights)) if len(flights) > 1 else (None,):
            seen = joined([f.passed for k, f in enumerate(flights) if k != left_out])
            picked = np.unique(np.linspace(0, len(seen) - 1, min(samples, len(seen))).astype(int))
            model = flight.ForceModel(vehicle, seen.picked(picked), law)
            rows = (flight.vertical_rows if step.vertical else flight.balance_rows)(
                model, step.choice
            )
            values = fit(rows, step.choice, Settings(starts=1, folds=0)).values
            pairs = [_off(vehicle, flown, law, values) for flown in flights]
            off, hover = zip(*pairs, strict=True)
            free = {name: values[name] for name in step.choice.free}
            found.append(FittedStep(step.name, left_out, free, off, hover))
            if tell is not None:
                unseen = found[-1].off[left_out or 0].rms
                tell(f"{step.name}: {', '.join(f'{x:.3f}' for x in unseen)} N")
    return found


def gain(
    old: Sequence[AxisErrors], new: Sequence[AxisErrors], flights: Sequence[RecordedFlight]
) -> tuple[float, float]:
    """Fall of the mean square of the force error from one model to another and its deviation [N^2];
    errors within a second count as one, as they are correlated."""
    means = []
    for a, b, flown in zip(old, new, flights, strict=True):
        fall = np.sum(a.passed**2 - b.passed**2, axis=1)
        block = flown.passed.stretches(flight.CORRELATED)
        known = np.isfinite(fall)
        total = np.bincount(block[known], fall[known])
        count = np.bincount(block[known])
        means += (total[count > 0] / count[count > 0]).tolist()
    each = np.array(means)
    deviation = float(np.std(each, ddof=1)) / np.sqrt(each.size) if each.size > 1 else np.inf
    return float(np.mean(each)), float(deviation)


def judged(fall: float, deviation: float) -> str:
    """Say in a word or two whether a term with such a ``gain`` pays."""
    if fall > SURE * deviation:
        return "pays"
    if fall < -SURE * deviation:
        return "makes it worse"
    return "no sure gain"


def measured_off(vehicle: Vehicle, flown: RecordedFlight) -> AxisErrors | None:
    """Errors of the prediction that comes with a flight; None where there is none."""
    if flown.prediction is None or flown.raw_prediction is None:
        return None
    return AxisErrors(
        flown.prediction - vehicle.mass * flown.passed.specific_force,
        flown.raw_prediction - vehicle.mass * flown.raw.specific_force,
    )


def _off(
    vehicle: Vehicle, flown: RecordedFlight, base: Airfoil, values: dict[str, float]
) -> tuple[AxisErrors, AxisErrors]:
    """Errors of a fit's model and of the hover model."""
    found = model_with(Model(vehicle.propeller, base, vehicle.air), values)
    law = replace(parameters.constants_of(found.airfoil), corrections=tuple(found.correction_texts))
    others = {
        n: values[n]
        for n in (parameters.BODY | parameters.SENSOR | parameters.WAKES)
        if n in values
    }
    logs = (flown.passed, flown.raw)
    forces = [flight_forces(vehicle, log, law, parameters.FIRST_GUESS | others) for log in logs]
    measured = [vehicle.mass * log.specific_force for log in logs]
    model = (f.model[:, :3] - m for f, m in zip(forces, measured, strict=True))
    hover = (f.hover[:, :3] - m for f, m in zip(forces, measured, strict=True))
    return AxisErrors(*model), AxisErrors(*hover)


def values_for(
    file: FitFile, vehicle: Vehicle, log: FlightLog, paths: Sequence[Path]
) -> tuple[dict[str, float], list[str]]:
    """Choose parameters for the flights of a ``log`` from ``paths``, and remarks: a flight of the
    fit keeps its own, another has the mean's, and the thrust scale of its own hover where that is
    sure."""
    logs = file.record.data[:-1]  # The vehicle's file is the last.
    names = flight_names([source.file for source in logs])
    seen = {source.sha256: name for source, name in zip(logs, names, strict=True)}
    values, remarks = flight.of_others(file.values), []
    by_hover, applied = dict[str, float](), dict[str, float]()
    if file.hover_reference:
        hovers = flight.HoverScale.of(vehicle, log, file.hover_reference)
        by_hover, applied = hovers.scales, hovers.remarkable
    for named, path in zip(log.flights, paths, strict=True):
        name = seen.get(DataSource.of(path).sha256)
        for one in parameters.PER_FLIGHT:
            here = parameters.of_flight(one, named)
            values.pop(here, None)
            if name is not None:
                common = values.get(one, parameters.EVERY[one].start)
                values[here] = file.values.get(parameters.of_flight(one, name), common)
        scale = parameters.of_flight("thrust_scale", named)
        if name is None and scale in by_hover:
            values |= {scale: applied[scale]} if scale in applied else {}
            why = "so much is applied" if scale in applied else "too near to 1 to be applied"
            remarks.append(
                f"in its hover flight {named} has {by_hover[scale]:.3f} times the thrust of the "
                f"fit's flights at the same rotor speeds: {why}"
            )
    return values, remarks


def by_flight(fitted: Fitted, log: FlightLog) -> dict[str, dict[str, FlightErrors]]:
    """Errors by load and by flight of a fit to the samples of ``log``; none of one flight alone."""
    if len(log.flights) < 2:
        return {}
    rows = fitted.rows
    numbers = log.flight[rows.point]

    def of(load: int, number: int) -> FlightErrors:
        mine = rows.of_load(load) & (numbers == number) & np.isfinite(fitted.residual)
        off = fitted.residual[mine]
        bias = float(off.mean()) if off.size else float("nan")
        return FlightErrors(off.size, rms_known(off), bias, rms_known(fitted.left_out[mine]))

    return {
        load: {name: of(k, number) for number, name in enumerate(log.flights)}
        for k, load in enumerate(rows.names)
    }
