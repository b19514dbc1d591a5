"""Which operating points the data of a fit cover."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats

AT_REST = 0.1
"""[m/s], below which the direction of the flow means nothing."""

BAND = 15.0
"""Width of the bands of the angle beta [deg], the first one about 0."""

RPM = 30.0 / np.pi


def coverage(omega: Floats, speed: Floats, beta: Floats, radius: float) -> dict[str, Any]:
    """Ranges of n operating points, as plain data for a fit file.

    omega [rad/s], speed [m/s], beta [rad] within 0...pi : (n,).  radius : of the tip [m].
    The result has "points", and of those at rest and of each band of the angle that holds
    any: how many, and least and largest "rpm", "speed_mps", "advance_ratio" V/(Omega R),
    "beta_deg"; "typical_..." are medians.  Loads over Omega^2 depend on advance ratio and angle,
    and on little else.
    """
    turning = omega > 0.0
    omega, speed, beta = omega[turning], speed[turning], beta[turning]
    degrees, still = np.degrees(beta), speed < AT_REST
    band = np.round(degrees / BAND).astype(int)

    def ranges(mine: NDArray[np.bool_]) -> dict[str, Any]:
        rpm = omega[mine] * RPM
        found = {
            "points": int(mine.sum()),
            "rpm": _ends(rpm),
            "typical_rpm": float(np.median(rpm)),
            "speed_mps": _ends(speed[mine]),
            "advance_ratio": _ends(speed[mine] / (omega[mine] * radius)),
        }
        if still[mine].all():
            return found
        typical = float(np.median(degrees[mine]))
        return found | {"beta_deg": _ends(degrees[mine]), "typical_beta_deg": typical}

    told: dict[str, Any] = {"points": int(omega.size), "angles": []}
    if omega.size:
        told |= {"rpm": _ends(omega * RPM), "typical_rpm": float(np.median(omega * RPM))}
        told["speed_mps"] = _ends(speed)
    if still.any():
        told["at_rest"] = ranges(still)
    told["angles"] = [ranges(~still & (band == k)) for k in np.unique(band[~still]).tolist()]
    return told


def _ends(values: Floats) -> list[float]:
    return [float(np.min(values)), float(np.max(values))]
