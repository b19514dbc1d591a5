"""Forces and moments of a flying vehicle, and their balances as rows of a fit, eqs. (16), (17)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError, quoted
from propmap.fit.fit import Coverage, coverage
from propmap.fit.least_squares import Evaluation, RowModel, Rows
from propmap.fit.moments import measured_moment, moment_of_all
from propmap.fit.parameters import (
    BODY,
    EVERY,
    MOUNT,
    PER_FLIGHT,
    ROTOR,
    ROTOR_SPEED,
    SENSOR,
    THROTTLE,
    TURNING,
    WAKES,
    WING,
    Choice,
    Prior,
    general,
    of_flight,
)
from propmap.fit.tunnel import model_with
from propmap.hover import HoverModel
from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil
from propmap.model.envelope import Envelope, Range
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.log import FlightLog, hub_flow
from propmap.vehicle.throttle import ThrottleCurve
from propmap.vehicle.vehicle import Body, Vehicle, Wakes
from propmap.vehicle.vehicle_forces import free_stream_force, mounted_rotors
from propmap.vehicle.wakes import HubFlow, check_apart, rotor_wrench, wake_flow

# -------------------------------------------------------------------------------------------------
# Force and moment balances of a flying vehicle as rows of a fit, eqs. (16) and (17) and beyond.

AXES, VERTICAL = ("force_x", "force_y", "force_z"), ("vertical_force",)
MOMENTS = ("moment_x", "moment_y", "moment_z")
CORRELATED = 1.0
"""Length of the segments of a flight within which errors are assumed to be correlated [s]."""

UNITS = {**dict.fromkeys((*AXES, *VERTICAL), "N"), **dict.fromkeys(MOMENTS, "N m")}


def level_rows(model: ForceModel, choice: Choice) -> Rows:
    """Return a row for each steady level flight: vertical forces balance m g, eqs. (16), (17).

    For horizontal V, the vertical components of the forces of a rotor are T sin(beta) and
    D cos(beta).  Here these components are computed from the attitude, so a small climb rate or
    bank angle causes no error.

    Parameters
    ----------
    model : ForceModel
        Model of the vehicle, at steady operating points.
    choice : Choice
        Free parameters, fixed parameters and priors.

    Raises
    ------
    InputError
        For free parameters without effect.
    """
    weight = np.full((len(model.log), 1), model.vehicle.mass * GRAVITY)
    return _rows(model, choice, VERTICAL, weight)


def vertical_rows(model: ForceModel, choice: Choice, *, segment: float = CORRELATED) -> Rows:
    """Return a row for each sample of a whole flight: the vertical forces, as in (16) and (17).

    Mass times the vertical specific force replaces the weight.  Errors within a ``segment`` [s]
    are assumed to be correlated.
    """
    log = model.log
    measured = model.vehicle.mass * np.sum(log.specific_force * log.up, axis=1, keepdims=True)
    return _rows(model, choice, VERTICAL, measured, log.segments(segment))


def balance_rows(model: ForceModel, choice: Choice, *, segment: float = CORRELATED) -> Rows:
    """Return the rows of a whole flight, which compare forces with m times specific force.

    The forces are all forces except gravity.  Each sample has three rows.  If the vehicle file
    contains moments of inertia and the log has time derivatives, three more rows balance the
    aerodynamic moments with the angular motion.

    Parameters
    ----------
    model : ForceModel
        Model of the vehicle, at the samples of its log.
    choice : Choice
        Free parameters, fixed parameters and priors.
    segment : float
        Length of the segments within which errors are assumed to be correlated [s].

    Raises
    ------
    InputError
        For a log without specific force, and for free parameters without effect.
    """
    log = model.log
    if not np.isfinite(log.specific_force).all():
        found = "some samples have no specific force (accelerometer)"
        remedy = "add it to the log, or fit steady segments with --method level"
        raise InputError(found, remedy, log.source)
    group = log.segments(segment)
    measured = model.vehicle.mass * log.specific_force
    turning = measured_moment(model.vehicle, log)
    if not np.isfinite(turning).all():
        return _rows(model, choice, AXES, measured, group)
    six = np.concatenate([measured, turning], axis=1)
    return _rows(model, choice, (*AXES, *MOMENTS), six, group)


def _rows(
    model: ForceModel,
    choice: Choice,
    names: tuple[str, ...],
    measured: Floats,
    group: NDArray[np.intp] | None = None,
) -> Rows:
    """Return a row for each ``measured`` load (n, L).

    The scale of forces is the weight.  The scale of moments is the weight times a length.  The
    length is the mean distance of the hubs from the center of mass.  About z, or if this distance
    is zero, the length is the rotor radius.
    """
    free, given = choice.free, (*choice.free, *choice.fixed)

    def refuse(useless: list[str], fault: str, remedy: str) -> None:
        if useless:
            raise InputError(f"{useless[0]} {fault}", remedy)

    if names == VERTICAL:
        sensing = [name for name in free if general(name) in SENSOR | TURNING]
        refuse(sensing, "has no effect in steady segments", "fit it with --method balance")
    elif MOMENTS[0] not in names:
        remedy = "add inertia = [about x, about y, about z] in kg m^2 to the vehicle file"
        turning = [name for name in free if name in TURNING]
        refuse(turning, "is free, but the fit has no moments", remedy)
    if any(mount.drag is not None for mount in model.vehicle.mounts):
        remedy = "remove the [mount] table, or leave the parameter out of --free and --fix"
        mounted = [name for name in given if name in MOUNT]
        refuse(mounted, "is a parameter of the fit, but the vehicle file has it, too", remedy)
    if len(model.vehicle.mounts) == 1:
        wakes = [name for name in free if name in WAKES]
        refuse(wakes, "is free but the vehicle has one rotor", "leave it out of --free")
    if model.vehicle.wing is None:
        wing = [name for name in free if name in WING]
        refuse(wing, "is free but the vehicle has no wing", "add a [wing] table")

    def table(points: NDArray[np.intp]) -> RowModel:
        here = model if points.size == len(model.log) else model.at_samples(points)

        def forces(values: Mapping[str, float], free: tuple[str, ...]) -> Evaluation:
            loads, slopes = (_along(here.log, names, one) for one in here.at(values, free))
            return loads, np.moveaxis(slopes, 0, -1)

        return forces

    weight = model.vehicle.mass * GRAVITY
    places = np.array([mount.position for mount in model.vehicle.mounts])
    arm = float(np.mean(np.linalg.norm(places, axis=1))) or model.vehicle.propeller.radius
    # Torques about z scale with the rotor radius and are much smaller than thrust times arm.
    levers = dict(zip(MOMENTS, (arm, arm, model.vehicle.propeller.radius), strict=True))
    each = np.array([weight * levers.get(name, 1.0) for name in names])
    scale = np.broadcast_to(each, measured.shape)
    units = tuple(UNITS[name] for name in names)
    return Rows.of_points(names, units, measured, scale, model.log.speed, table, group)


def _along(log: FlightLog, names: tuple[str, ...], loads: Floats) -> Floats:
    """Return the loads ``names`` (..., n, L) from forces and moments (..., n, 6)."""
    if names == VERTICAL:
        return np.asarray(np.sum(loads[..., :3] * log.up, axis=-1, keepdims=True))
    return loads[..., : len(names)]


def hover_rows(model: ForceModel, values: Mapping[str, float], rows: Rows) -> Floats:
    """Return the loads (M,) of the hover model for the ``rows`` of ``model``.

    The rotor with the parameters ``values`` provides the constants of the hover model.
    """
    hover = HoverModel.from_rotor(Rotor(model_with(model.model, values)))
    return rows.picked(_along(model.log, rows.names, hover_loads(hover, model.flow)))


# --- Forces and moments on a flying vehicle at the samples of a log, and their derivatives -------

LIFT = ("c_l1", "zero_lift_angle", "reynolds_camber", "reynolds_lift", "untwist")
"""Parameters that change the attached lift, and therefore the wakes of the rotors."""

LIFT_STEP = 1e-4
"""Step of difference quotients with respect to ``LIFT``, in units of ``Parameter.spread``."""

TURNED = (ROTOR_SPEED, *THROTTLE)
"""Parameters that change the rotor speeds."""

SPEED_STEP = 1e-6
"""Relative step of difference quotients with respect to the rotor speed."""


class VehicleLoads(NamedTuple):
    """Force [N] and moment about the center of mass [N m] at n samples, in the vehicle's frame."""

    loads: Floats  # (n, 6), NaN for samples without loads of the rotors
    slopes: Floats  # derivatives with respect to P parameters, (P, n, 6)

    @property
    def force(self) -> Floats:
        """Force [N], (n, 3)."""
        return self.loads[:, :3]

    @property
    def moment(self) -> Floats:
        """Moment [N m], (n, 3)."""
        return self.loads[:, 3:]


