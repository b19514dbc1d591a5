"""The propellers of the experiments, all given at as many stations as the APC 8x6E.

XLA compiles a program for one number of stations, so one number for all saves minutes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from propmap.catalogue.lookup import propeller
from propmap.model.propeller import Propeller

TUNNEL_PROPELLER = "apc-8x6e"


def blade(name: str, radius: float | None = None) -> Propeller:
    """A propeller of the catalogue with as many stations as the APC 8x6E.

    Between the given stations the curves are those that the model uses, PCHIP; loads change by
    less than the model's accuracy.

    Parameters
    ----------
    name : str
        In the catalogue.
    radius : float, optional
        To scale it to [m].
    """
    from scipy.interpolate import PchipInterpolator

    given, count = propeller(name), propeller(TUNNEL_PROPELLER).station.size
    scale = 1.0 if radius is None else radius / given.radius
    if given.station.size == count and scale == 1.0:
        return given
    # As dense along the blade as the given stations are: they crowd where the curves bend.
    rank = np.linspace(0.0, 1.0, given.station.size)
    station = np.interp(np.linspace(0.0, 1.0, count), rank, given.station)
    chord, twist = (
        PchipInterpolator(given.station, values)(station) for values in (given.chord, given.twist)
    )
    return replace(
        given,
        name=given.name if radius is None else f"{given.name} scaled to {1e3 * radius:.0f} mm",
        station=scale * station,
        chord=scale * chord,
        twist=twist,
        root_cutout=None if given.root_cutout is None else scale * given.root_cutout,
    )
