"""What ``propmap props show`` says of a propeller's section constants."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from propmap.catalogue import Entry
from propmap.catalogue.expected import HELD
from propmap.catalogue.identified import PARAMETERS, all_identified
from propmap.catalogue.lookup import constants_to_expect, meant_by, own_constants, propeller
from propmap.cli.output import grid
from propmap.model.airfoil import Airfoil

if TYPE_CHECKING:
    from rich.table import Table


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
    others = sorted(
        one.blades
        for one in all_identified()
        if isinstance(meant, Entry) and one.propeller == meant.name and one.blades != blades
    )
    also = [f"identified with {' and '.join(map(str, others))} blades too: --blades N"]
    found = own_constants(meant, blades)
    if found is None:
        expected = constants_to_expect(meant, propeller(prop, blades))
        told: list[object] = [_table(expected.airfoil)]
        if isinstance(meant, Entry):
            # Else a note on the blade has said what both rest on.
            told.append(expected.told)
    else:
        rest = found.told.removesuffix(f"; {found.verdict}")
        told = [_table(found.airfoil), rest, f"verdict: {found.verdict}"]
    return [*told, *(also if others else [])]


def _table(law: Airfoil) -> Table:
    """The constants with their standard deviations, and those that are held."""
    assert law.uncertainty is not None  # both kinds carry it
    deviations = np.sqrt(np.diag(law.uncertainty.covariance.matrix))
    rows = [
        (name, f"{getattr(law, name):.4f}", f"{deviation:.4f}", UNITS[name])
        for name, deviation in zip(PARAMETERS, deviations, strict=True)
    ]
    held = [(name, f"{value:.4f}", "held", "-") for name, value in HELD.items()]
    return grid("<constant|value|standard deviation|<unit", [*rows, *held])
