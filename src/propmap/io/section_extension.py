"""A section's polar continued all the way round, and polars brought to common angles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from propmap.errors import InputError
from propmap.typing import Floats

ASPECT_RATIO = 10.0
"""Of a propeller's blade, in Viterna's drag of a plate across the flow."""

BACKWARDS = 0.7
"""Lift of a section that the air meets from behind, as a share of the same section's ahead."""

STILL_RISING = 0.5
"""Slope of the lift at the last angle, as a share of the steepest, from which the polar is taken
to end before stall."""

STEP = np.radians(5.0)
CLOSED = np.radians(330.0)
"""A polar over so much of the circle lacks no more than its ends."""

APART = np.radians(0.05)
"""Angles of different polars nearer than that are one."""


class Polar(NamedTuple):
    """C_L and C_D [-] of one Reynolds number at rising angles from the chord line [rad]; (K,)."""

    reynolds: float
    angle: Floats
    lift: Floats
    drag: Floats


def all_round(polar: Polar, where: str) -> tuple[Polar, str]:
    """The polar from -180 to 180 degrees, and what was added to it in words.

    Past stall C_L and C_D follow Viterna and Corrigan: those of a finite plate, matched to the
    polar's last row.  Behind +-90 degrees the section is met from behind and has 0.7 of that lift;
    between the mirrored last row and the first one both are linear.

    Raises
    ------
    InputError
        Where the polar ends before stall, or past it but not at 180 degrees.

    References
    ----------
    L. A. Viterna and R. D. Corrigan, "Fixed Pitch Rotor Performance of Large Horizontal Axis Wind
    Turbines", NASA CP-2230, 1981.
    """
    ends = polar.angle[[0, -1]]
    if ends[1] - ends[0] >= CLOSED:
        return _closed(polar), ""
    low, high = np.degrees(ends).tolist()
    told = f"angles run from {low:g} to {high:g} deg"
    if not (-90.0 < low < high < 90.0 and high > 0.0):
        raise InputError(
            f"{told}, expected -180 to 180, or around 0 and a little past stall",
            "complete the table, or leave out what is far past stall",
            where,
        )
    slope = np.diff(polar.lift) / np.diff(polar.angle)
    if polar.lift[-1] <= 0.0 or slope[-1] > STILL_RISING * slope.max():
        raise InputError(
            f"{told} and the lift still rises at the last: stall is not in the polar",
            "compute or measure it to larger angles",
            where,
        )
    return _extended(polar), f"continued from {low:g} and {high:g} deg by Viterna's method"


def _closed(polar: Polar) -> Polar:
    """With rows at -180 and 180 degrees, which are one angle."""
    inner = np.abs(polar.angle) < np.pi - 1e-6
    turn = [polar.angle, polar.angle + 2.0 * np.pi]

    def ends(values: Floats) -> Floats:
        at = float(np.interp(np.pi, np.concatenate(turn), np.tile(values, 2)))
        return np.array([at, *values[inner], at])

    angle = np.array([-np.pi, *polar.angle[inner], np.pi])
    return Polar(polar.reynolds, angle, ends(polar.lift), ends(polar.drag))


def _extended(polar: Polar) -> Polar:
    first, last = float(polar.angle[0]), float(polar.angle[-1])
    largest = max(1.11 + 0.018 * ASPECT_RATIO, float(polar.drag.max()))
    sine, cosine = np.sin(last), np.cos(last)
    a2 = (polar.lift[-1] - largest * sine * cosine) * sine / cosine**2
    b2 = (polar.drag[-1] - largest * sine**2) / cosine

    def plate(angle: Floats) -> tuple[Floats, Floats]:
        s, c = np.sin(angle), np.cos(angle)
        return largest * s * c + a2 * c**2 / s, largest * s**2 + b2 * c

    def linear(share: Floats) -> Floats:
        """Lift of a section met from behind and near 180 degrees; share of the stall angle."""
        return BACKWARDS * float(polar.lift[-1]) * share

    past = np.arange(1.0, np.ceil(2.0 * np.pi / STEP)) * STEP
    ahead = past[(past > last + 0.2 * STEP) & (past < 0.5 * np.pi + 1e-9)]
    behind = past[(past > 0.5 * np.pi + 1e-9) & (past < np.pi - last)]
    edge = past[(past > np.pi - last) & (past < np.pi - 1e-9)]
    lift_a, drag_a = plate(ahead)
    lift_b, drag_b = plate(np.pi - behind)
    drag_e = plate(np.pi - edge)[1]
    upper = np.concatenate([ahead, behind, edge])
    lift = np.concatenate([lift_a, -BACKWARDS * lift_b, linear((edge - np.pi) / last)])
    drag = np.concatenate([drag_a, drag_b, drag_e])
    # The lower side is the upper one mirrored; between them and the polar lies one straight line.
    mirrored = np.concatenate([[last], ahead]) > -first + 0.2 * STEP
    lower = np.concatenate([[last], ahead])[mirrored]
    lift_l = -BACKWARDS * np.concatenate([polar.lift[-1:], lift_a])[mirrored]
    drag_l = np.concatenate([polar.drag[-1:], drag_a])[mirrored]
    back = np.concatenate([behind, edge])
    lift_k = np.concatenate([BACKWARDS * lift_b, -linear((edge - np.pi) / last)])
    drag_k = np.concatenate([drag_b, drag_e])
    least = float(polar.drag.min())
    end = [max(plate(np.array([1e-6]))[1][0], least)]
    return Polar(
        polar.reynolds,
        np.concatenate([[-np.pi], -back[::-1], -lower[::-1], polar.angle, upper, [np.pi]]),
        np.concatenate([[0.0], lift_k[::-1], lift_l[::-1], polar.lift, lift, [0.0]]),
        np.concatenate(
            [
                end,
                np.maximum(drag_k[::-1], least),
                np.maximum(drag_l[::-1], least),
                polar.drag,
                np.maximum(drag, least),
                end,
            ]
        ),
    )


def at_common_angles(polars: Sequence[Polar]) -> tuple[Floats, Floats, Floats]:
    """Angles (K,), C_L and C_D (R, K) of polars all round, linear between the rows of each."""
    angles = np.unique(np.concatenate([polar.angle for polar in polars]))
    kept = [float(angles[0])]
    for angle in angles[1:-1]:
        if angle - kept[-1] >= APART and np.pi - angle >= APART:
            kept.append(float(angle))
    angle = polars[0].angle if len(polars) == 1 else np.array([*kept, np.pi])
    lift = np.stack([np.interp(angle, polar.angle, polar.lift) for polar in polars])
    return angle, lift, np.stack([np.interp(angle, polar.angle, polar.drag) for polar in polars])
