"""Whether a blade, the air, points and loads are possible, and like those of small propellers."""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median  # without numpy.ma, which takes longer to load than one point
from typing import TYPE_CHECKING, Any

import numpy as np

from propmap.errors import InputError, quoted
from propmap.typing import Floats
from propmap.units import GRAVITY, INCH, KMH, MPH, POUND, RPM, SLUG_PER_FT3, SPEED_OF_SOUND

if TYPE_CHECKING:
    from propmap.model.model import Air, Propeller


# -------------------------------------------------------------------------------------------------
# What small propellers are like, and the unit mistakes that take a figure out of these ranges:
# how a figure looks, and the factor that it has then.
#
# The ranges are those of the blades of the catalogue, and of the 134 sets of loads in the UIUC
# Propeller Database that have a geometry (Brandt, Deters, Ananda, Dantsker, Selig, volumes 1 to 3),
# with some room: a note is due where something is unlike all that has been measured.
# ``tests/catalogue/test_nothing_is_doubted.py`` holds them against these data.


@dataclass(frozen=True)
class Range:
    """Values from ``low`` to ``high``, both above 0."""

    low: float
    high: float

    def __contains__(self, value: float) -> bool:
        return self.low <= value <= self.high

    def distance(self, value: float) -> float:
        """Take the logarithm of the factor between a value and the range's geometric mean."""
        return abs(math.log(value / math.sqrt(self.low * self.high)))


RADIUS = Range(0.012, 2.0)  # [m]; measured 0.028 to 0.36
CHORD = Range(0.09, 0.40)  # chord at 0.75 of the radius over the radius; measured 0.10 to 0.35
WIDEST_CHORD = Range(0.12, 0.45)  # the largest chord over the radius; measured 0.15 to 0.38
TWIST = Range(3.0, 40.0)  # twist at 0.75 of the radius [deg]; measured 7 to 25
DENSITY = Range(0.3, 1.6)  # of air [kg/m^3], from 12 km up to a cold day at sea level
VISCOSITY = Range(1e-5, 2.5e-5)  # of air [Pa s], from -80 to 150 degrees Celsius

TIP_SPEED = Range(8.0, 255.0)
"""The fastest of a test [m/s]: measured 26 to 216; above the upper end is Mach 0.75."""

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

INDISTINCT = 2.3
"""Factor below which two mistakes look the same: what loads of similar blades differ by."""

LENGTH_MISTAKES = {
    "millimetres": 1e3,
    "centimetres": 1e2,
    "inches": 1.0 / INCH,
    "inches taken for millimetres": 1e-3 / INCH,
    "millimetres taken for inches": 1e3 * INCH,
    "metres taken for millimetres": 1e-3,
    "metres taken for inches": INCH,
}
"""For a length alone, given for metres unless something else is said."""

CHORD_MISTAKES = {
    "millimetres beside a radius in metres": 1e3,
    "per cent of the radius, or centimetres beside metres": 1e2,
    "inches beside a radius in metres": 1.0 / INCH,
    "millimetres beside a radius in inches": 1e3 * INCH,
    "millimetres beside a radius in centimetres": 10.0,
    "a fraction of the diameter, or the radius like the diameter": 0.5,
    "centimetres taken for millimetres": 0.1,
    "inches taken for millimetres": 1e-3 / INCH,
    "metres taken for inches": INCH,
    "metres taken for millimetres": 1e-3,
}
"""For the chord over the radius."""

DENSITY_MISTAKES = {
    "g/m^3": 1e3,
    "g/cm^3": 1e-3,
    "slug/ft^3": 1.0 / SLUG_PER_FT3,
    "lb/ft^3": 1.0 / 16.01846,
}
VISCOSITY_MISTAKES = {"microPa s": 1e6, "mPa s, or centipoise": 1e3, "poise": 10.0}

SPEED_MISTAKES = {"km/h": 1.0 / KMH, "miles an hour": 1.0 / MPH}

