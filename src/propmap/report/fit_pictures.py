"""Figures of an identification: its data, and the fitted model beside the hover model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.fit.body_forces import body_force, wing_values
from propmap.fit.force_model import hover_loads
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
from propmap.typing import Floats
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
