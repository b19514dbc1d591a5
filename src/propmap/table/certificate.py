"""``Certificate``: the errors of a table with respect to its model, as stored and as printed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from propmap.loads import LOADS
from propmap.units import DEGREE, RPM


@dataclass(frozen=True)
class Certificate:
    """Errors of a table with respect to its model.

    A sample of quasi-random points covers the envelope.  A search for the largest errors starts
    from the sample; see ``propmap.table.verification``.  Errors are fractions of the static loads
    at the same omega, by load; see ``loads.error_scales``.

    Attributes
    ----------
    tolerance : float
        Requested tolerance.
    points, seed : int
        Number of sample points, and seed of their scrambled Sobol sequence in (omega, speed, beta).
    max_error, rms_error : dict of str to float
        Errors at the points of the sample that have loads and are not "unresolved".  The largest
        error includes the points of the search.
    unresolved : int
        Number of sample points in unresolved cells, where the model's loads jump or are very steep.
    unresolved_cells, unresolved_volume : int, float
        Number of unresolved cells, and their fraction of the envelope.
    unresolved_points : int
        Number of evenly spread points inside unresolved cells.
    unresolved_max_error, unresolved_rms_error : dict of str to float
        Errors at these points.  The largest error includes the points of the search.
    vortex_ring, no_value : int
        Number of points of the sample with the status "vortex_ring", which count in the errors,
        and number of points without loads.
    search_points : int
        Number of points in the search for the largest errors.
    max_omega, max_speed, max_beta : dict of str to float
        Operating point of ``max_error`` [rad/s], [m/s], [rad].
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
    search_points: int
    max_omega: dict[str, float]
    max_speed: dict[str, float]
    max_beta: dict[str, float]

    @property
    def holds(self) -> bool:
        """Whether the largest error outside unresolved cells is within the tolerance."""
        return max(self.max_error.values()) <= self.tolerance

    def as_dict(self) -> dict[str, Any]:
        """Return the fields and ``holds`` as plain data for files."""
        return {**asdict(self), "holds": self.holds}


# --- The certificate as text ---------------------------------------------------------------------

TITLES = {name: load.share for name, load in LOADS.items()}  # labels of relative errors
PLACE = {"rpm": "1/min", "speed": "m/s", "beta": "deg"}  # coordinates in the envelope, with units


def largest_at(found: Mapping[str, Any]) -> dict[str, list[float] | None]:
    """Return the point, as in ``PLACE``, of the largest error of each load; None if it is zero."""
    units = {"max_omega": 1.0 / RPM, "max_speed": 1.0, "max_beta": 1.0 / DEGREE}
    places = {
        load: [factor * found[name][load] for name, factor in units.items()] for load in LOADS
    }
    return {load: place if found["max_error"][load] else None for load, place in places.items()}


def claims(found: Mapping[str, Any]) -> Iterator[str]:
    """Yield each claim of a table's certificate as a sentence."""
    cells = int(found["unresolved_cells"])
    outside = ", outside unresolved cells" if cells else ""
    yield (
        f"the tolerance of {found['tolerance']:.2%} holds on {found['points']} points that were "
        f"not used to build the table{outside}"
    )
    yield (
        f"a search for the largest errors used {found['search_points']} more points: in each "
        "cell of the table, and along paths of increasing error from the worst points"
    )
    if cells:
        worst = max(found["unresolved_max_error"].values())
        yield (
            f"unresolved: {cells} cells, {found['unresolved_volume']:.2%} of the envelope, "
            f"where the loads are too steep for a table; errors at {found['unresolved_points']} "
            f"points in these cells reach {worst:.2%}"
        )
    yield (
        f"of the {found['points']} points, {found['vortex_ring']} are in the vortex ring state; "
        f"points without loads: {found['no_value']}"
    )


def parameter_claims(found: Mapping[str, Any]) -> Iterator[str]:
    """Yield sentences on the standard deviations due to the section constants."""
    yield (
        "section constants: standard deviation of the loads from the covariance of "
        f"{', '.join(found['parameters'])}, at {found['points']} points"
    )
    if found["not_counted"]:
        names = ", ".join(found["not_counted"])
        yield f"not included, since the fit's data do not determine them: {names}"
