"""Operating points told by a table's cells, in which its errors are alike on every scale.

A position (n, 3) counts cells along the advance ratio and along beta, with the share of the cell
behind the point, and has the share of the rotational speeds that the envelope has at that
advance ratio, from the least to the largest.
"""

from __future__ import annotations

import numpy as np

from propmap.table.axis import locate
from propmap.table.content import TableContent
from propmap.typing import Floats


def most_position(content: TableContent) -> Floats:
    """The largest position (3,); the least is zero."""
    return np.array([content.advance.size - 1.0, content.beta.size - 1.0, 1.0])


def points_at(content: TableContent, position: Floats) -> tuple[Floats, Floats, Floats]:
    """omega, speed and beta (n,) each of positions (n, 3)."""
    advance, beta = (
        np.interp(position[:, axis], np.arange(knots.size), knots)
        for axis, knots in enumerate((content.advance, content.beta))
    )
    least, most = _omegas(content, advance)
    omega = least + position[:, 2] * (most - least)
    speed = np.clip(advance * content.radius * omega, *content.speed)
    return omega, speed, beta


def positions_of(content: TableContent, omega: Floats, advance: Floats, beta: Floats) -> Floats:
    """Positions (n, 3) of points of the envelope (n,) each."""
    along, across = (
        np.add(*locate(knots, values))
        for knots, values in ((content.advance, advance), (content.beta, beta))
    )
    least, most = _omegas(content, advance)
    share = np.divide(omega - least, most - least, out=np.zeros_like(omega), where=most > least)
    return np.clip(np.stack([along, across, share], axis=1), 0.0, most_position(content))


def _omegas(content: TableContent, advance: Floats) -> tuple[Floats, Floats]:
    """Least and largest omega (n,) at which the envelope has these advance ratios."""
    (slowest, fastest), per_omega = content.omega, advance * content.radius
    moves = per_omega > 0.0
    bounds = [
        np.divide(speed, per_omega, out=np.full_like(advance, end), where=moves)
        for speed, end in zip(content.speed, content.omega, strict=True)
    ]
    return np.clip(bounds[0], slowest, fastest), np.clip(bounds[1], slowest, fastest)