SLOW_MISTAKES = {"rad/s": RPM, "revolutions per second": 1.0 / 60.0}
"""For a rotational speed that is too low."""

FAST_MISTAKES = {
    "rpm converted from rad/s twice": 1.0 / RPM,
    "electrical rpm, of 7 pole pairs for example": 7.0,
    "rpm times 60": 60.0,
}
"""For a rotational speed that is too high."""

THRUST_MISTAKES = {
    "grams": 1e3 / GRAVITY,
    "kilograms": 1.0 / GRAVITY,
    "millinewtons": 1e3,
    "ounces": 16.0 / POUND,
    "pounds": 1.0 / POUND,
}
TORQUE_MISTAKES = {
    "N cm": 1e2,
    "N mm": 1e3,
    "kg m": 1.0 / GRAVITY,
    "kg cm": 1e2 / GRAVITY,
    "g cm": 1e5 / GRAVITY,
    "ounce-inches": 16.0 / (POUND * INCH),
    "pound-inches": 1.0 / (POUND * INCH),
}


def likely_mistakes(value: float, usual: Range, mistakes: Mapping[str, float]) -> list[str]:
    """Name the mistakes that explain a value outside the usual range, likeliest first.

    Undone they bring it into the range, and less than ``INDISTINCT`` times as far from its middle
    as the first does; none where the value is not above 0.
    """
    if not 0.0 < value < math.inf:
        return []
    far = {
        like: usual.distance(value / factor)
        for like, factor in mistakes.items()
        if value / factor in usual
    }
    first = min(far.values(), default=0.0)
    close = [like for like in far if far[like] < first + math.log(INDISTINCT)]
    return sorted(close, key=far.__getitem__)


def guessed(value: float, usual: Range, mistakes: Mapping[str, float], subject: str = "it") -> str:
    """Say at the end of a message what the value of a ``subject`` looks like, if anything."""
    likes = likely_mistakes(value, usual, mistakes)
    return f"; {subject} looks like {' or '.join(likes)}" if likes else ""


# -------------------------------------------------------------------------------------------------
# Whether a blade, the air and operating points are like those of small propellers, in words.

PITCH_STATION = 0.75  # share of the radius at which chord and twist stand for the blade
ADVANCE = Range(0.02, 0.7)  # flight speed over tip speed, of usual flights; measured up to 0.5

WINDMILLING = 2.0
"""Axial speed over the blade's pitch speed, beyond which a propeller is a windmill."""

USUAL_TIP_SPEED = Range(25.0, 220.0)
"""[m/s], that a correction of the rotational speed should lead to."""

RADIANS_WITHIN = 1e-3  # closeness to a multiple of 5 degrees in radians


def blade_warnings(propeller: Propeller) -> list[str]:
    """Warn of a radius, a chord and a twist at 0.75 of it unlike those of small propellers, and of
    a twist that rises towards the tip, as on no blade of the catalogue; with the likely cause."""
    radius, found = propeller.radius, []
    if radius not in RADIUS:
        found.append(
            f"the radius is {radius:.4g} m, those of small propellers are {RADIUS.low:g} to "
            f"{RADIUS.high:g} m" + guessed(radius, Range(0.025, 0.4), LENGTH_MISTAKES)
        )
    chord, twist = at_share(propeller, PITCH_STATION)
    if chord / radius not in CHORD:
        found.append(
            f"the chord is {100.0 * chord / radius:.3g} % of the radius at 0.75 of it, those of "
            f"small propellers are {100.0 * CHORD.low:g} to {100.0 * CHORD.high:g} %"
            + guessed(chord / radius, CHORD, CHORD_MISTAKES)
        )
    degrees, inner, outer = (
        math.degrees(angle)
        for angle in (twist, at_share(propeller, 0.4)[1], at_share(propeller, 0.9)[1])
    )
    if degrees < 0.0 and inner < outer:
        found.append("the twist is negative and rises to the tip; it looks like the wrong sign")
    elif inner < outer - 1.0:
        like = "it looks as if listed from the tip to the root"
        if degrees > TWIST.high:
            like = "it looks as if measured from the axis, not from the disk plane"
        found.append(
            f"the twist rises from {inner:.3g} to {outer:.3g} deg between 0.4 and 0.9 of the "
            f"radius; {like}"
        )
    elif degrees not in TWIST:
        like = "; it looks like radians twice converted" if 0.0 < degrees < 0.5 else ""
        found.append(
            f"the twist is {degrees:.3g} deg at 0.75 of the radius, those of small propellers are "
            f"{TWIST.low:g} to {TWIST.high:g} deg{like}"
        )
    return found