class ForceModel:
    """Forces except gravity, and their moments, on a vehicle at the samples of a log.

    Parameters
    ----------
    vehicle : Vehicle
        Vehicle with rotors, body and wing.
    log : FlightLog
        Motion of the vehicle.
    base : Airfoil
        Section law that provides the constants that no fit varies.
    setting : str
        Accuracy of the loads, as in ``Rotor``.

    Raises
    ------
    InputError
        For a log without one rotor speed per rotor.
    """

    def __init__(
        self, vehicle: Vehicle, log: FlightLog, base: Airfoil, setting: str = "standard"
    ) -> None:
        if log.rotor_speed.shape[1] != len(vehicle.mounts):
            found = f"{log.rotor_speed.shape[1]} rotor speeds for {len(vehicle.mounts)} rotors"
            remedy = "give the vehicle file one [[rotors]] table per rotor of the log"
            raise InputError(found, remedy, log.source)
        self.vehicle, self.log, self.base, self.setting = vehicle, log, base, setting
        self.model = Model(vehicle.propeller, base, vehicle.air)
        self.flow = hub_flow(vehicle, log)

    def at_samples(self, samples: NDArray[np.intp]) -> ForceModel:
        """Return the model at the samples with the numbers ``samples``."""
        return ForceModel(self.vehicle, self.log.picked(samples), self.base, self.setting)

    def at(self, values: Mapping[str, float], free: tuple[str, ...]) -> VehicleLoads:
        """Return forces and moments with their derivatives.

        Parameters
        ----------
        values : mapping of str to float
            All parameters by name.
        free : tuple of str
            Names of the P parameters of the derivatives.
        """
        check_flights(free, self.log)
        loads, slopes = self._rotors(values, free)
        return on_vehicle(self.vehicle, self.log, self.flow, loads, slopes, values, free)

    def _rotors(self, values: Mapping[str, float], free: tuple[str, ...]) -> tuple[Floats, Floats]:
        """Return the loads (n, 6) of all rotors, including wakes, and slopes (P, n, 6)."""
        section = tuple(name for name in free if name in (*ROTOR, *TURNED))
        at_section = [name in section for name in free]
        slopes = np.zeros((len(free), len(self.log), 6))
        wakes = wakes_with(self.vehicle, values)
        if wakes is None:
            loads, by_section = self._loads(values, section, self.flow.axial)
            slopes[at_section] = six_loads(self.flow, by_section)
            return six_loads(self.flow, loads), slopes
        check_apart(self.vehicle)
        thrust, by_lift = self._attached(values, section)
        wake = wake_flow(self.vehicle, wakes, self.flow, thrust)
        named = (*section, "v_axial") if free else ()
        loads, by_here = self._loads(values, named, self.flow.axial + wake.added)
        if not free:
            return six_loads(self.flow, loads), slopes
        by_axial = by_here[:, -1]
        # Parameters of the section also change the thrust, and the thrust changes the wakes.
        followed = np.einsum("nts,pns->pnt", wake.by_thrust, by_lift)
        by_section = by_here[:, :-1] + by_axial[:, None] * followed
        slopes[at_section] = six_loads(self.flow, by_section)
        for row, name in enumerate(free):
            if name in WAKES:
                added = wake.by_gain[name.removeprefix(PREFIX)]
                slopes[row] = six_loads(self.flow, by_axial * added)
        return six_loads(self.flow, loads), slopes

    def _attached(
        self, values: Mapping[str, float], names: tuple[str, ...]
    ) -> tuple[Floats, Floats]:
        """Return the thrust of unstalled blades (n, m), which sets the wakes; slopes (P, n, m)."""
        flow = self.flow
        known = {name: value for name, value in values.items() if name not in MOUNT}
        lifting = [name for name in names if name in LIFT]
        steps = [LIFT_STEP * EVERY[name].spread for name in lifting]
        perturbed = [
            model_with(self.model, {**known, name: known[name] + step})
            for name, step in zip(lifting, steps, strict=True)
        ]
        omega, by_name = self._turned(values)
        along = flow.axial, flow.inplane
        rotor = Rotor(model_with(self.model, known))
        thrust, more = rotor.attached_thrust(omega, *along, perturbed)
        slopes = np.zeros((len(names), *omega.shape))
        turning = [name for name in names if name in TURNED]
        if turning:
            faster, _ = rotor.attached_thrust((1.0 + SPEED_STEP) * omega, *along)
            by_omega = (faster - thrust) / (SPEED_STEP * np.where(omega > 0.0, omega, 1.0))
            for name in turning:
                slopes[names.index(name)] = by_omega * by_name[name]
        for name, step, change in zip(lifting, steps, more, strict=True):
            slopes[names.index(name)] = change / step
        return thrust, slopes

    def _loads(
        self, values: Mapping[str, float], names: tuple[str, ...], axial: Floats
    ) -> tuple[Floats, Floats]:
        """Return rotor loads (L, n, m) at V cos(beta) = ``axial`` (n, m); slopes (L, P, n, m)."""
        flow, shape = self.flow, self.flow.omega.shape
        omega, by_name = self._turned(values)
        asked = [name for name in names if name not in TURNED]
        asked += ["omega"] if len(asked) < len(names) else []
        place = [asked.index("omega" if name in TURNED else name) for name in names]
        loads = np.empty((len(LOADS), *shape))
        slopes = np.empty((len(LOADS), len(names), *shape))
        for model, mine in mounted_rotors(self.vehicle, model_with(self.model, values)):
            rotor = Rotor(model, accuracy=self.setting)
            found = rotor.gradients(
                tuple(asked), *(a[:, mine] for a in (omega, axial, flow.inplane))
            )
            loads[..., mine] = found.loads
            slopes[..., mine] = found.slopes[:, place]
        for row, name in enumerate(names):
            if name in TURNED:
                slopes[:, row] *= by_name[name]
        return loads, slopes

    def _turned(self, values: Mapping[str, float]) -> tuple[Floats, dict[str, Floats]]:
        """Return rotor speeds (n, m) [rad/s], and derivatives with respect to ``TURNED``."""
        log, scale = self.log, values.get(ROTOR_SPEED, 1.0)
        omega, by_name = self.flow.omega, dict.fromkeys(THROTTLE, np.zeros_like(self.flow.omega))
        if log.commanded:
            curve = ThrottleCurve.of(self.vehicle, values)
            omega, by_curve = curve.speeds(log.throttle, log.throttle_by_lag, omega)
            by_name |= {name: scale * slope for name, slope in by_curve.items()}
        return scale * omega, {ROTOR_SPEED: omega, **by_name}

    def coverage(self) -> Coverage:
        """Return the coverage of the operating points of all rotors."""
        flow = self.flow
        speed, beta = np.hypot(flow.axial, flow.inplane), np.arctan2(flow.inplane, flow.axial)
        radius = self.vehicle.propeller.radius
        return coverage(flow.omega.ravel(), speed.ravel(), beta.ravel(), radius)

    def envelope(self, percentiles: Range) -> Envelope:
        """Return the envelope of the flow at all rotors, between two ``percentiles``."""
        flow, radius = self.flow, self.vehicle.propeller.radius
        return Envelope.of(flow.omega, flow.axial, flow.inplane, radius, percentiles)


