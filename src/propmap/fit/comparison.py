"""Comparison of models with measurements and the hover model, and verdicts on the residuals."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.bands import OBLIQUE
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
    """Errors of a load over all rows, inside and outside the envelope of the fit, and by speed."""

    all: ResidualErrors
    by_speed: Mapping[str, ResidualErrors]
    # With the keys ``INSIDE`` and ``OUTSIDE``, if they have rows; empty without an envelope.
    by_envelope: Mapping[str, ResidualErrors] = field(default_factory=dict)
    in_band: float = np.nan  # share of the rows in the 95 % band; NaN without a band

    @property
    def bands(self) -> dict[str, ResidualErrors]:
        """All statistics by name."""
        return {"all": self.all, **self.by_envelope, **self.by_speed}


INSIDE, OUTSIDE = "within the fitted data", "outside the fitted data"


def compare_tunnel(
    model: Model, data: TunnelData, beyond: Beyond | None = None
) -> dict[str, SpeedErrors]:
    """Return the errors of a model for loads measured in a wind tunnel or on a bench.

    Parameters
    ----------
    model : Model
        Model with the propeller and the air of the test.
    data : TunnelData
        Measured loads.
    beyond : Beyond, optional
        Distances of the rows from the envelope of the fitted data.

    Returns
    -------
    dict of str to SpeedErrors
        Errors of the rotor and of its hover model, by the name of the load with its unit, for each
        measured load.  The hover model predicts thrust and torque; its other loads are zero.
    """
    rotor = Rotor(model)
    loads = rotor.loads(data.omega, data.speed, data.beta)
    hovers = HoverModel.from_rotor(rotor).loads(data.omega)
    found = {}
    for name, measured in data.loads.items():
        std = getattr(loads.std, name) if loads.std_by_source else np.nan
        both = getattr(loads, name), measured
        found[LOADS[name].column] = compared(*both, data.speed, hovers[name], beyond, std)
    return found


@dataclass(frozen=True, eq=False)
class FlightForces:
    """Predicted forces [N], except gravity, and moments about the center of mass [N m], in the
    vehicle frame.  ``model`` includes the errors of the accelerometer, ``flight.sensor_force``."""

    model: Floats  # (n, 6)
    hover: Floats  # (n, 6)


def flight_forces(
    vehicle: Vehicle, log: FlightLog, law: Section, values: Mapping[str, float]
) -> FlightForces:
    """Return the forces on a vehicle, except gravity, from a section law and fitted parameters.

    Parameters
    ----------
    vehicle, log : Vehicle, FlightLog
        Vehicle and its recorded motion.
    law : Airfoil or SectionTable
        Section law of the blades.
    values : mapping of str to float
        Parameters by name, except those of the rotor.  Missing parameters have the values of the
        vehicle file or their first guesses.
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
    return FlightForces(
        whole.loads, flight.hover_loads(HoverModel.from_rotor(Rotor(model)), logged)
    )


DRAG_DEVIATION = 0.12
"""Standard deviation, over flights, of a factor on the force perpendicular to the mean rotor axis.
The factor describes differences in drag and airspeed.  ``parameters.PER_FLIGHT`` explains the
value."""

BAND = 1.96  # half width of a 95 % band, in standard deviations


class ForceErrors(NamedTuple):
    """Forces [N] and moments [N m] by a flight fit at n samples, and the sources of their errors.

    P parameters have errors that are constant over a flight.  The first six parameters have unit
    variance: each scales the extrapolation error of one load beyond the data of the fit.  The last
    parameter is the drag factor of ``DRAG_DEVIATION``.
    """

    loads: Floats  # (n, 6)
    slopes: Floats  # derivatives with respect to the parameters, (P, n, 6)
    covariance: Floats  # of the parameters, including differences between flights, (P, P)
    left: Floats  # standard deviations of all other errors, (n, 6); NaN for loads not fitted
    excluded: tuple[str, ...]  # free parameters that the data of the fit do not determine

    @property
    def deviations(self) -> Floats:
        """Standard deviations (n, 6) of all errors."""
        known = np.einsum("pnl,pq,qnl->nl", self.slopes, self.covariance, self.slopes)
        return np.asarray(np.sqrt(known + self.left**2))


