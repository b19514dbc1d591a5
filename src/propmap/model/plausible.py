"""Whether a blade, the air and operating points are like those of small propellers, in words."""

from __future__ import annotations

import math
from statistics import median  # without numpy.ma, which takes longer to load than one point
from typing import TYPE_CHECKING

import numpy as np

from propmap.errors import InputError
from propmap.model.usual_ranges import (
    CHORD,
    CHORD_SLIPS,
    DENSITY,
    DENSITY_SLIPS,
    FAST_SLIPS,
    FAST_TIP_MACH,
    LENGTH_SLIPS,
    PITCH_SPEED_RATIO,
    RADIUS,
    SLOW_SLIPS,
    SPEED_OF_SOUND,
    SPEED_SLIPS,
    TIP_SPEED,
    TWIST,
    VISCOSITY,
    VISCOSITY_SLIPS,
    Range,
    guessed,
    likely_slips,
)

if TYPE_CHECKING:
    from propmap.model.air import Air
    from propmap.model.propeller import Propeller
    from propmap.typing import Floats

PITCH_STATION = 0.75
"""Share of the radius at which chord and twist stand for the blade."""

ADVANCE = Range(0.02, 0.7)
"""Flight speed over tip speed, of usual flights; measured up to 0.5."""

WINDMILLING = 2.0
"""Axial speed over the blade's pitch speed, beyond which a propeller is a windmill."""

USUAL_TIP_SPEED = Range(25.0, 220.0)
"""[m/s], that a correction of the rotational speed should lead to."""

RADIANS_WITHIN = 1e-3
"""Closeness to a multiple of 5 degrees in radians."""


def doubts_on_blade(propeller: Propeller) -> list[str]:
    """What is unlike the blades of small propellers, with the likely cause; mostly nothing.

    Judged are the radius, the chord and the twist at 0.75 of it, and whether the twist falls
    towards the tip, as it does on every blade of the catalogue.
    """
    radius, found = propeller.radius, []
    if radius not in RADIUS:
        found.append(
            f"the radius is {radius:.4g} m, those of small propellers are {RADIUS.low:g} to "
            f"{RADIUS.high:g} m" + guessed(radius, Range(0.025, 0.4), LENGTH_SLIPS)
        )
    chord, twist = at_share(propeller, PITCH_STATION)
    if chord / radius not in CHORD:
        found.append(
            f"the chord is {100.0 * chord / radius:.3g} % of the radius at 0.75 of it, those of "
            f"small propellers are {100.0 * CHORD.low:g} to {100.0 * CHORD.high:g} %"
            + guessed(chord / radius, CHORD, CHORD_SLIPS)
        )
    degrees, inner, outer = (
        math.degrees(angle)
        for angle in (twist, at_share(propeller, 0.4)[1], at_share(propeller, 0.9)[1])
    )
    if degrees < 0.0 and inner < outer:
        cause = "the twist is negative and rises towards the tip; it looks like the wrong sign"
        found.append(cause)
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


def doubts_on_air(air: Air) -> list[str]:
    """What is unlike the air that propellers turn in, with the likely cause; mostly nothing."""
    found = []
    if air.density not in DENSITY:
        found.append(
            f"the air density is {air.density:.4g} kg/m^3, near the ground it is about 1.2"
            + guessed(air.density, Range(0.9, 1.45), DENSITY_SLIPS)
        )
    if air.viscosity not in VISCOSITY:
        found.append(
            f"the viscosity is {air.viscosity:.4g} Pa s, that of air is about 1.8e-5"
            + guessed(air.viscosity, Range(1.4e-5, 2.2e-5), VISCOSITY_SLIPS)
        )
    return found


def doubts_on_points(propeller: Propeller, omega: Floats, speed: Floats, beta: Floats) -> list[str]:
    """What is unlike the operating points of small propellers, with the likely cause.

    Parameters
    ----------
    propeller : Propeller
        Whose radius and pitch count.
    omega, speed, beta : ndarray, shape (n,)
        [rad/s], [m/s] and [rad], or shapes that broadcast to it.

    Raises
    ------
    InputError
        Where a blade tip moves faster than sound: neither the momentum theory nor any section law
        here holds, and there is no number to give.
    """
    w, v, b = (np.ravel(values) for values in np.broadcast_arrays(omega, speed, beta))
    tip = w * propeller.radius
    fast = _doubts_on_mach(tip, v)
    if fast:
        return fast
    return [*_doubts_on_speeds(propeller, tip, v, b), *_doubts_on_angle(b)]


