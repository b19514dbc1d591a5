"""Operating points and section parameters at which the package meets the literal reference."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

RHO = 1.225  # [kg/m^3]
MU = 1.983e-5  # [Pa s]


def _section(c_l1: float, c_l2: float, c_d: float, alpha_0_deg: float) -> dict[str, float]:
    fitted = {"c_l1": c_l1, "c_l2": c_l2, "c_d": c_d, "alpha_0": float(np.deg2rad(alpha_0_deg))}
    return fitted | {"M": 50.0, "c_p": 1.328, "c_d0": 0.01}


# Table I of the paper; alpha_0 in rad.
SECTIONS: dict[str, dict[str, float]] = {
    "soft": _section(6.9, 2.0, 3.7, 20.4),
    "stiff": _section(4.2, 2.0, 1.3, 27.5),
    "apc": _section(5.3, 1.7, 1.8, 20.6),
}


class Point(NamedTuple):
    """One operating point of one rotor."""

    rpm: float
    v_axial: float  # [m/s], V cos(beta)
    v_inplane: float  # [m/s], V sin(beta)

    @property
    def omega(self) -> float:
        """Angular velocity [rad/s]."""
        return self.rpm * 2.0 * np.pi / 60.0


def _point(rpm: float, speed: float, beta_deg: float) -> Point:
    beta = np.deg2rad(beta_deg)
    # cos(pi/2) is not zero in floating point, and sin(0) stays exact: clear what is round-off.
    axial = 0.0 if beta_deg == 90.0 else speed * np.cos(beta)
    across = 0.0 if beta_deg == 180.0 else speed * np.sin(beta)
    return Point(float(rpm), float(axial), float(across))


def reference_points(n: int = 210, seed: int = 2017) -> list[Point]:
    """`n` >= 100 points: 2000-10000 rpm, V 0-20 m/s, beta 0-90 deg, the same for the same seed.

    Hover, pure axial, edgewise, slow flight below 3 m/s (where eq. (11) has several roots at
    some radii) and high advance ratio (2000 rpm at 20 m/s) are always in; the rest is random.
    """
    if n < 100:
        raise ValueError("n must be at least 100, so that every kind of point is in")
    rng = np.random.default_rng(seed)

    def rpm() -> float:
        return float(np.round(rng.uniform(2000.0, 10000.0)))

    def speed(low: float, high: float) -> float:
        return float(np.round(rng.uniform(low, high), 2))

    def beta() -> float:
        return float(np.round(rng.uniform(0.0, 90.0), 1))

    points = [_point(r, 0.0, 0.0) for r in np.linspace(2000.0, 10000.0, 11)]
    points += [_point(rpm(), speed(0.1, 20.0), 0.0) for _ in range(20)]
    points += [_point(rpm(), speed(0.1, 20.0), 90.0) for _ in range(20)]
    points += [_point(rpm(), speed(0.0, 3.0), beta()) for _ in range(40)]
    points += [_point(2000.0, 20.0, b) for b in (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0)]
    points += [_point(rpm(), speed(0.0, 20.0), beta()) for _ in range(n - len(points))]
    return points


def extended_points(n: int = 24, seed: int = 25) -> list[Point]:
    """`n` points for what goes beyond the paper: hover, climb, and every other one in descent."""
    rng = np.random.default_rng(seed)
    points = [_point(6000.0, 0.0, 0.0), _point(3000.0, 0.0, 0.0)]
    for k in range(n - len(points)):
        rpm, speed = np.round(rng.uniform(2500.0, 9000.0)), np.round(rng.uniform(0.5, 18.0), 2)
        beta = np.round(rng.uniform(0.0, 90.0), 1) + 90.0 * (k % 2)
        if k % 7 == 0:
            beta = 180.0 * (k % 2)
        points.append(_point(float(rpm), float(speed), float(beta)))
    return points