def fitted_forces(
    file: FitFile,
    vehicle: Vehicle,
    log: FlightLog,
    values: Mapping[str, float],
    names: tuple[str, ...] = (),
) -> flight.VehicleLoads:
    """Return forces and moments by a flight fit, and derivatives with respect to ``names``; the
    parameters ``values`` replace those of the fit."""
    record, law = file.record, parameters.constants_of(file.airfoil)
    # Exclude parameters of single flights: a flight of ``log`` may have the name of a fitted one.
    every = [p for p in record.parameters if parameters.general(p.name) == p.name]
    found = {p.name: p.value for p in every}
    own = {name: getattr(law, name) for name in parameters.SECTION}
    whole = {**parameters.FIRST_GUESS, **own, **record.fixed, **found, **values}
    return flight.ForceModel(vehicle, log, law).at(whole, names)


def force_errors(
    file: FitFile, vehicle: Vehicle, log: FlightLog, values: Mapping[str, float]
) -> ForceErrors | None:
    """Return forces and moments by a flight fit, and the sources of their errors.

    The sources are:

    - the joint covariance of all free parameters
    - the priors of the body, for a fit of slow flights
    - the differences between flights
    - the cross-validated error

    The cross-validated error is multiplied by the largest of 1 and two ratios.  One ratio is the
    predicted force over the rms of the measured force in the data of the fit.  The other ratio is
    V/(Omega R) over its maximum in these data.  The error that the second ratio adds is fully
    correlated between all samples.  Return None for a fit to a tunnel test or to level flights.
    """
    record = file.record
    if record.kind != "flight":
        return None
    every = SectionCovariance(tuple(record.free), record.covariance)
    known = every.determined
    known = known.of(
        [name for name in known.names if parameters.general(name) not in parameters.PER_FLIGHT]
    )
    # Prior standard deviations of the body areas.  Fits of slow flights fix these areas at zero.
    prior: dict[str, float] = record.settings.get("undetermined", {})
    names = (*known.names, *prior, *parameters.PER_FLIGHT)
    loads, by_name = fitted_forces(file, vehicle, log, values, names)
    axis = vehicle.rotor_axes.sum(axis=0)
    axis /= max(float(np.linalg.norm(axis)), 1e-9)
    across = np.pad(loads[:, :3] - np.outer(loads[:, :3] @ axis, axis), ((0, 0), (0, 3)))
    beyond = file.beyond(hub_flow(vehicle, log)[:3], vehicle.propeller.radius)
    fitted = {one.name: one for one in record.loads}
    trained = sum(fitted[name].measured_rms ** 2 for name in flight.AXES)
    growth = np.maximum(np.sum(loads[:, :3] ** 2, axis=1) / trained, 1.0)
    further = np.zeros(len(log)) if beyond is None else np.maximum(beyond.reach**2 - growth, 0.0)
    left, extrapolated = np.full_like(loads, np.nan), np.zeros((6, *loads.shape))
    for k, name in enumerate((*flight.AXES, *flight.MOMENTS)):
        if name in fitted:
            size = fitted[name].cross_validated
            size = size if np.isfinite(size) else fitted[name].rms
            left[:, k], extrapolated[k, :, k] = np.sqrt(growth) * size, np.sqrt(further) * size
    slopes = np.stack([*extrapolated, *by_name, across])
    # The variances of this flight and of the mean over F fitted flights add: factor 1 + 1/F.
    share = 1.0 / max(1, len(record.data) - 1)  # the last item is the vehicle file
    spread = (1.0 + share) * np.square([*parameters.PER_FLIGHT.values(), DRAG_DEVIATION])
    end = 6 + len(known.names)
    covariance = np.diag(np.concatenate([np.ones(end), np.square([*prior.values()]), spread]))
    covariance[6:end, 6:end] = known.matrix
    return ForceErrors(loads, slopes, covariance, left, every.unknown)


