"""A mission over time: speed, power, and the battery's charge and voltage."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from propmap.report.style import COLOURS, DASHED, MODEL, key, legend_below, new_figure, style

if TYPE_CHECKING:
    from propmap.aircraft.mission import Flown, Mission


@style()
def mission_course(title: str, legs: Mission, flown: Flown) -> Figure:
    """Four panels over time, which end where the mission cannot go on.

    Parameters
    ----------
    title : str
        Of the picture.
    legs : Mission
        What was to be flown.
    flown : Flown
        How it was.
    """
    figure = new_figure(8.6, 5.4)
    axes = figure.subplots(2, 2, sharex=True)
    motion, power, charge, voltage = axes.ravel()
    time = flown.course.time / 60.0
    over = time[:, [0, -1]].ravel()

    def steps(values: np.ndarray) -> np.ndarray:
        return np.repeat(values, 2)

    motion.plot(over, steps(legs.speed), color=COLOURS[0], **MODEL)
    motion.plot(over, steps(legs.climb), color=COLOURS[1], **DASHED)
    motion.set_ylabel("speed; climb [m/s]")
    power.plot(over, steps(flown.states.power), color=COLOURS[0], **MODEL)
    power.set_ylabel("power [W]")
    power.set_ylim(0.0, 1.1 * max(power.get_ylim()[1], 1.0))
    charge.plot(time.ravel(), 100.0 * flown.course.charge.ravel(), color=COLOURS[0], **MODEL)
    charge.set_ylabel("state of charge [%]")
    charge.set_ylim(0.0, 105.0)
    voltage.plot(time.ravel(), flown.course.voltage.ravel(), color=COLOURS[0], **MODEL)
    voltage.set_ylabel("battery's voltage [V]")
    for ax in (charge, voltage):
        ax.set_xlabel("time [min]")
    lost = ~flown.lasted
    if lost.any():
        end = time[int(np.argmax(lost)), 0]
        for ax in axes.ravel():
            ax.axvspan(end, time[-1, -1], color="0.92", linewidth=0.0)
    figure.suptitle(title)
    keys = [
        key("speed, power, charge, voltage", color=COLOURS[0], **MODEL),
        key("climb", color=COLOURS[1], **DASHED),
    ]
    if lost.any():
        keys.append(key("cannot be flown", color="0.88", linewidth=8.0))
    legend_below(figure, keys)
    return figure
