"""``Certificate``: the errors of a table against its model, as filed and as printed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from propmap.loads import LOADS
from propmap.units import DEGREE, RPM


@dataclass(frozen=True)
class Certificate:
    """Errors of a table against the model on quasi-random points of its envelope.

    The largest are searched for from these; see ``propmap.table.certificate``.  Errors are
    shares of the static loads at the same omega, by load; see ``loads.error_scales``.

    Attributes
    ----------
    tolerance : float
        What was asked for.
    points, seed : int
        How many, and of which scrambled Sobol sequence over (omega, speed, beta).
    max_error, rms_error : dict of str to float
        Over the points that have a value and are not "unresolved"; the largest also over those
        of the search.
    unresolved : int
        Points with that status, in cells where the model's loads jump or nearly so.
    unresolved_cells, unresolved_volume : int, float
        How many such cells there are, and their share of the envelope.
    unresolved_points : int
        Points inside them, spread evenly, of the next two.
    unresolved_max_error, unresolved_rms_error : dict of str to float
        Errors inside them; the largest also over the points of the search.
    vortex_ring, no_value : int
        Points with that status, which count in the errors; and points without loads.
    search_points : int
        How many the search for the largest errors took; 0 in tables of earlier versions, whose
        largest errors are of the sample alone.
    max_omega, max_speed, max_beta : dict of str to float
        Where ``max_error`` was met [rad/s], [m/s], [rad]; empty in tables of earlier versions.
    """

    tolerance: float
    points: int
    seed: int
    max_error: dict[str, float]
    rms_error: dict[str, float]
    unresolved: int
    unresolved_cells: int
    unresolved_volume: float
    unresolved_points: int
    unresolved_max_error: dict[str, float]
    unresolved_rms_error: dict[str, float]
    vortex_ring: int
    no_value: int
    search_points: int = 0
    max_omega: dict[str, float] = field(default_factory=dict)
    max_speed: dict[str, float] = field(default_factory=dict)
    max_beta: dict[str, float] = field(default_factory=dict)

    @property
    def holds(self) -> bool:
        """Whether the largest error is within the tolerance, unresolved points aside."""
        return max(self.max_error.values()) <= self.tolerance

    def as_dict(self) -> dict[str, Any]:
        """Plain data, as filed; with ``holds``."""
        return {**asdict(self), "holds": self.holds}


# -------------------------------------------------------------------------------------------------
# The certificate in words.

TITLES = {name: load.share for name, load in LOADS.items()}  # what errors are shares of
PLACE = {"rpm": "1/min", "speed": "m/s", "beta": "deg"}  # coordinates in the envelope, with units


def largest_at(found: Mapping[str, Any]) -> dict[str, list[float] | None]:
    """Find where, as in ``PLACE``, a certificate's largest errors are by load, None without errors;
    empty for one of earlier versions."""
    if not found.get("max_omega"):
        return {}
    units = {"max_omega": 1.0 / RPM, "max_speed": 1.0, "max_beta": 1.0 / DEGREE}
    places = {
        load: [factor * found[name][load] for name, factor in units.items()] for load in LOADS
    }
    return {load: place if found["max_error"][load] else None for load, place in places.items()}


def claims(found: Mapping[str, Any]) -> Iterator[str]:
    """Say what a table's certificate claims, a sentence each."""
    cells = int(found["unresolved_cells"])
    outside = ", outside unresolved cells" if cells else ""
    yield (
        f"tolerance {found['tolerance']:.2%} holds on {found['points']} points that the table was "
        f"not built from{outside}"
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
    """Say from what the uncertainty of the section law's parameters was computed."""
    yield (
        "parameters: standard deviation of the loads by the fit's covariance of "
        f"{', '.join(found['parameters'])}, on {found['points']} points"
    )
    if found["not_counted"]:
        names = ", ".join(found["not_counted"])
        yield f"not counted, as the fit's data do not determine them: {names}"
