"""The hover model T = k_T Omega^2, the reference of the comparisons in the paper."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.rotor import Rotor

REFERENCE_TIP_SPEED = 60.0  # default tip speed at which the constants are computed [m/s]


@dataclass(frozen=True)
class HoverModel:
    """Loads that depend only on the rotational speed: thrust and torque, without rotor drag.

    Attributes
    ----------
    k_thrust, k_torque : float
        k_T [N s^2] and k_tau [N m s^2].
    omega : float
        Rotational speed at which the constants were computed [rad/s].
    """

    k_thrust: float
    k_torque: float
    omega: float

    @classmethod
    def from_rotor(cls, rotor: Rotor, omega: float | None = None) -> HoverModel:
        """Return the hover model with the constants of a rotor at V = 0.

        Parameters
        ----------
        rotor : Rotor
            The rotor.
        omega : float, optional
            Rotational speed [rad/s], by default for a tip speed of 60 m/s.  It changes the
            constants by up to 4 % from 4000 to 8000 rpm (APC 8x6E), due to the Reynolds number.

        Raises
        ------
        InputError
            Unless omega is positive.
        """
        omega = (
            REFERENCE_TIP_SPEED / rotor.model.propeller.radius if omega is None else float(omega)
        )
        if not omega > 0.0:
            raise InputError(f"omega is {omega}: the hover model needs a positive value [rad/s]")
        still = rotor.loads(omega, 0.0, 0.0)
        return cls(float(still.thrust) / omega**2, float(still.torque) / omega**2, omega)

    def thrust(self, omega: ArrayLike) -> NDArray[np.float64]:
        """Return the thrust [N] at ``omega`` [rad/s], any shape."""
        return np.asarray(self.k_thrust * np.square(omega))

    def torque(self, omega: ArrayLike) -> NDArray[np.float64]:
        """Return the torque [N m] at ``omega`` [rad/s], any shape."""
        return np.asarray(self.k_torque * np.square(omega))

    def loads(self, omega: ArrayLike) -> dict[str, NDArray[np.float64]]:
        """Return all loads by name [N], [N m] at ``omega`` [rad/s]; zero for loads not modeled."""
        none = np.zeros_like(omega, dtype=np.float64)
        known = {"thrust": self.thrust(omega), "torque": self.torque(omega)}
        return {name: known.get(name, none) for name in LOADS}

    def loads_at_velocity(self, omega: ArrayLike, velocity: ArrayLike) -> Any:  # noqa: ARG002
        """Return ``loads`` at ``omega``, and a ``status``; ``velocity`` has no effect."""
        return SimpleNamespace(**self.loads(omega), status=np.full(np.shape(omega), "ok"))
