"""A table's certificate in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from propmap.loads import LOADS

TITLES = {name: load.share for name, load in LOADS.items()}
"""What errors are shares of, by load."""


PLACE = {"rpm": "1/min", "speed": "m/s", "beta": "deg"}
"""How a place in the envelope is told, with units."""


def largest_at(found: Mapping[str, Any]) -> dict[str, list[float] | None]:
    """Where in the envelope, as in ``PLACE``, a certificate's largest errors are, by load.

    Empty for a certificate of earlier versions, which does not say; None for a load without
    errors.
    """
    if not found.get("max_omega"):
        return {}
    units = {"max_omega": 30.0 / np.pi, "max_speed": 1.0, "max_beta": 180.0 / np.pi}
    places = {
        load: [factor * found[name][load] for name, factor in units.items()] for load in LOADS
    }
    return {load: place if found["max_error"][load] else None for load, place in places.items()}


def claims(found: Mapping[str, Any]) -> Iterator[str]:
    """What a table's certificate claims, a sentence each."""
    cells = int(found["unresolved_cells"])
    apart = ", unresolved cells apart" if cells else ""
    yield (
        f"tolerance {found['tolerance']:.2%} holds on {found['points']} points that the table was "
        f"not built from{apart}"
    )
    if found.get("search_points"):
        yield (
            f"the largest errors were searched for, on {found['search_points']} points more: in "
            "each cell of the table, and uphill from its worst points"
        )
    if cells:
        worst = max(found["unresolved_max_error"].values())
        yield (
            f"unresolved: {cells} cells, {found['unresolved_volume']:.2%} of the envelope, "
            f"where the loads change too steeply for a table; there errors reach {worst:.2%} on "
            f"{found['unresolved_points']} points"
        )
    yield (
        f"of the {found['points']} points, {found['vortex_ring']} are vortex ring and "
        f"{found['no_value']} without loads"
    )


def parameter_claims(found: Mapping[str, Any]) -> Iterator[str]:
    """From what the uncertainty of the section law's parameters was computed."""
    yield (
        "parameters: standard deviation of the loads by the fit's covariance of "
        f"{', '.join(found['parameters'])}, on {found['points']} points"
    )
    if found["not_counted"]:
        yield f"not counted, the fit's data say nothing of them: {', '.join(found['not_counted'])}"
