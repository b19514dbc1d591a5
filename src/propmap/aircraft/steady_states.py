"""Steady states of an aircraft as values, and what their statuses mean."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.aircraft.limits import LIMITS
from propmap.typing import Floats

JUMP = 2e-3
"""Share of the weight by which a rotor's loads may jump past the balance, where their nodes change
with the speed."""

NOT_FOUND = "no_trim"
STALL = "stall"
OUTSIDE_TABLE = "outside_table"
VORTEX_RING = "vortex_ring"

COARSE = "coarse"
FLOWN = ("ok", COARSE, VORTEX_RING)
"""Statuses of states with numbers."""

STATUSES = {
    "ok": "found, within every limit",
    COARSE: f"found, but the loads jump past the balance, by less than {JUMP:.1%} of the weight",
    VORTEX_RING: "found, but a rotor is in the vortex ring state: not to be trusted",
    **{name: f"beyond {words}" for name, words in LIMITS.items()},
    OUTSIDE_TABLE: "nothing balances the aircraft inside the table's envelope",
    STALL: "slower than the wing's stall speed, and the rotors cannot carry what is missing",
    NOT_FOUND: "no attitude and rotor speeds balance it",
}
"""Statuses in words."""


@dataclass(frozen=True, eq=False)
class SteadyStates:
    """n steady states of an aircraft with k rotors.

    Of a state that was not found, or is beyond a limit, all are NaN but the first three and, beyond
    a limit, the next two, which say by how much.

    Attributes
    ----------
    speed, climb, bank : ndarray, shape (n,)
        Horizontal speed through the air [m/s], climb rate [m/s], and bank of a coordinated level
        turn [rad], positive to the right.
    used : dict of str to ndarray, shape (n,)
        Share of each of ``LIMITS`` that the state uses or would use, 1 at the limit.
    thrust_margin : ndarray, shape (n,)
        Thrust of all rotors, were all sped up alike to the first limit, over that which is needed;
        below 1 beyond a limit.
    pitch, roll : ndarray, shape (n,)
        Positive nose down, and right side down [rad].
    rotor_speed, thrust, torque : ndarray, shape (n, k)
        Of each rotor [rad/s], [N], [N m].
    shaft_power : ndarray, shape (n,)
        Of all rotors [W].
    electrical_power : ndarray, shape (n,)
        At the battery's terminals [W]; NaN where the vehicle has no motor.
    motor_current, throttle : ndarray, shape (n, k)
        [A]; share of the battery's voltage [-].  NaN where the vehicle has no motor, no battery.
    battery_current, battery_voltage : ndarray, shape (n,)
        [A], [V]; NaN where the vehicle has no battery.
    moment : ndarray, shape (n, 3)
        About the centre of mass, what rotors cannot balance and control surfaces must [N m].
    residual : ndarray, shape (n,)
        The largest unbalanced force over the weight, and moment over the weight times the longest
        arm [-].
    status : ndarray of str, shape (n,)
        Of ``STATUSES``.
    """

    speed: Floats
    climb: Floats
    bank: Floats
    used: dict[str, Floats]
    thrust_margin: Floats
    pitch: Floats
    roll: Floats
    rotor_speed: Floats
    thrust: Floats
    torque: Floats
    shaft_power: Floats
    electrical_power: Floats
    motor_current: Floats
    throttle: Floats
    battery_current: Floats
    battery_voltage: Floats
    moment: Floats
    residual: Floats
    status: NDArray[np.str_]

    def __len__(self) -> int:
        return int(self.speed.size)

    @property
    def found(self) -> NDArray[np.bool_]:
        """Where there are numbers, (n,)."""
        return np.isfinite(self.shaft_power)

    @property
    def power(self) -> Floats:
        """Electrical power where it is known, else shaft power [W], (n,)."""
        known = np.isfinite(self.electrical_power)
        return np.where(known, self.electrical_power, self.shaft_power)

    def and_also(self, other: SteadyStates) -> SteadyStates:
        """These states and those of the ``other`` at further speeds, in the order of speeds."""
        _, order = np.unique(np.concatenate([self.speed, other.speed]), return_index=True)

        def both(mine: Any, its: Any) -> Any:
            if isinstance(mine, dict):
                return {name: both(values, its[name]) for name, values in mine.items()}
            return np.concatenate([mine, its])[order]

        return SteadyStates(
            *(both(getattr(self, f.name), getattr(other, f.name)) for f in fields(self))
        )
