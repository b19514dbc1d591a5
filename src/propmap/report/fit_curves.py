"""Curves of a fit over speed, and pictures of the measurements that it was made from."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.fit.files import FitFile, FitRecord
from propmap.fit.fit import CoveredAngle
from propmap.fit.flight import body_force, hover_loads, wing_values
from propmap.fit.least_squares import rms
from propmap.fit.parameters import EVERY, ROTOR
from propmap.fit.tunnel import TunnelData
from propmap.loads import LOADS, Load
from propmap.model.model import Model
from propmap.report.html import (
    COLOURS,
    HOVER,
    MEASURED,
    MODEL,
    csv_of_columns,
    key,
    legend_below,
    legend_in_last,
    new_figure,
    share_of_weight,
    style,
)
from propmap.report.words import motor_note
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import GRAVITY, RPM
from propmap.vehicle.log import FlightLog
from propmap.vehicle.wakes import hub_flow, rotor_forces

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from propmap.fit.tunnel import TunnelData
    from propmap.model.model import Section
    from propmap.vehicle.vehicle import Vehicle


# -------------------------------------------------------------------------------------------------
# Loads of the fitted propeller over speed, and what the parameters' uncertainty does to them.

SPEEDS = 26
MOST_ANGLES = 4
BEYOND = 1.25
"""How far the curves go, in units of the data's largest advance ratio."""

UNTESTED = 0.25
"""Advance ratio to which they go where all data are from rest."""

APART = 22.5
"""[deg], closer than which two angles are one."""


NEAR = np.radians(2.5)
"""Of a curve's angle, within which measured points are drawn with it."""

DATA: dict[str, Any] = {"color": "0.92", "linewidth": 0.0}
BAND: dict[str, Any] = {"color": COLOURS[5], "alpha": 0.55, "linewidth": 0.0}
POINTS: dict[str, Any] = {**MEASURED, "color": COLOURS[1], "marker": "o"}


@dataclass(frozen=True, eq=False)
class Curve:
    """Loads at one angle.

    Attributes
    ----------
    beta : float
        The angle [rad].
    covered : tuple of float or None
        Ends of the speeds that the data cover at this angle [m/s].
    loads, low, high : dict of str to ndarray, shape (n,)
        Loads by name, and the ends of their bands; these are None without a band.
    valid : ndarray, shape (n,)
        Where momentum theory holds.
    """

    beta: float
    covered: tuple[float, float] | None
    loads: dict[str, Floats]
    low: dict[str, Floats] | None
    high: dict[str, Floats] | None
    valid: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Curves:
    """Curves at one rotational speed.

    Attributes
    ----------
    omega, radius : float
        Rotational speed [rad/s] and radius of the propeller [m].
    speed : ndarray, shape (n,)
        Flight speeds of all curves [m/s].
    curves : sequence of Curve
        By rising angle.
    hover : dict of str to float
        The hover model's loads by name.
    seen : collection of str
        Loads that the data tell of.
    draws : int
        How many sets of parameters make the bands.
    motor : str
        A sentence on ``motor_note``, empty where the model has what is mounted.
    """

    omega: float
    radius: float
    speed: Floats
    curves: Sequence[Curve]
    hover: dict[str, float]
    seen: Collection[str]
    draws: int
    motor: str

    @property
    def rpm(self) -> float:
        """Rotational speed [1/min]."""
        return self.omega / RPM


