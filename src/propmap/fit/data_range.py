"""What the range of the data cannot tell, in plain words."""

from __future__ import annotations

import numpy as np

from propmap.fit.rows import Rows

HOVER_BELOW, NARROW = 1.0, 2.0
"""Speeds [m/s]: below the first everything hovers; a range below the second is one speed."""


def range_warnings(rows: Rows) -> list[str]:
    """Sentences, none where the speeds of the rows spread enough."""
    speed = rows.speed[rows.weight > 0.0]
    low, high = float(np.min(speed)), float(np.max(speed))
    if high < HOVER_BELOW:
        return [
            "all data are from hover: they fix the static loads alone and cannot tell one "
            "parameter from another; add data at speed"
        ]
    if high - low < NARROW:
        return [
            f"all data are from one speed, {low:.1f} to {high:.1f} m/s: the parameters can hardly "
            "be told apart; add data at other speeds"
        ]
    return []