def on_vehicle(
    vehicle: Vehicle,
    log: FlightLog,
    flow: HubFlow,
    loads: Floats,
    slopes: Floats,
    values: Mapping[str, float],
    free: tuple[str, ...],
) -> VehicleLoads:
    """Return force and moment on the vehicle, without gravity, from the ``loads`` (n, 6) of all
    rotors and their ``slopes`` (P, n, 6)."""
    scale = at_samples("thrust_scale", values, log)[:, None]
    slopes = scale * slopes
    for row, name in enumerate(free):
        if general(name) == "thrust_scale":
            slopes[row] = samples_of(name, values, log)[:, None] * loads
    loads = scale * loads
    body, by_body = body_force(vehicle, log, values, free)
    force, by_force = loads[:, :3] + body, slopes[..., :3] + by_body
    loads = np.concatenate([force, loads[:, 3:]], axis=-1)
    slopes = np.concatenate([by_force, slopes[..., 3:]], axis=-1)
    moment, by_moment = moment_of_all(vehicle, log, flow, loads, slopes, values, free)
    sensed, by_sensor = sensor_force(vehicle, log, values, free)
    return VehicleLoads(
        np.concatenate([force + sensed, moment], axis=-1),
        np.concatenate([by_force + by_sensor, by_moment], axis=-1),
    )


