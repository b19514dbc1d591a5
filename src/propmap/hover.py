"""The hover model, T = k_T Omega^2, that the paper compares with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.rotor import Rotor

REFERENCE_TIP_SPEED = 60.0  # [m/s] at which the constants are taken by default


@dataclass(frozen=True)
class HoverModel:
    """Loads from the rotational speed alone; no drag, whatever the flight speed.

    Attributes
    ----------
    k_thrust, k_torque : float
        k_T [N s^2] and k_tau [N m s^2].
    omega : float
        Rotational speed at which the rotor gave these constants [rad/s].
    """

    k_thrust: float
    k_torque: float
    omega: float

    @classmethod
    def of(cls, rotor: Rotor, omega: float | None = None) -> HoverModel:
        """Take the constants from a rotor at V = 0.

        Parameters
        ----------
        rotor : Rotor
            The rotor.
        omega : float, optional
            Rotational speed [rad/s], by default that of a tip speed of 60 m/s.  The constants
            depend on it through the Reynolds number alone, by about 0.1 % from 4000 to 8000 rpm.

        Raises
        ------
        InputError
            Unless omega is positive.
        """
        omega = (
            REFERENCE_TIP_SPEED / rotor.model.propeller.radius if omega is None else float(omega)
        )
        if not omega > 0.0:
            raise InputError(f"omega is {omega}: the hover model needs a positive one [rad/s]")
        still = rotor.loads(omega, 0.0, 0.0)
        return cls(float(still.thrust) / omega**2, float(still.torque) / omega**2, omega)

    def thrust(self, omega: ArrayLike) -> NDArray[np.float64]:
        """Thrust [N] at ``omega`` [rad/s], any shape."""
        return np.asarray(self.k_thrust * np.square(omega))

    def torque(self, omega: ArrayLike) -> NDArray[np.float64]:
        """Torque [N m] at ``omega`` [rad/s], any shape."""
        return np.asarray(self.k_torque * np.square(omega))

    def loads(self, omega: ArrayLike) -> dict[str, NDArray[np.float64]]:
        """Every load by name [N], [N m] at ``omega`` [rad/s]; zero where the model has none."""
        none = np.zeros_like(omega, dtype=np.float64)
        known = {"thrust": self.thrust(omega), "torque": self.torque(omega)}
        return {name: known.get(name, none) for name in LOADS}