def load_curves(file: FitFile) -> Curves:
    """The fitted rotor at the data's typical rotational speed, past the speeds of the data."""
    fit = file.record
    omega = fit.covered.typical_rpm * RPM
    tip = omega * file.model.propeller.radius
    top = max([one.advance[1] for one in fit.covered.main_angles], default=UNTESTED / BEYOND)
    speed = np.linspace(0.0, BEYOND * top * tip, SPEEDS)
    angles = _angles(fit)
    betas = np.radians([beta for beta, _ in angles])

    rotor = Rotor(file.model)
    found = rotor.loads(omega, speed, betas[:, None])
    values, status = np.stack([getattr(found, name) for name in LOADS]), found.status
    names, changes = drawn_changes(fit)
    low, high = values, values
    if len(changes):
        moved = values + np.tensordot(changes, _slopes(rotor, names, omega, speed, betas), 1)
        # The fit may sit in a corner of the bounds, with all draws on one side of it.
        low, high = np.percentile(moved, [2.5, 97.5], axis=0)
        low, high = np.minimum(low, values), np.maximum(high, values)
    curves = [
        Curve(
            beta=float(np.radians(beta)),
            covered=_covered(fit, data, tip),
            loads=_named(values[:, k]),
            low=_named(low[:, k]) if len(changes) else None,
            high=_named(high[:, k]) if len(changes) else None,
            valid=status[k] != "vortex_ring",
        )
        for k, (beta, data) in enumerate(angles)
    ]
    still = HoverModel.of(rotor).loads(omega)
    hover = {name: float(value) for name, value in still.items()}
    motor = motor_note(rotor, found, speed, betas[:, None])
    radius = file.model.propeller.radius
    return Curves(omega, radius, speed, curves, hover, _seen(fit), len(changes), motor)


@style()
def curve_figure(curves: Curves, measured: TunnelData | None) -> Figure:
    """A row per load, a column per angle; with the measured points if there are any."""
    count = len(curves.curves)
    figure = new_figure(max(2.35 * count + 0.6, 8.6), 2.15 * len(LOADS))
    axes = figure.subplots(len(LOADS), count, sharex=True, sharey="row", squeeze=False)
    for row, (name, load) in zip(axes, LOADS.items(), strict=True):
        row[0].set_ylabel(load.title)
        for ax, one in zip(row, curves.curves, strict=True):
            if name in curves.seen and one.covered is not None:
                ax.axvspan(*one.covered, **DATA)
            if one.low is not None and one.high is not None:
                ax.fill_between(curves.speed, one.low[name], one.high[name], **BAND)
            ax.plot(curves.speed, np.full_like(curves.speed, curves.hover[name]), **HOVER)
            look = {**MODEL, "color": COLOURS[0]}
            ax.plot(curves.speed, np.where(one.valid, one.loads[name], np.nan), **look)
            if not one.valid.all():
                ring = np.where(one.valid, np.nan, one.loads[name])
                ax.plot(curves.speed, ring, **{**look, "linestyle": ":"})
            if measured is not None and name in measured.loads:
                _points(ax, curves, one, name, measured)
    for ax, one in zip(axes[0], curves.curves, strict=True):
        data = "" if one.covered else ", no data"
        ax.set_title(f"β = {np.degrees(one.beta):.0f}°{data}", fontsize=9.0)
    for ax in axes[-1]:
        ax.set_xlabel("flight speed V [m/s]")
        ax.set_xlim(0.0, curves.speed[-1])
    handles = [
        key("this model", color=COLOURS[0], **MODEL),
        *([Patch(label="95 % by the parameters", **BAND)] if curves.draws else []),
        key("hover model", **HOVER),
        Patch(label="covered by the data", **DATA),
        *([key("measured", **{**POINTS, "markersize": 4.0})] if measured is not None else []),
    ]
    legend_below(figure, handles, columns=5)
    return figure


def curve_sheet(curves: Curves) -> str:
    """The curves as CSV."""
    groups = []
    for one in curves.curves:
        low, high = one.covered or (1.0, 0.0)
        group: dict[str, Any] = {
            "beta_deg": np.degrees(one.beta),
            "speed_mps": curves.speed,
            "rpm": curves.rpm,
            "advance_ratio": curves.speed / (curves.omega * curves.radius),
            "covered": ((low <= curves.speed) & (curves.speed <= high)).astype(int),
            "momentum_theory_holds": one.valid.astype(int),
            **{load.column: one.loads[name] for name, load in LOADS.items()},
        }
        for name, load in LOADS.items():
            for end, side in (("low", one.low), ("high", one.high)):
                column = load.column.replace(name, f"{name}_{end}_95")
                group[column] = side[name] if side else None
        group |= {f"hover_{load.column}": curves.hover[name] for name, load in LOADS.items()}
        groups.append(group)
    return csv_of_columns(groups)


