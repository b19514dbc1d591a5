"""Figures of an identification: its data, and the fitted model beside the hover model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from propmap.arrays.types import Floats
from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.fit.body_forces import body_force, wing_values
from propmap.fit.flight import hover_force
from propmap.fit.parameters import EVERY
from propmap.fit.residuals import rms
from propmap.loads import LOADS, Load
from propmap.model.model import Model
from propmap.report.style import (
    COLOURS,
    HOVER,
    MEASURED,
    MODEL,
    RPM,
    key,
    legend_below,
    legend_in_last,
    new_figure,
    share_of_weight,
    style,
)
from propmap.rotor import Rotor
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.hub_flow import hub_flow, rotor_forces

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from propmap.fit.tunnel import TunnelData
    from propmap.model.model import Section
    from propmap.vehicle.vehicle import Vehicle

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
    model = _Curves(vehicle, points, airfoil, accuracy)
    speed = points.speed
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
    pitch = np.degrees(np.arctan2(-points.up[:, 0], points.up[:, 2]))
    measured = {0: model.felt_thrust, 1: model.felt_drag, 4: pitch}
    for k, values in measured.items():
        axes[k].plot(speed, values, color=COLOURS[1], marker="o", **MEASURED)
    axes[3].axhline(0.0, color="0.6", linewidth=0.8)
    share_of_weight(axes[3], vehicle.mass * GRAVITY)
    axes[4].set_ylabel("pitch angle, nose down [deg]")
    for ax in axes[:5]:
        ax.margins(x=0.02)
    legend_in_last(axes, _flight_keys(model, vehicle), "flight speed V [m/s]")
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
        rotor = Rotor(Model(vehicle.propeller, airfoil, vehicle.air), accuracy=accuracy)
        flow = hub_flow(vehicle, points)
        velocity = np.stack([flow.inplane, 0.0 * flow.inplane, flow.axial], axis=-1)
        loads = rotor.loads_at_velocity(flow.omega, velocity)
        hover = HoverModel.of(rotor, float(np.mean(flow.omega)))
        values = {name: parameter.start for name, parameter in EVERY.items()}
        body, _ = body_force(vehicle, points, values | wing_values(vehicle), ())
        force = rotor_forces(flow, loads.thrust, loads.drag) + body
        weight = vehicle.mass * GRAVITY
        self.thrust, self.hover_thrust = (
            values.sum(axis=1) for values in (loads.thrust, hover.thrust(flow.omega))
        )
        self.torque, self.hover_torque = (
            values.sum(axis=1) for values in (loads.torque, hover.torque(flow.omega))
        )
        self.drag = loads.drag.sum(axis=1)
        self.error, self.hover_error = (
            np.sum(each * points.up, axis=1) - weight for each in (force, hover_force(hover, flow))
        )
        felt = vehicle.mass * points.specific_force
        across = points.velocity[:, :2]
        length = np.linalg.norm(across, axis=1, keepdims=True)
        direction = np.divide(across, length, out=np.zeros_like(across), where=length > 0.0)
        self.felt_thrust, self.felt_drag = felt[:, 2], -np.sum(felt[:, :2] * direction, axis=1)
        self.felt = bool(np.isfinite(points.specific_force).any())


def _flight_keys(model: _Curves, vehicle: Vehicle) -> list[Line2D]:
    points: dict[str, Any] = {**MEASURED, "clip_on": True, "marker": "o", "color": COLOURS[1]}
    body = vehicle.wing is not None or any((*vehicle.body.drag_area, vehicle.body.lift_area))
    with_body = " (with the body's)" if body else ""
    felt = f"measured: mass by accelerometer{with_body},\npitch angle"
    own, hover = rms(model.error), rms(model.hover_error)
    return [
        key(f"this model, force error {own:.3g} N rms", color=COLOURS[0], **MODEL),
        key(f"hover model, force error {hover:.3g} N rms", **HOVER),
        key(felt if model.felt else "measured: pitch angle", **points),
    ]


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
        rotors.plot(log.time, RPM * values, color=colour, rasterized=True, **SAMPLES)
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
