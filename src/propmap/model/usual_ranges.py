"""What small propellers are like, and the slips of units that take a figure out of these ranges.

The ranges are those of the blades of the catalogue, and of the 134 sets of loads in the UIUC
Propeller Database that have a geometry (Brandt, Deters, Ananda, Dantsker, Selig, volumes 1 to 3),
with some room: a note is due where something is unlike all that has been measured.
``tests/model/test_usual_ranges.py`` holds them against these data.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Range:
    """From ``low`` to ``high``, both above 0, with the middle in the sense of factors."""

    low: float
    high: float

    def __contains__(self, value: float) -> bool:
        return self.low <= value <= self.high

    def distance(self, value: float) -> float:
        """Logarithm of the factor between a value above 0 and the middle."""
        return abs(math.log(value / math.sqrt(self.low * self.high)))


@dataclass(frozen=True)
class Slip:
    """A mistake that multiplies a figure by ``factor``, and what the figure is ``like`` then."""

    like: str
    factor: float


RADIUS = Range(0.012, 2.0)
"""[m]; measured 0.028 to 0.36."""

CHORD = Range(0.09, 0.40)
"""Chord at 0.75 of the radius over the radius; measured 0.10 to 0.35."""

WIDEST_CHORD = Range(0.12, 0.45)
"""The largest chord over the radius; measured 0.15 to 0.38."""

TWIST = Range(3.0, 40.0)
"""Twist at 0.75 of the radius [deg]; measured 7 to 25."""

DENSITY = Range(0.3, 1.6)
"""Of air [kg/m^3], from 12 km up to a cold day at sea level."""

VISCOSITY = Range(1e-5, 2.5e-5)
"""Of air [Pa s], from -80 to 150 degrees Celsius."""

TIP_SPEED = Range(8.0, 255.0)
"""The fastest of a test [m/s]: measured 26 to 216; above the upper end is Mach 0.75."""

SPEED_OF_SOUND = 340.3
"""[m/s] at 15 degrees Celsius (ICAO Doc 7488/3, 1993); 8 % less at 10 km."""

FAST_TIP_MACH = 0.75
"""Above it the drag of thick sections rises steeply, which no section law here has."""

LOAD_RATIO = Range(1.0 / 2.3, 2.3)
"""A measured load over the estimate from chord and twist; measured 0.6 to 1.6 for thrust, 0.55 to
2.0 for torque (medians of sets)."""

IMPOSSIBLE_COEFFICIENT = 0.75
"""C_T and C_P thrice the largest that have been measured (0.25 of four blades)."""

PITCH_SPEED_RATIO = 1.6
"""Axial speed over that of a screw with the blade's pitch, up to which a propeller pulls; measured
1.35 at a quarter of the largest thrust."""

ALIKE = 2.3
"""Factor below which two slips cannot be told apart: what loads of like blades differ by."""

RPM_PER_RADIAN = 60.0 / (2.0 * math.pi)
INCH = 0.0254

LENGTH_SLIPS = (
    Slip("millimetres", 1e3),
    Slip("centimetres", 1e2),
    Slip("inches", 1.0 / INCH),
    Slip("inches taken for millimetres", 1e-3 / INCH),
    Slip("millimetres taken for inches", 1e3 * INCH),
    Slip("metres taken for millimetres", 1e-3),
    Slip("metres taken for inches", INCH),
)
"""Of a length alone, given for metres unless something else is said."""

CHORD_SLIPS = (
    Slip("millimetres beside a radius in metres", 1e3),
    Slip("per cent of the radius, or centimetres beside metres", 1e2),
    Slip("inches beside a radius in metres", 1.0 / INCH),
    Slip("millimetres beside a radius in inches", 1e3 * INCH),
    Slip("millimetres beside a radius in centimetres", 10.0),
    Slip("a fraction of the diameter, or the radius like the diameter", 0.5),
    Slip("centimetres taken for millimetres", 0.1),
    Slip("inches taken for millimetres", 1e-3 / INCH),
    Slip("metres taken for inches", INCH),
    Slip("metres taken for millimetres", 1e-3),
)
"""Of the chord over the radius."""

DENSITY_SLIPS = (
    Slip("g/m^3", 1e3),
    Slip("g/cm^3", 1e-3),
    Slip("slug/ft^3", 1.0 / 515.379),
    Slip("lb/ft^3", 1.0 / 16.01846),
)
VISCOSITY_SLIPS = (Slip("microPa s", 1e6), Slip("mPa s, or centipoise", 1e3), Slip("poise", 10.0))

SPEED_SLIPS = (Slip("km/h", 3.6), Slip("miles an hour", 2.23694))

SLOW_SLIPS = (
    Slip("rad/s", 1.0 / RPM_PER_RADIAN),
    Slip("revolutions per second", 1.0 / 60.0),
)
"""Of the rotational speed, where it is too low."""

FAST_SLIPS = (
    Slip("rpm converted from rad/s twice", RPM_PER_RADIAN),
    Slip("electrical rpm, of 7 pole pairs for example", 7.0),
    Slip("rpm times 60", 60.0),
)
"""Of the rotational speed, where it is too high."""

NEWTON_PER_POUND = 4.4482216
NEWTON_PER_KILOGRAM = 9.80665

THRUST_SLIPS = (
    Slip("grams", 1e3 / NEWTON_PER_KILOGRAM),
    Slip("kilograms", 1.0 / NEWTON_PER_KILOGRAM),
    Slip("millinewtons", 1e3),
    Slip("ounces", 16.0 / NEWTON_PER_POUND),
    Slip("pounds", 1.0 / NEWTON_PER_POUND),
)
TORQUE_SLIPS = (
    Slip("N cm", 1e2),
    Slip("N mm", 1e3),
    Slip("kg m", 1.0 / NEWTON_PER_KILOGRAM),
    Slip("kg cm", 1e2 / NEWTON_PER_KILOGRAM),
    Slip("g cm", 1e5 / NEWTON_PER_KILOGRAM),
    Slip("ounce-inches", 16.0 / (NEWTON_PER_POUND * INCH)),
    Slip("pound-inches", 1.0 / (NEWTON_PER_POUND * INCH)),
)


def likely_slips(value: float, usual: Range, slips: Sequence[Slip]) -> list[Slip]:
    """The slips that explain a value outside a range, likeliest first.

    Those bring it into the range, and less than ``ALIKE`` times as far from its middle as the first
    does; none where the value is not above 0.
    """
    if not 0.0 < value < math.inf:
        return []
    far = {
        slip: usual.distance(value / slip.factor) for slip in slips if value / slip.factor in usual
    }
    first = min(far.values(), default=0.0)
    close = [slip for slip in far if far[slip] < first + math.log(ALIKE)]
    return sorted(close, key=far.__getitem__)


def guessed(value: float, usual: Range, slips: Sequence[Slip], subject: str = "it") -> str:
    """What the value of a ``subject`` looks like, for the end of a message, or nothing."""
    likes = [slip.like for slip in likely_slips(value, usual, slips)]
    return f"; {subject} looks like {' or '.join(likes)}" if likes else ""
