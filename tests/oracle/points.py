"""Air and section parameters of the literal reference."""

from __future__ import annotations

import numpy as np

RHO = 1.225  # [kg/m^3]
MU = 1.983e-5  # [Pa s]


def _section(c_l1: float, c_l2: float, c_d: float, alpha_0_deg: float) -> dict[str, float]:
    fitted = {"c_l1": c_l1, "c_l2": c_l2, "c_d": c_d, "alpha_0": float(np.deg2rad(alpha_0_deg))}
    return fitted | {"M": 50.0, "c_p": 1.328, "c_d0": 0.01}


# Table I of the paper; alpha_0 in rad.
SECTIONS: dict[str, dict[str, float]] = {
    "soft": _section(6.9, 2.0, 3.7, 20.4),
    "stiff": _section(4.2, 2.0, 1.3, 27.5),
    "apc": _section(5.3, 1.7, 1.8, 20.6),
}
