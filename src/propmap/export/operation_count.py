"""What one call of a vehicle's exported wrench costs: operations, bytes, and time on a small core.

The counts follow from the structure of the code in ``templates/vehicle.h.j2``, piece by piece;
``tests/export/test_vehicle_c.py`` holds them to a run with numbers that count.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Self

from propmap.export.c_header import table_bytes
from propmap.export.wake_geometry import wake_geometry
from propmap.loads import LOADS
from propmap.table.query import LoadTable
from propmap.vehicle.interference import STEPS
from propmap.vehicle.vehicle import Vehicle


class Operations(NamedTuple):
    """How many there are; a comparison and a change of sign count as sums, and ``functions`` are
    those of the C library but the square root."""

    sums: int = 0
    products: int = 0
    divisions: int = 0
    roots: int = 0
    functions: int = 0

    def __add__(self, other: object) -> Self:
        if not isinstance(other, Operations):
            return NotImplemented
        return type(self)(*(a + b for a, b in zip(self, other, strict=True)))

    def times(self, count: int) -> Operations:
        """As many of each."""
        return Operations(*(count * each for each in self))

    @property
    def total(self) -> int:
        """All together."""
        return sum(self)


BODY = Operations(12, 15)
"""Air's velocity, drag and download."""

LIFT, WING = Operations(4, 10, 0, 1, 3), Operations(9, 9, 2, 0, 5)

INDUCED = Operations(2, 8)
"""Drag, where a wing has a span."""

FLOW, FORCE = Operations(14, 18, 1, 1), Operations(28, 35)
"""At a hub, and of a rotor on the vehicle."""

QUERY = Operations(321, 307, 2, 2, 1)
"""Of the map, with the angle and the speed that it is asked at."""

SOURCE, STEP = Operations(35, 30, 1, 2, 2), Operations(10, 4, 2, 1)
"""A rotor's wake, without the steps of Newton's method for its inflow, and such a step."""

PAIR = Operations(40, 49, 0, 0, 1)
"""Of a wake at another rotor."""

USUAL_STEPS = 6
"""Of Newton's method, outside of descent; it ends after ``interference.STEPS``."""

CYCLES = Operations(3, 3, 16, 16, 150)
"""Assumed of a core with a floating-point unit for single precision, loads, stores and loops
included: sums and products take 1 cycle, divisions and roots 14 on an Arm Cortex-M4F (Technical
Reference Manual, Arm DDI 0439) and no more on a Cortex-M7."""

CLOCKS = {"Cortex-M4F at 168 MHz": 168e6, "Cortex-M7 at 480 MHz": 480e6}

RATE = 1000.0
"""Calls per second."""


@dataclass(frozen=True)
class Cost:
    """Of one call, in single precision.

    Attributes
    ----------
    operations : Operations
        Outside of descent.
    worst : Operations
        Where Newton's method takes all its steps.
    read : int
        Bytes of tables that it reads, each as often as it is used.
    stored : int
        Bytes of tables, the map included.
    """

    operations: Operations
    worst: Operations
    read: int
    stored: int

    @property
    def cycles(self) -> int:
        """By ``CYCLES``."""
        return sum(a * b for a, b in zip(self.operations, CYCLES, strict=True))

    @property
    def sentence(self) -> str:
        """All of this in words."""
        done = self.operations
        parts = ", ".join(f"{count} {kind}" for kind, count in done._asdict().items() if count)
        worst = f" (at most {self.worst.total}, in fast descent)" if self.worst != done else ""
        times = " and ".join(
            f"{self.cycles / clock * 1e3:.2f} ms on a {core}" for core, clock in CLOCKS.items()
        )
        share = max(self.cycles / clock * RATE for clock in CLOCKS.values())
        return (
            f"A call takes {done.total} operations{worst}: {parts}. It reads {self.read} bytes of "
            f"tables, which are {self.stored / 1000.0:.0f} kB in all, in single precision. At an "
            f"assumed {CYCLES.sums} cycles for a sum or a product, {CYCLES.divisions} for a "
            f"division or a root and {CYCLES.functions} for another function, loads and stores "
            f"included, it is {self.cycles} cycles: {times}, so that {RATE:g} calls a second take "
            f"at most {share:.0%} of the time. Not measured on such a core."
        )


def cost(vehicle: Vehicle, table: LoadTable) -> Cost:
    """What a call costs.

    Parameters
    ----------
    vehicle, table : Vehicle, LoadTable
        What is exported.
    """
    rotors = len(vehicle.mounts)
    pairs = rotors * (rotors - 1) if vehicle.wakes is not None else 0
    done = BODY + (FLOW + QUERY + FORCE).times(rotors)
    if vehicle.body.lift_area or vehicle.wing is not None:
        done += LIFT
    if vehicle.wing is not None:
        done += WING
        if vehicle.wing.span is not None:
            done += INDUCED
    # Sixteen knots with both ends of each load, three polynomials of weights, knots and scales.
    query = 16 * 2 * len(LOADS) * 4 + (3 * 16 + len(LOADS) + 12) * 4
    read = (query + 7 * 4) * rotors
    stored = table_bytes(table.content, 4) + (7 * rotors + 6) * 4
    worst = done
    if pairs:
        without = done + (SOURCE + QUERY).times(rotors) + PAIR.times(pairs)
        done = without + STEP.times(USUAL_STEPS * rotors)
        worst = without + STEP.times(STEPS * rotors)
        wake = wake_geometry(vehicle)
        polynomials = wake.skew.weights.size + wake.around.weights.size
        read += query * rotors + (pairs * (16 + 16 + 5) + rotors * (16 + 9)) * 4
        stored += (wake.coefficients.size + polynomials + pairs * 5 + rotors * 9) * 4
    return Cost(done, worst, read, stored)