def air_warnings(air: Air) -> list[str]:
    """Warn of air unlike that in which propellers turn, with the likely cause."""
    found = []
    if air.density not in DENSITY:
        found.append(
            f"the air density is {air.density:.4g} kg/m^3, near the ground it is about 1.2"
            + guessed(air.density, Range(0.9, 1.45), DENSITY_MISTAKES)
        )
    if air.viscosity not in VISCOSITY:
        found.append(
            f"the viscosity is {air.viscosity:.4g} Pa s, that of air is about 1.8e-5"
            + guessed(air.viscosity, Range(1.4e-5, 2.2e-5), VISCOSITY_MISTAKES)
        )
    return found


def point_warnings(propeller: Propeller, omega: Floats, speed: Floats, beta: Floats) -> list[str]:
    """Warn of operating points [rad/s], [m/s], [rad] unlike those of small propellers.

    Raises ``InputError`` where a blade tip moves faster than sound: there neither momentum theory
    nor any section law here holds, and there is no number to give.
    """
    w, v, b = (np.ravel(values) for values in np.broadcast_arrays(omega, speed, beta))
    tip = w * propeller.radius
    fast = _mach_warnings(tip, v)
    if fast:
        return fast
    return [*_speeds_warnings(propeller, tip, v, b), *_angle_warnings(b)]


def at_share(propeller: Propeller, share: float) -> tuple[float, float]:
    """Interpolate chord [m] and twist [rad] at a share of the radius."""
    place = share * propeller.radius
    chord, twist = (
        float(np.interp(place, propeller.station, values))
        for values in (propeller.chord, propeller.twist)
    )
    return chord, twist


def pitch_ratio(propeller: Propeller) -> float:
    """Divide the speed of a screw with the blade's pitch by the tip speed [-]."""
    return PITCH_STATION * math.tan(at_share(propeller, PITCH_STATION)[1])


def _mach_warnings(tip: Floats, speed: Floats) -> list[str]:
    helical = np.hypot(tip, speed)
    k = int(np.argmax(helical))
    mach = float(helical[k]) / SPEED_OF_SOUND
    if mach <= FAST_TIP_MACH:
        return []
    found = (
        f"the tip moves at {helical[k]:.4g} m/s, Mach {mach:.3g}, with {tip[k]:.4g} m/s from the "
        f"rotation and {speed[k]:.4g} m/s from the flight"
    )
    if speed[k] > tip[k]:
        like = guessed(float(speed[k]), Range(1.0, 130.0), SPEED_MISTAKES, "the speed")
    else:
        like = guessed(float(tip[k]), Range(40.0, 130.0), FAST_MISTAKES, "the rotational speed")
        like += ", or the radius like the diameter" if like else ""
    if mach > 1.0:
        remedy = "check rpm, speed and radius: nothing here holds above Mach 1"
        raise InputError(f"{found}{like}", remedy)
    return [
        f"{found}; above {FAST_TIP_MACH:g} drag rises, which the section law does not have{like}"
    ]


