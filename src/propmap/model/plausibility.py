"""Warnings of implausible blades, air, operating points and loads, and of likely unit errors."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from statistics import median  # without numpy.ma, which takes longer to load than one point

import numpy as np

from propmap.errors import InputError
from propmap.model.air import Air
from propmap.model.propeller import LIKELY_RADIUS, Propeller
from propmap.model.unit_errors import (
    ELECTRICAL_POWER,
    LOAD_UNIT_ERRORS,
    ROTORS,
    UNIT_ERRORS,
    Range,
    common_errors,
    likely_cause,
    looks_like,
    unit_errors,
    unusual,
)
from propmap.typing import Floats
from propmap.units import SPEED_OF_SOUND

# -------------------------------------------------------------------------------------------------
# Usual ranges of small propellers.
#
# They are those of the blades of the catalogue, and of the 134 sets of loads in the UIUC Propeller
# Database that have a geometry (Brandt, Deters, Ananda, Dantsker, Selig, volumes 1 to 3), with some
# room: a warning is due where something is unlike all that has been measured.
# ``tests/catalogue/test_nothing_is_doubted.py`` holds them against these data.

RADIUS = Range(0.012, 2.0)  # [m]; measured 0.028 to 0.36
CHORD = Range(0.09, 0.40)  # over the radius, at 0.75 of it; measured 0.10 to 0.35
TWIST = Range(3.0, 40.0)  # [deg] at 0.75 of the radius; measured 7 to 25
DENSITIES = Range(0.3, 1.6), "density", Range(0.9, 1.45)
"""Usual of air [kg/m^3], from 12 km up to a cold day at sea level, its quantity, and likely."""
VISCOSITIES = Range(1e-5, 2.5e-5), "viscosity", Range(1.4e-5, 2.2e-5)
"""Usual of air [Pa s], from -80 to 150 degrees Celsius, its quantity, and likely."""
TIP_SPEED = Range(8.0, 255.0)  # of the fastest point [m/s]: measured 26 to 216; 255 is Mach 0.75
LIKELY_TIP_SPEED = Range(25.0, 220.0)
ADVANCE = Range(0.02, 0.7)  # flight speed over tip speed of usual flights; measured up to 0.5
LOAD_RATIO = Range(1.0 / 2.3, 2.3)
"""A measured load over the estimate from chord and twist; medians of sets are 0.6 to 1.6 for thrust
and 0.55 to 2.0 for torque."""
WRONG_LOAD_RATIO = Range(1.0 / 1.5, 1.5)  # the same where loads are known to be wrong
WIDE_LOAD_RATIO = Range(1.0 / 3.5, 3.5)  # and where nothing else explains them

MOST_FOR_THRUST, LEAST_FOR_THRUST = (1.4, 1.95), 0.7
"""Torque over its estimate, over the same of thrust: the 134 sets have 0.81 to 1.85. The first
limit is for power; two of the sets have more."""

FAST_TIP_MACH = 0.75  # above it the drag of thick sections rises, which no law here has
PITCH_STATION = 0.75  # share of the radius at which chord and twist stand for the blade
PULLING, WINDMILLING = 1.6, 2.0
"""Axial speed over that of a screw with the blade's pitch, up to which a propeller pulls (measured
1.35 at a quarter of the largest thrust), and beyond which it is a windmill."""

RADIANS_WITHIN = 1e-3  # closeness to a multiple of 5 degrees in radians


# -------------------------------------------------------------------------------------------------
# Warnings on a blade, the air and operating points.


def blade_warnings(propeller: Propeller) -> list[str]:
    """Warn of radius, chord or twist unlike small propellers, or twist that rises to the tip."""
    radius = propeller.radius
    chord, twist = at_share(propeller, PITCH_STATION)
    found = unusual("the radius", radius, "m", RADIUS, "length", LIKELY_RADIUS)
    usual = CHORD, "chord over radius"
    found += unusual("the chord at 0.75 of the radius", chord / radius, "radii", *usual)
    others = (at_share(propeller, share)[1] for share in (0.4, 0.9))
    degrees, inner, outer = map(math.degrees, (twist, *others))
    if degrees < 0.0 and inner < outer:
        sign = "the twist is negative and rises towards the tip; it looks like the wrong sign"
        return [*found, sign]
    if inner < outer - 1.0:
        like = "it looks as if listed from the tip to the root"
        if degrees > TWIST.high:
            like = "it looks as if measured from the axis, not from the disk plane"
        rise = f"the twist rises from {inner:.3g} to {outer:.3g} deg"
        return [*found, f"{rise} between 0.4 and 0.9 of the radius; {like}"]
    return [*found, *unusual("the twist at 0.75 of the radius", degrees, "deg", TWIST, "twist")]


def air_warnings(air: Air) -> list[str]:
    """Warn of a density or a viscosity that no air has where propellers turn."""
    found = unusual("the air density", air.density, "kg/m^3", *DENSITIES)
    return found + unusual("the viscosity", air.viscosity, "Pa s", *VISCOSITIES)


def point_warnings(propeller: Propeller, omega: Floats, speed: Floats, beta: Floats) -> list[str]:
    """Warn of operating points [rad/s], [m/s], [rad] that broadcast to (n,), unlike small
    propellers'; ``InputError`` where a tip is faster than sound, as nothing here holds then."""
    w, v, b = (np.ravel(values) for values in np.broadcast_arrays(omega, speed, beta))
    tip = w * propeller.radius
    fast = _fast_tip(tip, v)
    if fast:
        return fast
    return [*_unlike_speeds(pitch_ratio(propeller), tip, v, b), *_beta_in_radians(b)]


