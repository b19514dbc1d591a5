"""``propmap demo``: a catalogue prediction compared with measurements that propmap includes."""

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
one operating point:  propmap predict "{NAME}" --rpm 6000 --speed 10 --beta 60
other propellers:     propmap props
a table of loads:     propmap table "{NAME}" --rpm 4000:8000 --speed 0:20 --tolerance 2% -o a.npz"""

TUNNELS = (
    "The two tunnels differ in axial flow. In the 2019 tunnel, the static thrust is 8 % larger. "
    "The thrust also contains an error in the form of the drag of a stand with a drag area of "
    "47 cm^2. The bands exclude these measurement errors. After their removal, the bands contain "
    "91 % of the thrust values and 96 % of the torque values in oblique flow "
    "(docs/how-to/uncertainty.md, python -m tools.coverage)."
)


def demo() -> None:
    """Compare a catalogue prediction with measured propeller loads."""
    data = measurement(DATA)
    rotor = propmap.Rotor(propmap.catalogue_model(NAME, air=propmap.Air(data.air_density)))
    loads = rotor.loads(data.omega, data.speed, data.beta)
    low, high = loads.interval(0.95)
    hover = HoverModel.from_rotor(rotor).loads(data.omega)
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
        f"{NAME}, {data.omega.size} operating points up to {data.speed.max():g} m/s, from climb to "
        "edgewise flight. Measured: polynomials of a wind-tunnel campaign (Gill & D'Andrea 2019). "
        "The prediction uses section constants from axial loads in another tunnel (UIUC).",
        out.grid("<load|measured, rms|error, rms|in the 95 % band|error of k Omega^2", rows),
        TUNNELS,
        NEXT,
    )
