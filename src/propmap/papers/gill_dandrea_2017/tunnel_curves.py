"""The model's lines through the tunnel's points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from propmap.arrays.types import Floats
from propmap.catalogue.measurements import Measurement
from propmap.loads import LOADS
from propmap.model.air import Air
from propmap.model.airfoil import Airfoil
from propmap.model.model import Model
from propmap.papers.gill_dandrea_2017.blades import blade
from propmap.papers.gill_dandrea_2017.tunnel import Compared
from propmap.rotor import Rotor

AXIAL_OMEGA = 5000.0 * np.pi / 30.0
"""[rad/s] of the axial lines; the Reynolds number moves them by a per cent at most."""

OBLIQUE_OMEGA = 6579.0 * np.pi / 30.0
"""[rad/s]: the rotational speed at which the published fit has most points."""

BETAS = np.radians([0.0, 30.0, 60.0, 90.0])
LARGEST_ADVANCE = 1.1


@dataclass(frozen=True, eq=False)
class AxialCurve:
    """advance J = V/(n D), thrust_coefficient C_T, power_coefficient C_P; (n,) each [-]."""

    label: str
    advance: Floats
    thrust_coefficient: Floats
    power_coefficient: Floats


@dataclass(frozen=True, eq=False)
class ObliqueCurves:
    """speed (n,) [m/s]; loads by name, (angles of ``BETAS``, n), in SI."""

    label: str
    speed: Floats
    loads: dict[str, Floats]


@dataclass(frozen=True, eq=False)
class ThrustCurve:
    """Thrust (n,) [N] over omega (n,) [rad/s] at one speed [m/s] and angle [rad]."""

    label: str
    speed: float
    beta: float
    omega: Floats
    thrust: Floats


def coefficients(data: Measurement) -> tuple[Floats, Floats, Floats]:
    """J, C_T and C_P [-] of measured axial rows, (n,) each."""
    thrust, torque = data.loads["thrust"], data.loads["torque"]
    shape = blade(data.propeller)
    return _coefficients(data.omega, data.speed, thrust, torque, data.air_density, shape)


def axial_curves(data: Measurement, laws: dict[str, Airfoil]) -> list[AxialCurve]:
    """A line of C_T and C_P over J for each law."""
    shape, air = blade(data.propeller), Air(density=data.air_density)
    fastest = LARGEST_ADVANCE * shape.diameter * AXIAL_OMEGA / (2.0 * np.pi)
    speed = np.linspace(0.0, fastest, 45)
    omega = np.full_like(speed, AXIAL_OMEGA)
    found = []
    for label, law in laws.items():
        loads = Rotor(Model(shape, law, air)).loads(omega, speed, 0.0)
        three = _coefficients(omega, speed, loads.thrust, loads.torque, air.density, shape)
        found.append(AxialCurve(label, *three))
    return found


def oblique_curves(one: Compared, laws: dict[str, Airfoil]) -> list[ObliqueCurves]:
    """Lines of every load over speed, for each law and angle."""
    data = one.data
    shape, air = blade(data.propeller), Air(density=data.air_density)
    speed = np.linspace(0.0, float(data.speed.max()), 29)
    found = []
    for label, law in laws.items():
        loads: Any = Rotor(Model(shape, law, air)).loads(OBLIQUE_OMEGA, speed, BETAS[:, None])
        found.append(ObliqueCurves(label, speed, {n: getattr(loads, n) for n in LOADS}))
    return found


def thrust_curves(one: Compared) -> list[ThrustCurve]:
    """Lines of thrust over rotational speed for each law and flow of the 8x4.5MR's rows."""
    data = one.data
    shape, air = blade(data.propeller), Air(density=data.air_density)
    omega = np.linspace(0.15, 1.0, 30) * float(data.omega.max())
    rounded = np.round(np.stack([data.speed, data.beta]), 3)
    _, first = np.unique(rounded, axis=1, return_index=True)
    found = []
    for label, law in one.laws.items():
        rotor = Rotor(Model(shape, law, air))
        for speed, beta in zip(data.speed[first], data.beta[first], strict=True):
            thrust = rotor.loads(omega, speed, beta).thrust
            found.append(ThrustCurve(label, float(speed), float(beta), omega, thrust))
    return found


def _coefficients(
    omega: Floats, speed: Floats, thrust: Floats, torque: Floats, density: float, shape: Any
) -> tuple[Floats, Floats, Floats]:
    rate, size = omega / (2.0 * np.pi), shape.diameter
    power = torque * omega
    return (
        speed / (rate * size),
        thrust / (density * rate**2 * size**4),
        power / (density * rate**3 * size**5),
    )
