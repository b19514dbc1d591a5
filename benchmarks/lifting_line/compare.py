"""The package's inflow theories and the lifting line at the same operating points."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

import propmap
from benchmarks.lifting_line.circulation import averaged_flow
from benchmarks.lifting_line.free_wake import free_wake
from benchmarks.lifting_line.rotor import RotorLoads, consistent, in_rigid_wake
from benchmarks.lifting_line.vortices import Floats
from benchmarks.lifting_line.wake import Flight, Resolution

CONSTANTS = propmap.Airfoil(
    c_l1=4.4599,
    c_l2=2.0,
    c_d=1.4884,
    alpha_0=0.39986,
    zero_lift_angle=-0.066173,
    name="8x6E by thrust and torque",
    source=(
        "propmap fit tunnel apc-8x6e gill-dandrea-2019-8x6e --loads thrust,torque "
        "--free c_l1,c_d,alpha_0,zero_lift_angle --fix c_l2=2 --folds 0 --starts 2 -o fit.toml"
    ),
)
"""Fitted to thrust and torque of the 2019 polynomials, by the command that is their source."""

OMEGA = 6000.0 * np.pi / 30.0
"""[rad/s]."""

FREE = ("c_l1", "c_d", "alpha_0", "zero_lift_angle")
"""Constants by which a lifting line is given a thrust and a torque."""

THEORIES: dict[str, tuple[str, ...]] = {
    "annulus": (),
    "pitt_peters": ("pitt-peters",),
    "pitt_peters_tip_loss": ("pitt-peters", "tip-loss"),
}


class Point(NamedTuple):
    """An operating point at ``OMEGA``."""

    speed: float
    beta_deg: float

    @property
    def beta(self) -> float:
        """[rad]."""
        return float(np.radians(self.beta_deg))

    @property
    def flight(self) -> Flight:
        """Along and across the axis."""
        return Flight(
            OMEGA, self.speed * float(np.cos(self.beta)), self.speed * float(np.sin(self.beta))
        )


def model(constants: propmap.Airfoil = CONSTANTS, corrections: tuple[str, ...] = ()) -> Any:
    """The 8x6E with these ``constants`` and ``corrections``."""
    blade = propmap.propeller("apc-8x6e")
    return propmap.Model(
        blade, constants, corrections=tuple(propmap.correction(name) for name in corrections)
    )


def by_theory(points: list[Point]) -> dict[str, list[RotorLoads]]:
    """Loads at ``points`` by each of ``THEORIES``."""
    speed, beta = (np.array(a) for a in zip(*((p.speed, p.beta) for p in points), strict=True))
    found = {}
    for name, corrections in THEORIES.items():
        rotor = propmap.Rotor(model(corrections=corrections))
        loads = rotor.loads(OMEGA, speed, beta)
        columns = [np.asarray(getattr(loads, load)).tolist() for load in RotorLoads._fields]
        found[name] = [RotorLoads(*row) for row in zip(*columns, strict=True)]
    return found


class InRigidWake(NamedTuple):
    """Loads in the rigid wake of the rotor's own thrust."""

    loads: RotorLoads
    same_all_around: RotorLoads
    """What they would be if what the wake induces were its mean over the turn at each radius."""
    left: float  # error of the circulation, over the largest [-]


def by_rigid_wake(constants: propmap.Airfoil, point: Point, resolution: Resolution) -> InRigidWake:
    """Compute loads in a rigid wake."""
    rotor, solution = consistent(model(constants), point.flight, resolution)
    averaged = averaged_flow(rotor.sections, rotor.law, solution.flow)
    return InRigidWake(rotor.loads(solution.flow), rotor.loads(averaged), solution.left)


class InFreeWake(NamedTuple):
    """Loads in a free wake, and in the rigid one that it started as."""

    start: RotorLoads  # in the rigid wake
    end: RotorLoads
    moved: list[float]  # root mean square by which the wake moved at each round, over R [-]


def by_free_wake(
    constants: propmap.Airfoil, point: Point, thrust: float, resolution: Resolution
) -> InFreeWake:
    """Compute loads in a free wake, which starts with a ``thrust`` [N]."""
    rotor = model(constants)
    start = in_rigid_wake(rotor, point.flight, thrust, resolution)
    found = free_wake(rotor, point.flight, thrust, resolution, free_turns=2, rounds=10)
    return InFreeWake(
        start.loads(start.solved().flow), found.rotor.loads(found.solution.flow), found.moved
    )


def identified(
    points: list[Point], wanted: list[RotorLoads], resolution: Resolution
) -> propmap.Airfoil:
    """Find constants with which the lifting line has the thrust and torque of another theory."""
    rotors = [
        in_rigid_wake(model(), point.flight, want.thrust, resolution)
        for point, want in zip(points, wanted, strict=True)
    ]
    before = [rotor.solved().circulation for rotor in rotors]
    start: Floats = np.array([getattr(CONSTANTS, name) for name in FREE])
    target = np.array([[want.thrust, want.torque] for want in wanted])

    def residuals(relative: Floats) -> Floats:
        changed = model(_constants(relative * start))
        found = []
        for rotor, circulation in zip(rotors, before, strict=True):
            other = replace(rotor, model=changed)
            loads = other.loads(other.solved(circulation).flow)
            found.append((loads.thrust, loads.torque))
        return ((np.array(found) - target) / target.mean(axis=0)).ravel()

    best = least_squares(residuals, np.ones(len(FREE)), diff_step=1e-2, xtol=1e-3, max_nfev=8)
    return _constants(best.x * start)


def _constants(values: Floats) -> propmap.Airfoil:
    changes = dict(zip(FREE, map(float, values), strict=True))
    return CONSTANTS.with_parameters(
        name="8x6E, lifting line", source="thrust and torque of pitt-peters", **changes
    )
