"""Warnings of implausible blades, air, operating points and loads, with likely unit errors."""

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
from propmap.units import RPM, SPEED_OF_SOUND

# -------------------------------------------------------------------------------------------------
# Usual ranges of small propellers.
#
# They include all blades of the catalogue and the 134 sets of loads in the UIUC Propeller Database
# that have a geometry (Brandt, Deters, Ananda, Dantsker, Selig, volumes 1 to 3), with a margin.  So
# a value outside its range is unlike all measured ones and needs a warning.
# ``tests/catalogue/test_nothing_is_doubted.py`` compares the ranges with these data.

RADIUS = Range(0.012, 2.0)  # [m]; measured 0.028 to 0.36
CHORD = Range(0.09, 0.40)  # over the radius, at 0.75 of the radius; measured 0.10 to 0.35
TWIST = Range(3.0, 40.0)  # [deg] at 0.75 of the radius; measured 7 to 25
DENSITIES = Range(0.3, 1.6), "density", Range(0.9, 1.45)
"""Air density [kg/m^3]: usual range, from 12 km altitude to a cold day at sea level; name of the
quantity; range of likely values."""
VISCOSITIES = Range(1e-5, 2.5e-5), "viscosity", Range(1.4e-5, 2.2e-5)
"""Viscosity of air [Pa s]: usual range, from -80 to 150 degrees Celsius; name of the quantity;
range of likely values."""
TIP_SPEED = Range(8.0, 255.0)  # of the fastest point [m/s]: measured 26 to 216; 255 is Mach 0.75
LIKELY_TIP_SPEED = Range(25.0, 220.0)
ADVANCE = Range(0.02, 0.7)  # airspeed over tip speed of usual flights; measured up to 0.5
LOAD_RATIO = Range(1.0 / 2.3, 2.3)
"""Measured load over the estimate from chord and twist.  Medians of UIUC's 134 sets are 0.6 to
1.6 for thrust and 0.55 to 2.0 for torque."""
WRONG_LOAD_RATIO = Range(1.0 / 1.5, 1.5)  # narrower, for loads that are known to be wrong
WIDE_LOAD_RATIO = Range(1.0 / 3.5, 3.5)  # wider, for loads that nothing else explains

MOST_FOR_THRUST, LEAST_FOR_THRUST = (1.4, 1.95), 0.7
"""Limits of the torque ratio (torque over its estimate) divided by the thrust ratio; these sets
have 0.81 to 1.85.  The first limit applies if power was measured; two sets exceed it."""
GOOD_ROTOR = 0.8
"""Ratio of ideal power to shaft power above which a large thrust is doubted.  In hover, the ratio
of a good large propeller is 0.7 to 0.75.  The thrust of two rotors multiplies the ratio by 2.8."""

FAST_TIP_MACH = 0.75  # above, the drag of thick sections rises, which no section law includes
PITCH_STATION = 0.75  # share of the radius at which chord and twist represent the blade
PULLING, WINDMILLING = 1.6, 2.0
"""Limits of the axial speed divided by the pitch speed, the speed of a screw with the pitch of the
blade.  Up to the first limit, a propeller pulls (measured 1.35 at a quarter of the largest thrust).
Above the second limit, it is a windmill."""

RADIANS_WITHIN = 1e-3  # tolerance for a multiple of 5 degrees in radians


# --- Warnings on a blade, the air and operating points -------------------------------------------


def blade_warnings(propeller: Propeller) -> list[str]:
    """Warn of radius, chord or twist unusual for small propellers, and twist rising to the tip."""
    radius = propeller.radius
    chord, twist = at_share(propeller, PITCH_STATION)
    found = unusual("the radius", radius, "m", RADIUS, "length", LIKELY_RADIUS)
    usual = CHORD, "chord over radius"
    found += unusual("the chord at 0.75 of the radius", chord / radius, "radii", *usual)
    others = (at_share(propeller, share)[1] for share in (0.4, 0.9))
    degrees, inner, outer = map(math.degrees, (twist, *others))
    if degrees < 0.0 and inner < outer:
        sign = "the twist is negative and rises toward the tip; it looks like the wrong sign"
        return [*found, sign]
    if inner < outer - 1.0:
        like = "its rows seem to run from the tip to the root"
        if degrees > TWIST.high:
            like = "it seems to be measured from the axis, not from the disk plane"
        rise = f"the twist rises from {inner:.3g} to {outer:.3g} deg"
        return [*found, f"{rise} between 0.4 and 0.9 of the radius; {like}"]
    return [*found, *unusual("the twist at 0.75 of the radius", degrees, "deg", TWIST, "twist")]


