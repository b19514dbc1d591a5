"""Whether measured loads fit the blade they are said to be of: slips of units, signs, angles.

Chord and twist at 0.75 of the radius give thrust and torque in axial flow within a factor of two
(``estimated_loads``), so that a load out by more is in other units; which, the factors of
``propmap.model.usual_ranges`` tell.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from propmap.errors import InputError
from propmap.model.plausible import PITCH_STATION, at_share, pitch_ratio
from propmap.model.usual_ranges import (
    IMPOSSIBLE_COEFFICIENT,
    LOAD_RATIO,
    PITCH_SPEED_RATIO,
    RPM_PER_RADIAN,
    SPEED_SLIPS,
    THRUST_SLIPS,
    TORQUE_SLIPS,
    Range,
    likely_slips,
)

if TYPE_CHECKING:
    from propmap.model.air import Air
    from propmap.model.propeller import Propeller
    from propmap.typing import Floats

SLOW = 0.6
"""Axial speed over the blade's pitch speed, up to which an estimate of the loads is any good."""

AXIAL, EDGEWISE = 0.9, 0.3
"""|cos(beta)| above which flow counts as axial, and below which as edgewise."""

LIFT_SLOPE, ZERO_LIFT, DRAG = 5.5, math.radians(-4.0), 0.03
INDUCED = 1.25
SMALL_BLADES = 0.68
"""Measured loads over the estimate without this factor: the median of 134 propellers."""

NARROW_LOAD_RATIO = Range(1.0 / 1.5, 1.5)
"""The same where loads are known to be wrong."""

ENERGY_MARGIN = 1.15
"""Ideal power over shaft power, above which no error of measurement explains it."""

WEAK = 0.25
"""Share of the slow thrust below which rows do not tell how far a propeller pulls."""

DRAG_SHARE = 0.02
"""Drag over thrust that no axial flow has."""

AXIAL_KEEPS, EDGEWISE_KEEPS = 0.8, 0.5
"""Of the thrust at rest, the most that is left at 0.7 of the pitch speed along the axis, and the
least at this speed across it; measured at most 0.52, and more than 1."""

Loads = Mapping[str, "Floats"]

SHARED_SLIPS: tuple[tuple[str, float, float], ...] = (
    ("rpm like rad/s", RPM_PER_RADIAN**2, RPM_PER_RADIAN**2),
    ("rpm like revolutions per second", 3600.0, 3600.0),
    ("rpm converted from rad/s twice", RPM_PER_RADIAN**-2, RPM_PER_RADIAN**-2),
    ("a radius like the diameter", 1.0 / 16.0, 1.0 / 32.0),
    ("a diameter like the radius", 16.0, 32.0),
    *(("electrical rpm", pairs**-2.0, pairs**-2.0) for pairs in (4, 6, 7, 11)),
    ("coefficients over rho A (Omega R)^2", 4.0 / math.pi**3, 4.0 / math.pi**4),
)
"""What takes thrust and torque out of their ranges together, and the factors of both."""


def doubts_on_loads(
    propeller: Propeller, air: Air, omega: Floats, speed: Floats, beta: Floats, loads: Loads
) -> list[str]:
    """What does not fit the blade, with the likely cause; mostly nothing.

    Parameters
    ----------
    propeller, air : Propeller, Air
        Of the test.
    omega, speed, beta : ndarray, shape (n,)
        [rad/s], [m/s] and [rad].
    loads : mapping of str to ndarray, shape (n,)
        Measured, by their names in ``propmap.loads.LOADS`` [N], [N m]; NaN where not measured.

    Raises
    ------
    InputError
        Where loads cannot be: more power in the slipstream than on the shaft, or a coefficient
        three times the largest that has been measured.  Constants fitted to such loads mean
        nothing.
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
    found = _doubts_on_size(ratios, LOAD_RATIO) or [
        *_doubts_on_signs(v, known),
        *_doubts_on_reach(propeller, air, w, v, b, known),
        *_doubts_on_direction(propeller, w, v, b, known),
    ]
    impossible = _impossible(propeller, air, w, v, b, known)
    if impossible:
        found = found or _doubts_on_size(ratios, NARROW_LOAD_RATIO)
        raise InputError("; ".join([impossible, *found]), "convert what is in another unit")
    return found


def estimated_loads(
    propeller: Propeller, air: Air, omega: Floats, axial: Floats
) -> dict[str, Floats]:
    """Thrust [N] and torque [N m] of a blade in axial flow, within a factor of two.

    Momentum and blade element at 0.75 of the radius, with a linear lift (J. G. Leishman,
    Principles of Helicopter Aerodynamics, 2nd ed., Cambridge 2006, section 3.3), scaled to small
    propellers.

    Parameters
    ----------
    propeller, air : Propeller, Air
        Of the test.
    omega, axial : ndarray, shape (n,)
        [rad/s] and V cos(beta) [m/s], not above the blade's pitch speed.
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
    """Medians of thrust and torque over their estimates, in the rows nearest to rest."""
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