def at_share(propeller: Propeller, share: float) -> tuple[float, float]:
    """Return chord [m] and twist [rad] at a ``share`` of the radius."""
    place = share * propeller.radius
    chord = np.interp(place, propeller.station, propeller.chord)
    return float(chord), float(np.interp(place, propeller.station, propeller.twist))


def pitch_ratio(propeller: Propeller) -> float:
    """Return the speed of a screw with the blade's pitch over the tip speed [-]."""
    return PITCH_STATION * math.tan(at_share(propeller, PITCH_STATION)[1])


def _fast_tip(tip: Floats, speed: Floats) -> list[str]:
    """Warn of the fastest tip above Mach 0.75, raise ``InputError`` above Mach 1."""
    helical = np.hypot(tip, speed)
    k = int(np.argmax(helical))
    mach = float(helical[k]) / SPEED_OF_SOUND
    if mach <= FAST_TIP_MACH:
        return []
    motion = f"the tip moves at {helical[k]:.4g} m/s, Mach {mach:.3g}, with {tip[k]:.4g} m/s from "
    motion += f"the rotation and {speed[k]:.4g} m/s from the flight"
    if speed[k] > tip[k]:
        like = likely_cause(float(speed[k]), Range(1.0, 130.0), "speed", "the speed")
    else:
        usual = Range(40.0, 130.0)
        like = likely_cause(float(tip[k]), usual, "fast rotation", "the rotational speed")
        like += ", or the radius like the diameter" if like else ""
    if mach > 1.0:
        remedy = "check rpm, speed and radius: nothing here holds above Mach 1"
        raise InputError(motion + like, remedy)
    drag = f"above {FAST_TIP_MACH:g} drag rises, which the section law does not have"
    return [f"{motion}; {drag}{like}"]