def compare_forces(
    vehicle: Vehicle,
    log: FlightLog,
    forces: FlightForces,
    beyond: Beyond | None = None,
    deviations: Floats | None = None,
) -> dict[str, SpeedErrors]:
    """Return the errors of forces and moments of a flight by name with unit.

    The measured forces are mass times specific force.

    Parameters
    ----------
    vehicle : Vehicle
        Its mass scales the specific force.  Measured moments require its inertia.
    log : FlightLog
        Flight with n samples.
    forces : FlightForces
        Predicted forces and moments, from ``flight_forces``.
    beyond : Beyond, optional
        Distances of the samples from the envelope of the fit.
    deviations : (n, 6) array, optional
        Standard deviations of the predicted forces [N] and moments [N m].

    Returns
    -------
    dict of str to SpeedErrors
        Errors [N] or [N m] along each axis.

    Raises
    ------
    InputError
        For a log without specific force.
    """
    measured = np.concatenate(
        [vehicle.mass * log.specific_force, measured_moment(vehicle, log)], axis=1
    )
    if not np.isfinite(measured[:, :3]).any():
        fault = "there is no specific force to compare with"
        raise InputError(fault, "log the accelerometer", log.source)
    names = (*flight.AXES, *flight.MOMENTS) if np.isfinite(measured[:, 3:]).any() else flight.AXES
    found = {}
    for k, name in enumerate(names):
        both = forces.model[:, k], measured[:, k]
        std = np.nan if deviations is None else deviations[:, k]
        one = compared(*both, log.speed, forces.hover[:, k], beyond, std)
        found[f"{name}_{flight.UNITS[name].replace(' ', '')}"] = one
    return found


def useless(load: str, share: float) -> list[str]:
    """Return a warning if ``share``, error divided by measured moment, is at least 1.

    Forces get no warning, because side forces near zero have large relative errors in any model.
    """
    if load not in flight.MOMENTS or not share >= 1.0:
        return []
    return [
        f"the error of {load} is {100.0 * share:.0f} % of the measured moment, more than "
        "the error of a prediction of zero: do not use the modeled moment"
    ]


def force_trends(vehicle: Vehicle, log: FlightLog, forces: FlightForces) -> list[list[Trend]]:
    """Return the trends of the error of each force, strongest first; see ``compare_forces``."""
    off = forces.model[:, :3] - vehicle.mass * log.specific_force
    block = log.segments(flight.CORRELATED)
    return [trends(log, name, "N", off[:, k], block) for k, name in enumerate(flight.AXES)]


def compare_level(
    vehicle: Vehicle,
    log: FlightLog,
    law: Section,
    values: Mapping[str, float],
    beyond: Beyond | None = None,
) -> dict[str, SpeedErrors]:
    """Return the errors of the vertical force of steady level flights against the weight, eqs. (16)
    and (17), with the arguments of ``flight_forces`` and ``compare_forces``."""
    model, hover = level_forces(vehicle, log, law, values)
    weight = np.full(len(log), vehicle.mass * GRAVITY)
    return {"vertical_force_N": compared(model, weight, log.speed, hover, beyond)}


def level_forces(
    vehicle: Vehicle, log: FlightLog, law: Section, values: Mapping[str, float]
) -> tuple[Floats, Floats]:
    """Return the vertical forces [N] (n,) of model and hover model at the center of mass."""
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
    model: Floats,
    measured: Floats,
    speed: Floats,
    hover: Floats,
    beyond: Beyond | None,
    std: Floats | float = np.nan,
) -> SpeedErrors:
    """Return the errors of the loads ``model`` and ``hover`` against ``measured``, (n,) each;
    the standard deviations ``std`` of ``model`` determine ``in_band``."""
    parts = {} if beyond is None else {INSIDE: ~beyond.samples, OUTSIDE: beyond.samples}
    by_envelope = {
        name: errors(model[mine], measured[mine], hover[mine])
        for name, mine in parts.items()
        if mine.any()
    }
    by_speed = by_band(model, measured, speed, hover)
    off = np.abs(model - measured)
    inside = (off <= BAND * np.asarray(std))[np.isfinite(off) & np.isfinite(std)]
    share = float(inside.mean()) if inside.size else np.nan
    return SpeedErrors(errors(model, measured, hover), by_speed, by_envelope, share)


