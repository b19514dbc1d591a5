"""Target ``rotorpy``: the rotor's part of a RotorPy vehicle.

RotorPy's rotor gives thrust = k_eta Omega^2 + k_h v_across^2 - k_z Omega v_axial, torque = k_m
Omega^2, drag = k_d Omega v_across, and a flapping moment k_flap Omega v_across about the axis to
the left of the in-plane velocity, which is minus the pitching moment.  It has no rolling moment and
no side force: the exported module adds k_roll and k_side times Omega v_across.
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
class RotorPyRotor:
    """RotorPy's coefficients [N s^2], [N m s^2], [kg], [kg], [kg/m], and of in-plane loads by Omega
    and the in-plane speed [kg m], [kg m], [kg]."""

    k_eta: float
    k_m: float
    k_d: float
    k_z: float
    k_h: float
    k_flap: float
    k_roll: float
    k_side: float

    def loads(self, omega: Floats, axial: Floats, inplane: Floats) -> dict[str, Floats]:
        """Loads (n,) [N], [N m] at n points [rad/s], [m/s]."""
        thrust = self.k_eta * omega**2 + self.k_h * inplane**2 - self.k_z * omega * axial
        across = omega * inplane
        return {
            "thrust": thrust,
            "drag": self.k_d * across,
            "torque": self.k_m * omega**2,
            "roll_moment": self.k_roll * across,
            "side_force": self.k_side * across,
            "pitch_moment": -self.k_flap * across,
        }


def fit_rotor(table: LoadTable, samples: Samples) -> RotorPyRotor:
    """Static thrust and torque as they are, the rest by least squares."""
    middle = middle_omega(table)
    static = static_loads(table, np.array([middle]))
    k_eta, k_m = (float(static[load][0]) / middle**2 for load in ("thrust", "torque"))
    chosen = samples.simple
    omega, axial, inplane = (x[chosen] for x in (samples.omega, samples.axial, samples.inplane))
    scale = samples.static["thrust"][chosen]
    matrix = np.stack([-omega * axial, inplane**2], axis=-1) / scale[:, None]
    rest = (samples.loads["thrust"][chosen] - k_eta * omega**2) / scale
    k_z, k_h = np.linalg.lstsq(matrix, rest, rcond=None)[0].tolist()
    k_d, pitch, k_roll, k_side = (
        slope(samples, load) for load in ("drag", "pitch_moment", "roll_moment", "side_force")
    )
    return RotorPyRotor(k_eta, k_m, k_d, k_z, k_h, -pitch, k_roll, k_side)


def files(table: LoadTable) -> Files:
    """The parameters as a Python module, and the note."""
    samples = sample(table)
    fitted = fit_rotor(table, samples)
    found = errors(samples, fitted.loads(samples.omega, samples.axial, samples.inplane))
    rpm = middle_omega(table) * 30.0 / np.pi
    return {
        f"{identifier(table)}_rotorpy.py": rendered("rotorpy.py", table, fitted=fitted),
        "README-rotorpy.txt": note(table, "rotorpy", found, rpm=rpm),
    }