def _unlike_speeds(pitch: float, tip: Floats, speed: Floats, beta: Floats) -> list[str]:
    """Warn of slow tips, and of flight that is fast beside the tip or the ``pitch`` ratio."""
    turning = tip > 0.0
    if not turning.any():
        return []
    flying = turning & (speed > 0.0)
    fastest = float(tip.max())
    usual = TIP_SPEED, "slow rotation", LIKELY_TIP_SPEED, "the rotational speed"
    slow = unusual("the fastest tip speed", fastest, "m/s", *usual)
    if slow or not flying.any():
        return slow
    share = speed[flying] / tip[flying]
    advance = median(share.tolist())
    along = median((share * np.cos(beta[flying])).tolist()) / max(pitch, 1e-3)
    if advance <= ADVANCE.high and along <= WINDMILLING:
        return []
    fast = f"the speed is {advance:.3g} times the tip speed"
    if advance <= ADVANCE.high:
        fast = f"the speed along the axis is {along:.3g} times the speed of the blade's pitch"
    if fastest not in LIKELY_TIP_SPEED:
        slow_errors = UNIT_ERRORS["slow rotation"]
        for like in unit_errors(fastest, LIKELY_TIP_SPEED, slow_errors):
            if advance * slow_errors[like] in ADVANCE:
                return [f"{fast}; the rotational speed looks like {like}"]
    for like in unit_errors(advance, ADVANCE, UNIT_ERRORS["speed"]):
        if along / UNIT_ERRORS["speed"][like] < PULLING:
            return [f"{fast}; the speed looks like {like}"]
    return [f"{fast}; check rpm, speed and radius"]


def _beta_in_radians(beta: Floats) -> list[str]:
    """Warn of radians taken for degrees: angles are multiples of 5 degrees, converted twice."""
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
# Whether measured loads fit the blade they are said to be of: unit errors, signs, angles.
#
# Chord and twist at 0.75 of the radius give thrust and torque in axial flow within a factor of two,
# so that a load out by more is in other units.

SLOW = 0.6  # axial over pitch speed, up to which an estimate of the loads is any good
AXIAL, EDGEWISE = 0.9, 0.3  # |cos(beta)| above which flow is axial, and below, edgewise

LIFT_SLOPE, ZERO_LIFT, DRAG = 5.5, math.radians(-4.0), 0.03
INDUCED = 1.25
SMALL_BLADES = 0.68  # measured loads over the estimate otherwise, median of 134 propellers
IMPOSSIBLE_COEFFICIENT = 0.75  # C_T and C_P thrice the largest measured
ENERGY_MARGIN = 1.15  # ideal power over shaft power that no error of measurement explains
WEAK = 0.25  # share of the slow thrust below which rows do not say how far a propeller pulls
DRAG_SHARE = 0.02  # drag over thrust that no axial flow has
AXIAL_KEEPS, EDGEWISE_KEEPS = 0.8, 0.5
"""Shares of the thrust at rest: the most that is left at 0.7 of the pitch speed along the axis, and
the least at this speed across it; measured at most 0.52, and more than 1."""


def load_warnings(
    propeller: Propeller,
    air: Air,
    omega: Floats,
    speed: Floats,
    beta: Floats,
    loads: Mapping[str, Floats],
    *,
    by_power: bool = False,
) -> list[str]:
    """Warn of measured ``loads`` (n,) [N], [N m] that do not fit the blade; NaN is not measured.
    ``by_power`` says that the torque was measured as power; ``InputError`` where there can be no
    such loads: constants fitted to them mean nothing."""
    turning = omega > 0.0
    w, v, b = omega[turning], speed[turning], beta[turning]
    known = {n: loads[n][turning] for n in loads if np.isfinite(loads[n][turning]).any()}
    if not w.size or not {"thrust", "torque"} & set(known):
        return []
    ratios = _over_estimates(propeller, air, w, v, b, known)
    backwards = [name for name in ratios if ratios[name] < 0.0]
    if backwards:
        return [f"{name} is negative near rest; its sign looks reversed" for name in backwards]
    found = _wrong_size(ratios, LOAD_RATIO, by_power=by_power)
    proportion = _out_of_proportion(ratios, by_power=by_power)
    if found and by_power and ELECTRICAL_POWER not in found[0]:
        found += [text for text in proportion if ELECTRICAL_POWER in text]
    found = found or [
        *_negative_at_rest(v, known),
        *proportion,
        # One mistake is likelier than two.
        *(
            _pulls_too_fast(propeller, air, w, v, b, known)
            or _beta_from_the_disk(propeller, w, v, b, known)
        ),
    ]
    impossible = _impossible(propeller, air, w, v, b, known)
    if impossible:
        found = found or _wrong_size(ratios, WRONG_LOAD_RATIO, by_power=by_power)
        raise InputError("; ".join([impossible, *found]), "convert what is in another unit")
    return found