def six_loads(flow: HubFlow, loads: Floats) -> Floats:
    """Return the sum of forces and moments (..., n, 6) of all rotors with loads (L, ..., n, m)."""
    return np.concatenate(rotor_wrench(flow, loads), axis=-1)


def hover_loads(hover: HoverModel, flow: HubFlow) -> Floats:
    """Return force [N] and moment [N m] (n, 6) of all rotors on the vehicle by the hover model."""
    known = hover.loads(flow.omega)
    return six_loads(flow, np.stack([known[name] for name in LOADS]))


# --- Forces of the body and the wing on the vehicle: section III.A and footnote 4 ----------------

STEPS = dict.fromkeys(BODY, 1e-3) | {"wing_c_l1": 1e-4, "wing_c_l2": 1e-4, "wing_alpha_0": 1e-5}
"""Steps of central differences; the forces are nonlinear only in ``wing_alpha_0``."""


def wing_values(vehicle: Vehicle) -> dict[str, float]:
    """Return the parameters of the wing in the vehicle file by name; none without a wing."""
    if vehicle.wing is None:
        return {}
    return {name: getattr(vehicle.wing, name.removeprefix("wing_")) for name in WING}


def body_force(
    vehicle: Vehicle, log: FlightLog, values: Mapping[str, float], free: tuple[str, ...]
) -> tuple[Floats, Floats]:
    """Return the force (n, 3) [N] of body and wing in the vehicle frame, and derivatives (P, n, 3).

    The parameters of the body in ``values`` add to those of the vehicle file.
    """
    force = _force(vehicle, log, values)
    slopes = np.zeros((len(free), *force.shape))
    for k, name in enumerate(free):
        if name in STEPS:
            h = STEPS[name]
            up, down = (_force(vehicle, log, {**values, name: values[name] + d}) for d in (h, -h))
            slopes[k] = (up - down) / (2.0 * h)
    return force, slopes


