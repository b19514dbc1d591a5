"""Findings in words: a table's certificate, and how a rotor is installed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from propmap.loads import DRAG_FACTOR, LOADS, MOUNT_AREA
from propmap.model.corrections import TYPICAL_FACTOR, Installed
from propmap.units import DEGREE, RPM

if TYPE_CHECKING:
    from propmap.rotor import Rotor

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


def installation_note(rotor: Rotor) -> str:
    """Say whether the rotor drag is that of the blades alone, or of a rotor as it is installed."""
    mount, radius = rotor.model.correction_of(Installed), rotor.model.propeller.radius
    if mount is None:
        return (
            "rotor drag is that of the blades alone; on a motor or a stand it was measured to be "
            f"about {TYPICAL_FACTOR[0]:g} times that, and more by what stands in the slipstream "
            "(correction installed)"
        )
    unknown = mount.deviations(radius)
    factor, area = f"{mount.blade_factor:g}", f"{1e4 * mount.area(radius):.3g}"
    if DRAG_FACTOR in unknown:
        factor += f" (+- {unknown[DRAG_FACTOR]:g})"
    if MOUNT_AREA in unknown:
        area += f" (+- {1e4 * unknown[MOUNT_AREA]:.3g})"
    return (
        f"rotor drag is that of the installed rotor: {factor} times the blades' own, and the drag "
        f"of {area} cm^2 in the slipstream"
    )