def estimated_loads(
    propeller: Propeller, air: Air, omega: Floats, axial: Floats
) -> dict[str, Floats]:
    """Estimate thrust [N] and torque [N m] of a blade in axial flow (n,) up to its pitch speed
    within a factor of two, by momentum and blade element at 0.75 R (J. G. Leishman, Principles of
    Helicopter Aerodynamics, 2nd ed., Cambridge 2006, section 3.3), scaled to small propellers."""
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


def _over_estimates(
    propeller: Propeller, air: Air, w: Floats, v: Floats, b: Floats, known: Mapping[str, Floats]
) -> dict[str, float]:
    """Divide thrust and torque by their estimates: medians of the rows nearest to rest."""
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


def _negative_at_rest(speed: Floats, known: Mapping[str, Floats]) -> list[str]:
    """Warn of single rows at rest with a sign that the others do not have."""
    found = []
    for name in ("thrust", "torque"):
        still = known[name][speed == 0.0] if name in known else np.empty(0)
        count = int(np.count_nonzero(still < 0.0))
        if count:
            rows = f"{count} of {still.size} rows at rest"
            found.append(f"{name} is negative in {rows}; check its sign")
    return found


def _wrong_size(ratios: Mapping[str, float], usual: Range, *, by_power: bool) -> list[str]:
    """Warn, in one text, of ratios to the estimates out of a range, with the likely errors."""
    odd = [name for name, ratio in ratios.items() if ratio not in usual]
    if not odd:
        return []
    names = {name: "power" if by_power and name == "torque" else name for name in ratios}
    sizes = " and ".join(
        f"{names[name]} is {ratio:.3g} times what such a blade gives"
        for name, ratio in ratios.items()
    )
    each = (
        looks_like(_sized(_errors_of(names[name], ratios[name]), ratios[name]), names[name])
        for name in odd
    )
    causes = [like for like in each if like]
    measured = [name in ratios for name in ("thrust", "torque")]
    errors = [one for one in LOAD_UNIT_ERRORS if all(measured) or one[0] != ROTORS]
    common = [(name, [*itertools.compress(each, measured)]) for name, each in errors]
    middle = math.exp(sum(math.log(max(r, 1e-9)) for r in ratios.values()) / len(ratios))
    likely = common_errors([*ratios.values()], LOAD_RATIO, common)
    if len(causes) < len(odd):
        likely = likely or common_errors([*ratios.values()], WIDE_LOAD_RATIO, common)
    shared = looks_like(_sized(likely, middle))
    # One mistake is likelier than two; with one load measured, both kinds explain it.
    if shared and (len(odd) > 1 or len(ratios) == 1 or not causes):
        causes = [*causes, shared] if len(ratios) == 1 else [shared]
    return [f"{sizes}; {', or '.join(causes) or 'check units, radius and rpm'}"]


def _out_of_proportion(ratios: Mapping[str, float], *, by_power: bool) -> list[str]:
    """Warn of thrust and torque that are each possible, but not with each other."""
    if not {"thrust", "torque"} <= set(ratios):
        return []
    share = ratios["torque"] / ratios["thrust"]
    if share > MOST_FOR_THRUST[not by_power]:
        name = "power" if by_power else "torque"
        causes = [ELECTRICAL_POWER] if by_power else [ROTORS, ELECTRICAL_POWER]
    elif share < LEAST_FOR_THRUST:
        name, share, causes = "thrust", 1.0 / share, [ROTORS]
    else:
        return []
    other = "torque" if name == "thrust" else "thrust"
    times = f"{name} is {share:.3g} times what such a blade has at its {other}"
    return [f"{times}; it may be {' or '.join(_sized(causes, share))}"]


