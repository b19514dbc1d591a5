"""Target ``gazebo``: parameters of the multicopter motor model of Gazebo and PX4.

With the velocity through the air split along and across the axis, the plugin applies thrust =
motorConstant Omega^2, torque = momentConstant thrust, drag = |Omega| rotorDragCoefficient
v_across and, about v_across, |Omega| rollingMomentCoefficient v_across.  It has no side force and
no pitching moment.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.export.folder import Files
from propmap.export.note import note
from propmap.export.provenance import identifier
from propmap.export.samples import Samples, errors, middle_omega, sample, slope, static_loads
from propmap.export.template import rendered
from propmap.table.query import LoadTable
from propmap.typing import Floats


@dataclass(frozen=True)
class MotorModel:
    """The plugin's parameters [N s^2], [m], [N s^2/m], [N s^2], by its formulas."""

    motor_constant: float
    moment_constant: float
    rotor_drag_coefficient: float
    rolling_moment_coefficient: float

    def loads(self, omega: Floats, inplane: Floats) -> dict[str, Floats]:
        """Loads (n,) [N], [N m] at n points [rad/s], [m/s]."""
        thrust, across = self.motor_constant * omega**2, omega * inplane
        return {
            "thrust": thrust,
            "drag": self.rotor_drag_coefficient * across,
            "torque": self.moment_constant * thrust,
            "roll_moment": self.rolling_moment_coefficient * across,
        }


def fit_motor_model(table: LoadTable, samples: Samples) -> MotorModel:
    """Static thrust and torque as they are; drag and roll moment by least squares."""
    omega = middle_omega(table)
    static = static_loads(table, np.array([omega]))
    thrust, torque = float(static["thrust"][0]), float(static["torque"][0])
    drag, roll = slope(samples, "drag"), slope(samples, "roll_moment")
    return MotorModel(thrust / omega**2, torque / thrust, drag, roll)


def files(table: LoadTable) -> Files:
    """The SDF elements and the note."""
    samples = sample(table)
    fitted = fit_motor_model(table, samples)
    found = errors(samples, fitted.loads(samples.omega, samples.inplane))
    rpm = middle_omega(table) * 30.0 / np.pi
    return {
        f"{identifier(table)}_motor.sdf": rendered("motor.sdf", table, fitted=fitted),
        "README-gazebo.txt": note(table, "gazebo", found, rpm=rpm),
    }
