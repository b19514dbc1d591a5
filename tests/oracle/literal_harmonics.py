"""Inflow that varies around the disk, for the literal reference: Pitt and Peters with SciPy.

On the annulus inflow of the literal rotor, three unknowns are found by SciPy: a change of the mean
inflow and the two first harmonics.  Written with the coefficients as printed (by rho A (Omega R)^2,
times R for moments), on a full turn of azimuth, unlike the package.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import fsolve

from tests.oracle.literal_rotor import LiteralRotor, radial_nodes
from tests.oracle.literal_section import Array

TURN = 2.0 * np.pi


def harmonic_loads(rotor: LiteralRotor, root: float, azimuths: int = 96) -> dict[str, float]:
    """Loads [N], [N m] with the inflow of Pitt and Peters on top of the annulus inflow.

    The blade begins at ``root`` [m].  Thrust, drag, torque, roll_moment (advancing side lifted),
    side_force (towards the retreating side), pitch_moment (front lifted), and the three
    ``harmonics`` [m/s].
    """
    tip = float(rotor.station[-1])
    radii, weights = radial_nodes(rotor, root, tip)
    share, measured = rotor.ring
    annulus = np.array([measured if share == 1.0 else rotor.inflow_root(y)[0] for y in radii])
    annulus = (1.0 - share) * annulus + share * measured
    psi = TURN * (np.arange(azimuths) + 0.5) / azimuths
    mean = float(np.sum(weights * radii * annulus) / np.sum(weights * radii))

    def loads(added: Array) -> dict[str, float]:
        total = np.zeros(6)
        for y, weight, v_i in zip(radii, weights, annulus, strict=True):
            local = v_i + added[0] + y / tip * (added[1] * np.sin(psi) + added[2] * np.cos(psi))
            lift, drag, phi = _element(rotor, y, local, psi)
            up = lift * np.cos(phi) - drag * np.sin(phi)
            back = lift * np.sin(phi) + drag * np.cos(phi)
            rows = (
                up,
                back * np.sin(psi),
                y * back,
                y * up * np.sin(psi),
                back * np.cos(psi),
                -y * up * np.cos(psi),
            )
            total += weight * rotor.blades * np.array([row.mean() for row in rows])
        names = ("thrust", "drag", "torque", "roll_moment", "side_force", "pitch_moment")
        return dict(zip(names, map(float, total), strict=True))

    alone = loads(np.zeros(3))["thrust"]
    tip_speed = rotor.omega * tip
    unit = rotor.rho * np.pi * tip**2 * tip_speed**2
    mu = rotor.v_inplane / tip_speed
    climb, induced = rotor.v_axial / tip_speed, mean / tip_speed
    through = climb + induced
    total = np.hypot(mu, through)
    meets = max(min(-climb, induced), 0.0)  # of the inflow, what meets air from below
    mass_flow = (mu**2 + through * (through + induced)) / total
    mass_flow = max(mass_flow, 0.5 * total, meets)
    chi = np.arctan2(mu, max(abs(through), meets))

    def wanted(added: Array) -> Array:
        found = loads(added)
        c_t, c_roll = found["thrust"] / unit, found["roll_moment"] / (unit * tip)
        c_rear = -found["pitch_moment"] / (unit * tip)
        return (
            (1.0 - share)
            * tip_speed
            * np.array(
                [
                    (c_t - alone / unit) / (2.0 * mass_flow),
                    4.0 / (1.0 + np.cos(chi)) * c_roll / mass_flow,
                    15.0 * np.pi / 64.0 * np.tan(0.5 * chi) * c_t / mass_flow
                    + 4.0 * np.cos(chi) / (1.0 + np.cos(chi)) * c_rear / mass_flow,
                ]
            )
        )

    found, _, flag, message = fsolve(
        lambda added: added - wanted(added), np.zeros(3), xtol=1e-12, full_output=True
    )
    if flag != 1:
        raise ValueError(message)
    return loads(found) | {"harmonics": found}


def _element(
    rotor: LiteralRotor, y: float, inflow: Array, psi: Array
) -> tuple[Array, Array, Array]:
    """dL/dy, dD/dy of one blade [N/m] and phi [rad], with the inflow at each azimuth."""
    # Every inflow at every azimuth; those that belong together are on the diagonal.
    phi, lift, drag = (np.diagonal(found) for found in rotor.element(y, inflow, psi))
    return lift, drag, phi