def _slopes(
    rotor: Rotor, names: tuple[str, ...], omega: float, speed: Floats, betas: Floats
) -> Floats:
    """Derivatives (P, loads, angles, n) of the loads by the parameters named."""
    b = betas[:, None]
    flow = (omega, speed * np.cos(b), speed * np.abs(np.sin(b)))
    return rotor.gradients(names, *flow).slopes.swapaxes(0, 1)


def _angles(fit: FitRecord) -> list[tuple[float, CoveredAngle | None]]:
    """Up to four angles [deg] with the data's points about them, and edgewise or axial flow where
    there were points at one angle at most."""
    groups = fit.covered.main_angles
    betas = np.array([one.typical_beta for one in groups])
    wanted = np.linspace(betas[0], betas[-1], MOST_ANGLES) if betas.size else betas
    nearest = dict.fromkeys(int(np.argmin(np.abs(betas - beta))) for beta in wanted)
    found: dict[float, CoveredAngle | None] = {groups[k].typical_beta: groups[k] for k in nearest}
    for other in (0.0, 90.0):
        if all(abs(other - beta) > APART for beta in found) and len(found) < MOST_ANGLES:
            found[other] = None
    return sorted(found.items(), key=lambda pair: pair[0])


def _covered(fit: FitRecord, data: CoveredAngle | None, tip: float) -> tuple[float, float] | None:
    if data is None:
        return None
    low = 0.0 if fit.covered.at_rest is not None else data.advance[0]
    return low * tip, data.advance[1] * tip


def _named(values: Floats) -> dict[str, Floats]:
    return dict(zip(LOADS, values, strict=True))


def _points(ax: Axes, curves: Curves, one: Curve, load: str, data: TunnelData) -> None:
    """Points near the curve's angle, at the advance ratio that they were measured at."""
    ratio = curves.omega / np.maximum(data.omega, 1e-9)
    mine = (np.abs(data.folded_beta - one.beta) < NEAR) | (data.speed == 0.0)
    mine &= (data.omega > 0.0) & (data.speed * ratio <= curves.speed[-1])
    loads = data.loads[load] * ratio**2
    ax.plot((data.speed * ratio)[mine], loads[mine], **{**POINTS, "markersize": 2.6})


def _seen(fit: FitRecord) -> Collection[str]:
    """In flight, the loads that make the forces."""
    if fit.kind == "tunnel":
        return [one.name for one in fit.loads]
    return ("thrust",) if fit.kind == "level flight" else ("thrust", "drag")


# -------------------------------------------------------------------------------------------------
# Figures of an identification: its data, and the fitted model beside the hover model.

ALIKE = 0.02
"""Relative difference of two predictions of the hover model that are drawn as one."""

SAMPLES: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 1.5}
SHADE: dict[str, Any] = {"color": COLOURS[4], "alpha": 0.25, "linewidth": 0.0}
"""Of the steady stretches."""


