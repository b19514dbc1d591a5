"""How far forward flight is known: relative uncertainty of thrust and torque, before and after."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.fit.fitted import Fitted
from propmap.fit.parameters import ROTOR
from propmap.fit.tunnel import rotor_with
from propmap.loads import LOADS
from propmap.model.model import Model
from propmap.typing import Floats

ADVANCE = (0.0, 0.2, 0.4, 0.6, 0.2, 0.4, 0.6)
"""J = V / (n D) of the points looked at [-]."""

BETA = np.radians([0.0, 0.0, 0.0, 0.0, 90.0, 90.0, 90.0])
"""Their angles to the axis [rad]."""

TOLD = ("thrust", "torque")

MODEL_ERROR = 0.03
"""What the model gets wrong with the best constants, as a share of the load at rest; so much makes
the intervals hold after a fit to static rows: ``python -m tools.after_static``."""

SMALL = 0.1
"""Share of the load at rest below which a load has no relative uncertainty worth telling."""


@dataclass(frozen=True, eq=False)
class ForwardTrust:
    """Thrust and torque at m points, and how uncertain they are.

    Attributes
    ----------
    omega : float
        Rotational speed of all points [rad/s].
    advance, beta : ndarray, shape (m,)
        V / (n D) [-] and the angle to the axis [rad].
    load : ndarray, shape (m, 2)
        Thrust [N] and torque [N m] after the fit.
    before, after : ndarray, shape (m, 2)
        Standard deviations over the loads [-]; NaN where a load is hardly there, and infinite
        where nothing was known.
    """

    omega: float
    advance: Floats
    beta: Floats
    load: Floats
    before: Floats
    after: Floats


def forward_trust(model: Model, fitted: Fitted, omega: float, setting: str) -> ForwardTrust:
    """What a fit leaves open of thrust and torque at rest, in axial and in edgewise flow.

    To first order, sqrt(g' S g) with g the derivatives by the free constants: before the fit at
    the most likely ones with their covariance, after it at those found with that of the fit; and
    ``MODEL_ERROR`` beside it.

    Parameters
    ----------
    model : Model
        That was fitted.
    fitted : Fitted
        The fit.
    omega : float
        Rotational speed [rad/s].
    setting : str
        Accuracy of the loads, as in ``Rotor``.
    """
    choice = fitted.choice
    by_prior = choice.apart(choice.first)[1]
    before = np.asarray(np.linalg.pinv(by_prior.T @ by_prior), np.float64)
    unknown = [k for k, name in enumerate(choice.free) if choice.prior_of(name) is None]
    speed = np.array(ADVANCE) * omega / (2.0 * np.pi) * model.propeller.diameter
    flow = np.full(speed.size, omega), speed * np.cos(BETA), speed * np.sin(BETA)
    rows = [list(LOADS).index(name) for name in TOLD]

    def loads(x: Floats, covariance: Floats) -> tuple[Floats, Floats]:
        rotor = rotor_with(model, choice.values(x), setting)
        names = tuple(name for name in choice.free if name in ROTOR)
        found = rotor.gradients(names, *flow)
        mine = [choice.free.index(name) for name in names]
        part = covariance[np.ix_(mine, mine)]
        variance = np.einsum("lpm,pq,lqm->ml", found.slopes[rows], part, found.slopes[rows])
        load = found.loads[rows].T
        relative = np.sqrt(variance + (MODEL_ERROR * load[0]) ** 2) / np.abs(load)
        return load, np.where(load < SMALL * load[0], np.nan, relative)

    _, was = loads(choice.first, before)
    if unknown:
        was = np.where(np.isfinite(was), np.inf, was)
    load, now = loads(fitted.x, fitted.uncertainty.covariance)
    return ForwardTrust(omega, np.array(ADVANCE), BETA, load, was, now)
