"""Target ``rotorpy``: the rotor's part of a RotorPy vehicle.

RotorPy's rotor gives thrust = k_eta Omega^2 + k_h v_across^2 - k_z Omega v_axial, torque = k_m
Omega^2, drag = k_d Omega v_across, and a flapping moment across the in-plane velocity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.arrays.types import Floats
from propmap.export.folder import Files
from propmap.export.note import note
from propmap.export.provenance import hash_comment, identifier, provenance
from propmap.export.samples import SIMPLE, Samples, errors, middle_omega, sample, static_loads
from propmap.table.query import LoadTable


@dataclass(frozen=True)
class RotorPyRotor:
    """RotorPy's coefficients [N s^2], [N m s^2], [kg], [kg], [kg/m]."""

    k_eta: float
    k_m: float
    k_d: float
    k_z: float
    k_h: float

    def loads(self, omega: Floats, axial: Floats, inplane: Floats) -> Floats:
        """Loads (n, 4) [N], [N m] at n points [rad/s], [m/s]."""
        thrust = self.k_eta * omega**2 + self.k_h * inplane**2 - self.k_z * omega * axial
        drag = self.k_d * omega * inplane
        return np.stack([thrust, drag, self.k_m * omega**2, np.zeros_like(omega)], axis=-1)


def fit_rotor(table: LoadTable, samples: Samples) -> RotorPyRotor:
    """Static thrust and torque as they are, the rest by least squares."""
    middle = middle_omega(table)
    thrust, _, torque, _ = static_loads(table, np.array([middle]))[0].tolist()
    k_eta, k_m = thrust / middle**2, torque / middle**2
    chosen = samples.simple
    omega, axial, inplane = (x[chosen] for x in (samples.omega, samples.axial, samples.inplane))
    static = samples.static[chosen, 0]
    matrix = np.stack([-omega * axial, inplane**2], axis=-1) / static[:, None]
    rest = (samples.loads[chosen, 0] - k_eta * omega**2) / static
    k_z, k_h = np.linalg.lstsq(matrix, rest, rcond=None)[0].tolist()
    across = omega * inplane / static
    k_d = float(across @ (samples.loads[chosen, 1] / static) / (across @ across))
    return RotorPyRotor(k_eta, k_m, k_d, k_z, k_h)


def files(table: LoadTable) -> Files:
    """The parameters as a Python module, and the note."""
    samples = sample(table)
    fitted = fit_rotor(table, samples)
    found = errors(samples, fitted.loads(samples.omega, samples.axial, samples.inplane))
    name = identifier(table)
    paragraphs = [
        "RotorPy's rotor knows thrust = k_eta omega^2 + k_h v^2 - k_z omega v_z, torque = k_m "
        "omega^2 and drag = k_d omega v, with v the velocity across the axis. k_eta and k_m are "
        f"those of hover, at {middle_omega(table) * 30.0 / np.pi:.0f} rpm; the rest are least "
        f"squares over {SIMPLE}. The torque does not change with the flight speed. RotorPy has "
        "no rolling moment; its k_flap is a moment across the velocity, which this rigid rotor "
        "does not have.",
        f"{name}_rotorpy.py holds what the propeller decides. Merge it into a vehicle: "
        "quad_params = {**frame, **rotor_params}, with mass, inertia, rotor positions and the "
        "motor's time constant from the frame. RotorPy clips omega to the range of the map.",
    ]
    low, high = table.envelope["omega"]
    lines = hash_comment(provenance(table))
    text = f'''"""The rotor of a RotorPy vehicle: quad_params = {{**frame, **rotor_params}}."""

{lines}

rotor_params = {{
    "rotor_radius": {table.content.radius!r},  # m
    "k_eta": {fitted.k_eta!r},  # N/(rad/s)^2
    "k_m": {fitted.k_m!r},  # N m/(rad/s)^2
    "k_d": {fitted.k_d!r},  # N/(rad m/s^2)
    "k_z": {fitted.k_z!r},  # N/(rad m/s^2)
    "k_h": {fitted.k_h!r},  # N/(m/s)^2
    "k_flap": 0.0,  # N m/(rad m/s^2)
    "rotor_speed_min": {low!r},  # rad/s
    "rotor_speed_max": {high!r},  # rad/s
}}
'''
    return {
        f"{name}_rotorpy.py": text,
        "README-rotorpy.txt": note(table, "rotorpy", paragraphs, found),
    }
