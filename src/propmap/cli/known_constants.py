"""What ``propmap props show`` says of a propeller's section constants."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from propmap.catalogue import Entry
from propmap.catalogue.expected_constants import expected_constants
from propmap.catalogue.family_prior import family_prior
from propmap.catalogue.identified import PARAMETERS, all_identified, identified
from propmap.catalogue.lookup import meant_by
from propmap.catalogue.prior import HELD, constants_of, slopes_of
from propmap.catalogue.spread import spread
from propmap.cli.output import grid

if TYPE_CHECKING:
    from rich.table import Table

    from propmap.arrays.types import Floats

UNITS = {
    "c_l1": "1/rad",
    "c_d": "-",
    "alpha_0": "rad",
    "zero_lift_angle": "rad",
    "c_d0": "-",
    "reynolds_camber": "rad",
    "drag_angle": "rad",
}


def known_constants(prop: str, blades: int) -> list[object]:
    """What to show: the constants that commands take for PROP by default, and how sure they are.

    Parameters
    ----------
    prop : str
        As it was given; of a file there is nothing to say.
    blades : int
        How many blades it has.
    """
    meant = meant_by(prop)
    if meant is None:
        return []
    if not isinstance(meant, Entry):
        # A note on the blade has said what both rest on.
        return [_expected(meant.family)]
    others = sorted(
        one.blades
        for one in all_identified()
        if one.propeller == meant.name and one.blades != blades
    )
    also = [f"identified with {' and '.join(map(str, others))} blades too: --blades N"]
    found = identified(meant.name, blades)
    if found is None:
        told = [_expected(meant.family), expected_constants(meant.family)[1]]
    else:
        rest = found.told.removesuffix(f"; {found.verdict}")
        table = _table(found.constants, np.sqrt(np.diag(found.covariance)))
        told = [table, rest, f"verdict: {found.verdict}"]
    return [*told, *(also if others else [])]


def _expected(family: str | None) -> Table:
    """The constants to be expected of a propeller of the family, with their spread."""
    every = all_identified()
    prior = family_prior([one for one in every if one.family == family], spread(every))
    slopes = slopes_of(prior.mean)
    return _table(constants_of(prior.mean), np.sqrt(slopes**2 @ prior.deviation**2))


def _table(values: Floats, deviations: Floats) -> Table:
    rows = [
        (name, f"{value:.4f}", f"{deviation:.4f}", UNITS[name])
        for name, value, deviation in zip(PARAMETERS, values, deviations, strict=True)
    ]
    held = [(name, f"{value:.4f}", "held", "-") for name, value in HELD.items()]
    return grid("<constant|value|standard deviation|<unit", [*rows, *held])