def _force(vehicle: Vehicle, log: FlightLog, values: Mapping[str, float]) -> Floats:
    area = np.array([values[f"drag_area_{a}"] for a in "xyz"]) + vehicle.body.drag_area
    down = np.array([values[f"download_area_{a}"] for a in "xy"]) + vehicle.body.download_area
    lift = values["lift_area"] + vehicle.body.lift_area
    plate = values["plate_area"] + vehicle.body.plate_area
    body = Body(tuple(area.tolist()), lift, tuple(down.tolist()), plate)
    wing = vehicle.wing
    if wing is not None:
        wing = replace(wing, **{n.removeprefix("wing_"): values[n] for n in WING})
    return free_stream_force(body, wing, vehicle.air.density, log.velocity)


# -------------------------------------------------------------------------------------------------
# Effects of position, delay, tilt and bias of an accelerometer on the force balance.
#
# At r from the center of mass of a vehicle that turns at w, an accelerometer reads
# a = a_cm + dw/dt x r + w x (w x r).  If its time stamps are late by d, it reads a(t - d), here
# a - d da/dt.  If it is tilted by small angles q, it reads a - q x a.  A bias b adds to a.

OFFSET = ("sensor_x", "sensor_y", "sensor_z")
CLOCK = "clock_offset"
TILT = ("sensor_tilt_x", "sensor_tilt_y")
BIAS = ("sensor_bias_x", "sensor_bias_y", "sensor_bias_z")


