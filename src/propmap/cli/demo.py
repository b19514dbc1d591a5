"""``propmap demo``: what a propeller's name tells, beside measurements that come with propmap."""

from __future__ import annotations

import numpy as np

import propmap
from propmap.catalogue.lookup import measurement
from propmap.cli import output as out
from propmap.fit.least_squares import errors, rms
from propmap.hover import HoverModel
from propmap.loads import LOADS

NAME, DATA = "APC 8x6E", "gill-dandrea-2019-8x6e"
NEXT = f"""\
the same for a point: propmap predict "{NAME}" --rpm 6000 --speed 10 --beta 60
what else is known:   propmap props
a table to fly with:  propmap table "{NAME}" --rpm 4000:8000 --speed 0:20 --tolerance 2% -o a.npz"""


def demo() -> None:
    """Compare what the name of a propeller tells with measured loads."""
    data = measurement(DATA)
    rotor = propmap.Rotor(propmap.known_model(NAME, air=propmap.Air(data.air_density)))
    loads = rotor.loads(data.omega, data.speed, data.beta)
    low, high = loads.interval(0.95)
    hover = HoverModel.of(rotor).loads(data.omega)
    rows = []
    for name, measured in data.loads.items():
        inside = (getattr(low, name) <= measured) & (measured <= getattr(high, name))
        mine, its = (errors(found[name], measured).rms for found in (vars(loads), hover))
        size = rms(measured)
        shares = (mine / size, float(np.mean(inside)), its / size)
        cells = f"{size:.3g} {LOADS[name].unit}", *(f"{100.0 * share:.0f} %" for share in shares)
        rows.append((name.replace("_", " "), *cells))
    out.show(
        None,
        f"{NAME}, {data.omega.size} points up to {data.speed.max():g} m/s from climb to edgewise "
        "flight: polynomials of a wind-tunnel campaign (Gill & D'Andrea 2019) beside what the name "
        "tells, with constants from another tunnel's axial loads (UIUC)",
        out.grid("<load|measured, rms|error, rms|in the 95 % band|error of k Omega^2", rows),
        NEXT,
    )
