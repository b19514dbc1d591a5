"""Loads against flight speed for several angles, as in the paper's figure 7."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from propmap.arrays.types import Floats
from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.report.style import COLOURS, HOVER, MARKERS, MEASURED, MODEL, new_figure, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from propmap.rotor import Rotor

PANELS = tuple((name, load.title) for name, load in LOADS.items())
ROWS = -(-len(PANELS) // 2)
"""Of figures with two panels side by side."""

RPM = 30.0 / np.pi
"""Revolutions per minute in 1 rad/s."""

NEAR_ANGLE = np.radians(0.5)


@dataclass(frozen=True, eq=False)
class MeasuredLoads:
    """Loads measured at one rotational speed.

    label : for the legend.  speed [m/s], beta [rad] : shape (n,).
    loads : by field of ``rotor.Loads``, each (n,) in SI; NaN where there is no figure.
    """

    label: str
    speed: Floats
    beta: Floats
    loads: dict[str, Floats]


def load_curves(
    rotor: Rotor,
    omega: float,
    speed: Floats,
    betas: Sequence[float],
    measured: MeasuredLoads | None = None,
) -> Figure:
    """Every load against speed, a curve for each angle.

    omega [rad/s]; speed : shape (n,) [m/s]; betas : up to 7 angles [rad].
    Measured points appear where their angle is within half a degree of a curve's; those of
    axial flow at rest belong to every curve and are drawn with the first.
    """
    if len(betas) > len(COLOURS):
        raise InputError(
            f"{len(betas)} angles make an unreadable picture", f"give at most {len(COLOURS)}"
        )
    angles = np.array(betas)
    loads = rotor.loads(omega, speed, angles[:, None])
    still = HoverModel.of(rotor).loads(omega)
    with style():
        figure = new_figure(8.6, 3.3 * ROWS)
        axes = figure.subplots(ROWS, 2, sharex=True).ravel()
        for ax, (field, label) in zip(axes, PANELS, strict=True):
            ax.axhline(float(still[field]), **HOVER)
            for curve, colour in zip(getattr(loads, field), COLOURS, strict=False):
                ax.plot(speed, curve, color=colour, **MODEL)
            if measured is not None:
                _points(ax, measured, field, angles)
            ax.set_ylabel(label)
            ax.margins(x=0.02)
        for ax in axes[-2:]:
            ax.set_xlabel("flight speed V [m/s]")
        m = rotor.model
        title = f"{m.propeller.name}, airfoil {m.law_title}, {omega * RPM:.0f} rpm"
        if measured is not None:
            title += f"; points: {measured.label}"
        figure.suptitle(title)
        handles = _legend(angles, marked=measured is not None)
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return figure


def _points(ax: Axes, measured: MeasuredLoads, field: str, angles: Floats) -> None:
    values = measured.loads.get(field)
    if values is None:
        return
    for i, angle in enumerate(angles):
        mine = np.abs(measured.beta - angle) < NEAR_ANGLE
        if i == 0:
            mine |= measured.speed == 0.0
        ax.plot(measured.speed[mine], values[mine], marker=MARKERS[i], color=COLOURS[i], **MEASURED)


def _legend(angles: Floats, *, marked: bool) -> list[Line2D]:
    handles = []
    for i, angle in enumerate(angles):
        handle = Line2D([], [], color=COLOURS[i], label=f"β = {np.degrees(angle):.4g}°", **MODEL)
        if marked:
            handle.set_marker(MARKERS[i])
            handle.set_markersize(4.5)
        handles.append(handle)
    return [*handles, Line2D([], [], label="hover model", **HOVER)]