def sensor_force(
    vehicle: Vehicle, log: FlightLog, values: Mapping[str, float], free: tuple[str, ...]
) -> tuple[Floats, Floats]:
    """Return mass times the excess of the accelerometer reading over the specific force at the
    center of mass [N] (n, 3), and slopes (P, n, 3).

    The position in ``values`` adds to that of the vehicle file.  Steady operating points have no
    time derivatives, so the vehicle file's position is ignored for them.  Raise an ``InputError``
    if a parameter needs time derivatives and the log has none.
    """
    own = np.array([values.get(name, 0.0) for name in OFFSET])
    place, late = own + vehicle.sensor, at_samples(CLOCK, values, log)
    force, slopes = np.zeros((len(log), 3)), np.zeros((len(free), len(log), 3))
    for name, axis in zip((*TILT, *BIAS), np.eye(3)[[0, 1, 0, 1, 2]], strict=True):
        each = at_samples(name, values, log)[:, None]
        mine = [row for row, one in enumerate(free) if general(one) == name]
        if not mine and not each.any():
            continue  # steady operating points have no specific force
        by_name = vehicle.mass * (-np.cross(axis, log.specific_force) if name in TILT else axis)
        force += each * by_name
        for row in mine:
            slopes[row] = by_name * samples_of(free[row], values, log)[:, None]
    fitted = own.any() or late.any() or any(general(name) in (*OFFSET, CLOCK) for name in free)
    points = not np.isfinite(log.angular_acceleration).any()
    if not fitted and (points or not place.any()):
        return force, slopes
    if not np.isfinite(log.angular_acceleration).all():
        found = "position and delay of the accelerometer need a log with time derivatives"
        remedy = "fit whole flights with --method balance, or leave out the sensor parameters"
        raise InputError(found, remedy, log.source)
    rates, turning = log.rates, log.angular_acceleration
    by_place = [
        vehicle.mass * (np.cross(turning, e) + np.cross(rates, np.cross(rates, e)))
        for e in np.eye(3)
    ]
    by_clock = -vehicle.mass * log.specific_force_rate
    force += np.einsum("k,knj->nj", place, np.stack(by_place)) + late[:, None] * by_clock
    for row, name in enumerate(free):
        if name in OFFSET:
            slopes[row] = by_place[OFFSET.index(name)]
        elif general(name) == CLOCK:
            slopes[row] = by_clock * samples_of(name, values, log)[:, None]
    return force, slopes


# --- Parameters of the effects of rotor wakes on other rotors ------------------------------------

PREFIX = "wake_"


