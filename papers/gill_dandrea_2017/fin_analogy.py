"""Ribner's fin analogy for the side force of a propeller in yaw, without blade elements.

H. S. Ribner, NACA TR 819 and 820, 1945.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from propmap.errors import InputError
from propmap.model.propeller import Propeller
from propmap.typing import Floats

ASPECT_RATIO = 8.0  # effective, of the fin; "of the order of 8" in the reports
STATIONS = 400


def inflow_factor(thrust: ArrayLike, speed: ArrayLike, radius: float, density: float) -> Floats:
    """Return the inflow a at the disk over the airspeed [-], from momentum theory.

    T = 2 rho pi R^2 V^2 a (1 + a); with T_c = T/(rho V^2 D^2), a = (sqrt(1 + 8 T_c/pi) - 1)/2.
    The result is NaN for T_c < -pi/8, where momentum theory is not valid.  ``thrust`` is in [N];
    ``speed`` must be above 0 [m/s].
    """
    v = np.asarray(speed, dtype=np.float64)
    if not (v > 0.0).all():
        raise InputError("the fin analogy needs an airspeed", "give speeds above 0 m/s")
    coefficient = np.asarray(thrust, dtype=np.float64) / (density * v**2 * (2.0 * radius) ** 2)
    root = 1.0 + 8.0 * coefficient / np.pi
    return np.asarray(0.5 * (np.sqrt(np.where(root >= 0.0, root, np.nan)) - 1.0))


def dynamic_pressure_factor(inflow: ArrayLike) -> Floats:
    """Return the factor f(a) [-] by which the inflow a [-] raises the fin's dynamic pressure.

    f(a) = (1 + a) ((1 + a) + (1 + 2 a)^2) / (1 + (1 + 2 a)^2); it is 1 without inflow and
    approaches 1 + a for strong inflow.
    """
    a = np.asarray(inflow, dtype=np.float64)
    wake = (1.0 + 2.0 * a) ** 2
    return np.asarray((1.0 + a) * ((1.0 + a) + wake) / (1.0 + wake))


def side_area(propeller: Propeller, zero_lift_angle: float = 0.0) -> float:
    """Return the projected side area of all blades, averaged over a turn [m^2].

    The area is N_b/2 times the integral of c(y) sin(theta(y)) from the root to the tip of the
    ``propeller``.  theta is the pitch of the zero-lift line, which is at ``zero_lift_angle`` [rad]
    to the chord line.
    """
    from scipy.interpolate import PchipInterpolator

    y = np.linspace(propeller.root, propeller.radius, STATIONS)
    shapes = (propeller.chord, propeller.twist)
    chord, twist = (PchipInterpolator(propeller.station, values)(y) for values in shapes)
    width = chord * np.sin(twist - zero_lift_angle)
    return float(0.5 * propeller.blades * np.trapezoid(width, y))


def side_force(
    propeller: Propeller,
    thrust: ArrayLike,
    speed: ArrayLike,
    incidence: ArrayLike,
    density: float,
    *,
    zero_lift_angle: float = 0.0,
) -> Floats:
    """Return the force in the disk plane against the in-plane velocity [N], for small incidence.

    The propeller acts as a fin with its ``side_area``, the aspect ratio 8, the lift slope
    2 pi A/(A + 2) of lifting-line theory and the dynamic pressure 1/2 rho V^2 f(a).  Spinner,
    nacelle and compressibility are excluded.  The force is proportional to the sine of the
    ``incidence``, the angle between velocity and axis [rad].  ``thrust`` is the thrust without yaw
    [N]; ``speed`` must be above 0 [m/s].
    """
    a = inflow_factor(thrust, speed, propeller.radius, density)
    slope = 2.0 * math.pi * ASPECT_RATIO / (ASPECT_RATIO + 2.0)
    pressure = 0.5 * density * np.square(speed) * dynamic_pressure_factor(a)
    area = side_area(propeller, zero_lift_angle)
    return np.asarray(pressure * area * slope * np.sin(incidence))
