"""Print how loads of the APC 8x6E by name compare with another tunnel's, and with their bands.

Usage: python -m tools.other_tunnel

The constants are those identified from UIUC's axial loads; measured are the polynomials of Gill and
D'Andrea, Drones 3(4):77, 2019, doi 10.3390/drones3040077, for oblique flow.  All points of one
tunnel err together, so that the share inside the bands says little by itself; the mean error in
standard deviations says how unusual the other tunnel is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import propmap
from propmap.catalogue.measurements import measurement
from propmap.loads import LOADS

PROPELLER, MEASURED = "apc-8x6e", "gill-dandrea-2019-8x6e"


class Compared(NamedTuple):
    """One load over all points where it is not zero by symmetry.

    Attributes
    ----------
    label : str
        In words.
    inside : float
        Share of the points within the band of 95 % [-].
    mean : float
        Mean of (measured - computed) in standard deviations [-].
    error : float
        Root mean square of the errors over that of what was measured [-].
    """

    label: str
    inside: float
    mean: float
    error: float


def other_tunnel() -> list[Compared]:
    """Every load that was measured."""
    data = measurement(MEASURED)
    model = propmap.known_model(PROPELLER, air=propmap.Air(data.air_density))
    loads = propmap.Rotor(model).loads(data.omega, data.speed, data.beta)
    low, high = loads.interval(0.95)
    found = []
    for name, measured in data.loads.items():
        computed, std = getattr(loads, name), getattr(loads.std, name)
        there = std > 0.0
        inside = (getattr(low, name) <= measured) & (measured <= getattr(high, name))
        error = np.sqrt(np.mean((computed - measured) ** 2) / np.mean(measured**2))
        apart = ((measured - computed)[there] / std[there]).mean()
        found.append(
            Compared(LOADS[name].label, float(inside[there].mean()), float(apart), float(error))
        )
    return found


def table() -> str:
    """The comparison as a table in Markdown."""
    rows = [
        "| load | inside 95 % | mean error, standard deviations | rms error |",
        "|---|---:|---:|---:|",
    ]
    rows += [
        f"| {one.label} | {one.inside:.0%} | {one.mean:+.1f} | {one.error:.0%} |"
        for one in other_tunnel()
    ]
    return "\n".join(rows)


if __name__ == "__main__":
    print(table())
