"""Loads against flight speed for several angles, as in the paper's figure 7."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.report.style import (
    BAND,
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
from propmap.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

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

    def along(self, beta: float, *, at_rest: bool) -> NDArray[np.intp]:
        """Which points lie within half a degree of ``beta`` [rad], in the order of their speed;
        those at rest too, at any angle, if ``at_rest``."""
        near = np.abs(self.beta - beta) < NEAR_ANGLE
        mine = np.flatnonzero(near | (at_rest & (self.speed == 0.0)))
        return mine[np.argsort(self.speed[mine], kind="stable")]


@style()
def load_curves(
    rotor: Rotor,
    omega: float,
    speed: Floats,
    betas: Sequence[float],
    measured: MeasuredLoads | None = None,
    *,
    band: Rotor | None = None,
    band_label: str = "95 % band of the model",
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
    band : Rotor, optional
        Of this one, the band that holds the true loads with a probability of 95 % is shaded, where
        it says how well it is known.
    band_label : str
        For the legend.

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
    low, high = None, None
    if band is not None and band.model.uncertainty is not None:
        shaded = found if band is rotor else band.loads(omega, speed, np.array(betas)[:, None])
        low, high = shaded.interval()
    hover = HoverModel.of(rotor).loads(omega)
    figure, axes = load_panels(3.3, sharex=True)
    for ax, load in zip(axes.ravel(), LOADS.values(), strict=True):
        ax.axhline(float(hover[load.name]), **HOVER)
        for k, curve in enumerate(getattr(found, load.name)):
            ax.plot(speed, curve, color=COLOURS[k], **MODEL)
            if low is not None and high is not None:
                edges = (getattr(low, load.name)[k], getattr(high, load.name)[k])
                ax.fill_between(speed, *edges, color=COLOURS[k], **BAND)
        if measured is not None and load.name in measured.loads:
            _draw_measured(ax, load.name, betas, measured)
        ax.set_ylabel(load.title)
        ax.margins(x=0.02)
    for ax in axes[-1]:
        ax.set_xlabel("flight speed V [m/s]")
    model = rotor.model
    title = f"{model.propeller.name}, airfoil {model.law_title}, {omega * RPM:.0f} rpm"
    figure.suptitle(title if measured is None else f"{title}; points: {measured.label}")
    keys: list[Any] = angle_keys(betas, markersize=0.0 if measured is None else 4.5, **MODEL)
    keys.append(key("hover model", **HOVER))
    if low is not None:
        keys.append(Patch(label=band_label, color="0.4", **BAND))
    legend_below(figure, keys)
    return figure


def _draw_measured(ax: Axes, load: str, betas: Sequence[float], measured: MeasuredLoads) -> None:
    """The points of a load."""
    values = measured.loads[load]
    for k, beta in enumerate(betas):
        mine = measured.along(beta, at_rest=k == 0)
        ax.plot(measured.speed[mine], values[mine], **marked(k), **MEASURED)