# --- Relative uncertainty of thrust and torque in forward flight, before and after a fit ---------

ADVANCE = (0.0, 0.2, 0.4, 0.6, 0.2, 0.4, 0.6)  # J = V / (n D) of the evaluated points [-]
BETA = np.radians([0.0, 0.0, 0.0, 0.0, 90.0, 90.0, 90.0])  # angle beta of these points [rad]

JUDGED = ("thrust", "torque")

MODEL_ERROR = 0.03
"""Error of the model with the best constants, as a share of the static load.  With this value, the
95 % intervals after a fit to static rows contain 95 % of a propeller's rows in axial flight:
``python -m tools.after_static``."""

SMALL = 0.1  # share of the static load below which relative uncertainties are meaningless


@dataclass(frozen=True, eq=False)
class ForwardTrust:
    """Thrust and torque at m points, with their uncertainty before and after a fit."""

    omega: float  # rotational speed of all points [rad/s]
    advance: Floats  # V / (n D) [-], (m,)
    beta: Floats  # angle beta [rad], (m,)
    load: Floats  # thrust [N] and torque [N m] after the fit, (m, 2)
    # Standard deviations / loads [-], (m, 2); NaN for loads near zero, infinite without a prior.
    before: Floats
    after: Floats


def forward_trust(model: Model, fitted: Fitted, omega: float, setting: str) -> ForwardTrust:
    """Return the uncertainty before and after a fit, at rest and in axial and edgewise flow.

    The uncertainty combines ``MODEL_ERROR``, the error of the theory in oblique flow
    (``propmap.bands.OBLIQUE``) and the error sqrt(g' S g) of the free constants of ``model``.  S is
    their covariance, and g is the gradient of the load.
    """
    choice = fitted.choice
    by_prior = choice.prior_residuals(choice.first)[1]
    before = np.asarray(np.linalg.pinv(by_prior.T @ by_prior), np.float64)
    unknown = [k for k, name in enumerate(choice.free) if choice.prior_of(name) is None]
    speed = np.array(ADVANCE) * omega / (2.0 * np.pi) * model.propeller.diameter
    flow = np.full(speed.size, omega), speed * np.cos(BETA), speed * np.sin(BETA)
    rows = [list(LOADS).index(name) for name in JUDGED]
    share = flow[2] / np.hypot(omega * model.propeller.radius, flow[2])
    oblique = np.outer(share, [OBLIQUE[name] for name in JUDGED])

    def loads(x: Floats, covariance: Floats) -> tuple[Floats, Floats]:
        rotor = rotor_with(model, choice.values(x), setting)
        names = tuple(name for name in choice.free if name in parameters.ROTOR)
        found = rotor.gradients(names, *flow)
        mine = [choice.free.index(name) for name in names]
        part = covariance[np.ix_(mine, mine)]
        variance = np.einsum("lpm,pq,lqm->ml", found.slopes[rows], part, found.slopes[rows])
        load = found.loads[rows].T
        variance = variance + (MODEL_ERROR * load[0]) ** 2 + (oblique * load) ** 2
        relative = np.sqrt(variance) / np.abs(load)
        return load, np.where(load < SMALL * load[0], np.nan, relative)

    _, was = loads(choice.first, before)
    if unknown:
        was = np.where(np.isfinite(was), np.inf, was)
    load, now = loads(fitted.x, fitted.uncertainty.covariance)
    return ForwardTrust(omega, np.array(ADVANCE), BETA, load, was, now)


FAR = 2.5  # z-score among propellers above which a constant gets a remark


