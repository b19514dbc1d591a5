"""A table's certificate in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from propmap.loads import LOADS

TITLES = {name: load.share for name, load in LOADS.items()}
"""What errors are shares of, by load."""


def claims(found: Mapping[str, Any]) -> Iterator[str]:
    """What a table's certificate claims, a sentence each."""
    cells = int(found["unresolved_cells"])
    apart = ", unresolved cells apart" if cells else ""
    yield (
        f"tolerance {found['tolerance']:.2%} holds on {found['points']} points that the table was "
        f"not built from{apart}"
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
