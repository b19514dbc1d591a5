"""Target ``c``: a table, or a whole vehicle with a table, as C99 headers.

Like the table file, the header stores the coefficients in single precision at both ends of omega.
It stores no ghost values beyond the edges of the table: the weights of the outermost intervals
include their contribution.  So a query reads only sixteen knots.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.export.files import Files, identifier, note, rendered, vehicle_name
from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil
from propmap.results import spin_sign
from propmap.table import interpolation
from propmap.table.query import END_SLACK, SLACK, LoadTable
from propmap.typing import Floats
from propmap.vehicle import wakes
from propmap.vehicle.vehicle import Vehicle, Wakes
from propmap.vehicle.vehicle_forces import Rotors

MOST_BUCKETS = 1024

LINE = 96


def c_files(table: LoadTable) -> Files:
    """Return the header and the note."""
    return {f"{identifier(table)}.h": header(table), "README-c.txt": note("c", table)}


def header(table: LoadTable) -> str:
    """Return the text of the header."""
    content, order = table.content, list(LOADS)
    root = float(content.omega[0]) ** -0.5
    box = list(table.envelope.values())
    rows, columns, odd = _weights(content)
    cells = interpolation.cell_codes(content)
    size = 4 * content.coefficients.size + 8 * (rows.size + columns.size) + cells.size
    row_bucket, row_per_bucket = _buckets(content.advance)
    column_bucket, column_per_bucket = _buckets(content.beta)
    return rendered(
        "table.h",
        table,
        content=content,
        kilobytes=round(size / 1000.0),
        box=box,
        end_slack=END_SLACK,
        slack=[SLACK * (high - low) for low, high in box],
        root=root,
        per_root=1.0 / (float(content.omega[1]) ** -0.5 - root),
        row_per_width=1.0 / np.diff(content.advance),
        column_per_width=1.0 / np.diff(content.beta),
        row_per_bucket=row_per_bucket,
        column_per_bucket=column_per_bucket,
        row_bucket=row_bucket,
        column_bucket=column_bucket,
        row_weights=rows,
        column_weights=columns,
        odd_weights=odd,
        cells=cells,
        # Each knot stores the loads at the smallest omega, then at the largest omega.
        data=content.coefficients.transpose(2, 3, 0, 1)
        .reshape(*content.coefficients.shape[2:], -1)
        .astype(np.float32),
        thrust=order.index("thrust"),
        torque=order.index("torque"),
        numbers=numbers,
        singles=singles,
    )


def _weights(content: interpolation.TableContent) -> tuple[Floats, Floats, Floats]:
    """Return weights of rows and columns (n - 1, 16), and of odd loads at both ends (2, 16)."""
    ends = interpolation.on_planes(content.beta)
    even, odd = (
        _folded(content.beta, *(np.array(parity) if on else None for on in ends))
        for parity in (1.0, -1.0)
    )
    return _folded(content.advance, None, None), even, odd[[0, -1]]


def _folded(knots: Floats, low: Floats | None, high: Floats | None) -> Floats:
    """Return weight polynomials (n - 1, 16), powers first, of the knots without ghost values.

    The weights of the ghost values, with the parities ``low`` and ``high`` of ``pad``, are added to
    the three knots at each end.
    """
    weights = interpolation.interval_polynomials(knots)
    ghosts = interpolation.pad(knots, np.eye(knots.size), low, high)
    weights[0, 1:] += ghosts[0, :3, None] * weights[0, 0]
    weights[-1, :3] += ghosts[-1, -3:, None] * weights[-1, 3]
    weights[0, 0] = weights[-1, 3] = 0.0
    return weights.transpose(0, 2, 1).reshape(-1, 16)


def _buckets(knots: Floats) -> tuple[NDArray[np.intp], float]:
    """Return the interval at the start of each of many equal buckets, and buckets per unit."""
    count = min(MOST_BUCKETS, 4 * knots.size)
    width = float(knots[-1] - knots[0]) / count
    # Start a hundredth of a bucket early: with rounding, the search must not start too late.
    begin = knots[0] + width * (np.arange(count) - 0.01)
    return np.searchsorted(knots[1:-1], begin, side="right"), 1.0 / width


def numbers(values: Iterable[Any]) -> str:
    """Format an array for C in wrapped lines; arrays with several axes as rows in braces."""
    rows = list(values)
    if np.ndim(rows[0]):
        return ",\n".join("{\n" + numbers(row) + "}" for row in rows)
    words = ", ".join(map(repr, np.asarray(rows).tolist()))
    return textwrap.fill(words, LINE, break_long_words=False, break_on_hyphens=False)


def singles(blocks: NDArray[np.float32]) -> str:
    """Format an array with three axes for C in single precision, with one line per row."""

    def row(values: NDArray[np.float32]) -> str:
        return ", ".join("NAN" if np.isnan(value) else f"{value!s}f" for value in values)

    lines = (",\n".join(f"{{{row(values)}}}" for values in block) for block in blocks)
    return ",\n".join("{\n" + block + "}" for block in lines)


# -------------------------------------------------------------------------------------------------
# Target ``c`` of a vehicle: a C99 header with the aerodynamic force and moment on the vehicle.
#
# The loads come from the rotor's header, the wakes from ``exported_wakes``.


def vehicle_c_files(vehicle: Vehicle, table: LoadTable) -> Files:
    """Return both headers and the note; ``InputError`` for a table of another propeller or air."""
    Rotors.of(vehicle, table)
    return {
        f"{identifier(table)}.h": header(table),
        f"{vehicle_name(vehicle, table)}.h": vehicle_header(vehicle, table),
        "README-c.txt": note("c", table, vehicle=vehicle),
    }


def vehicle_header(vehicle: Vehicle, table: LoadTable) -> str:
    """Return the text of the vehicle's header."""
    name = vehicle_name(vehicle, table)
    values: dict[str, Any] = {"pairs": False}
    if vehicle.wakes is not None and len(vehicle.mounts) > 1:
        values |= {
            "pairs": True,
            "wakes": vehicle.wakes,
            "wake": exported_wakes(vehicle, vehicle.wakes),
            "disk": vehicle.air.density * np.pi * vehicle.propeller.radius**2,
            "cylinder": wakes.limits(),
        }
    return rendered(
        "vehicle.h",
        table,
        v=name,
        V=name.upper(),
        vehicle=vehicle,
        rotors=vehicle.mounts,
        spins=[spin_sign(mount.spin) for mount in vehicle.mounts],
        lifts=bool(vehicle.body.lift_area) or vehicle.wing is not None,
        sharpness=Airfoil.sharpness,
        numbers=numbers,
        singles=singles,
        **values,
    )