def unlikely_constants(fitted: Fitted) -> list[str]:
    """Return a sentence on fitted constants far from other propellers; none without a prior."""
    expected = fitted.choice.expected
    if expected is None:
        return []
    away = np.abs(expected.z_scores(fitted.values)[0])
    own = {**fitted.choice.fixed, **fitted.choice.priors}
    far = [
        f"{name} is {fitted.values[name]:.3g}, {away[k]:.1f} standard deviations from the "
        "mean over propellers"
        for k, name in enumerate(PARAMETERS)
        if away[k] > FAR and name not in own
    ]
    if not far:
        return []
    causes = "the twist of the blade, the radius, the units and the density"
    return [f"unusual constants: {'; '.join(far)}; check {causes}"]


# --- Effect of one more free parameter on a fit: wrong assumptions, terms of the body ------------

# An assumption is reported as wrong if the residuals without it / with it are below this ratio.
REMARKABLE = 0.7
POOR = 0.03  # relative residual above which assumptions are checked

ASSUMPTIONS = {
    "zero_lift_angle": "C_L(0) = 0, an uncambered section",
    "c_d0": "c_d0 = 0.01, the constant drag",
    "mount_area": "no drag of parts in the slipstream",
}  # text of each assumption, by the parameter that is free in a fit without the assumption

BODY_TERMS = ("lift_area", "drag_area_x")

LEAST_FALL = 0.05  # least relative decrease of the residuals if a term of the body improves the fit


def failing_assumptions(fitted: Fitted, rows_for: Callable[[parameters.Choice], Rows]) -> list[str]:
    """Return a sentence for each wrong assumption of the section law.

    An assumption is wrong if the residuals of a poor fit decrease by more than 30 % without it.
    ``rows_for`` returns the rows for another choice of parameters.
    """
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
                f"wrong assumption: {assumption}; with {name} free ({again.x[-1]:.3g} "
                f"{parameters.described(name).unit}) the residuals fall to {100.0 * left:.0f} %"
            )
    return sentences


def body_terms_verdict(fitted: Fitted, rows_for: Callable[[parameters.Choice], Rows]) -> list[str]:
    """Return sentences on whether lift and drag of the body improve a fit that excludes them.

    Section III.A defines the terms.  A term improves the fit if its interval excludes zero and the
    residuals decrease by ``LEAST_FALL``.  ``rows_for`` returns the rows for another choice.
    """
    sentences = []
    size = rms(fitted.minimum.residual)
    for name in BODY_TERMS:
        if name in fitted.choice.free:
            continue
        choice, begin = _with(fitted, name)
        rows = rows_for(choice)
        again = search(rows, choice, [begin], error=fitted.error)
        sure = uncertainty(rows, choice, again, fitted.error)
        fall = 0.0 if not size > 0.0 else 1.0 - rms(again.residual) / size
        shift = np.max(np.abs(again.x[:-1] - fitted.x) / fitted.choice.column("spread"))
        nonzero = sure.low[-1] > 0.0 or sure.high[-1] < 0.0
        verdict = "improves" if nonzero and fall > LEAST_FALL else "does not improve"
        sentences.append(
            f"{name} {verdict} the fit: {again.x[-1]:.4g} m^2 ({sure.low[-1]:.2g} to "
            f"{sure.high[-1]:.2g}), residuals {-100.0 * fall:+.1f} %, the other parameters move by "
            f"at most {shift:.2f} of their spread"
        )
    return sentences


def _with(fitted: Fitted, name: str) -> tuple[parameters.Choice, Floats]:
    """Return the choice with the further free parameter ``name``, and initial values (P + 1,)."""
    fixed = {k: v for k, v in fitted.choice.fixed.items() if k != name}
    choice = replace(fitted.choice, free=(*fitted.choice.free, name), fixed=fixed)
    return choice, np.append(fitted.x, fitted.values.get(name, parameters.described(name).start))


# --- Trends: dependence of the residuals of a flight fit on variables of the flight --------------

# A variable is reported if it explains at least this share of the residuals' variance.
LEAST_SHARE = 0.05
CERTAIN = 3.0  # least ratio of a significant slope to its block-wise standard error
MOST = 2  # largest number of sentences per load


