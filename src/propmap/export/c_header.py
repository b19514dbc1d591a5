"""Target ``c``: a table, or with it a whole vehicle, as a C99 header.

The header keeps the coefficients as the file does, in single precision at both ends of omega, and
extrapolates to no ghost values: their share is in the weights of the outermost intervals.  So a
point costs the memory of its sixteen knots alone.
"""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Iterable
from dataclasses import dataclass
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
    """Write the header and its note."""
    return {f"{identifier(table)}.h": header(table), "README-c.txt": note("c", table)}


def header(table: LoadTable) -> str:
    """Return the text of the header."""
    content, order = table.content, list(LOADS)
    root = float(content.omega[0]) ** -0.5
    box = list(table.envelope.values())
    rows, columns, odd = _weights(content)
    row_bucket, row_per_bucket = _buckets(content.advance)
    column_bucket, column_per_bucket = _buckets(content.beta)
    return rendered(
        "table.h",
        table,
        content=content,
        kilobytes=round(table_bytes(content, 8) / 1000.0),
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
        cells=interpolation.cell_codes(content),
        # At each knot the loads at the least omega, then at the largest.
        data=content.coefficients.transpose(2, 3, 0, 1)
        .reshape(*content.coefficients.shape[2:], -1)
        .astype(np.float32),
        thrust=order.index("thrust"),
        torque=order.index("torque"),
        numbers=numbers,
        singles=singles,
    )


def table_bytes(content: interpolation.TableContent, real: int) -> int:
    """Count bytes of the tables: numbers of ``real`` bytes, 8 or 4, and coefficients of 4."""
    cells = (content.advance.size - 1) + (content.beta.size - 1)
    return content.coefficients.size * 4 + 16 * cells * real + content.cells.size


def _weights(content: interpolation.TableContent) -> tuple[Floats, Floats, Floats]:
    """Return weights of rows and columns (n - 1, 16), of odd loads in the end columns (2, 16)."""
    ends = interpolation.on_planes(content.beta)
    even, odd = (
        _folded(content.beta, *(np.array(parity) if on else None for on in ends))
        for parity in (1.0, -1.0)
    )
    return _folded(content.advance, None, None), even, odd[[0, -1]]


def _folded(knots: Floats, low: Floats | None, high: Floats | None) -> Floats:
    """Give weight polynomials (n - 1, 16), powers first, of the values at the knots alone: ghosts,
    by the parities ``low`` and ``high`` as for ``pad``, are spread over the three knots at their
    end."""
    weights = interpolation.interval_polynomials(knots)
    ghosts = interpolation.pad(knots, np.eye(knots.size), low, high)
    weights[0, 1:] += ghosts[0, :3, None] * weights[0, 0]
    weights[-1, :3] += ghosts[-1, -3:, None] * weights[-1, 3]
    weights[0, 0] = weights[-1, 3] = 0.0
    return weights.transpose(0, 2, 1).reshape(-1, 16)


def _buckets(knots: Floats) -> tuple[NDArray[np.intp], float]:
    """Find the interval in which each of many equal buckets begins, and buckets per unit."""
    count = min(MOST_BUCKETS, 4 * knots.size)
    width = float(knots[-1] - knots[0]) / count
    # A hundredth of a bucket early, so that no rounding leads beyond the interval looked for.
    begin = knots[0] + width * (np.arange(count) - 0.01)
    return np.searchsorted(knots[1:-1], begin, side="right"), 1.0 / width


def numbers(values: Iterable[Any]) -> str:
    """Write an array with commas, in lines of some length; with several axes, rows in braces."""
    rows = list(values)
    if np.ndim(rows[0]):
        return ",\n".join("{\n" + numbers(row) + "}" for row in rows)
    words = ", ".join(map(repr, np.asarray(rows).tolist()))
    return textwrap.fill(words, LINE, break_long_words=False, break_on_hyphens=False)


def singles(blocks: NDArray[np.float32]) -> str:
    """Write an array with three axes in single precision, a line per row."""

    def row(values: NDArray[np.float32]) -> str:
        return ", ".join("NAN" if np.isnan(value) else f"{value!s}f" for value in values)

    lines = (",\n".join(f"{{{row(values)}}}" for values in block) for block in blocks)
    return ",\n".join("{\n" + block + "}" for block in lines)


# -------------------------------------------------------------------------------------------------
# Target ``c`` of a vehicle: a C99 header with force and moment of the air on all of it.
#
# The loads are those of the rotor's header, the wakes those of ``wake_geometry``.


