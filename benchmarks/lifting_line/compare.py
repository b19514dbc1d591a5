"""The package's inflow theories and the lifting line at the same operating points."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

import propmap
from benchmarks.lifting_line.free_wake import free_wake
from benchmarks.lifting_line.rotor import LiftingRotor, RotorLoads, consistent, in_rigid_wake
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
"""Constants fitted to the thrust and torque of the 2019 polynomials, by the command of its source."""

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
        rotor = propmap.Rotor(model(corrections=corrections), compiled=False)
        loads = rotor.loads(OMEGA, speed, beta)
        columns = [np.asarray(getattr(loads, load)).tolist() for load in RotorLoads._fields]
        found[name] = [RotorLoads(*row) for row in zip(*columns, strict=True)]
    return found


def by_rigid_wake(
    constants: propmap.Airfoil, point: Point, resolution: Resolution
) -> tuple[RotorLoads, float]:
    """Loads in the rigid wake of the rotor's own thrust, and the error left.

    Parameters
    ----------
    constants, point, resolution
        Section law, operating point and division.
    """
    rotor, solution = consistent(model(constants), point.flight, resolution)
    return rotor.loads(solution.flow), solution.left


def by_free_wake(
    constants: propmap.Airfoil, point: Point, thrust: float, resolution: Resolution
) -> tuple[RotorLoads, list[float]]:
    """Loads in a free wake, and by how much the wake moved at each round, over R [-].

    Parameters
    ----------
    constants, point, resolution
        Section law, operating point and division.
    thrust : float
        With which the wake starts [N].
    """
    found = free_wake(model(constants), point.flight, thrust, resolution, free_turns=2, rounds=12)
    return found.rotor.loads(found.solution.flow), found.moved


def identified(
    points: list[Point], wanted: list[RotorLoads], resolution: Resolution
) -> propmap.Airfoil:
    """Constants with which the lifting line has the thrust and torque of another theory.

    Parameters
    ----------
    points : list of Point
        Where.
    wanted : list of RotorLoads
        By the other theory.
    resolution : Resolution
        The division.
    """
    rotors = [
        in_rigid_wake(model(), point.flight, want.thrust, resolution)
        for point, want in zip(points, wanted, strict=True)
    ]
    start: Floats = np.array([getattr(CONSTANTS, name) for name in FREE])
    target = np.array([[want.thrust, want.torque] for want in wanted])

    def residuals(relative: Floats) -> Floats:
        constants = _constants(relative * start)
        found = [_loads(rotor, constants) for rotor in rotors]
        got = np.array([[loads.thrust, loads.torque] for loads in found])
        return ((got - target) / target.mean(axis=0)).ravel()

    best = least_squares(residuals, np.ones(len(FREE)), diff_step=1e-2, xtol=1e-3, max_nfev=8)
    return _constants(best.x * start)


def _constants(values: Floats) -> propmap.Airfoil:
    changes = dict(zip(FREE, map(float, values), strict=True))
    return CONSTANTS.with_parameters(
        name="8x6E, lifting line", source="thrust and torque of pitt-peters", **changes
    )


def _loads(rotor: LiftingRotor, constants: propmap.Airfoil) -> RotorLoads:
    changed = LiftingRotor(
        model(constants), rotor.flight, rotor.radius, rotor.width, rotor.azimuth, rotor.sections
    )
    return changed.loads(changed.solved().flow)
