"""Derivatives of a table's loads, by the chain rule through J, beta and Omega^(-1/2)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from propmap.table.content import TableContent
from propmap.table.lookup import WIDTH, Lookup
from propmap.table.results import TORQUE
from propmap.typing import Floats

HARDLY_MOVING = 1e-7
"""Advance ratio below which d/dbeta over J, 0/0 at rest, is taken from its limit."""


def polar_gradient(
    content: TableContent, lookup: Lookup, omega: Floats, speed: Floats, beta: Floats, sign: Floats
) -> Floats:
    """Derivatives by omega, speed and beta, (n, L + 1, 3); ``sign`` is that of beta's change."""
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
    tip_speed = omega * content.radius
    advance = speed / tip_speed
    root = omega**-0.5 - content.omega[0] ** -0.5
    return chain_rule(lookup.slopes(advance, beta), omega, advance, tip_speed, root, np.where)


def chain_rule(
    found: Any, omega: Any, advance: Any, tip_speed: Any, root: Any, where: Callable[..., Any]
) -> tuple[Any, Any, Any, Any]:
    """Loads, and their derivatives by omega, by speed, and by beta over the speed, (..., L).

    Parameters
    ----------
    found : array, shape (..., 2, 2, WIDTH)
        As from ``Lookup.slopes``.
    omega, advance, tip_speed : array, shape (...)
        Omega [rad/s], J [-], Omega R [m/s].
    root : array, shape (...)
        Omega^(-1/2) less that at the least omega of the table [(s/rad)^(1/2)].
    where : function
        Of NumPy or of JAX.
    """
    half = WIDTH // 2
    both = found[..., :half] + root[..., None, None, None] * found[..., half:]
    value, by_beta = both[..., 0, 0, :], both[..., 0, 1, :]
    by_advance, mixed = both[..., 1, 0, :], both[..., 1, 1, :]
    omega, advance = omega[..., None], advance[..., None]
    resting = advance < HARDLY_MOVING
    by_angle = where(resting, mixed, by_beta / where(resting, 1.0, advance))
    square = omega**2
    # dJ/dOmega = -J / Omega; the Reynolds term is linear in Omega^(-1/2).
    by_root = found[..., 0, 0, half:] * (-0.5 * omega**-1.5)
    by_omega = square * (2.0 * value / omega - by_advance * (advance / omega) + by_root)
    per_speed = square / tip_speed[..., None]
    return square * value, by_omega, per_speed * by_advance, per_speed * by_angle


def _with_power(loads: Floats, omega: Floats, each: Floats) -> Floats:
    """``each`` (n, L, k), and the power's (n, L + 1, k); the first variable is omega."""
    power = each[:, TORQUE] * omega[:, None]
    power[:, 0] += loads[:, TORQUE]
    return np.concatenate([each, power[:, None]], axis=1)
