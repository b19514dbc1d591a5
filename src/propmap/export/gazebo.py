"""Target ``gazebo``: parameters of the multicopter motor model of Gazebo and PX4.

With the velocity through the air split along and across the axis, the plugin applies thrust =
motorConstant Omega^2, torque = momentConstant thrust, drag = |Omega| rotorDragCoefficient
v_across and, about v_across, |Omega| rollingMomentCoefficient v_across.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.arrays.types import Floats
from propmap.export.folder import Files
from propmap.export.note import note
from propmap.export.provenance import identifier, provenance, xml_comment
from propmap.export.samples import SIMPLE, Samples, errors, middle_omega, sample, static_loads
from propmap.table.query import LoadTable


@dataclass(frozen=True)
class MotorModel:
    """The plugin's parameters [N s^2], [m], [N s^2/m], [N s^2], by its formulas."""

    motor_constant: float
    moment_constant: float
    rotor_drag_coefficient: float
    rolling_moment_coefficient: float

    def loads(self, omega: Floats, inplane: Floats) -> Floats:
        """Loads (n, 4) [N], [N m] at n points [rad/s], [m/s]."""
        thrust = self.motor_constant * omega**2
        across = omega * inplane
        return np.stack(
            [
                thrust,
                self.rotor_drag_coefficient * across,
                self.moment_constant * thrust,
                self.rolling_moment_coefficient * across,
            ],
            axis=-1,
        )


def fit_motor_model(table: LoadTable, samples: Samples) -> MotorModel:
    """Static thrust and torque as they are; drag and roll moment by least squares."""
    omega = middle_omega(table)
    thrust, _, torque, _ = static_loads(table, np.array([omega]))[0].tolist()
    chosen = samples.simple
    across = samples.omega * samples.inplane

    def slope(k: int) -> float:
        x, y = (v[chosen] / samples.static[chosen, k] for v in (across, samples.loads[:, k]))
        return float(x @ y / (x @ x))

    return MotorModel(thrust / omega**2, torque / thrust, slope(1), slope(3))


def files(table: LoadTable) -> Files:
    """The SDF elements and the note."""
    samples = sample(table)
    fitted = fit_motor_model(table, samples)
    found = errors(samples, fitted.loads(samples.omega, samples.inplane))
    most = table.envelope["omega"][1]
    paragraphs = [
        "The multicopter motor model knows thrust = motorConstant omega^2, torque = "
        "momentConstant thrust, drag = omega rotorDragCoefficient v, rolling moment = omega "
        "rollingMomentCoefficient v, with v the velocity across the axis. Thrust and torque do "
        "not change with the flight speed: they are those of hover, at "
        f"{middle_omega(table) * 30.0 / np.pi:.0f} rpm. The coefficients of drag and rolling "
        f"moment are least squares over {SIMPLE}.",
        "The plugin of PX4's Gazebo Classic multiplies the thrust by 1 - |v_axial|/25 m/s, "
        "whatever the propeller, which is not in the errors below.",
        "PX4's Gazebo Classic plugin turns the rolling moment's sign with turningDirection; "
        "gz-sim's MulticopterMotorModel and RotorS do not: for them, negate "
        "rollingMomentCoefficient where turningDirection is cw.",
    ]
    values = {
        "maxRotVelocity": most,
        "motorConstant": fitted.motor_constant,
        "momentConstant": fitted.moment_constant,
        "rotorDragCoefficient": fitted.rotor_drag_coefficient,
        "rollingMomentCoefficient": fitted.rolling_moment_coefficient,
    }
    lines = [
        "Elements of a <plugin>, the multicopter motor model; see the note on the sign of",
        "rollingMomentCoefficient.",
        *provenance(table),
    ]
    elements = "\n".join(f"<{key}>{value:.9g}</{key}>" for key, value in values.items())
    return {
        f"{identifier(table)}_motor.sdf": f"{xml_comment(lines)}\n{elements}\n",
        "README-gazebo.txt": note(table, "gazebo", paragraphs, found),
    }
