"""Power, attitude, rotor speeds and thrust margin of an aircraft against its speed."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from propmap.errors import InputError
from propmap.report.style import (
    BAND,
    COLOURS,
    DASHED,
    HOVER,
    MODEL,
    RPM,
    key,
    legend_below,
    new_figure,
    style,
)

WIDE = NormalDist().inv_cdf(0.975)
"""Standard deviations on either side of a band that holds 95 %."""

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from propmap.aircraft.deviations import Spread
    from propmap.aircraft.performance import Performance
    from propmap.aircraft.steady_states import SteadyStates


@style()
def power_curves(
    title: str,
    flown: Sequence[SteadyStates],
    hover: Sequence[SteadyStates],
    found: Performance | None = None,
    sure: Sequence[Spread | None] = (),
) -> Figure:
    """Four panels against speed, a curve for each climb rate, the hover model dashed.

    Power, pitch and rotor speeds have bands that hold them with a probability of 95 %.

    Parameters
    ----------
    title : str
        Of the picture.
    flown, hover : sequence of SteadyStates
        Up to 7, of the aircraft and of the same with the hover model, each at one climb rate.
    found : Performance, optional
        Whose states with a name are marked.
    sure : sequence of Spread, optional
        Standard deviations of ``flown``, None where nothing is known of them.

    Raises
    ------
    InputError
        For more than 7 climb rates.
    """
    if len(flown) > len(COLOURS):
        raise InputError(
            f"{len(flown)} climb rates make an unreadable picture", f"give at most {len(COLOURS)}"
        )
    figure = new_figure(8.6, 6.2)
    axes = figure.subplots(2, 2, sharex=True)
    power, pitch, speed, margin = axes.ravel()
    bands = sure or [None] * len(flown)
    for states, still, known, colour in zip(flown, hover, bands, COLOURS, strict=False):
        v = states.speed
        same: dict[str, Any] = {"color": colour}
        both = bool(np.isfinite(states.electrical_power).any())
        power.plot(v, states.power, **MODEL, **same)
        if both:
            power.plot(v, states.shaft_power, linewidth=0.9, **same)
        rpm = states.rotor_speed * RPM
        edges = rpm.min(axis=1), rpm.max(axis=1)
        for edge in edges:
            speed.plot(v, edge, **MODEL, **same)
        if known is not None:
            degrees, turning = np.degrees(states.pitch), known.rotor_speed.max(axis=1) * RPM
            for ax, low, high, std in (
                (power, states.power, states.power, known.power),
                (pitch, degrees, degrees, np.degrees(known.pitch)),
                (speed, *edges, turning),
            ):
                ax.fill_between(v, low - WIDE * std, high + WIDE * std, **BAND, **same)
        pitch.plot(v, np.degrees(states.pitch), **MODEL, **same)
        margin.plot(v, states.thrust_margin, **MODEL, **same)
        look = HOVER if len(flown) == 1 else {**DASHED, **same}
        for ax, values in (
            (power, still.power),
            (pitch, np.degrees(still.pitch)),
            (speed, still.rotor_speed.mean(axis=1) * RPM),
            (margin, still.thrust_margin),
        ):
            ax.plot(v, values, **look)
    margin.axhline(1.0, color="0.5", linewidth=0.8)
    electric = bool(np.isfinite(flown[0].electrical_power).any())
    power.set_ylabel("electrical power (thin: shafts) [W]" if electric else "shaft power [W]")
    pitch.set_ylabel("pitch, nose down [deg]")
    speed.set_ylabel("slowest and fastest rotor [1/min]")
    margin.set_ylabel("thrust at the first limit / thrust [-]")
    power.set_ylim(bottom=0.0)
    margin.set_ylim(bottom=0.0)
    for ax in (margin, speed):
        ax.set_xlabel("horizontal speed through the air [m/s]")
    if found is not None:
        _mark(power, found)
    figure.suptitle(title)
    climbs = [float(states.climb[0]) for states in flown]
    keys: list[Any] = [
        key(f"climb {c:g} m/s" if c or len(climbs) > 1 else "this model", color=colour, **MODEL)
        for c, colour in zip(climbs, COLOURS, strict=False)
    ]
    keys.append(key("hover model", **(HOVER if len(flown) == 1 else {**DASHED, "color": "0.35"})))
    if any(each is not None for each in bands):
        keys.append(Patch(label="95 % of what is likely", color="0.4", **BAND))
    legend_below(figure, keys)
    return figure


def _mark(ax: Axes, found: Performance) -> None:
    """The states with a name that lie in the picture, on the power curve."""
    low, high = found.states.speed[[0, -1]]
    for state, label, marker in (
        (found.least_power, "least power", "v"),
        (found.best_range, "best range", "D"),
        (found.fastest, "top speed", "s"),
    ):
        if state is not None and low <= state.speed <= high:
            ax.plot(state.speed, state.power, marker, color="black", markersize=5.0, label=label)
    if ax.get_legend_handles_labels()[0]:
        ax.legend(loc="lower left", fontsize=8.0)