def _speeds_warnings(propeller: Propeller, tip: Floats, speed: Floats, beta: Floats) -> list[str]:
    turning = tip > 0.0
    if not turning.any():
        return []
    flying = turning & (speed > 0.0)
    fastest = float(tip.max())
    if fastest < TIP_SPEED.low:
        like = guessed(fastest, USUAL_TIP_SPEED, SLOW_MISTAKES, "the rotational speed")
        return [f"the tip speed is {fastest:.3g} m/s at most, very slow{like}"]
    if not flying.any():
        return []
    share = speed[flying] / tip[flying]
    advance = median(share.tolist())
    along = median((share * np.cos(beta[flying])).tolist()) / max(pitch_ratio(propeller), 1e-3)
    if advance <= ADVANCE.high and along <= WINDMILLING:
        return []
    found = f"the speed is {advance:.3g} times the tip speed"
    if advance <= ADVANCE.high:
        found = f"the speed along the axis is {along:.3g} times the speed of the blade's pitch"
    for like in likely_mistakes(fastest, USUAL_TIP_SPEED, SLOW_MISTAKES):
        if fastest not in USUAL_TIP_SPEED and advance * SLOW_MISTAKES[like] in ADVANCE:
            return [f"{found}; the rotational speed looks like {like}"]
    for like in likely_mistakes(advance, ADVANCE, SPEED_MISTAKES):
        if along / SPEED_MISTAKES[like] < PITCH_SPEED_RATIO:
            return [f"{found}; the speed looks like {like}"]
    return [f"{found}; check rpm, speed and radius"]


def _angle_warnings(beta: Floats) -> list[str]:
    """Warn of radians given for degrees: multiples of 5 degrees, converted twice."""
    degrees = np.sort(np.abs(np.degrees(beta)), axis=None)
    nonzero = degrees[degrees > 1e-9]
    step = math.radians(5.0)
    if not nonzero.size or nonzero[-1] > math.pi + RADIANS_WITHIN:
        return []
    off = np.abs(nonzero - step * np.round(nonzero / step))
    if (off > RADIANS_WITHIN).any() or (np.abs(nonzero - np.round(nonzero)) < 1e-9).any():
        return []
    return [f"beta is {nonzero[-1]:.5g} deg at most; it looks like radians"]


# -------------------------------------------------------------------------------------------------
# Whether measured loads fit the blade they are said to be of: unit mistakes, signs, angles.
#
# Chord and twist at 0.75 of the radius give thrust and torque in axial flow within a factor of two
# (``estimated_loads``), so that a load out by more is in other units.

SLOW = 0.6
"""Axial speed over the blade's pitch speed, up to which an estimate of the loads is any good."""

AXIAL, EDGEWISE = 0.9, 0.3
"""|cos(beta)| above which flow counts as axial, and below which as edgewise."""

LIFT_SLOPE, ZERO_LIFT, DRAG = 5.5, math.radians(-4.0), 0.03
INDUCED = 1.25
SMALL_BLADES = 0.68
"""Measured loads over the estimate without this factor: the median of 134 propellers."""

NARROW_LOAD_RATIO = Range(1.0 / 1.5, 1.5)  # where loads are known to be wrong

ENERGY_MARGIN = 1.15
"""Ideal power over shaft power, above which no error of measurement explains it."""

WEAK = 0.25  # share of the slow thrust below which rows do not show how far a propeller pulls
DRAG_SHARE = 0.02  # drag over thrust that no axial flow has

AXIAL_KEEPS, EDGEWISE_KEEPS = 0.8, 0.5
"""Shares of the thrust at rest: the most that is left at 0.7 of the pitch speed along the axis, and
the least at this speed across it; measured at most 0.52, and more than 1."""

Loads = Mapping[str, Floats]

SHARED_MISTAKES: tuple[tuple[str, float, float], ...] = (
    ("rpm like rad/s", 1.0 / RPM**2, 1.0 / RPM**2),
    ("rpm like revolutions per second", 3600.0, 3600.0),
    ("rpm converted from rad/s twice", RPM**2, RPM**2),
    ("a radius like the diameter", 1.0 / 16.0, 1.0 / 32.0),
    ("a diameter like the radius", 16.0, 32.0),
    *(("electrical rpm", pairs**-2.0, pairs**-2.0) for pairs in (4, 6, 7, 11)),
    ("coefficients over rho A (Omega R)^2", 4.0 / math.pi**3, 4.0 / math.pi**4),
)
"""What takes thrust and torque out of their ranges together, and the factors of both."""


