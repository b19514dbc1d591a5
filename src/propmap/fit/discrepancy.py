"""What a fit could not explain, as errors of thrust and power coefficients."""

from __future__ import annotations

import numpy as np

from propmap.baselines.hover import HoverModel
from propmap.fit.fitted import Fitted
from propmap.fit.residuals import errors
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.typing import Floats

OF_THRUST, OF_TORQUE = ("thrust", "force_z", "vertical_force"), ("torque",)
"""Rows whose errors, over what the hover model says of them, are shares of a static load."""


def discrepancy(fitted: Fitted, found: Model, hover: Floats) -> dict[str, float]:
    """Standard deviations of C_T and C_P, by the names of ``model.uncertainty.DISCREPANCIES``.

    A load that was not fitted is taken to err by as large a share as the other.

    Parameters
    ----------
    fitted : Fitted
        The fit.
    found : Model
        With its parameters.
    hover : ndarray, shape (M,)
        The hover model's values of the rows.
    """
    shares = {}
    for kind, names in (("thrust", OF_THRUST), ("torque", OF_TORQUE)):
        for k, name in enumerate(fitted.rows.names):
            still = hover[fitted.rows.of_load(k)]
            size = float(np.sqrt(np.nanmean(still**2))) if still.size else 0.0
            if name in names and size > 0.0:
                shares[kind] = errors(*fitted.compared(k)).rms / size
    if not shares or not np.isfinite(list(shares.values())).all():
        return {}
    static = HoverModel.of(Rotor(found))
    blade, air = found.propeller, found.air
    thrust = abs(static.k_thrust) * (2.0 * np.pi) ** 2 / (air.density * blade.diameter**4)
    power = abs(static.k_torque) * (2.0 * np.pi) ** 3 / (air.density * blade.diameter**5)
    largest = max(shares.values())
    return {
        "thrust_coefficient": shares.get("thrust", largest) * thrust,
        "power_coefficient": shares.get("torque", largest) * power,
    }