def air_warnings(air: Air) -> list[str]:
    """Warn of a density or viscosity outside the range of the air in which propellers operate."""
    found = unusual("the air density", air.density, "kg/m^3", *DENSITIES)
    return found + unusual("the viscosity", air.viscosity, "Pa s", *VISCOSITIES)


def point_warnings(propeller: Propeller, omega: Floats, speed: Floats, beta: Floats) -> list[str]:
    """Warn of operating points [rad/s], [m/s], [rad] (n,) that are unusual for small propellers.

    Raise ``InputError`` for a tip speed above the speed of sound, where no model is valid.
    """
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
    """Return the pitch speed of the blade divided by the tip speed [-]."""
    return PITCH_STATION * math.tan(at_share(propeller, PITCH_STATION)[1])


def _fast_tip(tip: Floats, speed: Floats) -> list[str]:
    """Warn of the fastest tip above Mach 0.75, raise ``InputError`` above Mach 1."""
    helical = np.hypot(tip, speed)
    k = int(np.argmax(helical))
    mach = float(helical[k]) / SPEED_OF_SOUND
    if mach <= FAST_TIP_MACH:
        return []
    motion = f"the tip moves at {helical[k]:.4g} m/s, Mach {mach:.3g}: {tip[k]:.4g} m/s from "
    motion += f"the rotation, {speed[k]:.4g} m/s from the flight"
    if speed[k] > tip[k]:
        like = likely_cause(float(speed[k]), Range(1.0, 130.0), "speed", "the speed")
    else:
        usual = Range(40.0, 130.0)
        like = likely_cause(float(tip[k]), usual, "fast rotation", "the rotational speed")
        like += ", or the radius looks like a diameter" if like else ""
    if mach > 1.0:
        remedy = "check rpm, speed and radius: propmap has no model above Mach 1"
        raise InputError(motion + like, remedy)
    drag = f"the section law does not include the drag rise above Mach {FAST_TIP_MACH:g}"
    return [f"{motion}; {drag}{like}"]


def _unlike_speeds(pitch: float, tip: Floats, speed: Floats, beta: Floats) -> list[str]:
    """Warn of slow tips, and of flight too fast for the tip speed or for the ``pitch`` ratio."""
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
        fast = f"the speed along the axis is {along:.3g} times the pitch speed"
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
    """Warn of radians in place of degrees: multiples of 5 degrees that were converted twice."""
    degrees = np.sort(np.abs(np.degrees(beta)), axis=None)
    nonzero = degrees[degrees > 1e-9]
    step = math.radians(5.0)
    if not nonzero.size or nonzero[-1] > math.pi + RADIANS_WITHIN:
        return []
    off = np.abs(nonzero - step * np.round(nonzero / step))
    if (off > RADIANS_WITHIN).any() or (np.abs(nonzero - np.round(nonzero)) < 1e-9).any():
        return []
    return [f"the largest beta is {nonzero[-1]:.5g} deg; it looks like radians"]


# -------------------------------------------------------------------------------------------------
# Consistency of measured loads with the blade: unit errors, signs, angles.
#
# Chord and twist at 0.75 of the radius predict thrust and torque in axial flow within a factor of
# two, so a larger difference indicates wrong units.

SLOW = 0.6  # axial speed over pitch speed up to which the estimate of the loads is useful
AXIAL, EDGEWISE = 0.9, 0.3  # |cos(beta)|: axial flow above the first, edgewise below the second