@style()
def level_flight(
    vehicle: Vehicle, points: FlightLog, airfoil: Section, *, accuracy: str = "standard"
) -> Figure:
    """The paper's figure 6: loads, vertical force error and pitch angle against flight speed.

    Loads are sums over the rotors, computed at the rotor speeds and the flow of each point; the
    error is the vertical force of rotors, body and wing, less the weight.  What an accelerometer
    read is drawn as measured thrust and drag: it includes the body's share, and leaves out what
    acts across the flight.

    Parameters
    ----------
    vehicle : Vehicle
        What flew.
    points : FlightLog
        Operating points of steady flight.
    airfoil : Section
        The section law.
    accuracy : str
        Of the loads.
    """
    points = points.picked(np.argsort(points.speed, kind="stable"))
    panels = _level_panels(
        vehicle, points, Model(vehicle.propeller, airfoil, vehicle.air), accuracy
    )
    figure = new_figure(9.6, 6.4)
    axes = figure.subplots(2, 3, sharex=True).ravel()
    for ax, (label, (found, hover, measured)) in zip(axes, panels.items(), strict=False):
        if found is not None and hover is not None:
            ax.plot(points.speed, hover, **HOVER)
            ax.plot(points.speed, found, color=COLOURS[0], marker=".", markersize=3.0, **MODEL)
        if measured is not None:
            ax.plot(points.speed, measured, color=COLOURS[1], marker="o", **MEASURED)
        ax.set_ylabel(label)
    axes[3].axhline(0.0, color="0.6", linewidth=0.8)
    share_of_weight(axes[3], vehicle.mass * GRAVITY)
    for ax in axes[:5]:
        ax.margins(x=0.02)

    left, hover_left, _ = panels["vertical force error [N]"]
    body = vehicle.wing is not None or any((*vehicle.body.drag_area, vehicle.body.lift_area))
    share = " (with the body's)" if body else ""
    felt = f"mass by accelerometer{share},\n" if np.isfinite(points.specific_force).any() else ""
    handles = [
        key(f"this model, force error {rms(left):.3g} N rms", color=COLOURS[0], **MODEL),
        key(f"hover model, force error {rms(hover_left):.3g} N rms", **HOVER),
        key(
            f"measured: {felt}pitch angle", color=COLOURS[1], marker="o",
            **{**MEASURED, "clip_on": True},
        ),
    ]  # fmt: skip
    legend_in_last(axes, handles, "flight speed V [m/s]")
    figure.suptitle(
        f"{vehicle.name}, {vehicle.propeller.name}, airfoil {airfoil.name}: "
        f"{len(points)} operating points"
    )
    return figure


def _level_panels(
    vehicle: Vehicle, points: FlightLog, model: Model, accuracy: str
) -> dict[str, tuple[Any, Any, Any]]:
    """By label: this model, the hover model, and what was measured; (n,) each, or None."""
    rotor, flow = Rotor(model, accuracy=accuracy), hub_flow(vehicle, points)
    velocity = np.stack([flow.inplane, 0.0 * flow.inplane, flow.axial], axis=-1)
    loads = rotor.loads_at_velocity(flow.omega, velocity)
    hover = HoverModel.of(rotor, float(np.mean(flow.omega)))
    still = {name: each.sum(axis=1) for name, each in hover.loads(flow.omega).items()}
    values = {name: parameter.start for name, parameter in EVERY.items()}
    body, _ = body_force(vehicle, points, values | wing_values(vehicle), ())
    error, hover_error = (
        np.sum(force * points.up, axis=1) - vehicle.mass * GRAVITY
        for force in (
            rotor_forces(flow, loads.thrust, loads.drag) + body,
            hover_loads(hover, flow)[:, :3],
        )
    )
    felt, across = vehicle.mass * points.specific_force, points.velocity[:, :2]
    length = np.linalg.norm(across, axis=1, keepdims=True)
    direction = np.divide(across, length, out=np.zeros_like(across), where=length > 0.0)
    felt_drag = -np.sum(felt[:, :2] * direction, axis=1)
    pitch = np.degrees(np.arctan2(-points.up[:, 0], points.up[:, 2]))
    return {
        "collective thrust ΣT [N]": (loads.thrust.sum(axis=1), still["thrust"], felt[:, 2]),
        "collective rotor drag ΣD [N]": (loads.drag.sum(axis=1), still["drag"], felt_drag),
        "collective torque [N m]": (loads.torque.sum(axis=1), still["torque"], None),
        "vertical force error [N]": (error, hover_error, None),
        "pitch angle, nose down [deg]": (None, None, pitch),
    }