def vehicle_c_files(vehicle: Vehicle, table: LoadTable) -> Files:
    """Write both headers and the note; ``InputError`` for a table of another propeller or air."""
    Rotors.of(vehicle, table)
    return {
        f"{identifier(table)}.h": header(table),
        f"{vehicle_name(vehicle, table)}.h": vehicle_header(vehicle, table),
        "README-c.txt": note(
            "c",
            table,
            vehicle=vehicle,
            cost=cost(vehicle, table),
            kinds=KINDS,
            assumed=CYCLES,
            clocks=CLOCKS,
            zip=zip,
        ),
    }


def vehicle_header(vehicle: Vehicle, table: LoadTable) -> str:
    """Return the text of the vehicle's header."""
    name = vehicle_name(vehicle, table)
    values: dict[str, Any] = {"pairs": False}
    if vehicle.wakes is not None and len(vehicle.mounts) > 1:
        values |= {
            "pairs": True,
            "wakes": vehicle.wakes,
            "wake": wake_geometry(vehicle, vehicle.wakes),
            "disk": vehicle.air.density * np.pi * vehicle.propeller.radius**2,
            "cylinder": wakes,
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
# What one call of a vehicle's exported wrench costs: operations, bytes, and time on a small core.
#
# The counts follow from the structure of the code in ``templates/vehicle.h.j2``, piece by piece;
# ``tests/export/test_vehicle_export.py`` holds them to a run with numbers that count.


# Comparisons and changes of sign are sums; functions are those of the C library, but the root.
KINDS = ("sums", "products", "divisions", "roots", "functions")
BODY = np.array([12, 15, 0, 0, 0])  # air's velocity, drag and download
LEVEL_PLATE = np.array([3, 6, 0, 1, 0])
LIFT, WING = np.array([4, 10, 0, 1, 3]), np.array([9, 9, 2, 0, 5])
INDUCED = np.array([2, 8, 0, 0, 0])  # drag, where a wing has a span
FLOW, FORCE = np.array([14, 18, 1, 1, 0]), np.array([28, 35, 0, 0, 0])  # at a hub, of a rotor there
QUERY = np.array([321, 307, 2, 2, 1])  # of the table, with the angle and the speed asked for
SOURCE = np.array([35, 30, 1, 2, 2])  # a rotor's wake without its inflow
STEP = np.array([10, 4, 2, 1, 0])  # of Newton's method for that inflow
PAIR = np.array([40, 52, 0, 0, 2])  # a wake at another rotor

USUAL_STEPS = 6  # of Newton's method, outside of descent; it ends after ``STEPS``
CYCLES = np.array([3, 3, 16, 16, 150])
"""Assumed of a core with a floating-point unit for single precision, loads, stores and loops
included: sums and products take 1 cycle, divisions and roots 14 on an Arm Cortex-M4F (Technical
Reference Manual, Arm DDI 0439) and no more on a Cortex-M7."""

CLOCKS = {"Cortex-M4F at 168 MHz": 168e6, "Cortex-M7 at 480 MHz": 480e6}


@dataclass(frozen=True)
class Cost:
    """What one call takes, in single precision."""

    operations: NDArray[np.int_]  # by ``KINDS``, outside of descent (5,)
    worst: NDArray[np.int_]  # where Newton's method takes all its steps
    read: int  # bytes of tables, each as often as it is used
    stored: int  # bytes of all tables, the rotor's included

    @property
    def cycles(self) -> int:
        """Cycles of the processor, by ``CYCLES``."""
        return int(self.operations @ CYCLES)


def cost(vehicle: Vehicle, table: LoadTable) -> Cost:
    """Count what a call for a ``vehicle`` takes."""
    rotors = len(vehicle.mounts)
    pairs = rotors * (rotors - 1) if vehicle.wakes is not None else 0
    done = BODY + LEVEL_PLATE * bool(vehicle.body.plate_area) + rotors * (FLOW + QUERY + FORCE)
    if vehicle.body.lift_area or vehicle.wing is not None:
        done = done + LIFT
    if vehicle.wing is not None:
        done = done + WING
        if vehicle.wing.span is not None:
            done = done + INDUCED
    # Sixteen knots with both ends of each load, three polynomials of weights, knots and scales.
    query = 16 * 2 * len(LOADS) * 4 + (3 * 16 + len(LOADS) + 12) * 4
    read = (query + 7 * 4) * rotors
    stored = table_bytes(table.content, 4) + (7 * rotors + 6) * 4
    worst = done
    if pairs and vehicle.wakes is not None:
        without = done + rotors * (SOURCE + QUERY) + pairs * PAIR
        done = without + USUAL_STEPS * rotors * STEP
        worst = without + wakes.STEPS * rotors * STEP
        wake = wake_geometry(vehicle, vehicle.wakes)
        polynomials = wake.skew.weights.size + wake.around.weights.size
        read += query * rotors + (pairs * (16 + 16 + 5) + rotors * (16 + 9)) * 4
        stored += (wake.coefficients.size + polynomials + pairs * 5 + rotors * 9) * 4
    return Cost(done, worst, read, stored)


# -------------------------------------------------------------------------------------------------
# The rotors' wakes on each other as tables for exported code.
#
# They are the splines of ``vehicle.wake_table``: coefficients over skew and bearing of a wake, and
# the weights of four neighbouring ones as polynomials in each interval between the table's knots.


class SplineAxis(NamedTuple):
    """The n intervals of one axis of the splines, all of one width."""

    per_unit: float  # intervals per radian
    first: NDArray[np.intp]  # the first of the four coefficients that count in each (n,)
    kind: NDArray[np.intp]  # which of the K polynomials each has (n,): most have the same
    # Constant terms of four, linear ones, and so on, of the place in the interval 0 to 1 (K, 16).
    weights: Floats


class WakeGeometry(NamedTuple):
    """The wakes of k rotors on each other."""

    frames: Floats  # rows: two directions in the disk, and the axis (k, 3, 3)
    kind: NDArray[np.intp]  # which of the K kinds of pairs each target and source are (k, k)
    bearing: Floats  # of the target in the source's frame [rad] (k, k)
    towards: Floats  # unit vector from source to target in the source's disk plane (k, k, 3)
    downwash: Floats  # gain of the downwash (k, k)
    coefficients: NDArray[np.float32]  # of the splines (K, a, b)
    skew: SplineAxis  # from straight down to straight up
    around: SplineAxis


def wake_geometry(vehicle: Vehicle, given: Wakes) -> WakeGeometry:
    """Tabulate the wakes ``given`` to the rotors of a ``vehicle``, two or more."""
    mounts, radius = vehicle.mounts, vehicle.propeller.radius
    k = len(mounts)
    frames = np.stack([wakes.frame_of(mount.axis) for mount in mounts])
    kind, bearing, towards = np.zeros((k, k), int), np.zeros((k, k)), np.zeros((k, k, 3))
    splines: list[object] = []
    for t, target in enumerate(mounts):
        for s, source in enumerate(mounts):
            if t == s:
                continue
            seen = wakes.seen_wake(source, target, radius, given.slipstreams_alone)
            # Pairs with the same geometry share a spline.
            same = [n for n, spline in enumerate(splines) if spline is seen.spline]
            if not same:
                splines.append(seen.spline)
            kind[t, s] = same[0] if same else len(splines) - 1
            bearing[t, s] = seen.towards
            arm = np.subtract(target.position, source.position)
            beside = arm - (arm @ frames[s, 2]) * frames[s, 2]
            length = np.linalg.norm(beside)
            towards[t, s] = beside / (length if length > 1e-9 else 1.0)
    knots = splines[0].tck[:2]  # type: ignore[attr-defined]
    skew = _axis(knots[0], np.linspace(0.0, np.pi, wakes.SKEWS))
    around = _axis(knots[1], np.linspace(0.0, 2.0 * np.pi, wakes.BEARINGS + 1))
    used = slice(around.first[0], around.first[-1] + 4)
    tables = [
        spline.get_coeffs().reshape(len(knots[0]) - 4, -1)[:, used]  # type: ignore[attr-defined]
        for spline in splines
    ]
    around.first[:] -= used.start
    gains, coefficients = wakes.downwash_gains(vehicle, given), np.stack(tables).astype(np.float32)
    return WakeGeometry(frames, kind, bearing, towards, gains, coefficients, skew, around)


def _axis(knots: Floats, breaks: Floats) -> SplineAxis:
    """Expand cubic splines with these ``knots`` in powers, between ``breaks``."""
    from scipy.interpolate import BSpline

    inside = np.linspace(0.1, 0.9, 4)
    to_powers = np.linalg.inv(np.vander(inside, increasing=True))
    every, first = [], []
    for low, high in itertools.pairwise(breaks):
        span = int(np.searchsorted(knots, 0.5 * (low + high), side="right")) - 4
        at = low + inside * (high - low)
        four = [BSpline.basis_element(knots[j : j + 5])(at) for j in range(span, span + 4)]
        every.append((to_powers @ np.stack(four, axis=1)).ravel())
        first.append(span)
    rounded = np.round(np.array(every), 9) + 0.0
    _, where, kind = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    per_unit = 1.0 / float(breaks[1] - breaks[0])
    return SplineAxis(per_unit, np.array(first), kind.ravel(), np.array(every)[where])