def load_warnings(
    propeller: Propeller, air: Air, omega: Floats, speed: Floats, beta: Floats, loads: Loads
) -> list[str]:
    """Warn of measured loads (n,) [N], [N m] at points (n,) that do not fit the blade; NaN where
    not measured.

    Raises ``InputError`` where they cannot be: more power in the slipstream than on the shaft, or a
    coefficient three times the largest measured.  Constants fitted to such loads mean nothing.
    """
    turning = omega > 0.0
    w, v, b = omega[turning], speed[turning], beta[turning]
    known = {n: loads[n][turning] for n in loads if np.isfinite(loads[n][turning]).any()}
    if not w.size or not {"thrust", "torque"} & set(known):
        return []
    ratios = _ratios(propeller, air, w, v, b, known)
    backwards = [name for name in ratios if ratios[name] < 0.0]
    if backwards:
        return [f"{name} is negative near rest; its sign looks reversed" for name in backwards]
    found = _size_warnings(ratios, LOAD_RATIO) or [
        *_signs_warnings(v, known),
        *_reach_warnings(propeller, air, w, v, b, known),
        *_direction_warnings(propeller, w, v, b, known),
    ]
    impossible = _impossible(propeller, air, w, v, b, known)
    if impossible:
        found = found or _size_warnings(ratios, NARROW_LOAD_RATIO)
        raise InputError("; ".join([impossible, *found]), "convert what is in another unit")
    return found


def estimated_loads(
    propeller: Propeller, air: Air, omega: Floats, axial: Floats
) -> dict[str, Floats]:
    """Estimate thrust [N] and torque [N m] in axial flow within a factor of two.

    By momentum and blade element at 0.75 of the radius with a linear lift (J. G. Leishman,
    Principles of Helicopter Aerodynamics, 2nd ed., Cambridge 2006, section 3.3), scaled to small
    propellers; ``axial`` [m/s] is not above the blade's pitch speed.
    """
    radius = propeller.radius
    chord, twist = at_share(propeller, PITCH_STATION)
    solidity = propeller.blades * chord / (math.pi * radius)
    climb = axial / (omega * radius)
    half = solidity * LIFT_SLOPE / 16.0 - climb / 2.0
    attack = max(twist - ZERO_LIFT, math.radians(1.0))
    inflow = np.sqrt(half**2 + solidity * LIFT_SLOPE * attack * PITCH_STATION / 8.0) - half
    thrust = 2.0 * inflow * (inflow - climb)
    torque = INDUCED * thrust * inflow + solidity * DRAG / 8.0
    force = SMALL_BLADES * air.density * math.pi * radius**4 * omega**2
    return {"thrust": force * thrust, "torque": force * radius * torque}


def _ratios(
    propeller: Propeller, air: Air, w: Floats, v: Floats, b: Floats, known: Loads
) -> dict[str, float]:
    """Divide thrust and torque by their estimates: medians over the rows nearest to rest."""
    share = v / (w * propeller.radius)
    reach = SLOW * abs(pitch_ratio(propeller))
    found = {}
    for name in ("thrust", "torque"):
        if name in known:
            measured = np.isfinite(known[name])
            rows = measured & (share <= reach)
            # Where all are fast, the slowest tenth, estimated as near to rest as will do.
            if not rows.any():
                rows = measured & (share <= np.percentile(share[measured], 10.0))
            climb = np.clip(share * np.cos(b), 0.0, reach)[rows] * w[rows] * propeller.radius
            estimate = estimated_loads(propeller, air, w[rows], climb)[name]
            found[name] = float(np.median(known[name][rows] / estimate))
    return found


