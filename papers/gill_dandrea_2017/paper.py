"""The statements of the paper that are compared, and the propellers of its experiments."""

from __future__ import annotations

from dataclasses import replace

from propmap.catalogue.lookup import propeller
from propmap.model.propeller import Propeller

CITATION = (
    "R. Gill, R. D'Andrea, Propeller Thrust and Drag in Forward Flight, IEEE CCTA 2017, "
    "doi 10.1109/CCTA.2017.8062443"
)
RIBNER = (
    "H. S. Ribner, Formulas for Propellers in Yaw and Charts of the Side-Force Derivative, "
    "NACA TR 819, and Propellers in Yaw, NACA TR 820, 1945"
)

TABLE_1 = {
    "paper-soft": "soft: AR.Drone 2.0",
    "paper-stiff": "stiff: HQP 8x4.5",
    "paper-apc": "APC 8x6",
}
"""The rows of Table I by the name of the parameter set."""

FLOWN = {"paper-soft": "soft", "paper-stiff": "stiff"}
"""Short names of the propellers that were flown, by the name of the parameter set."""


RADIUS = 0.1  # [m] of all three propellers
TETHER = 1.7  # [m], radius of the level circles
FASTEST = 14.5  # [m/s] of the level circles
FLIGHTS = 20  # level flights of a quadrotor in one identification
HOVER_FAILS = {"paper-soft": 7.0, "paper-stiff": 9.0}  # [m/s] from which the hover model fails
SIGN_CHANGES = 7.0  # [m/s], where the hover model's force changes from too small to too large
TUNNEL_ERROR = 0.09  # largest relative error of the model in the tunnel
HOVER_TUNNEL_ERROR = 1.0  # largest relative error of the hover model in the tunnel
ONE_POINT = 3.0  # [s] for one operating point
IDENTIFICATION = (2.0 * 3600.0, 10.0 * 3600.0)  # [s], range for one identification

TUNNEL_PROPELLER = "apc-8x6e"


def blade(name: str, radius: float | None = None) -> Propeller:
    """Load a propeller of the catalogue, and scale it to a tip radius [m] if one is given."""
    given = propeller(name)
    if radius is None:
        return given
    scale = radius / given.radius
    return replace(
        given,
        name=f"{given.name} scaled to {1e3 * radius:.0f} mm",
        station=scale * given.station,
        chord=scale * given.chord,
        root_cutout=None if given.root_cutout is None else scale * given.root_cutout,
    )
