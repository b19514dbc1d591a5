"""The propellers of the experiments."""

from __future__ import annotations

from dataclasses import replace

from propmap.catalogue.lookup import propeller
from propmap.model.model import Propeller

TUNNEL_PROPELLER = "apc-8x6e"


def blade(name: str, radius: float | None = None) -> Propeller:
    """A propeller of the catalogue, scaled where a tip radius is given.

    Parameters
    ----------
    name : str
        In the catalogue.
    radius : float, optional
        To scale it to [m].
    """
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