def _signs_warnings(speed: Floats, known: Loads) -> list[str]:
    """Warn of single rows at rest with a sign that the others do not have."""
    found = []
    for name in ("thrust", "torque"):
        still = known[name][speed == 0.0] if name in known else np.empty(0)
        count = int(np.count_nonzero(still < 0.0))
        if count:
            rows = f"{count} of {still.size} rows at rest"
            found.append(f"{name} is negative in {rows}; check its sign")
    return found


def _size_warnings(ratios: Mapping[str, float], usual: Range) -> list[str]:
    """Warn of ratios of which one at least is out of a range, with the mistakes that explain it."""
    columns = {"thrust": THRUST_MISTAKES, "torque": TORQUE_MISTAKES}
    odd = {name: ratio for name, ratio in ratios.items() if ratio not in usual}
    if not odd:
        return []
    each = (
        f"{name} is {ratio:.3g} times what such a blade gives" for name, ratio in ratios.items()
    )
    own = [
        f"{name} looks like {' or '.join(likes)}"
        for name, ratio in odd.items()
        if (likes := likely_mistakes(ratio, LOAD_RATIO, columns[name]))
    ]
    shared = _shared_mistakes(ratios)
    # One mistake is likelier than two; with one load measured, both kinds explain it.
    if shared and (len(odd) > 1 or len(ratios) == 1):
        own = [*own, *shared] if len(ratios) == 1 else shared
    cause = ", or ".join(own or shared) or "check units, radius and rpm"
    return [f"{' and '.join(each)}; {cause}"]


def _shared_mistakes(ratios: Mapping[str, float]) -> list[str]:
    """Name the mistakes that undone bring all loads into their ranges, likeliest first."""
    far: dict[str, float] = {}
    for like, thrust, torque in SHARED_MISTAKES:
        factors = {"thrust": thrust, "torque": torque}
        mended = [ratio / factors[name] for name, ratio in ratios.items()]
        if all(value in LOAD_RATIO for value in mended):
            distance = sum(LOAD_RATIO.distance(value) for value in mended)
            far[like] = min(distance, far.get(like, math.inf))
    return [f"it looks like {' or '.join(sorted(far, key=far.__getitem__))}"] if far else []


def _impossible(
    propeller: Propeller, air: Air, w: Floats, v: Floats, b: Floats, known: Loads
) -> str:
    """Say what no propeller can do; an empty text for nothing."""
    turns, diameter = w / (2.0 * math.pi), propeller.diameter
    force = air.density * turns**2 * diameter**4
    sizes = {"thrust": ("C_T", force), "torque": ("C_P", force * diameter / (2.0 * math.pi))}
    for name, (symbol, size) in sizes.items():
        if name in known:
            value = float(np.nanmedian(known[name] / size))
            if value > IMPOSSIBLE_COEFFICIENT:
                return f"{symbol} is {value:.3g}, of no propeller more than 0.25"
    if len(known.keys() & sizes.keys()) < len(sizes):
        return ""
    thrust, power = known["thrust"], known["torque"] * w
    rows = (thrust > 0.0) & (power > 0.0)
    if not rows.any():
        return ""
    along, disk = v[rows] * np.cos(b[rows]), math.pi * propeller.radius**2
    across = v[rows] * np.sin(b[rows])
    # Glauert's momentum (10) at the least induced speed, that of a uniform inflow.
    induced = np.zeros_like(along)
    for _ in range(60):
        flow = np.hypot(along + induced, across)
        step = thrust[rows] / (2.0 * air.density * disk * np.maximum(flow, 1e-9))
        induced = 0.5 * (induced + np.minimum(step, 1e6))
    share = float(np.median(thrust[rows] * (along + induced) / power[rows]))
    if share > ENERGY_MARGIN:
        return f"the air gets {share:.3g} times the power on the shaft"
    return ""