def wakes_with(vehicle: Vehicle, values: Mapping[str, float]) -> Wakes | None:
    """Return the wakes of the vehicle with the parameters of ``WAKES`` in ``values``.

    Return None if neither ``vehicle`` nor ``values`` has wakes: then no rotor affects another.
    """
    given = {name.removeprefix(PREFIX): values[name] for name in WAKES if name in values}
    if not given:
        return vehicle.wakes
    return Wakes(**(asdict(vehicle.wakes or Wakes()) | given))


FAST = 0.5
"""Ratio of the largest airspeed to the inflow in hover above which a fit frees wakes and body [-].
At lower ratios, wakes are within 27 deg of the rotor axis.  One prior standard deviation of a body
area changes the force by at most 2.5 % of the weight.  Errors of the thrust are as large.  A fit to
Neural-Fly flights at ratios up to 0.3 attributes such errors to wakes and body.  With free wake
parameters, this fit predicts only a quarter of the measured thrust at 4.2 m/s.  With free body
areas, this fit predicts two thirds of the measured thrust at 8.5 m/s."""


def is_fast(vehicle: Vehicle, log: FlightLog) -> bool:
    """Return whether a flight is fast enough to determine the wakes and the body."""
    disks = len(vehicle.mounts) * vehicle.air.density * np.pi * vehicle.propeller.radius**2
    inflow = np.sqrt(vehicle.mass * GRAVITY / (2.0 * disks))
    return bool(np.nanmax(log.speed) > FAST * inflow)


# -------------------------------------------------------------------------------------------------
# The thrust scale of a flight from its hover: effect of battery, mass and rotor speed errors.
#
# In hover, the thrust of a rotor is proportional to the square of its speed.  The hover ratio of a
# flight is its measured thrust / sum of squared rotor speeds.  Its differences between flights
# are due to errors of rotor speeds or forces, not of the model.  The hover ratio, divided by the
# ratio of all flights of a fit, gives the factor ``thrust_scale[FLIGHT]`` on the rotor loads.

SLOW, LEVEL_RATE, QUIET = 1.0, 0.5, 0.15
"""Limits of hover: speed [m/s], angular rate [rad/s], and difference of the specific force from
gravity, as a share of gravity."""

LEAST_HOVER = 0.5
"""Least duration of hover that determines a scale [s]."""

NAME = "thrust_scale"

IN_HOVER = 0.01
"""Prior standard deviation of the scale of a flight with hover.  In the two flights of
examples/neurobem, the scales of hover at the start and at the end differ by 0.7 and 1.2 %."""

RANGE = (0.9, 1.1)
"""Range of scales that are applied; outside, the mass or the unit of the rotor speeds is wrong."""


