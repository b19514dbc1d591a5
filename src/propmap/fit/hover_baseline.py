"""What the hover model says of measured loads and forces: the baseline of every comparison."""

from __future__ import annotations

import numpy as np

from propmap.arrays.types import Floats
from propmap.baselines.hover import REFERENCE_TIP_SPEED, HoverModel
from propmap.engine.evaluation import prepare
from propmap.engine.gradients import load_gradients
from propmap.engine.plan import accuracy
from propmap.rotor import Rotor
from propmap.solve.load_slopes import LOADS
from propmap.vehicle.hub_flow import HubFlow, rotor_forces


def hover_after_fit(rotor: Rotor) -> HoverModel:
    """``HoverModel.of(rotor)`` by the program that the fit has compiled, within 0.1 %."""
    omega = REFERENCE_TIP_SPEED / rotor.propeller.radius
    still, setting = np.zeros(1), accuracy(rotor.accuracy)
    found = load_gradients(prepare(rotor.arrays), setting, (), np.array([omega]), still, still)
    static = dict(zip(LOADS, found.loads[:, 0].tolist(), strict=True))
    return HoverModel(static["thrust"] / omega**2, static["torque"] / omega**2, omega)


def hover_loads(hover: HoverModel, omega: Floats) -> dict[str, Floats]:
    """Loads by name at omega [rad/s] (n,); [N], [N m], (n,) each."""
    nothing = np.zeros_like(omega)
    return {
        "thrust": hover.thrust(omega),
        "drag": nothing,
        "torque": hover.torque(omega),
        "roll_moment": nothing,
    }


def hover_force(hover: HoverModel, flow: HubFlow) -> Floats:
    """Force of all rotors on the vehicle [N] (n, 3).

    flow : rotor speeds of n samples, and the axes.
    """
    thrust = hover.thrust(flow.omega)
    return rotor_forces(flow, thrust, np.zeros_like(thrust))