def _reach_warnings(
    propeller: Propeller, air: Air, w: Floats, v: Floats, b: Floats, known: Loads
) -> list[str]:
    """Warn of a pull faster than the pitch moves: speeds are in another unit."""
    if "thrust" not in known:
        return []
    at_rest = estimated_loads(propeller, air, w, np.zeros_like(w))["thrust"]
    pulling = known["thrust"] > WEAK * np.maximum(at_rest, np.nanmax(known["thrust"] / w**2) * w**2)
    rows = pulling & (v > 0.0) & (np.cos(b) > AXIAL)
    if not rows.any():
        return []
    along = v[rows] * np.cos(b[rows]) / (w[rows] * propeller.radius)
    farthest = float(np.max(along)) / max(pitch_ratio(propeller), 1e-3)
    if farthest <= PITCH_SPEED_RATIO:
        return []
    units = [u for u, f in SPEED_MISTAKES.items() if 0.5 < farthest / f <= PITCH_SPEED_RATIO]
    like = f"the speed looks like {units[0]}" if units else "check speed, rpm and beta"
    return [f"it pulls at {farthest:.3g} times the speed of the blade's pitch; {like}"]


def _direction_warnings(
    propeller: Propeller, w: Floats, v: Floats, b: Floats, known: Loads
) -> list[str]:
    """Warn of axial flow with the loads of edgewise flow, or the reverse: beta from the disk."""
    axial = (v > 0.0) & (np.abs(np.cos(b)) > AXIAL)
    edgewise = (v > 0.0) & (np.abs(np.cos(b)) < EDGEWISE)
    hint = "beta looks as if measured from the disk plane, 0 is along the axis here"
    thrust = known.get("thrust", np.full_like(w, np.nan))
    if "drag" in known:
        across = np.abs(known["drag"]) / np.maximum(np.abs(thrust), 1e-9)
        across = across[axial & np.isfinite(across)]
        if across.size and float(np.median(across)) > DRAG_SHARE:
            return [f"there is drag in the disk plane in axial flow; {hint}"]
    # The speed over that of the blade's pitch: what is fast along the axis.
    reach = v / (w * propeller.radius * max(pitch_ratio(propeller), 1e-3))
    coefficient, measured = thrust / w**2, np.isfinite(thrust)
    slow, fast = measured & (reach < 0.3), measured & (reach > 0.7)
    if not (slow.any() and fast.any()):
        return []
    rest = float(np.median(coefficient[slow]))
    for flow, rows in (("axial", axial & fast), ("edgewise", edgewise & fast)):
        if not rows.any():
            continue
        kept = float(np.median(coefficient[rows])) / rest
        # Axial flow takes thrust away, edgewise flow adds to it.
        if kept > AXIAL_KEEPS if flow == "axial" else kept < EDGEWISE_KEEPS:
            return [f"in fast {flow} flow thrust is {kept:.2g} times that at rest; {hint}"]
    return []


# -------------------------------------------------------------------------------------------------
# What a blade must satisfy before any load is computed from it.

MIN_STATIONS = 4
MAX_BLADES = 12
MAX_ROOT_CUTOUT = 0.9
# Above any rotor that flies, and below a model propeller in millimetres.
MAX_RADIUS = 20.0
# No blade is set at 92 degrees to its disk, so a larger figure is in degrees.
MAX_TWIST = 1.6