LIFT_SLOPE, ZERO_LIFT, DRAG = 5.5, math.radians(-4.0), 0.03
INDUCED = 1.25
SMALL_BLADES = 0.68  # median of measured loads over the unscaled estimate, 134 propellers
IMPOSSIBLE_COEFFICIENT = 0.75  # C_T and C_P, three times the largest measured value
ENERGY_MARGIN = 1.15  # ideal power over shaft power that no measurement error explains
WEAK = 0.25  # share of the thrust at low speed below which a row does not count as pulling
ACROSS = 0.1  # V sin(beta) above which the flow is oblique and a drag column is rotor drag [m/s]
DRAG_SHARE = 0.02  # drag over thrust that does not occur in axial flow
AXIAL_KEEPS, EDGEWISE_KEEPS = 0.8, 0.5
"""Limits at 0.7 of the pitch speed, as shares of the static thrust: largest thrust in axial flow
(measured at most 0.52), and smallest thrust in edgewise flow (measured more than 1)."""


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

    ``by_power``: the torque was measured as power.  Raise ``InputError`` for impossible loads,
    because constants fitted to them would be meaningless.
    """
    turning = omega > 0.0
    w, v, b = omega[turning], speed[turning], beta[turning]
    known = {n: loads[n][turning] for n in loads if np.isfinite(loads[n][turning]).any()}
    if not w.size or not {"thrust", "torque"} & set(known):
        return []
    ratios = _over_estimates(propeller, air, w, v, b, known)
    backwards = [name for name in ratios if ratios[name] < 0.0]
    if backwards:
        return [f"{name} is negative near V = 0; its sign looks reversed" for name in backwards]
    drag = known.get("drag", np.full_like(w, np.nan))
    drag = drag[np.isfinite(drag) & (v * np.abs(np.sin(b)) > ACROSS)]
    if 2 * np.count_nonzero(drag < 0.0) > drag.size:
        fault = "the rotor drag is negative in most rows of oblique flow"
        raise InputError(fault, "change its sign: drag is the force against the in-plane velocity")
    found = _wrong_size(ratios, LOAD_RATIO, by_power=by_power)
    share = _ideal_share(propeller, air, w, v, b, known)
    proportion = _out_of_proportion(ratios, share, by_power=by_power)
    if found and by_power and ELECTRICAL_POWER not in found[0]:
        found += [text for text in proportion if ELECTRICAL_POWER in text]
    found = found or [
        *_negative_at_rest(v, known),
        *proportion,
        # One mistake is more likely than two.
        *(
            _pulls_too_fast(propeller, air, w, v, b, known)
            or _beta_from_the_disk(propeller, w, v, b, known)
        ),
    ]
    impossible = _impossible(propeller, air, w, v, known, share)
    if impossible:
        found = found or _wrong_size(ratios, WRONG_LOAD_RATIO, by_power=by_power)
        remedy = "correct units, divide totals by the number of rotors, or name the right propeller"
        raise InputError("; ".join([impossible, *found]), remedy)
    return found


def estimated_loads(
    propeller: Propeller, air: Air, omega: Floats, axial: Floats
) -> dict[str, Floats]:
    """Estimate thrust [N] and torque [N m] in axial flow (n,) up to the pitch speed.

    Blade-element momentum theory at 0.75 R (J. G. Leishman, Principles of Helicopter Aerodynamics,
    2nd ed., Cambridge 2006, section 3.3), scaled to small propellers, is within a factor of two.
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


def _over_estimates(
    propeller: Propeller, air: Air, w: Floats, v: Floats, b: Floats, known: Mapping[str, Floats]
) -> dict[str, float]:
    """Return measured thrust and torque over their estimates, as medians of the slowest rows."""
    share = v / (w * propeller.radius)
    reach = SLOW * abs(pitch_ratio(propeller))
    found = {}
    for name in ("thrust", "torque"):
        if name in known:
            measured = np.isfinite(known[name])
            rows = measured & (share <= reach)
            # If all rows are fast, use the slowest tenth, with the speed clipped to the estimate.
            if not rows.any():
                rows = measured & (share <= np.percentile(share[measured], 10.0))
            climb = np.clip(share * np.cos(b), 0.0, reach)[rows] * w[rows] * propeller.radius
            estimate = estimated_loads(propeller, air, w[rows], climb)[name]
            found[name] = float(np.median(known[name][rows] / estimate))
    return found