# -------------------------------------------------------------------------------------------------
# The wakes of the rotors on each other, as tables for exported code.
#
# The tables contain the splines of ``vehicle.wakes``: coefficients over skew and bearing of a wake,
# and for each interval between knots the weights of four neighboring coefficients as polynomials.


class SplineAxis(NamedTuple):
    """One axis of the splines, with n intervals of equal width."""

    per_unit: float  # intervals per radian
    first: NDArray[np.intp]  # first of the four coefficients used in each interval (n,)
    kind: NDArray[np.intp]  # index of the polynomials of each interval (n,); most are equal
    # Four constant terms, four linear terms, and so on, of the position 0 to 1 in the interval; for
    # K different polynomials (K, 16).
    weights: Floats


class ExportedWakes(NamedTuple):
    """The wakes of k rotors on each other, by target and source, with K different splines."""

    frames: Floats  # rows: two directions in the disk, and the axis (k, 3, 3)
    kind: NDArray[np.intp]  # index of the spline of each target and source (k, k)
    bearing: Floats  # bearing of the target in the source's frame [rad] (k, k)
    towards: Floats  # unit vector from source to target in the source's disk plane (k, k, 3)
    downwash: Floats  # gain of the downwash (k, k)
    coefficients: NDArray[np.float32]  # spline coefficients (K, a, b)
    skew: SplineAxis  # from straight down to straight up
    around: SplineAxis  # bearing


def exported_wakes(vehicle: Vehicle, given: Wakes) -> ExportedWakes:
    """Tabulate the ``given`` wakes of a ``vehicle`` with two rotors or more."""
    radius = vehicle.propeller.radius
    frames, kind, bearing, slipstream, splines = wakes.wake_geometry(
        vehicle.mounts, radius, given.slipstreams_alone
    )
    turned = np.stack([np.cos(bearing), np.sin(bearing)], axis=-1)
    towards = np.einsum("tsj,sjk->tsk", turned, frames[:, :2])
    knots = splines[0].tck[:2]
    skew = _axis(knots[0], np.linspace(0.0, np.pi, wakes.SKEWS))
    around = _axis(knots[1], np.linspace(0.0, 2.0 * np.pi, wakes.BEARINGS + 1))
    used = slice(around.first[0], around.first[-1] + 4)
    tables = [spline.get_coeffs().reshape(len(knots[0]) - 4, -1)[:, used] for spline in splines]
    around.first[:] -= used.start
    gains, coefficients = np.where(slipstream, 1.0, given.downwash), np.stack(tables)
    coefficients = coefficients.astype(np.float32)
    return ExportedWakes(frames, kind, bearing, towards, gains, coefficients, skew, around)


def _axis(knots: Floats, breaks: Floats) -> SplineAxis:
    """Convert cubic splines with ``knots`` to polynomials in the intervals between ``breaks``."""
    first, weights = wakes.interval_weights(knots, breaks)
    every = weights.reshape(len(weights), -1)
    rounded = np.round(every, 9) + 0.0
    _, where, kind = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    per_unit = 1.0 / float(breaks[1] - breaks[0])
    return SplineAxis(per_unit, first, kind.ravel(), every[where])
