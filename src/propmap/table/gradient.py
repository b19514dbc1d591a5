"""Derivatives of a table's loads, by the chain rule through J, beta and Omega^(-1/2)."""

from __future__ import annotations

import numpy as np

from propmap.arrays.types import Floats
from propmap.table.content import TableContent
from propmap.table.lookup import WIDTH, Lookup
from propmap.table.results import TORQUE

HARDLY_MOVING = 1e-7
"""Advance ratio below which d/dbeta over J, 0/0 at rest, is taken from its limit."""


def polar_gradient(
    content: TableContent, lookup: Lookup, omega: Floats, speed: Floats, beta: Floats, sign: Floats
) -> Floats:
    """Derivatives by omega, speed and beta, (n, L + 1, 3); sign : of the change of beta."""
    loads, by_omega, by_speed, by_angle = _derivatives(content, lookup, omega, speed, beta)
    by_beta = by_angle * (sign * speed)[:, None]
    return _with_power(loads, omega, np.stack([by_omega, by_speed, by_beta], axis=-1))


def velocity_gradient(
    content: TableContent,
    lookup: Lookup,
    omega: Floats,
    speed: Floats,
    beta: Floats,
    vx: Floats,
    vy: Floats,
) -> Floats:
    """Derivatives by omega and the velocity's components, (n, L + 1, 4)."""
    loads, by_omega, by_speed, by_angle = _derivatives(content, lookup, omega, speed, beta)
    cosine, sine = np.cos(beta)[:, None], np.sin(beta)[:, None]
    by_axial = by_speed * cosine - by_angle * sine
    by_inplane = by_speed * sine + by_angle * cosine
    across = np.hypot(vx, vy)
    moves = across > 0.0
    divisor = np.where(moves, across, 1.0)
    x, y = np.where(moves, vx / divisor, 1.0)[:, None], (vy / divisor)[:, None]
    each = np.stack([by_omega, by_inplane * x, by_inplane * y, by_axial], axis=-1)
    return _with_power(loads, omega, each)


def _derivatives(
    content: TableContent, lookup: Lookup, omega: Floats, speed: Floats, beta: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """Loads, and their derivatives with omega, with speed, and with beta over the speed; (n, L)."""
    tip_speed = omega * content.radius
    advance = speed / tip_speed
    found = lookup.slopes(advance, beta)
    half = WIDTH // 2
    root = (omega**-0.5 - content.omega[0] ** -0.5)[:, None, None, None]
    (value, by_beta), (by_advance, by_both) = np.moveaxis(
        found[..., :half] + root * found[..., half:], 0, 2
    )
    square = (omega**2)[:, None]
    resting = (advance < HARDLY_MOVING)[:, None]
    by_angle = np.where(resting, by_both, by_beta / np.where(resting, 1.0, advance[:, None]))
    # dJ/dOmega = -J / Omega; the Reynolds term is linear in Omega^(-1/2).
    by_root = found[:, 0, 0, half:] * (-0.5 * omega**-1.5)[:, None]
    by_omega = square * (
        2.0 * value / omega[:, None] - by_advance * (advance / omega)[:, None] + by_root
    )
    per_speed = square / tip_speed[:, None]
    return square * value, by_omega, per_speed * by_advance, per_speed * by_angle


def _with_power(loads: Floats, omega: Floats, each: Floats) -> Floats:
    """``each`` (n, L, k), and the power's (n, L + 1, k); the first variable is omega."""
    power = each[:, TORQUE] * omega[:, None]
    power[:, 0] += loads[:, TORQUE]
    return np.concatenate([each, power[:, None]], axis=1)
