"""Pictures of an identification: its data, and the fitted model beside the hover model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from propmap.arrays.types import Floats
from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.fit.residuals import rms
from propmap.loads import LOADS
from propmap.model.model import Model
from propmap.report.style import COLOURS, HOVER, MEASURED, MODEL, new_figure, style
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.hub_flow import hub_flow, rotor_forces

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from propmap.fit.tunnel import TunnelData
    from propmap.model.model import Section
    from propmap.rotor import Rotor
    from propmap.vehicle.vehicle import Vehicle

RPM = 30.0 / np.pi
"""Revolutions per minute in 1 rad/s."""

ALIKE = 0.02
"""Relative difference of two predictions of the hover model that are drawn as one."""

SAMPLES: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 1.5}
SHADE: dict[str, Any] = {"color": COLOURS[4], "alpha": 0.25, "linewidth": 0.0}
"""Of the steady stretches."""


def level_flight(
    vehicle: Vehicle, points: FlightLog, airfoil: Section, *, accuracy: str = "standard"
) -> Figure:
    """The paper's figure 6: loads, vertical force error and pitch angle against flight speed.

    points : operating points of steady flight.  Loads are sums over the rotors, computed at
    the rotor speeds and the flow of each point; the error is the vertical force of all rotors,
    of body and of wing, less the weight.  What an accelerometer read is drawn as measured
    thrust and drag: with the body's share in it, and without what acts across the flight.
    """
    order = np.argsort(points.speed, kind="stable")
    points = points.picked(order)
    model = _Curves(vehicle, points, airfoil, accuracy)
    speed = points.speed
    with style():
        figure = new_figure(9.6, 6.4)
        axes = figure.subplots(2, 3, sharex=True).ravel()
        panels = (
            ("collective thrust ΣT [N]", model.thrust, model.hover_thrust),
            ("collective rotor drag ΣD [N]", model.drag, 0.0 * speed),
            ("collective torque [N m]", model.torque, model.hover_torque),
            ("vertical force error [N]", model.error, model.hover_error),
        )
        for ax, (label, found, hover) in zip(axes, panels, strict=False):
            ax.plot(speed, hover, **HOVER)
            ax.plot(speed, found, color=COLOURS[0], marker=".", markersize=3.0, **MODEL)
            ax.set_ylabel(label)
        for ax, values in ((axes[0], model.felt_thrust), (axes[1], model.felt_drag)):
            ax.plot(speed, values, color=COLOURS[1], marker="o", **MEASURED)
        axes[3].axhline(0.0, color="0.6", linewidth=0.8)
        _share_of_weight(axes[3], vehicle.mass * GRAVITY)
        pitch = np.degrees(np.arctan2(-points.up[:, 0], points.up[:, 2]))
        axes[4].plot(speed, pitch, color=COLOURS[1], marker="o", **MEASURED)
        axes[4].set_ylabel("pitch angle, nose down [deg]")
        for ax in axes[:5]:
            ax.margins(x=0.02)
        # What is left of the grid is for the legend.
        for ax in axes[2:5]:
            ax.set_xlabel("flight speed V [m/s]")
            ax.tick_params(labelbottom=True)
        axes[5].axis("off")
        axes[5].legend(handles=_flight_legend(model, vehicle), loc="center", fontsize=9.0)
        figure.suptitle(
            f"{vehicle.name}, {vehicle.propeller.name}, airfoil {airfoil.name}: "
            f"{len(points)} operating points"
        )
    return figure


class _Curves:
    """Loads at operating points sorted by speed, each (n,)."""

    def __init__(
        self, vehicle: Vehicle, points: FlightLog, airfoil: Section, accuracy: str
    ) -> None:
        from propmap.fit.body_forces import body_force
        from propmap.fit.parameters import EVERY
        from propmap.rotor import Rotor

        rotor = Rotor(Model(vehicle.propeller, airfoil, vehicle.air), accuracy=accuracy)
        flow = hub_flow(vehicle, points)
        velocity = np.stack([flow.inplane, 0.0 * flow.inplane, flow.axial], axis=-1)
        loads = rotor.loads_at_velocity(flow.omega, velocity)
        hover = HoverModel.of(rotor, float(np.mean(flow.omega)))
        still = hover.thrust(flow.omega)
        values = {name: parameter.start for name, parameter in EVERY.items()}
        if vehicle.wing is not None:
            values |= {f"wing_{n}": getattr(vehicle.wing, n) for n in ("c_l1", "c_l2", "alpha_0")}
        body, _ = body_force(vehicle, points, values, ())
        force = rotor_forces(flow, loads.thrust, loads.drag) + body
        nothing = np.zeros_like(still)
        weight = vehicle.mass * GRAVITY
        self.thrust, self.hover_thrust = loads.thrust.sum(axis=1), still.sum(axis=1)
        self.drag, self.torque = loads.drag.sum(axis=1), loads.torque.sum(axis=1)
        self.hover_torque = hover.torque(flow.omega).sum(axis=1)
        self.error = np.sum(force * points.up, axis=1) - weight
        self.hover_error = np.sum(rotor_forces(flow, still, nothing) * points.up, axis=1) - weight
        felt = vehicle.mass * points.specific_force
        across = points.velocity[:, :2]
        length = np.linalg.norm(across, axis=1)
        moving = length > 0.0
        direction = np.where(moving[:, None], across, 0.0) / np.where(moving, length, 1.0)[:, None]
        self.felt_thrust, self.felt_drag = felt[:, 2], -np.sum(felt[:, :2] * direction, axis=1)
        self.felt = bool(np.isfinite(points.specific_force).any())


def _share_of_weight(ax: Axes, weight: float) -> None:
    """A second scale, so that an error can be read as a share of the weight."""
    functions: Any = (lambda force: 100.0 * force / weight, lambda share: share * weight / 100.0)
    share = ax.secondary_yaxis("right", functions=functions)
    share.set_ylabel("share of the weight [%]")


def _flight_legend(model: _Curves, vehicle: Vehicle) -> list[Line2D]:
    points: dict[str, Any] = {**MEASURED, "clip_on": True, "marker": "o", "color": COLOURS[1]}
    body = vehicle.wing is not None or any((*vehicle.body.drag_area, vehicle.body.lift_area))
    with_body = " (with the body's)" if body else ""
    name = f"measured: mass by accelerometer{with_body},\npitch angle"
    own, hover = rms(model.error), rms(model.hover_error)
    return [
        Line2D([], [], color=COLOURS[0], label=f"this model, force error {own:.3g} N rms", **MODEL),
        Line2D([], [], label=f"hover model, force error {hover:.3g} N rms", **HOVER),
        Line2D([], [], label=name if model.felt else "measured: pitch angle", **points),
    ]


def tunnel_fit(data: TunnelData, rotor: Rotor) -> Figure:
    """Measured against predicted, a panel per load, the hover model's predictions dashed.

    The hover model knows the rotational speed alone: rows of one speed have one prediction.
    """
    measured = {n: v for n, v in data.loads.items() if n in LOADS and np.isfinite(v).any()}
    if not measured:
        raise InputError("there is no load to draw", f"give {', '.join(LOADS)}", data.source)
    found: Any = rotor.loads(data.omega, data.speed, data.beta)
    hover = HoverModel.of(rotor).loads(data.omega)
    wide = len(measured) > 1
    with style():
        figure = new_figure(8.6 if wide else 5.2, 3.8 * -(-len(measured) // 2) + 0.6)
        axes = figure.subplots(-(-len(measured) // 2), 2 if wide else 1, squeeze=False).ravel()
        for ax in axes[len(measured) :]:
            ax.axis("off")
        for ax, (name, truth) in zip(axes, measured.items(), strict=False):
            _one_load(ax, name, truth, getattr(found, name), _alike(truth, hover[name]))
        handles = [
            Line2D([], [], color="0.6", linewidth=1.0, label="predicted = measured"),
            Line2D([], [], color=COLOURS[0], marker="o", linestyle="none", markersize=4.5,
                   label="this model"),
            Line2D([], [], label="hover model", **HOVER),
        ]  # fmt: skip
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
        figure.suptitle(
            f"{rotor.model.propeller.name}, airfoil {rotor.model.law_title}\n"
            f"{len(data)} rows of {data.source}"
        )
    return figure


def _one_load(
    ax: Axes, name: str, truth: Floats, found: Floats, hover: list[tuple[float, float, float]]
) -> None:
    known = np.isfinite(truth) & np.isfinite(found)
    levels = [level for _, _, level in hover]
    ends = np.array([*truth[known], *found[known], *levels, 0.0])
    low, high = float(ends.min()), float(ends.max())
    ax.axline((0.0, 0.0), slope=1.0, color="0.6", linewidth=1.0)
    for left, right, level in hover:
        # A single row gets a dash of its own.
        least = 0.04 * (high - low)
        middle, half = 0.5 * (left + right), max(0.5 * (right - left), least)
        ax.plot([middle - half, middle + half], [level, level], **HOVER)
    ax.plot(truth[known], found[known], color=COLOURS[0], marker="o", **MEASURED)
    load, left = LOADS[name], rms((found - truth)[known])
    ax.set_title(f"{load.label}: rms error {left:.3g} {load.unit}", fontsize=9.0)
    ax.set_xlabel(f"measured {load.title}")
    ax.set_ylabel(f"predicted {load.title}")


def _alike(truth: Floats, hover: Floats) -> list[tuple[float, float, float]]:
    """The range of the measured load over the rows of which the hover model says the same."""
    known = np.flatnonzero(np.isfinite(truth))
    known = known[np.argsort(hover[known])]
    breaks = np.flatnonzero(np.diff(hover[known]) > ALIKE * hover[known][1:]) + 1
    groups = np.split(known, breaks)
    return [(float(truth[g].min()), float(truth[g].max()), float(hover[g].mean())) for g in groups]


def steady_parts(log: FlightLog, stretches: Sequence[slice]) -> Figure:
    """Speed, climb rate and rotor speeds against time, the steady stretches shaded.

    stretches : of the log's samples, as ``flight.steady.steady_stretches`` finds them.
    """
    with style():
        figure = new_figure(9.2, 6.0)
        axes = figure.subplots(3, 1, sharex=True, height_ratios=(1.2, 1.0, 1.2))
        speed, climb, rotors = axes
        for ax, values in ((speed, log.speed), (climb, log.climb_rate)):
            ax.plot(log.time, values, color=COLOURS[0], rasterized=True, **SAMPLES)
            for part in stretches:
                ends = log.time[[part.start, part.stop - 1]]
                ax.plot(ends, 2 * [np.mean(values[part])], color=COLOURS[1], linewidth=1.6)
        for k, values in enumerate(log.rotor_speed.T):
            colour = COLOURS[k % len(COLOURS)]
            rotors.plot(log.time, RPM * values, color=colour, rasterized=True, **SAMPLES)
        for ax in axes:
            for part in stretches:
                ax.axvspan(log.time[part.start], log.time[part.stop - 1], **SHADE)
        speed.set_ylabel("speed V [m/s]")
        climb.set_ylabel("climb rate [m/s]")
        rotors.set_ylabel("rotor speeds [1/min]")
        rotors.set_xlabel("time [s]")
        rotors.set_xlim(log.time[0], log.time[-1])
        dots: dict[str, Any] = {"marker": ".", "linestyle": "none"}
        handles: list[Any] = [
            Patch(label="steady stretch", **SHADE),
            Line2D([], [], color=COLOURS[1], linewidth=1.6, label="its average"),
            *(
                Line2D([], [], color=COLOURS[k % len(COLOURS)], label=f"rotor {k + 1}", **dots)
                for k in range(log.rotor_speed.shape[1])
            ),
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 8))
        seconds = sum(float(log.time[s.stop - 1] - log.time[s.start]) for s in stretches)
        figure.suptitle(
            f"{log.source}: {len(stretches)} steady stretches, {seconds:.0f} of "
            f"{log.time[-1] - log.time[0]:.0f} s"
        )
    return figure
