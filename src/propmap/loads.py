"""The registry of loads: names, units, words, and what errors are shares of.

Everything that lists loads iterates over ``LOADS``, and every array of loads has its order.  A new
load is computed in ``element.hpp`` of the core, described here, and a field of ``propmap.Loads``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Load:
    """One load of a rotor.

    Attributes
    ----------
    name : str
        Field of ``propmap.Loads``, and the key where loads are kept by name.
    label : str
        In words.
    symbol : str
        In formulas and heads of tables; "" for none.
    unit : str
        "N" or "N m".
    meaning : str
        What it is, with its direction, for descriptions of files.
    scale : str
        The load at rest that errors are shares of; see ``error_scales``.
    inplane : bool
        Whether it points along or about the in-plane velocity.  Such a load vanishes in axial
        flow and at rest, so that the hover model has none.
    """

    name: str
    label: str
    symbol: str
    unit: str
    meaning: str
    scale: str
    inplane: bool

    @property
    def column(self) -> str:
        """Its name with the unit, as in files: "torque_Nm"."""
        return f"{self.name}_{self.unit.replace(' ', '')}"

    def column_of(self, what: str) -> str:
        """The column of a quantity of it: "torque_std_Nm" where ``what`` is "std"."""
        return f"{self.name}_{what}_{self.unit.replace(' ', '')}"

    @property
    def head(self) -> str:
        """A short name, for the heads of tables: "T"."""
        return self.symbol or self.name.partition("_")[0]

    @property
    def title(self) -> str:
        """In words with the unit, for axes of figures: "thrust T [N]"."""
        return f"{' '.join(filter(None, (self.label, self.symbol)))} [{self.unit}]"

    @property
    def moment(self) -> bool:
        """Whether it is a moment, not a force."""
        return self.unit == "N m"

    @property
    def share(self) -> str:
        """Its error as a share, in words: "thrust / static thrust"."""
        static = f"static {self.scale}"
        whole = static if self.unit == LOADS[self.scale].unit else f"({static} R)"
        return f"{self.label} / {whole}"


LOADS = {
    load.name: load
    for load in (
        Load("thrust", "thrust", "T", "N", "thrust along the axis", "thrust", inplane=False),
        Load("drag", "rotor drag", "D", "N",
             "rotor drag, in the disk plane against the in-plane velocity", "thrust", inplane=True),
        Load("torque", "torque", "Q", "N m", "shaft torque", "torque", inplane=False),
        Load("roll_moment", "rolling moment", "", "N m",
             "moment about the in-plane velocity, positive: advancing side lifted", "thrust",
             inplane=True),
        Load("side_force", "side force", "Y", "N",
             "force in the disk plane across the in-plane velocity, towards the retreating side",
             "thrust", inplane=True),
        Load("pitch_moment", "pitching moment", "", "N m",
             "moment about the axis across the in-plane velocity, positive: front lifted", "thrust",
             inplane=True),
    )
}  # fmt: skip
"""Every load by its name."""


def error_scales(static: Mapping[str, Any], radius: float) -> dict[str, Any]:
    """What errors are shares of, by load: static thrust, static torque, static thrust times R.

    Parameters
    ----------
    static : mapping of str
        Loads at rest by name [N] or [N m].
    radius : float
        R [m].
    """
    return {
        name: static[load.scale] * (1.0 if load.unit == LOADS[load.scale].unit else radius)
        for name, load in LOADS.items()
    }


FLOW = ("omega", "v_axial", "v_inplane")  # which loads can be differentiated by

DRAG_FACTOR, MOUNT_AREA = "drag_factor", "mount_area"
"""How a rotor is installed, where the model says so: the factor on the blades' own drag [-], and
the area of what is mounted in the slipstream [m^2]."""

GEOMETRY = ("chord_scale", "twist_offset", "untwist")
"""The blade's common relative change of the chord [-] and common offset of the twist [rad], and
what its twist loses as it turns [rad]; as ``BladeUntwist`` has it."""
