"""The model's lines through the tunnel's points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from propmap.catalogue.lookup import Measurement
from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil
from propmap.model.model import Model
from propmap.papers.gill_dandrea_2017.blades import blade
from propmap.papers.gill_dandrea_2017.tunnel import Compared
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import RPM

AXIAL_OMEGA = 5000.0 * RPM
"""[rad/s] of the axial lines; the Reynolds number moves them by a per cent at most."""

OBLIQUE_OMEGA = 6579.0 * RPM
"""[rad/s]: the rotational speed at which the 2019 campaign has most points."""

BETAS = np.radians([0.0, 30.0, 60.0, 90.0])
LARGEST_ADVANCE = 1.1


class Coefficients(NamedTuple):
    """J = V/(n D), C_T = T/(rho n^2 D^4) and C_P = P/(rho n^3 D^5) [-], each (n,)."""

    advance: Floats
    thrust: Floats
    power: Floats


@dataclass(frozen=True, eq=False)
class ThrustCurve:
    """Thrust (n,) [N] over omega (n,) [rad/s] at one speed [m/s] and angle [rad]."""

    label: str
    speed: float
    beta: float
    omega: Floats
    thrust: Floats


def measured_coefficients(data: Measurement) -> Coefficients:
    """Those of measured axial rows."""
    thrust, torque = data.loads["thrust"], data.loads["torque"]
    return _coefficients(data, data.omega, data.speed, thrust, torque)


def axial_curves(one: Compared, laws: dict[str, Airfoil]) -> dict[str, Coefficients]:
    """A line of C_T and C_P over J for each law, by label."""
    shape = blade(one.data.propeller)
    fastest = LARGEST_ADVANCE * shape.diameter * AXIAL_OMEGA / (2.0 * np.pi)
    speed = np.linspace(0.0, fastest, 45)
    omega = np.full_like(speed, AXIAL_OMEGA)
    found = {}
    for label, law in laws.items():
        loads = Rotor(Model(shape, law, one.air)).loads(omega, speed, 0.0)
        found[label] = _coefficients(one.data, omega, speed, loads.thrust, loads.torque)
    return found


def oblique_curves(
    one: Compared, laws: dict[str, Airfoil]
) -> tuple[Floats, dict[str, dict[str, Floats]]]:
    """Speeds (n,) [m/s], and loads by label of the law and by name, (angles of ``BETAS``, n)."""
    speed = np.linspace(0.0, float(one.data.speed.max()), 29)
    found = {}
    for label, law in laws.items():
        rotor = Rotor(Model(blade(one.data.propeller), law, one.air))
        loads: Any = rotor.loads(OBLIQUE_OMEGA, speed, BETAS[:, None])
        found[label] = {name: getattr(loads, name) for name in LOADS}
    return speed, found


def thrust_curves(one: Compared) -> list[ThrustCurve]:
    """Lines of thrust over rotational speed for each law and flow of the 8x4.5MR's rows."""
    data = one.data
    omega = np.linspace(0.15, 1.0, 30) * float(data.omega.max())
    rounded = np.round(np.stack([data.speed, data.beta]), 3)
    _, first = np.unique(rounded, axis=1, return_index=True)
    found = []
    for label, law in one.laws.items():
        rotor = Rotor(Model(blade(data.propeller), law, one.air))
        for speed, beta in zip(data.speed[first], data.beta[first], strict=True):
            thrust = rotor.loads(omega, speed, beta).thrust
            found.append(ThrustCurve(label, float(speed), float(beta), omega, thrust))
    return found


def _coefficients(
    data: Measurement, omega: Floats, speed: Floats, thrust: Floats, torque: Floats
) -> Coefficients:
    rate, size, density = omega / (2.0 * np.pi), blade(data.propeller).diameter, data.air_density
    return Coefficients(
        speed / (rate * size),
        thrust / (density * rate**2 * size**4),
        torque * omega / (density * rate**3 * size**5),
    )