def _doubts_on_signs(speed: Floats, known: Loads) -> list[str]:
    """Single rows at rest with a sign that the others do not have."""
    found = []
    for name in ("thrust", "torque"):
        still = known[name][speed == 0.0] if name in known else np.empty(0)
        count = int(np.count_nonzero(still < 0.0))
        if count:
            rows = f"{count} of {still.size} rows at rest"
            found.append(f"{name} is negative in {rows}; check its sign")
    return found


def _doubts_on_size(ratios: Mapping[str, float], usual: Range) -> list[str]:
    """The slips that explain ratios of which one at least is out of a range, in one text."""
    columns = {"thrust": THRUST_SLIPS, "torque": TORQUE_SLIPS}
    odd = {name: ratio for name, ratio in ratios.items() if ratio not in usual}
    if not odd:
        return []
    told = " and ".join(
        f"{name} is {ratio:.3g} times what such a blade gives" for name, ratio in ratios.items()
    )
    own = [
        f"{name} looks like {' or '.join(slip.like for slip in slips)}"
        for name, ratio in odd.items()
        if (slips := likely_slips(ratio, LOAD_RATIO, columns[name]))
    ]
    shared = _shared_slips(ratios)
    # One mistake is likelier than two; with one load measured, both kinds explain it.
    if shared and (len(odd) > 1 or len(ratios) == 1):
        own = [*own, *shared] if len(ratios) == 1 else shared
    return [f"{told}; {', or '.join(own or shared) or 'check units, radius and rpm'}"]


def _shared_slips(ratios: Mapping[str, float]) -> list[str]:
    """Slips that bring all loads into their ranges, likeliest first, in one text."""
    far: dict[str, float] = {}
    for like, thrust, torque in SHARED_SLIPS:
        factors = {"thrust": thrust, "torque": torque}
        mended = [ratio / factors[name] for name, ratio in ratios.items()]
        if all(value in LOAD_RATIO for value in mended):
            distance = sum(LOAD_RATIO.distance(value) for value in mended)
            far[like] = min(distance, far.get(like, math.inf))
    return [f"it looks like {' or '.join(sorted(far, key=far.__getitem__))}"] if far else []


def _impossible(
    propeller: Propeller, air: Air, w: Floats, v: Floats, b: Floats, known: Loads
) -> str:
    """What no propeller can do, or nothing."""
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


def _doubts_on_reach(
    propeller: Propeller, air: Air, w: Floats, v: Floats, b: Floats, known: Loads
) -> list[str]:
    """A propeller that pulls faster than its pitch moves: the speeds are in another unit."""
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
    slips = [slip for slip in SPEED_SLIPS if 0.5 < farthest / slip.factor <= PITCH_SPEED_RATIO]
    like = f"the speed looks like {slips[0].like}" if slips else "check speed, rpm and beta"
    return [f"it pulls at {farthest:.3g} times the speed of the blade's pitch; {like}"]


def _doubts_on_direction(
    propeller: Propeller, w: Floats, v: Floats, b: Floats, known: Loads
) -> list[str]:
    """Axial flow with the loads of edgewise flow, or the reverse: beta from the disk plane."""
    axial = (v > 0.0) & (np.abs(np.cos(b)) > AXIAL)
    edgewise = (v > 0.0) & (np.abs(np.cos(b)) < EDGEWISE)
    told = "beta looks as if measured from the disk plane, 0 is along the axis here"
    thrust = known.get("thrust", np.full_like(w, np.nan))
    if "drag" in known:
        across = np.abs(known["drag"]) / np.maximum(np.abs(thrust), 1e-9)
        across = across[axial & np.isfinite(across)]
        if across.size and float(np.median(across)) > DRAG_SHARE:
            return [f"there is drag in the disk plane in axial flow; {told}"]
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
            return [f"in fast {flow} flow thrust is {kept:.2g} times that at rest; {told}"]
    return []