def check_blade(station: Floats, chord: Floats, twist: Floats, labels: Sequence[str] = ()) -> None:
    """Raise ``InputError`` unless station [m], chord [m] and twist [rad], (n,) each, are one blade.

    ``labels`` are n names of the stations for messages, such as "line 7".
    """
    columns = {"station": station, "chord": chord, "twist": twist}
    for field, values in columns.items():
        if values.ndim != 1 or values.size != station.size:
            found = f"{field} has shape {values.shape}, expected one value per station"
            raise InputError(found, "give station, chord and twist as lists of one length")
    if station.size < MIN_STATIONS:
        found = f"found {station.size} stations, expected at least {MIN_STATIONS}"
        raise InputError(found, "add stations between root and tip")
    labels = labels or [f"station {i}" for i in range(station.size)]
    for field, values in columns.items():
        for k in np.flatnonzero(~np.isfinite(values))[:1]:
            found = f"{labels[k]}: {field} is {values[k]}, expected a finite number"
            raise InputError(found, "remove the row or correct it")
    if station[0] <= 0.0:
        found = f"{labels[0]}: the first station is at {station[0]:g} m, expected more than 0"
        raise InputError(found, "start at the hub radius, where the blade begins")
    for k in np.flatnonzero(station[1:] <= station[:-1])[:1] + 1:
        found, remedy = "is repeated", "keep one row per station"
        if station[k] < station[k - 1]:
            found = f"is unsorted (it follows {station[k - 1]:g} m)"
            remedy = "sort the rows by station"
        found = f"{labels[k]}: station {station[k]:g} m {found}"
        raise InputError(f"{found}, expected stations that rise from root to tip", remedy)
    radius = float(station[-1])
    if radius > MAX_RADIUS:
        found = f"{labels[-1]}: the radius is {radius:g} m, expected at most {MAX_RADIUS:g} m"
        like = guessed(radius, Range(0.025, 0.4), LENGTH_MISTAKES)
        raise InputError(f"{found}{like}", "check the units; lengths are in metres")
    low, high = int(np.argmin(chord)), int(np.argmax(chord))
    if chord[low] < 0.0:
        found = f"{labels[low]}: chord is {chord[low]:g} m, expected 0 or more"
        raise InputError(found, "correct the negative chord")
    if chord[high] == 0.0:
        raise InputError("every chord is 0", "give the chord of each station")
    if chord[high] >= radius:
        found = f"{labels[high]}: chord is {chord[high]:g} m, expected less than the radius of "
        like = guessed(float(chord[high]) / radius, WIDEST_CHORD, CHORD_MISTAKES)
        raise InputError(f"{found}{radius:g} m{like}", "check the units of chord and radius")
    steepest = int(np.argmax(np.abs(twist)))
    if abs(twist[steepest]) > MAX_TWIST:
        found = f"{labels[steepest]}: twist is {twist[steepest]:g} rad, expected at most "
        remedy = "the column must be in radians or be named twist_deg"
        raise InputError(f"{found}{MAX_TWIST}; it looks like degrees", remedy)


def check_blades(blades: Any) -> int:
    """Check that the number of blades is a whole 1 to 12, and return it as an ``int``."""
    try:
        count = operator.index(blades)
    except TypeError:
        count = 0
    if isinstance(blades, bool | np.bool_) or not 1 <= count <= MAX_BLADES:
        found = f"the number of blades is {quoted(blades)}, expected a whole number from 1 to "
        raise InputError(f"{found}{MAX_BLADES}", "pass --blades 2 (in Python: blades=2)")
    return count


def check_root_cutout(root_cutout: Any, station: Floats) -> float:
    """Check that the root cut-out [m] lies on the blade, and return it as a ``float``."""
    first, last = float(station[0]), MAX_ROOT_CUTOUT * float(station[-1])
    try:
        value = float(root_cutout)
    except (TypeError, ValueError):
        value = float("nan")
    if not first <= value <= last:
        raise InputError(
            f"the root cut-out is {quoted(root_cutout)} m, "
            f"expected between {first:.6g} m (first station) and {last:.6g} m (0.9 radius)",
            "choose a root cut-out on the blade, in metres",
        )
    return value


def twist_from_degrees(degrees: Floats) -> Floats:
    """Convert a column of twist (n,) from degrees to radians; refuse what looks like radians.

    A blade whose steepest section stands at less than 1.6 degrees makes no propeller.
    """
    steepest = float(np.nanmax(np.abs(degrees), initial=0.0))
    if degrees.size and steepest < MAX_TWIST:
        found = f"the largest twist is {steepest:g} degrees; it looks like radians"
        raise InputError(found, "the column must be in degrees or be named twist_rad")
    return np.deg2rad(degrees)
