"""Loads against flight speed for several angles, as in the paper's figure 7."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from propmap.arrays.types import Floats
from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.report.style import (
    COLOURS,
    HOVER,
    MEASURED,
    MODEL,
    RPM,
    angle_keys,
    key,
    legend_below,
    load_panels,
    marked,
    style,
)

if TYPE_CHECKING:
    from propmap.rotor import Rotor

NEAR_ANGLE = np.radians(0.5)


@dataclass(frozen=True, eq=False)
class MeasuredLoads:
    """Loads measured at one rotational speed.

    Attributes
    ----------
    label : str
        For the title.
    speed, beta : ndarray, shape (n,)
        Operating points [m/s], [rad].
    loads : dict of str to ndarray, shape (n,)
        By name; NaN where not measured.
    """

    label: str
    speed: Floats
    beta: Floats
    loads: dict[str, Floats]


@style()
def load_curves(
    rotor: Rotor,
    omega: float,
    speed: Floats,
    betas: Sequence[float],
    measured: MeasuredLoads | None = None,
) -> Figure:
    """Every load against flight speed, a curve for each angle, the hover model dashed.

    Parameters
    ----------
    rotor : Rotor
        What is drawn.
    omega : float
        Rotational speed [rad/s].
    speed : ndarray, shape (n,)
        Flight speeds [m/s].
    betas : sequence of float
        Up to 7 angles [rad].
    measured : MeasuredLoads, optional
        Points, drawn where their angle is within half a degree of a curve's; those at rest belong
        to every curve and are drawn with the first.

    Raises
    ------
    InputError
        For more than 7 angles.
    """
    if len(betas) > len(COLOURS):
        raise InputError(
            f"{len(betas)} angles make an unreadable picture", f"give at most {len(COLOURS)}"
        )
    found = rotor.loads(omega, speed, np.array(betas)[:, None])
    hover = HoverModel.of(rotor).loads(omega)
    figure, axes = load_panels(3.3, sharex=True)
    for ax, load in zip(axes.ravel(), LOADS.values(), strict=True):
        ax.axhline(float(hover[load.name]), **HOVER)
        for curve, colour in zip(getattr(found, load.name), COLOURS, strict=False):
            ax.plot(speed, curve, color=colour, **MODEL)
        if measured is not None and load.name in measured.loads:
            for k, beta in enumerate(betas):
                mine = np.abs(measured.beta - beta) < NEAR_ANGLE
                if k == 0:
                    mine |= measured.speed == 0.0
                values = measured.loads[load.name][mine]
                ax.plot(measured.speed[mine], values, **marked(k), **MEASURED)
        ax.set_ylabel(load.title)
        ax.margins(x=0.02)
    for ax in axes[-1]:
        ax.set_xlabel("flight speed V [m/s]")
    model = rotor.model
    title = f"{model.propeller.name}, airfoil {model.law_title}, {omega * RPM:.0f} rpm"
    figure.suptitle(title if measured is None else f"{title}; points: {measured.label}")
    keys = angle_keys(betas, markersize=0.0 if measured is None else 4.5, **MODEL)
    legend_below(figure, [*keys, key("hover model", **HOVER)])
    return figure