@style()
def tunnel_fit(data: TunnelData, rotor: Rotor) -> Figure:
    """Measured against predicted, a panel per load, the hover model's predictions dashed.

    The hover model knows the rotational speed alone: rows of one speed have one prediction.
    Raises ``InputError`` without a measured load.
    """
    measured = {n: v for n, v in data.loads.items() if n in LOADS and np.isfinite(v).any()}
    if not measured:
        raise InputError("there is no load to draw", f"give {', '.join(LOADS)}", data.source)
    found: Any = rotor.loads(data.omega, data.speed, data.beta)
    hover = HoverModel.of(rotor).loads(data.omega)
    rows, columns = -(-len(measured) // 2), min(len(measured), 2)
    figure = new_figure(8.6 if columns > 1 else 5.2, 3.8 * rows + 0.6)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax in axes[len(measured) :]:
        ax.axis("off")
    for ax, (name, truth) in zip(axes, measured.items(), strict=False):
        _one_load(ax, LOADS[name], truth, getattr(found, name), _alike(truth, hover[name]))
    handles = [
        key("predicted = measured", color="0.6", linewidth=1.0),
        key("this model", color=COLOURS[0], marker="o", linestyle="none", markersize=4.5),
        key("hover model", **HOVER),
    ]
    legend_below(figure, handles)
    figure.suptitle(
        f"{rotor.model.propeller.name}, airfoil {rotor.model.law_title}\n"
        f"{len(data)} rows of {data.source}"
    )
    return figure


def _one_load(
    ax: Axes, load: Load, truth: Floats, found: Floats, hover: list[tuple[float, float, float]]
) -> None:
    known = np.isfinite(truth) & np.isfinite(found)
    ends = np.array([*truth[known], *found[known], *(level for _, _, level in hover), 0.0])
    # A single row gets a dash of its own.
    least = 0.04 * float(np.ptp(ends))
    ax.axline((0.0, 0.0), slope=1.0, color="0.6", linewidth=1.0)
    for left, right, level in hover:
        middle, half = 0.5 * (left + right), max(0.5 * (right - left), least)
        ax.plot([middle - half, middle + half], [level, level], **HOVER)
    ax.plot(truth[known], found[known], color=COLOURS[0], marker="o", **MEASURED)
    left = rms((found - truth)[known])
    ax.set_title(f"{load.label}: rms error {left:.3g} {load.unit}", fontsize=9.0)
    ax.set_xlabel(f"measured {load.title}")
    ax.set_ylabel(f"predicted {load.title}")


def _alike(truth: Floats, hover: Floats) -> list[tuple[float, float, float]]:
    """Range of the measured load over rows with one prediction of the hover model, and that."""
    known = np.flatnonzero(np.isfinite(truth))
    known = known[np.argsort(hover[known])]
    breaks = np.flatnonzero(np.diff(hover[known]) > ALIKE * hover[known][1:]) + 1
    groups = np.split(known, breaks)
    return [(float(truth[g].min()), float(truth[g].max()), float(hover[g].mean())) for g in groups]


@style()
def steady_parts(log: FlightLog, stretches: Sequence[slice]) -> Figure:
    """Speed, climb rate and rotor speeds against time, the steady stretches shaded.

    Parameters
    ----------
    log : FlightLog
        The flight.
    stretches : sequence of slice
        Of its samples, as ``flight.steady.steady_stretches`` finds them.
    """
    ends = [(log.time[part.start], log.time[part.stop - 1]) for part in stretches]
    figure = new_figure(9.2, 6.0)
    axes = figure.subplots(3, 1, sharex=True, height_ratios=(1.2, 1.0, 1.2))
    speed, climb, rotors = axes
    for ax, values in ((speed, log.speed), (climb, log.climb_rate)):
        ax.plot(log.time, values, color=COLOURS[0], rasterized=True, **SAMPLES)
        for pair, part in zip(ends, stretches, strict=True):
            ax.plot(pair, 2 * [np.mean(values[part])], color=COLOURS[1], linewidth=1.6)
    colours = [COLOURS[k % len(COLOURS)] for k in range(log.rotor_speed.shape[1])]
    for colour, values in zip(colours, log.rotor_speed.T, strict=True):
        rotors.plot(log.time, values / RPM, color=colour, rasterized=True, **SAMPLES)
    for ax, label in zip(
        axes, ("speed V [m/s]", "climb rate [m/s]", "rotor speeds [1/min]"), strict=True
    ):
        for pair in ends:
            ax.axvspan(*pair, **SHADE)
        ax.set_ylabel(label)
    rotors.set_xlabel("time [s]")
    rotors.set_xlim(log.time[0], log.time[-1])
    dots: dict[str, Any] = {"marker": ".", "linestyle": "none"}
    handles: list[Any] = [
        Patch(label="steady stretch", **SHADE),
        key("its average", color=COLOURS[1], linewidth=1.6),
        *(key(f"rotor {k + 1}", color=colour, **dots) for k, colour in enumerate(colours)),
    ]
    legend_below(figure, handles, columns=min(len(handles), 8))
    seconds = sum(float(last - first) for first, last in ends)
    figure.suptitle(
        f"{log.source}: {len(stretches)} steady stretches, {seconds:.0f} of "
        f"{log.time[-1] - log.time[0]:.0f} s"
    )
    return figure


# -------------------------------------------------------------------------------------------------
# Parameters drawn from what a fit knows of them, within their bounds.

DRAWS = 200
"""Sets of parameters that make a band."""

TRIED, ROUNDS = 20_000, 50
"""Draws at a time, and how often, until enough of them are within the bounds."""

SEED = 2017


def drawn_changes(fit: FitRecord) -> tuple[tuple[str, ...], Floats]:
    """Parameters of section and mount drawn from the normal distribution with the fit's covariance.

    All parameters are drawn together; draws with any of them outside its bounds are thrown away.
    Parameters of infinite variance keep their value.

    Returns
    -------
    tuple of str
        Names of P of these parameters.
    ndarray, shape (``DRAWS``, P)
        By how much the draws differ from the fit; (0, P) where almost no draw is within the bounds.
    """
    known = [k for k in range(len(fit.parameters)) if np.isfinite(fit.covariance[k, k])]
    chosen = [fit.parameters[k] for k in known]
    section = [k for k, p in enumerate(chosen) if p.name in ROTOR]
    names = tuple(chosen[k].name for k in section)
    covariance = fit.covariance[np.ix_(known, known)]
    if not section or not np.isfinite(covariance).all():
        return names, np.empty((0, len(section)))
    middle, lower, upper = np.array([(p.value, p.lower, p.upper) for p in chosen]).T
    # A value at its bound is within it, whatever rounding made of it.
    slack = 1e-9 * (upper - lower)
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(size, size))
    root = size[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    rng = np.random.default_rng(SEED)
    kept: list[Floats] = []
    for _ in range(ROUNDS):
        change = rng.standard_normal((TRIED, len(known))) @ root.T
        found = middle + change
        kept.append(change[((found >= lower - slack) & (found <= upper + slack)).all(axis=1)])
        if sum(map(len, kept)) >= DRAWS:
            return names, np.concatenate(kept)[:DRAWS, section]
    return names, np.empty((0, len(section)))


def held(fit: FitRecord) -> list[str]:
    """Names of these free parameters that keep their value in every draw."""
    return [
        p.name
        for k, p in enumerate(fit.parameters)
        if p.name in ROTOR and not np.isfinite(fit.covariance[k, k])
    ]