def _errors_of(quantity: str, ratio: float) -> list[str]:
    """List what is wrong with one load, likeliest first: its unit, how many rotors it is of, or
    what power it is."""
    errors: list[tuple[str, Sequence[float]]] = [
        (name, (factor,)) for name, factor in UNIT_ERRORS[quantity].items()
    ]
    errors += [(ROTORS, (float(count),)) for count in (2, 3, 4, 6, 8)]
    if quantity != "thrust":
        errors += [(ELECTRICAL_POWER, (factor,)) for factor in (1.5, 2.0, 3.0, 5.0, 8.0)]
    return common_errors((ratio,), LOAD_RATIO, errors)


def _sized(errors: Iterable[str], ratio: float) -> list[str]:
    """Put into names of errors the number that a ``ratio`` to the estimate tells."""
    rotors = min((2, 3, 4, 6, 8), key=lambda count: abs(math.log(max(ratio, 1e-9) / count)))
    pairs = max(2, round(max(ratio, 1e-9) ** -0.5))
    return [name.format(rotors=f"about {rotors}", pairs=f"about {pairs}") for name in errors]


def _impossible(
    propeller: Propeller, air: Air, w: Floats, v: Floats, b: Floats, known: Mapping[str, Floats]
) -> str:
    """Say what of the loads no propeller can do; empty where there is nothing."""
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
    return f"the air gets {share:.3g} times the power on the shaft" if share > ENERGY_MARGIN else ""


def _pulls_too_fast(
    propeller: Propeller, air: Air, w: Floats, v: Floats, b: Floats, known: Mapping[str, Floats]
) -> list[str]:
    """Warn of a propeller that pulls faster than its pitch moves: the speed's unit is wrong."""
    if "thrust" not in known:
        return []
    at_rest = estimated_loads(propeller, air, w, np.zeros_like(w))["thrust"]
    pulling = known["thrust"] > WEAK * np.maximum(at_rest, np.nanmax(known["thrust"] / w**2) * w**2)
    rows = pulling & (v > 0.0) & (np.cos(b) > AXIAL)
    if not rows.any():
        return []
    along = v[rows] * np.cos(b[rows]) / (w[rows] * propeller.radius)
    farthest = float(np.max(along)) / max(pitch_ratio(propeller), 1e-3)
    if farthest <= PULLING:
        return []
    errors = unit_errors(farthest, Range(0.5, PULLING), UNIT_ERRORS["speed"])
    like = looks_like(errors, "the speed") or "check speed, rpm and beta"
    return [f"it pulls at {farthest:.3g} times the speed of the blade's pitch; {like}"]


def _beta_from_the_disk(
    propeller: Propeller, w: Floats, v: Floats, b: Floats, known: Mapping[str, Floats]
) -> list[str]:
    """Warn of axial flow with loads of edgewise flow, or the reverse: beta from the disk plane."""
    axial = (v > 0.0) & (np.abs(np.cos(b)) > AXIAL)
    edgewise = (v > 0.0) & (np.abs(np.cos(b)) < EDGEWISE)
    cause = "beta looks as if measured from the disk plane, 0 is along the axis here"
    thrust = known.get("thrust", np.full_like(w, np.nan))
    if "drag" in known:
        across = np.abs(known["drag"]) / np.maximum(np.abs(thrust), 1e-9)
        across = across[axial & np.isfinite(across)]
        if across.size and float(np.median(across)) > DRAG_SHARE:
            return [f"there is drag in the disk plane in axial flow; {cause}"]
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
            return [f"in fast {flow} flow thrust is {kept:.2g} times that at rest; {cause}"]
    return []
