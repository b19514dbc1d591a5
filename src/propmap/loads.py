"""The registry of loads: names, units, descriptions, and reference values of relative errors.

All code that lists loads iterates over ``LOADS``.  Every array of loads has the order of ``LOADS``.
To add a load, compute it in ``element.hpp`` of the core, describe it here, and give it a field in
``propmap.results.LoadValues``.
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
        Field of ``propmap.Loads``, and key in mappings of loads.
    label : str
        Name in texts, "rotor drag".
    symbol : str
        Symbol in formulas and table headings; "" for none.
    unit : str
        "N" or "N m".
    meaning : str
        Description with the direction, for files.
    scale : str
        Static load in the reference value of relative errors; see ``error_scales``.
    inplane : bool
        Whether its direction depends on the in-plane velocity.  Such a load vanishes in axial flow
        and at rest, so the hover model does not have it.
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
        """Column name in files, with the unit: "torque_Nm"."""
        return f"{self.name}_{self.unit.replace(' ', '')}"

    def column_of(self, what: str) -> str:
        """Return the column name of a property ``what`` of the load: "torque_std_Nm" for "std"."""
        return f"{self.name}_{what}_{self.unit.replace(' ', '')}"

    @property
    def head(self) -> str:
        """Short name for table headings: "T"."""
        return self.symbol or self.name.partition("_")[0]

    @property
    def title(self) -> str:
        """Label of figure axes, with the unit: "thrust T [N]"."""
        return f"{' '.join(filter(None, (self.label, self.symbol)))} [{self.unit}]"

    @property
    def moment(self) -> bool:
        """Whether the load is a moment."""
        return self.unit == "N m"

    @property
    def share(self) -> str:
        """Label of its relative error: "thrust / static thrust"."""
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
             "force in the disk plane across the in-plane velocity, toward the retreating side",
             "thrust", inplane=True),
        Load("pitch_moment", "pitching moment", "", "N m",
             "moment about the axis across the in-plane velocity, positive: front lifted", "thrust",
             inplane=True),
    )
}  # fmt: skip
"""All loads by name."""


def error_scales(static: Mapping[str, Any], radius: float) -> dict[str, Any]:
    """Return the reference value of the relative error of each load.

    The reference value is the static thrust, the static torque, or the static thrust times R.

    Parameters
    ----------
    static : mapping of str
        Static loads by name [N] or [N m].
    radius : float
        Blade radius R [m].
    """
    return {
        name: static[load.scale] * (1.0 if load.unit == LOADS[load.scale].unit else radius)
        for name, load in LOADS.items()
    }


FLOW = ("omega", "v_axial", "v_inplane")  # flow variables with derivatives of the loads

DRAG_FACTOR, MOUNT_AREA = "drag_factor", "mount_area"
"""Parameters of an installed rotor: factor on the drag of the blades [-], and area of the parts in
the slipstream [m^2]; see ``Installed``."""

GEOMETRY = ("chord_scale", "twist_offset", "untwist")
"""Parameters of the blade: relative change of the chord [-] and change of the twist [rad], both at
all stations, and the untwist of the tip [rad]; see ``BladeUntwist``."""