def candidates(log: FlightLog) -> dict[str, Floats]:
    """Return variables (n,) of a log that may explain residuals, by name with unit."""
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
        "descent speed along the body's z axis [m/s]": np.maximum(-up, 0.0),
        "roll rate [rad/s]": roll,
        "pitch rate [rad/s]": pitch,
        "yaw rate [rad/s]": yaw,
        "square of the roll rate [rad^2/s^2]": roll**2,
        "square of the pitch rate [rad^2/s^2]": pitch**2,
        "rotor speed [rad/s]": rotor,
        "time since the start of the flight [s]": log.since_start,
    }


@dataclass(frozen=True, eq=False)
class Trend:
    """Dependence of the residual of one load on one variable, over n samples."""

    load: str
    unit: str
    variable: str  # name with unit
    at: Floats  # values of the variable, (n,)
    residual: Floats  # model minus measurement, (n,)
    block: NDArray[np.intp]  # segment of each sample, (n,); errors may be correlated in a segment
    slope: float  # by least squares
    error: float  # block-wise standard error of the slope
    share: float  # share of the residual's variance that the slope explains [-]

    @property
    def sure(self) -> bool:
        """Whether the trend is significant and large enough for a sentence."""
        return self.share >= LEAST_SHARE and abs(self.slope) >= CERTAIN * self.error

    @property
    def sentence(self) -> str:
        """Sentence on the change of the residual with the variable."""
        way, per = "increases" if self.slope > 0.0 else "decreases", self.variable.partition(" [")
        return (
            f"the error of {self.load} {way} with the {per[0]} ({self.slope:+.2g} {self.unit} "
            f"per {per[2].rstrip(']')}), which explains {100.0 * self.share:.0f} % of its variance"
        )


def trends(
    log: FlightLog, load: str, unit: str, residual: Floats, block: NDArray[np.intp]
) -> list[Trend]:
    """Return the trends of the ``residual`` (n,) of a load, model minus measurement, with all
    candidates, strongest first; errors may be correlated within a ``block`` (n,)."""
    known = np.isfinite(residual)
    off, segment, found = residual[known], block[known], []
    for name, variable in candidates(log).items():
        at = variable[known]
        found.append(Trend(load, unit, name, at, off, segment, *_slope(at, off, segment)))
    return sorted(found, key=lambda trend: -trend.share)


def residual_trends(fitted: Fitted, log: FlightLog) -> list[str]:
    """Return at most two sentences per load on trends in the residuals of a fit to ``log``."""
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
    """Return slope, block-wise standard error of the slope, and explained share of the variance."""
    x, y = variable - variable.mean(), residual - residual.mean()
    size, spread = float(x @ x), float(y @ y)
    if size <= 1e-12 * max(float(variable @ variable), 1e-300) or spread == 0.0:
        return 0.0, np.inf, 0.0
    slope = float(x @ y) / size
    _, index = np.unique(block, return_inverse=True)
    scores = np.bincount(index, weights=x * (y - slope * x))
    return slope, float(np.sqrt(scores @ scores)) / size, slope**2 * size / spread


# --- Effect of each term of a whole-flight fit on the errors for held-out flights ----------------

SURE = 2.0  # least change of the mean square error for a verdict, in standard errors


@dataclass(frozen=True, eq=False)
class RecordedFlight:
    """One flight with low-passed and with raw signals.  The optional predictions are
    forces [N] (n, 3) of another model, for either kind of signals."""

    name: str
    passed: FlightLog  # low-passed signals
    raw: FlightLog  # signals as recorded
    prediction: Floats | None = None
    raw_prediction: Floats | None = None


@dataclass(frozen=True)
class Step:
    """Model with one more term than the previous step."""

    name: str  # name of the added term
    choice: parameters.Choice  # parameters of the fit
    vertical: bool = False  # whether the fit uses only the vertical forces


@dataclass(frozen=True, eq=False)
class AxisErrors:
    """Errors of the forces of one flight along x, y and z, model minus measurement [N]."""

    passed: Floats  # for low-passed signals, (n, 3)
    raw: Floats  # for raw signals, (m, 3)

    @property
    def rms(self) -> Floats:
        """Root mean squares of the errors for low-passed signals, (3,)."""
        return np.asarray(np.sqrt(np.nanmean(self.passed**2, axis=0)))

    @property
    def raw_rms(self) -> Floats:
        """Root mean squares of the errors for raw signals, (3,)."""
        return np.asarray(np.sqrt(np.nanmean(self.raw**2, axis=0)))


