"""Laws of the package with the numbers of a literal section."""

from __future__ import annotations

import numpy as np

import propmap as pm
from tests.oracle.literal_section import drag_coefficient, lift_coefficient


def airfoil_of(section: dict[str, float], zero_lift_angle: float = 0.0) -> pm.Airfoil:
    """The package's law; ``attached`` and ``plate`` choose its lift."""
    law = "plate" if section.get("plate") else "blended"
    if section.get("attached") == 0.0:
        law = "simplified"
    others = {k: v for k, v in section.items() if k not in ("M", "attached", "plate")}
    sharpness = section.get("M", 50.0)
    return pm.Airfoil(**others, zero_lift_angle=zero_lift_angle, sharpness=sharpness, lift_law=law)


def sampled(
    section: dict[str, float], fine_deg: float, coarse_deg: float, reynolds: np.ndarray
) -> pm.SectionTable:
    """``section`` every ``fine_deg`` between -45 and 45 deg, and every ``coarse_deg`` beyond."""
    inner = np.arange(-45.0, 45.0 + 0.5 * fine_deg, fine_deg)
    outer = np.arange(45.0 + coarse_deg, 180.0, coarse_deg)
    angle = np.radians(np.concatenate([[-180.0], -outer[::-1], inner, outer, [180.0]]))
    c_l = lift_coefficient(angle, section)
    c_l[[0, -1]] = 0.0  # where the law itself jumps from one side to the other
    c_d = np.stack([drag_coefficient(angle, re, section) for re in reynolds])
    return pm.SectionTable(angle, reynolds, np.broadcast_to(c_l, c_d.shape), c_d)