@dataclass(frozen=True)
class HoverScale:
    """Thrust scales of the flights of a log, from the hover of each flight."""

    flights: tuple[str, ...]  # names by number
    # Hover ratio: thrust / sum of squared rotor speeds [N s^2], by number of the flight, for
    # flights with enough hover.
    measured: Mapping[int, float]
    reference: float | None  # hover ratio of the flights of a fit [N s^2]; None without hover

    @classmethod
    def of(cls, vehicle: Vehicle, log: FlightLog, reference: float | None = None) -> HoverScale:
        """Return the scales of a ``log``; the default ``reference`` is the mean hover ratio."""
        total = np.sum([mount.axis for mount in vehicle.mounts], axis=0)
        axis = total / max(float(np.linalg.norm(total)), 1e-9)
        still = (log.speed < SLOW) & (np.linalg.norm(log.rates, axis=1) < LEVEL_RATE)
        off = np.linalg.norm(log.specific_force - GRAVITY * log.up, axis=1)
        still &= off < QUIET * GRAVITY
        measured = {}
        for number in np.unique(log.flight):
            mine = log.flight == number
            steps = np.diff(log.time[mine])
            step = 0.0 if steps.size == 0 else float(np.median(steps))
            hovers = still & mine
            squares = float(np.sum(np.square(log.rotor_speed[hovers])))
            if np.count_nonzero(hovers) * step >= LEAST_HOVER and squares > 0.0:
                thrust = vehicle.mass * float(np.sum(log.specific_force[hovers] @ axis))
                measured[int(number)] = thrust / squares
        if reference is None and measured:
            reference = float(np.mean(list(measured.values())))
        return cls(log.flights, measured, reference)

    @property
    def scales(self) -> dict[str, float]:
        """Scales within ``RANGE`` [-], by the names ``thrust_scale[FLIGHT]``."""
        if not self.reference:
            return {}
        found = {
            of_flight(NAME, self.flights[number]): one / self.reference
            for number, one in self.measured.items()
        }
        return {n: scale for n, scale in found.items() if RANGE[0] <= scale <= RANGE[1]}

    @property
    def remarkable(self) -> dict[str, float]:
        """Scales that differ from 1 by more than two standard deviations ``IN_HOVER``."""
        return {name: one for name, one in self.scales.items() if abs(one - 1.0) > 2.0 * IN_HOVER}

    @property
    def priors(self) -> dict[str, Prior]:
        """Prior of the scale of each flight; empty for a single flight.

        A fit to a single flight cannot separate its scale from the thrust of the blade.
        """
        if len(self.flights) < 2:
            return {}
        names = [of_flight(NAME, flight) for flight in self.flights]
        known = {name: Prior(scale, IN_HOVER) for name, scale in self.scales.items()}
        return {name: known.get(name, Prior(1.0, PER_FLIGHT[NAME])) for name in names}

    def reference_at(self, values: Mapping[str, float]) -> float | None:
        """Return the hover ratio of a flight with scale 1 [N s^2], from the fitted ``values``."""
        each = [
            one / values.get(of_flight(NAME, self.flights[number]), 1.0)
            for number, one in self.measured.items()
        ]
        return float(np.mean(each)) if each else None


# --- Parameters with one value per flight of a log: thrust scale, clock offset and trim ----------


def of_each(name: str, log: FlightLog) -> tuple[str, ...]:
    """Return the names of the parameter ``name`` for each flight of ``log``."""
    return tuple(of_flight(name, flight) for flight in log.flights)


def at_samples(name: str, values: Mapping[str, float], log: FlightLog) -> Floats:
    """Return the parameter ``name`` of ``PER_FLIGHT`` at each sample (n,).

    For a flight without its own value, use the value of ``name`` without ``[FLIGHT]``.
    """
    common = values.get(name, EVERY[name].start)
    each = [values.get(one, common) for one in of_each(name, log)]
    return np.array(each)[log.flight.astype(int)]


def samples_of(name: str, values: Mapping[str, float], log: FlightLog) -> NDArray[np.bool_]:
    """Return whether the parameter ``name`` acts on each sample (n,).

    A parameter without ``[FLIGHT]`` acts on all flights without their own entry in ``values``.
    """
    if general(name) == name:
        own = np.array([one in values for one in of_each(name, log)])
        return np.asarray(~own[log.flight.astype(int)])
    flights = [of_flight(general(name), flight) for flight in log.flights]
    return np.asarray(log.flight == flights.index(name))


def check_flights(names: Sequence[str], log: FlightLog) -> None:
    """Raise an ``InputError`` if one of ``names`` refers to a flight that ``log`` does not have."""
    here = [one for name in PER_FLIGHT for one in of_each(name, log)]
    for name in names:
        if general(name) != name and name not in here:
            remedy = f"name one of {', '.join(log.flights)}, or omit the brackets for all flights"
            raise InputError(f"{quoted(name)} names no flight of the logs", remedy)


def of_others(values: Mapping[str, float]) -> dict[str, float]:
    """Return ``values`` for other flights: the means over the flights of the fit."""
    found = dict(values)
    for name in PER_FLIGHT:
        mine = [value for one, value in values.items() if general(one) == name != one]
        if mine:
            found[name] = float(np.mean(mine))
    return found