def _negative_at_rest(speed: Floats, known: Mapping[str, Floats]) -> list[str]:
    """Warn of single negative rows at rest."""
    found = []
    for name in ("thrust", "torque"):
        still = known[name][speed == 0.0] if name in known else np.empty(0)
        count = int(np.count_nonzero(still < 0.0))
        if count:
            rows = f"{count} of {still.size} rows at rest"
            found.append(f"{name} is negative in {rows}; check the sign")
    return found


def _wrong_size(ratios: Mapping[str, float], usual: Range, *, by_power: bool) -> list[str]:
    """Return one warning of all ratios outside the range, with the likely unit errors."""
    odd = [name for name, ratio in ratios.items() if ratio not in usual]
    if not odd:
        return []
    names = {name: "power" if by_power and name == "torque" else name for name in ratios}
    sizes = " and ".join(
        f"{names[name]} is {ratio:.3g} times the estimate for this blade"
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
    shared = looks_like(_sized(likely, middle), "the measurement")
    # One mistake is more likely than two.  With one measured load, both kinds of errors explain it.
    if shared and (len(odd) > 1 or len(ratios) == 1 or not causes):
        causes = [*causes, shared] if len(ratios) == 1 else [shared]
    said = ", or ".join(causes) or "check units, radius and rpm"
    return [f"{sizes}; {said}, or another propeller was measured"]


def _out_of_proportion(ratios: Mapping[str, float], ideal: float, *, by_power: bool) -> list[str]:
    """Return warnings of a thrust and a torque that are plausible alone but not together; ``ideal``
    is the ratio of ideal power to shaft power."""
    # The warning of a wrong size names a load that is zero.
    if not {"thrust", "torque"} <= set(ratios) or 0.0 in ratios.values():
        return []
    share = ratios["torque"] / ratios["thrust"]
    if share > MOST_FOR_THRUST[not by_power]:
        name = "power" if by_power else "torque"
        causes = [ELECTRICAL_POWER] if by_power else [ROTORS, ELECTRICAL_POWER]
    elif share < LEAST_FOR_THRUST and ideal > GOOD_ROTOR:
        name, share, causes = "thrust", 1.0 / share, [ROTORS]
    else:
        return []
    other = "torque" if name == "thrust" else "thrust"
    times = f"{name} is {share:.3g} times the value for this blade at its {other}"
    said = " or ".join(_sized(causes, share))
    return [f"{times}; it may be {said}, or another propeller was measured"]


def _errors_of(quantity: str, ratio: float) -> list[str]:
    """Return the likely errors of one load: unit, number of rotors, or kind of power."""
    errors: list[tuple[str, Sequence[float]]] = [
        (name, (factor,)) for name, factor in UNIT_ERRORS[quantity].items()
    ]
    errors += [(ROTORS, (float(count),)) for count in (2, 3, 4, 6, 8)]
    if quantity != "thrust":
        errors += [(ELECTRICAL_POWER, (factor,)) for factor in (1.5, 2.0, 3.0, 5.0, 8.0)]
    return common_errors((ratio,), LOAD_RATIO, errors)


def _sized(errors: Iterable[str], ratio: float) -> list[str]:
    """Return the names of ``errors`` with the numbers that follow from ``ratio``."""
    rotors = min((2, 3, 4, 6, 8), key=lambda count: abs(math.log(max(ratio, 1e-9) / count)))
    pairs = max(2, round(max(ratio, 1e-9) ** -0.5))
    return [name.format(rotors=f"about {rotors}", pairs=f"about {pairs}") for name in errors]


def _impossible(
    propeller: Propeller,
    air: Air,
    w: Floats,
    v: Floats,
    known: Mapping[str, Floats],
    ideal: float,
) -> str:
    """Return the property of the loads that is impossible for a propeller; empty without any."""
    turns, diameter = w / (2.0 * math.pi), propeller.diameter
    force = air.density * turns**2 * diameter**4
    sizes = {"thrust": ("C_T", force), "torque": ("C_P", force * diameter / (2.0 * math.pi))}
    for name, (symbol, size) in sizes.items():
        if name in known:
            value = float(np.nanmedian(known[name] / size))
            most = "at most 0.25 for all propellers measured"
            if value > IMPOSSIBLE_COEFFICIENT:
                return f"{symbol} is {value:.3g}, but {most}"
            # At low rotational speeds, errors of the balance may exceed the load, and the
            # coefficients of a windmill are large: such rows are not checked.
            measured = np.abs(known[name])
            rows = (measured > IMPOSSIBLE_COEFFICIENT * size) & (v < turns * diameter)
            rows &= measured > np.nanmedian(measured)
            if rows.any():
                k = int(np.flatnonzero(rows)[0])
                where = f"at {w[k] / RPM:.0f} rpm and {v[k]:g} m/s"
                return f"{where}, {symbol} is {known[name][k] / size[k]:.3g}, but {most}"
    fault = f"the ideal power is {ideal:.3g} times the shaft power, which is impossible"
    return fault if ideal > ENERGY_MARGIN else ""


def _ideal_share(
    propeller: Propeller, air: Air, w: Floats, v: Floats, b: Floats, known: Mapping[str, Floats]
) -> float:
    """Return the median ratio of ideal power to shaft power [-]; 0 without thrust or torque."""
    if not {"thrust", "torque"} <= set(known):
        return 0.0
    thrust, power = known["thrust"], known["torque"] * w
    rows = (thrust > 0.0) & (power > 0.0)
    if not rows.any():
        return 0.0
    along, disk = v[rows] * np.cos(b[rows]), math.pi * propeller.radius**2
    across = v[rows] * np.sin(b[rows])
    # Glauert's momentum equation (10) for a uniform inflow, which needs the least power.
    induced = np.zeros_like(along)
    most = 1e6 * air.density * disk  # thrust [N] of a hover inflow of 700 m/s; prevents overflow
    for _ in range(60):
        flow = np.hypot(along + induced, across)
        step = np.minimum(thrust[rows], most) / (2.0 * air.density * disk * np.maximum(flow, 1e-9))
        induced = 0.5 * (induced + np.minimum(step, 1e6))
    return float(np.median(thrust[rows] * (along + induced) / power[rows]))


def _pulls_too_fast(
    propeller: Propeller, air: Air, w: Floats, v: Floats, b: Floats, known: Mapping[str, Floats]
) -> list[str]:
    """Warn of a propeller that pulls far above its pitch speed: the unit of the speed is wrong."""
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
    return [f"the propeller pulls at {farthest:.3g} times its pitch speed; {like}"]


def _beta_from_the_disk(
    propeller: Propeller, w: Floats, v: Floats, b: Floats, known: Mapping[str, Floats]
) -> list[str]:
    """Warn of axial flow with loads of edgewise flow, or the reverse.

    Then beta was likely measured from the disk plane.
    """
    axial = (v > 0.0) & (np.abs(np.cos(b)) > AXIAL)
    edgewise = (v > 0.0) & (np.abs(np.cos(b)) < EDGEWISE)
    cause = "beta seems to be measured from the disk plane; propmap measures it from the axis"
    thrust = known.get("thrust", np.full_like(w, np.nan))
    if "drag" in known:
        across = np.abs(known["drag"]) / np.maximum(np.abs(thrust), 1e-9)
        across = across[axial & np.isfinite(across)]
        if across.size and float(np.median(across)) > DRAG_SHARE:
            return [f"the rotor drag is not zero in axial flow; {cause}"]
    # Divide the speed by the pitch speed, to find the rows that are fast if the flow is axial.
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
        # Axial flow decreases the thrust, edgewise flow increases it.
        if kept > AXIAL_KEEPS if flow == "axial" else kept < EDGEWISE_KEEPS:
            return [f"in fast {flow} flow the thrust is {kept:.2g} times static thrust; {cause}"]
    return []
