"""C_T and C_P of a propeller in axial flow, with derivatives by its section constants."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from propmap.catalogue.expected import HELD
from propmap.catalogue.identified import PARAMETERS
from propmap.io.uiuc import MeasuredPropeller
from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil
from propmap.model.model import Model, Propeller
from propmap.rotor import Rotor
from propmap.typing import Floats

_THRUST, _TORQUE = (list(LOADS).index(name) for name in ("thrust", "torque"))


def airfoil_of(constants: Floats, name: str = "unnamed", source: str = "") -> Airfoil:
    """The section law with ``constants`` (7,) in the order of ``PARAMETERS``."""
    values: Any = dict(zip(PARAMETERS, map(float, constants), strict=True)) | HELD
    return Airfoil(**values, name=name, source=source)


@dataclass(frozen=True, eq=False)
class AxialTest:
    """Coefficients measured at rest and in axial flow, and the propeller they belong to; n rows.

    Attributes
    ----------
    propeller : Propeller
        Its blade.
    tested : MeasuredPropeller
        What was measured.
    """

    propeller: Propeller
    tested: MeasuredPropeller

    @property
    def measured(self) -> Floats:
        """C_T and C_P [-], (2, n)."""
        return np.stack([self.tested.thrust, self.tested.power])

    def modelled(self, constants: Floats) -> tuple[Floats, Floats]:
        """C_T and C_P [-] with ``constants`` (7,), and their derivatives by these.

        Returns
        -------
        tuple of ndarray
            (2, n), NaN where no inflow was found, and (2, 7, n).
        """
        model = Model(self.propeller, airfoil_of(constants))
        turns = self.tested.rpm / 60.0
        diameter = 2.0 * self.propeller.radius
        flow = (2.0 * np.pi * turns, self.tested.advance * turns * diameter)
        found = Rotor(model).gradients(PARAMETERS, *flow, 0.0)
        force = model.air.density * turns**2 * diameter**4
        # P = 2 pi n tau.
        size = np.stack([force, force * diameter / (2.0 * np.pi)])
        rows = [_THRUST, _TORQUE]
        return found.loads[rows] / size, found.slopes[rows] / size[:, None]
