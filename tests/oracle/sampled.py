"""Section tables made from the paper's law."""

from __future__ import annotations

import numpy as np

import propmap as pm
from tests.oracle.paper_physics import Law, drag, lift


def sampled(law: Law, fine_deg: float, coarse_deg: float, reynolds: np.ndarray) -> pm.SectionTable:
    """``law`` every ``fine_deg`` between -45 and 45 deg, and every ``coarse_deg`` beyond."""
    inner = np.arange(-45.0, 45.0 + 0.5 * fine_deg, fine_deg)
    outer = np.arange(45.0 + coarse_deg, 180.0, coarse_deg)
    angle = np.radians(np.concatenate([[-180.0], -outer[::-1], inner, outer, [180.0]]))
    c_l = lift(angle, law)
    c_l[[0, -1]] = 0.0  # where the law itself jumps from one side to the other
    c_d = np.stack([drag(angle, re, law) for re in reynolds])
    return pm.SectionTable(angle, reynolds, np.broadcast_to(c_l, c_d.shape), c_d)