def at_share(propeller: Propeller, share: float) -> tuple[float, float]:
    """Chord [m] and twist [rad] at a share of the radius."""
    place = share * propeller.radius
    chord, twist = (
        float(np.interp(place, propeller.station, values))
        for values in (propeller.chord, propeller.twist)
    )
    return chord, twist


def pitch_ratio(propeller: Propeller) -> float:
    """Speed of a screw with the blade's pitch over the tip speed [-]."""
    return PITCH_STATION * math.tan(at_share(propeller, PITCH_STATION)[1])


def _doubts_on_mach(tip: Floats, speed: Floats) -> list[str]:
    helical = np.hypot(tip, speed)
    k = int(np.argmax(helical))
    mach = float(helical[k]) / SPEED_OF_SOUND
    if mach <= FAST_TIP_MACH:
        return []
    told = (
        f"the tip moves at {helical[k]:.4g} m/s, Mach {mach:.3g}, with {tip[k]:.4g} m/s from the "
        f"rotation and {speed[k]:.4g} m/s from the flight"
    )
    like = ""
    if speed[k] > tip[k]:
        like = guessed(float(speed[k]), Range(1.0, 130.0), SPEED_SLIPS, "the speed")
    else:
        like = guessed(float(tip[k]), Range(40.0, 130.0), FAST_SLIPS, "the rotational speed")
        like += ", or the radius like the diameter" if like else ""
    if mach > 1.0:
        raise InputError(
            f"{told}{like}", "check rpm, speed and radius: nothing here holds above Mach 1"
        )
    return [
        f"{told}; above {FAST_TIP_MACH:g} drag rises, which the section law does not have{like}"
    ]


def _doubts_on_speeds(propeller: Propeller, tip: Floats, speed: Floats, beta: Floats) -> list[str]:
    turning = tip > 0.0
    if not turning.any():
        return []
    flying = turning & (speed > 0.0)
    fastest = float(tip.max())
    if fastest < TIP_SPEED.low:
        like = guessed(fastest, USUAL_TIP_SPEED, SLOW_SLIPS, "the rotational speed")
        return [f"the tip speed is {fastest:.3g} m/s at most, very slow{like}"]
    if not flying.any():
        return []
    share = speed[flying] / tip[flying]
    advance = median(share.tolist())
    along = median((share * np.cos(beta[flying])).tolist()) / max(pitch_ratio(propeller), 1e-3)
    if advance <= ADVANCE.high and along <= WINDMILLING:
        return []
    told = f"the speed is {advance:.3g} times the tip speed"
    if advance <= ADVANCE.high:
        told = f"the speed along the axis is {along:.3g} times the speed of the blade's pitch"
    for slip in likely_slips(fastest, USUAL_TIP_SPEED, SLOW_SLIPS):
        if fastest not in USUAL_TIP_SPEED and advance * slip.factor in ADVANCE:
            return [f"{told}; the rotational speed looks like {slip.like}"]
    for slip in likely_slips(advance, ADVANCE, SPEED_SLIPS):
        if along / slip.factor < PITCH_SPEED_RATIO:
            return [f"{told}; the speed looks like {slip.like}"]
    return [f"{told}; check rpm, speed and radius"]


def _doubts_on_angle(beta: Floats) -> list[str]:
    """Radians among degrees: the angles are then multiples of 5 degrees once more converted."""
    degrees = np.sort(np.abs(np.degrees(beta)), axis=None)
    nonzero = degrees[degrees > 1e-9]
    step = math.radians(5.0)
    if not nonzero.size or nonzero[-1] > math.pi + RADIANS_WITHIN:
        return []
    off = np.abs(nonzero - step * np.round(nonzero / step))
    if (off > RADIANS_WITHIN).any() or (np.abs(nonzero - np.round(nonzero)) < 1e-9).any():
        return []
    return [f"beta is {nonzero[-1]:.5g} deg at most; it looks like radians"]
