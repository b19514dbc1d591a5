"""Figures of a fit: loads over airspeed with bands, and the measurements."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from propmap.errors import InputError
from propmap.fit.files import FitFile, FitRecord
from propmap.fit.fit import CoveredAngle
from propmap.fit.flight import body_force, hover_loads, wing_values
from propmap.fit.least_squares import rms
from propmap.fit.parameters import EVERY, ROTOR
from propmap.fit.tunnel import TunnelData
from propmap.hover import HoverModel
from propmap.loads import LOADS
from propmap.model.model import Model, Section, installation_note
from propmap.report.html import (
    COLORS,
    HOVER,
    MEASURED,
    MODEL,
    FigureRecord,
    key,
    legend_below,
    legend_in_last,
    new_figure,
    share_of_weight,
    style,
)
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import GRAVITY, RPM
from propmap.vehicle.log import FlightLog, hub_flow
from propmap.vehicle.vehicle import Vehicle
from propmap.vehicle.wakes import rotor_forces

SPEEDS, MOST_ANGLES = 26, 4
BEYOND = 1.25  # end of the curves, relative to the largest advance ratio of the data
UNTESTED = 0.25  # advance ratio at the end of the curves if all data are static
APART = 22.5  # [deg] smallest distance of a curve without data from the angles of the data
NEAR = np.radians(2.5)  # largest difference in angle between measured points and their curve

DATA: dict[str, Any] = {"color": "0.92", "linewidth": 0.0}
BAND: dict[str, Any] = {"color": COLORS[5], "alpha": 0.55, "linewidth": 0.0}
POINTS: dict[str, Any] = {**MEASURED, "color": COLORS[1], "marker": "o"}


def load_lines(file: FitFile, measured: TunnelData | None) -> tuple[FigureRecord, dict[str, Any]]:
    """Return the loads of the fitted rotor over airspeed, a row per load and a column per angle.

    The rotational speed is typical of the data.  The second result contains this ``rpm``, the
    number of samples ``draws`` of the bands, and a sentence on the installation as ``motor``.
    """
    fit = file.record
    omega = fit.covered.typical_rpm * RPM
    tip = omega * file.model.propeller.radius
    top = max([one.advance[1] for one in fit.covered.main_angles], default=UNTESTED / BEYOND)
    speed = np.linspace(0.0, BEYOND * top * tip, SPEEDS)
    angles = _angles(fit)
    betas = np.radians([beta for beta, _ in angles])[:, None]

    rotor = Rotor(file.model)
    found = rotor.loads(omega, speed, betas)
    values = np.stack([getattr(found, name) for name in LOADS])
    names, changes = drawn_changes(fit)
    low, high = values, values
    if len(changes):
        flow = (omega, speed * np.cos(betas), speed * np.abs(np.sin(betas)))
        slopes = rotor.gradients(names, *flow).slopes.swapaxes(0, 1)  # (P, loads, angles, n)
        perturbed = values + np.tensordot(changes, slopes, 1)
        # In a corner of the bounds, all samples can be on one side of the fit.
        low, high = np.percentile(perturbed, [2.5, 97.5], axis=0)
        low, high = np.minimum(low, values), np.maximum(high, values)
    still = HoverModel.from_rotor(rotor).loads(omega)
    hover = {name: float(value) for name, value in still.items()}
    # Range of airspeeds of the data at each angle; points at rest belong to all angles.
    from_rest = fit.covered.at_rest is not None
    ends = [
        None
        if data is None
        else ((0.0 if from_rest else data.advance[0]) * tip, data.advance[1] * tip)
        for _, data in angles
    ]
    groups = []
    for k, (beta, _) in enumerate(angles):
        first, last = ends[k] or (1.0, 0.0)
        group: dict[str, Any] = {
            "beta_deg": beta,
            "speed_mps": speed,
            "rpm": omega / RPM,
            "advance_ratio": speed / tip,
            "covered": ((first <= speed) & (speed <= last)).astype(int),
            "momentum_theory_holds": (found.status[k] != "vortex_ring").astype(int),
            **{load.column: values[i, k] for i, load in enumerate(LOADS.values())},
        }
        for i, (name, load) in enumerate(LOADS.items()):
            for end, side in (("low", low), ("high", high)):
                column = load.column.replace(name, f"{name}_{end}_95")
                group[column] = side[i, k] if len(changes) else None
        groups.append(group | {f"hover_{LOADS[name].column}": hover[name] for name in LOADS})

    # Measured forces in flight determine these loads of the rotors.
    seen: Sequence[str] = ("thrust",) if fit.kind == "level flight" else ("thrust", "drag")
    if fit.kind == "tunnel":
        seen = [one.name for one in fit.loads]

    def draw() -> Figure:
        count = len(groups)
        figure = new_figure(max(2.35 * count + 0.6, 8.6), 2.15 * len(LOADS))
        axes = figure.subplots(len(LOADS), count, sharex=True, sharey="row", squeeze=False)
        for row, (name, load) in zip(axes, LOADS.items(), strict=True):
            row[0].set_ylabel(load.title)
            for ax, one, covered in zip(row, groups, ends, strict=True):
                if name in seen and covered is not None:
                    ax.axvspan(*covered, **DATA)
                if len(changes):
                    band = [one[load.column_of(f"{end}_95")] for end in ("low", "high")]
                    ax.fill_between(speed, *band, **BAND)
                ax.plot(speed, np.full_like(speed, hover[name]), **HOVER)
                look = {**MODEL, "color": COLORS[0]}
                valid = one["momentum_theory_holds"] == 1
                ax.plot(speed, np.where(valid, one[load.column], np.nan), **look)
                if not valid.all():
                    ring = np.where(valid, np.nan, one[load.column])
                    ax.plot(speed, ring, **{**look, "linestyle": ":"})
                if measured is not None and name in measured.loads:
                    # Points near the angle of the curve, scaled at constant advance ratio.
                    ratio = omega / np.maximum(measured.omega, 1e-9)
                    away = np.abs(measured.folded_beta - np.radians(one["beta_deg"]))
                    mine = (away < NEAR) | (measured.speed == 0.0)
                    mine &= (measured.omega > 0.0) & (measured.speed * ratio <= speed[-1])
                    at, scaled = measured.speed * ratio, measured.loads[name] * ratio**2
                    ax.plot(at[mine], scaled[mine], **{**POINTS, "markersize": 2.6})
        for ax, one, covered in zip(axes[0], groups, ends, strict=True):
            data = "" if covered else ", no data"
            ax.set_title(f"β = {one['beta_deg']:.0f}°{data}", fontsize=9.0)
        for ax in axes[-1]:
            ax.set(xlabel="airspeed V [m/s]", xlim=(0.0, speed[-1]))
        handles = [
            key("this model", color=COLORS[0], **MODEL),
            *([Patch(label="95 % band", **BAND)] if len(changes) else []),
            key("hover model", **HOVER),
            Patch(label="range of the data", **DATA),
            *([key("measured", **{**POINTS, "markersize": 4.0})] if measured is not None else []),
        ]
        legend_below(figure, handles, columns=5)
        return figure

    facts = {"rpm": omega / RPM, "draws": len(changes), "motor": installation_note(rotor.model)}
    return FigureRecord("fit-loads", groups, draw), facts


def _angles(fit: FitRecord) -> list[tuple[float, CoveredAngle | None]]:
    """Return up to four angles [deg] and their data; axial and edgewise flow if there is room."""
    groups = fit.covered.main_angles
    betas = np.array([one.typical_beta for one in groups])
    wanted = np.linspace(betas[0], betas[-1], MOST_ANGLES) if betas.size else betas
    nearest = dict.fromkeys(int(np.argmin(np.abs(betas - beta))) for beta in wanted)
    found: dict[float, CoveredAngle | None] = {groups[k].typical_beta: groups[k] for k in nearest}
    for other in (0.0, 90.0):
        if all(abs(other - beta) > APART for beta in found) and len(found) < MOST_ANGLES:
            found[other] = None
    return sorted(found.items(), key=lambda pair: pair[0])


# --- Figures of the measurements, and of the fitted model and the hover model --------------------

ALIKE = 0.02  # relative difference below which predictions of the hover model share one dash

SAMPLES: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 1.5}
SHADE: dict[str, Any] = {"color": COLORS[4], "alpha": 0.25, "linewidth": 0.0}  # steady segments


@style()
def level_flight(vehicle: Vehicle, points: FlightLog, airfoil: Section) -> Figure:
    """Draw figure 6 of the paper: sums of loads over the rotors, vertical force error and pitch.

    The error is the vertical force of rotors, body and wing minus the weight.  Thrust and drag from
    the accelerometer include the forces of the body.
    """
    points = points.picked(np.argsort(points.speed, kind="stable"))
    rotor, flow = Rotor(Model(vehicle.propeller, airfoil, vehicle.air)), hub_flow(vehicle, points)
    velocity = np.stack([flow.inplane, 0.0 * flow.inplane, flow.axial], axis=-1)
    loads = rotor.loads_at_velocity(flow.omega, velocity)
    hover = HoverModel.from_rotor(rotor, float(np.mean(flow.omega)))
    still = {name: each.sum(axis=1) for name, each in hover.loads(flow.omega).items()}
    values = {name: parameter.start for name, parameter in EVERY.items()}
    body, _ = body_force(vehicle, points, values | wing_values(vehicle), ())
    own, by_hover = rotor_forces(flow, loads.thrust, loads.drag) + body, hover_loads(hover, flow)
    lifted = (np.sum(force * points.up, axis=1) for force in (own, by_hover[:, :3]))
    error, hover_error = (force - vehicle.mass * GRAVITY for force in lifted)
    felt, across = vehicle.mass * points.specific_force, points.velocity[:, :2]
    length = np.linalg.norm(across, axis=1, keepdims=True)
    direction = np.divide(across, length, out=np.zeros_like(across), where=length > 0.0)
    felt_drag = -np.sum(felt[:, :2] * direction, axis=1)
    pitch = np.degrees(np.arctan2(-points.up[:, 0], points.up[:, 2]))
    # By label: this model, the hover model and the measured values.
    panels: dict[str, tuple[Any, Any, Any]] = {
        "collective thrust ΣT [N]": (loads.thrust.sum(axis=1), still["thrust"], felt[:, 2]),
        "collective rotor drag ΣD [N]": (loads.drag.sum(axis=1), still["drag"], felt_drag),
        "collective torque [N m]": (loads.torque.sum(axis=1), still["torque"], None),
        "vertical force error [N]": (error, hover_error, None),
        "pitch angle, nose down [deg]": (None, None, pitch),
    }
    figure = new_figure(9.6, 6.4)
    axes = figure.subplots(2, 3, sharex=True).ravel()
    for ax, (label, (found, by_hover, measured)) in zip(axes, panels.items(), strict=False):
        if found is not None:
            ax.plot(points.speed, by_hover, **HOVER)
            ax.plot(points.speed, found, color=COLORS[0], marker=".", markersize=3.0, **MODEL)
        if measured is not None:
            ax.plot(points.speed, measured, color=COLORS[1], marker="o", **MEASURED)
        ax.set_ylabel(label)
    axes[3].axhline(0.0, color="0.6", linewidth=0.8)
    share_of_weight(axes[3], vehicle.mass * GRAVITY)
    for ax in axes[:5]:
        ax.margins(x=0.02)

    has_body = vehicle.wing is not None or any((*vehicle.body.drag_area, vehicle.body.lift_area))
    share = " (with body forces)" if has_body else ""
    known = np.isfinite(points.specific_force).any()
    sensed = f"mass times specific force{share},\n" if known else ""
    handles = [
        key(f"this model, force error {rms(error):.3g} N rms", color=COLORS[0], **MODEL),
        key(f"hover model, force error {rms(hover_error):.3g} N rms", **HOVER),
        key(
            f"measured: {sensed}pitch angle", color=COLORS[1], marker="o",
            **{**MEASURED, "clip_on": True},
        ),
    ]  # fmt: skip
    legend_in_last(axes, handles, "airspeed V [m/s]")
    figure.suptitle(
        f"{vehicle.name}, {vehicle.propeller.name}, airfoil {airfoil.name}: "
        f"{len(points)} operating points"
    )
    return figure


def tunnel_fit(data: TunnelData, rotor: Rotor) -> FigureRecord:
    """Return measured and predicted loads, one panel per load, with the hover model dashed.

    Raise ``InputError`` if no load is measured.
    """
    measured = {n: v for n, v in data.loads.items() if n in LOADS and np.isfinite(v).any()}
    if not measured:
        raise InputError("there is no load to draw", f"give {', '.join(LOADS)}", data.source)
    found: Any = rotor.loads(data.omega, data.speed, data.beta)
    hover = HoverModel.from_rotor(rotor).loads(data.omega)
    columns: dict[str, Any] = {"rpm": data.omega / RPM, "speed_mps": data.speed}
    columns["beta_deg"] = np.degrees(data.beta)
    for name, values in data.loads.items():
        columns[f"measured_{LOADS[name].column}"] = values
        columns[f"model_{LOADS[name].column}"] = getattr(found, name)
        columns[f"hover_{LOADS[name].column}"] = hover[name]

    def draw() -> Figure:
        rows, across = -(-len(measured) // 2), min(len(measured), 2)
        figure = new_figure(8.6 if across > 1 else 5.2, 3.8 * rows + 0.6)
        axes = figure.subplots(rows, across, squeeze=False).ravel()
        for ax in axes[len(measured) :]:
            ax.axis("off")
        for ax, name in zip(axes, measured, strict=False):
            load = LOADS[name]
            truth, model, still = (
                columns[f"{of}_{load.column}"] for of in ("measured", "model", "hover")
            )
            # Rows with the same prediction of the hover model share a dash.
            given = np.flatnonzero(np.isfinite(truth))
            given = given[np.argsort(still[given])]
            breaks = np.flatnonzero(np.diff(still[given]) > ALIKE * still[given][1:]) + 1
            dashes = [
                (float(truth[g].min()), float(truth[g].max()), float(still[g].mean()))
                for g in np.split(given, breaks)
            ]
            known = np.isfinite(truth) & np.isfinite(model)
            ends = [*truth[known], *model[known], *(level for *_, level in dashes), 0.0]
            least = 0.04 * float(np.ptp(ends))  # half width of the dash of a single row
            ax.axline((0.0, 0.0), slope=1.0, color="0.6", linewidth=1.0)
            for left, right, level in dashes:
                middle, half = 0.5 * (left + right), max(0.5 * (right - left), least)
                ax.plot([middle - half, middle + half], [level, level], **HOVER)
            ax.plot(truth[known], model[known], color=COLORS[0], marker="o", **MEASURED)
            error = rms((model - truth)[known])
            ax.set_title(f"{load.label}: rms error {error:.3g} {load.unit}", fontsize=9.0)
            ax.set(xlabel=f"measured {load.title}", ylabel=f"predicted {load.title}")
        handles = [
            key("predicted = measured", color="0.6", linewidth=1.0),
            key("this model", color=COLORS[0], marker="o", linestyle="none", markersize=4.5),
            key("hover model", **HOVER),
        ]
        legend_below(figure, handles)
        figure.suptitle(
            f"{rotor.model.propeller.name}, airfoil {rotor.model.law_title}\n"
            f"{len(data)} rows of {data.source}"
        )
        return figure

    return FigureRecord("fit-measured", [columns], draw)


@style()
def steady_parts(log: FlightLog, segments: Sequence[slice]) -> Figure:
    """Draw airspeed, climb rate and rotor speeds against time; shade the steady segments."""
    time = log.since_start
    ends = [(time[part.start], time[part.stop - 1]) for part in segments]
    figure = new_figure(9.2, 6.0)
    axes = figure.subplots(3, 1, sharex=True, height_ratios=(1.2, 1.0, 1.2))
    speed, climb, rotors = axes
    for ax, values in ((speed, log.speed), (climb, log.climb_rate)):
        ax.plot(time, values, color=COLORS[0], rasterized=True, **SAMPLES)
        for pair, part in zip(ends, segments, strict=True):
            ax.plot(pair, 2 * [np.mean(values[part])], color=COLORS[1], linewidth=1.6)
    colors = [COLORS[k % len(COLORS)] for k in range(log.rotor_speed.shape[1])]
    for color, values in zip(colors, log.rotor_speed.T, strict=True):
        rotors.plot(time, values / RPM, color=color, rasterized=True, **SAMPLES)
    labels = "airspeed V [m/s]", "climb rate [m/s]", "rotor speeds [1/min]"
    for ax, label in zip(axes, labels, strict=True):
        for pair in ends:
            ax.axvspan(*pair, **SHADE)
        ax.set_ylabel(label)
    rotors.set(xlabel="time [s]", xlim=(0.0, time[-1]))
    dots: dict[str, Any] = {"marker": ".", "linestyle": "none"}
    handles: list[Any] = [
        Patch(label="steady segment", **SHADE),
        key("average of a segment", color=COLORS[1], linewidth=1.6),
        *(key(f"rotor {k + 1}", color=color, **dots) for k, color in enumerate(colors)),
    ]
    legend_below(figure, handles, columns=min(len(handles), 8))
    seconds = sum(float(last - first) for first, last in ends)
    figure.suptitle(
        f"{log.source}: {len(segments)} steady segments, {seconds:.0f} of {time[-1]:.0f} s"
    )
    return figure


# --- Samples of the parameters from the covariance of a fit, within their bounds -----------------

DRAWS = 200  # number of samples for a band
TRIED, ROUNDS = 20_000, 50  # samples per round; rounds after which a fit has no band
SEED = 2017


def drawn_changes(fit: FitRecord) -> tuple[tuple[str, ...], Floats]:
    """Return names and sampled changes of P parameters of the rotor, (``DRAWS``, P).

    The samples are from the normal distribution of all parameters, truncated at the bounds.
    Parameters with infinite variance are not changed.  The changes have shape (0, P) if almost no
    sample is within the bounds.
    """
    known = [k for k in range(len(fit.parameters)) if np.isfinite(fit.covariance[k, k])]
    chosen = [fit.parameters[k] for k in known]
    section = [k for k, p in enumerate(chosen) if p.name in ROTOR]
    names = tuple(chosen[k].name for k in section)
    covariance = fit.covariance[np.ix_(known, known)]
    if not section or not np.isfinite(covariance).all():
        return names, np.empty((0, len(section)))
    middle, lower, upper = np.array([(p.value, p.lower, p.upper) for p in chosen]).T
    # Rounding errors must not exclude values at a bound.
    slack = 1e-9 * (upper - lower)
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(size, size))
    root = size[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    rng = np.random.default_rng(SEED)
    kept: list[Floats] = []
    for _ in range(ROUNDS):
        change = rng.standard_normal((TRIED, len(known))) @ root.T
        drawn = middle + change
        kept.append(change[((drawn >= lower - slack) & (drawn <= upper + slack)).all(axis=1)])
        if sum(map(len, kept)) >= DRAWS:
            return names, np.concatenate(kept)[:DRAWS, section]
    return names, np.empty((0, len(section)))


def held(fit: FitRecord) -> list[str]:
    """Return the names of the free parameters that keep their value in all samples."""
    lost = ~np.isfinite(np.diag(fit.covariance))
    return [p.name for p, its in zip(fit.parameters, lost, strict=True) if its and p.name in ROTOR]