@dataclass(frozen=True, eq=False)
class FittedStep:
    """One step, fitted to all flights except one, or to a single flight."""

    step: str  # name of the step
    left_out: int | None  # number of the held-out flight; None for a single flight
    values: dict[str, float]  # free parameters
    off: tuple[AxisErrors, ...]  # errors of the fitted model, one per flight
    hover: tuple[AxisErrors, ...]  # errors of the hover model with the fitted blade


def fit_terms(
    vehicle: Vehicle,
    flights: Sequence[RecordedFlight],
    steps: Sequence[Step],
    law: Airfoil,
    *,
    samples: int,
    tell: Callable[[str], None] | None = None,
) -> list[FittedStep]:
    """Return all steps fitted with each flight held out in turn, in the order of steps, then of
    held-out flights.

    Each fit uses at most ``samples`` samples of the other flights.  ``law`` provides the constants
    that are not free.  ``tell`` receives a line after each fit.
    """
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
                errors = ", ".join(f"{x:.3f}" for x in unseen)
                tell(f"{step.name}: rms errors along x, y, z {errors} N")
    return found


def gain(
    old: Sequence[AxisErrors], new: Sequence[AxisErrors], flights: Sequence[RecordedFlight]
) -> tuple[float, float]:
    """Return the decrease of the mean square force error [N^2] from one model to another, and its
    standard deviation.  The errors within a second, which are correlated, count as one error."""
    means = []
    for a, b, flown in zip(old, new, flights, strict=True):
        fall = np.sum(a.passed**2 - b.passed**2, axis=1)
        block = flown.passed.segments(flight.CORRELATED)
        known = np.isfinite(fall)
        total = np.bincount(block[known], fall[known])
        count = np.bincount(block[known])
        means += (total[count > 0] / count[count > 0]).tolist()
    each = np.array(means)
    deviation = float(np.std(each, ddof=1)) / np.sqrt(each.size) if each.size > 1 else np.inf
    return float(np.mean(each)), float(deviation)


def judged(fall: float, deviation: float) -> str:
    """Return a verdict on a term from the ``fall`` and ``deviation`` that ``gain`` returns."""
    if fall > SURE * deviation:
        return "pays"
    if fall < -SURE * deviation:
        return "makes it worse"
    return "no sure gain"


def measured_off(vehicle: Vehicle, flown: RecordedFlight) -> AxisErrors | None:
    """Return the errors of the predictions in ``flown``; None if there are no predictions."""
    if flown.prediction is None or flown.raw_prediction is None:
        return None
    return AxisErrors(
        flown.prediction - vehicle.mass * flown.passed.specific_force,
        flown.raw_prediction - vehicle.mass * flown.raw.specific_force,
    )


def _off(
    vehicle: Vehicle, flown: RecordedFlight, base: Airfoil, values: dict[str, float]
) -> tuple[AxisErrors, AxisErrors]:
    """Return the errors of the fitted model and of the hover model."""
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
    """Return parameters for the flights of ``log``, recorded in the files ``paths``, and remarks.

    A flight of the fit keeps its fitted parameters.  A new flight has the means over the flights of
    the fit.  If a new flight contains hover, its thrust scale is estimated from the hover.  A scale
    that differs significantly from 1 replaces the mean.
    """
    logs = file.record.data[:-1]  # the last item is the vehicle file
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
            why = "this scale is applied" if scale in applied else "too near to 1 to be applied"
            remarks.append(
                f"in hover, flight {named} has {by_hover[scale]:.3f} times the thrust of the "
                f"flights of the fit at the same rotor speeds: {why}"
            )
    return values, remarks


def by_flight(fitted: Fitted, log: FlightLog) -> dict[str, dict[str, FlightErrors]]:
    """Return the errors of a fit to ``log`` by load and flight; empty for a single flight."""
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
