"""Loads of the hover model where those of a rotor are wanted."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from propmap.baselines.hover import HoverModel
from propmap.typing import Floats


class HoverLoads:
    """T = k_T Omega^2 and Q = k_tau Omega^2 at any velocity, no other loads.

    Parameters
    ----------
    hover : HoverModel
        Gives the constants.
    """

    def __init__(self, hover: HoverModel) -> None:
        self.hover = hover

    def loads_at_velocity(self, omega: Floats, velocity: Floats) -> Any:  # noqa: ARG002
        """Loads by name and a ``status``, of the shape of ``omega`` [rad/s]."""
        return SimpleNamespace(**self.hover.loads(omega), status=np.full(omega.shape, "ok"))
