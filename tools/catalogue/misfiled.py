"""What is filed wrongly in the UIUC database: numbers of blades, and lost decimal points.

Eight runs of the NR640 name three or four blades and have the loads of others: those of two blades
(one of them, of four) to within the scatter of repeated runs, where the number they name is off by
a third to all of the thrust and power.  In each the number named is the first digit of the run's
rotational speed.  Runs at one rotational speed that disagreed by a quarter then agree.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from propmap.io.uiuc import MeasuredPropeller
from propmap.typing import Floats

MISFILED = {
    ("nr640 5x3.16 - 4", 4031.0): 2,
    ("nr640 5x4.29 - 4", 4027.0): 2,
    ("nr640 9x5.68 - 3", 3023.0): 2,
    ("nr640 9x5.68 - 3", 3024.0): 4,
    ("nr640 9x5.68 - 4", 4035.0): 2,
    ("nr640 9x7.72 - 3", 3020.0): 2,
    ("nr640 9x7.72 - 4", 4051.0): 2,
    ("nr640 9x7.72 - 4", 4058.0): 2,
}
"""Number of blades by the propeller's name in the database and the rotational speed [1/min]."""

LOST_POINTS = {
    "ancf 12.0x65.0": "ancf 12.0x6.5",
    "ancf 13.0x65.0": "ancf 13.0x6.5",
    "ancf 125.0x6.0": "ancf 12.5x6.0",
    "ancf 125.0x75.0": "ancf 12.5x7.5",
    "ancf 125.0x9.0": "ancf 12.5x9.0",
}
"""Blades whose labels have lost a decimal point, and what they are."""


def refiled(every: Sequence[MeasuredPropeller]) -> list[MeasuredPropeller]:
    """The database with each run under its blade's size and the number of blades of its loads.

    Parameters
    ----------
    every : sequence of MeasuredPropeller
        As the database files them.

    Returns
    -------
    list of MeasuredPropeller
        In the same order; a propeller of which nothing is left is left out.
    """
    every = [_with_point(one) for one in every]
    rows = {one.name: [(one, _own(one))] for one in every}
    for one in every:
        for (name, rpm), blades in MISFILED.items():
            moved = _at(one, rpm)
            if name == one.name and moved.any():
                home = f"{one.blade} - {blades}"
                rows.setdefault(home, []).append((one._replace(blades=blades), moved))
    joined = [_joined(name, parts) for name, parts in rows.items()]
    return [one for one in joined if one.rpm.size > 0]


def _with_point(one: MeasuredPropeller) -> MeasuredPropeller:
    blade = LOST_POINTS.get(one.blade, one.blade)
    return one._replace(name=one.name.replace(one.blade, blade), blade=blade)


def _at(one: MeasuredPropeller, rpm: float) -> NDArray[np.bool_]:
    return (np.round(one.rpm) == rpm) & (one.advance > 0.0)


def _own(one: MeasuredPropeller) -> NDArray[np.bool_]:
    """Which rows belong to the number of blades that they are filed under."""
    others = [_at(one, rpm) for name, rpm in MISFILED if name == one.name]
    return ~np.any(others, axis=0) if others else np.ones(one.rpm.size, bool)


def _joined(
    name: str, parts: Sequence[tuple[MeasuredPropeller, NDArray[np.bool_]]]
) -> MeasuredPropeller:
    first = parts[0][0]
    if len(parts) == 1 and parts[0][1].all():
        return first

    def column(field: str) -> Floats:
        return np.concatenate([getattr(one, field)[which] for one, which in parts])

    apart = [one.run[which] + 1000 * k for k, (one, which) in enumerate(parts)]
    return first._replace(
        name=name,
        blades=parts[-1][0].blades,
        rpm=column("rpm"),
        advance=column("advance"),
        thrust=column("thrust"),
        power=column("power"),
        run=np.concatenate(apart),
    )
