"""What the hover model says of measured loads and forces: the baseline of every comparison."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propmap.hover import HoverModel
from propmap.hub_flow import HubFlow, rotor_forces
from propmap.rotor import Rotor

Floats = NDArray[np.float64]


def hover_loads(rotor: Rotor, omega: Floats) -> dict[str, Floats]:
    """Loads by name at omega [rad/s] (n,), with this rotor's constants; [N], [N m], (n,) each."""
    hover = HoverModel.of(rotor)
    nothing = np.zeros_like(omega)
    return {
        "thrust": hover.thrust(omega),
        "drag": nothing,
        "torque": hover.torque(omega),
        "roll_moment": nothing,
    }


def hover_force(rotor: Rotor, flow: HubFlow) -> Floats:
    """Force of all rotors on the vehicle [N] (n, 3), with this rotor's constants.

    flow : rotor speeds of n samples, and the axes.
    """
    thrust = HoverModel.of(rotor).thrust(flow.omega)
    return rotor_forces(flow, thrust, np.zeros_like(thrust))
