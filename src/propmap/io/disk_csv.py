"""The fields over the disk as CSV."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from propmap.io.csv_text import csv_text

if TYPE_CHECKING:
    from propmap.rotor import Rotor

COLUMNS = (
    "radius_m",
    "psi_deg",
    "alpha_deg",
    "inflow_mps",
    "force_N_per_m",
    "past_stall_deg",
    "reverse",
)


def disk_csv(rotor: Rotor, omega: float, speed: float, beta: float) -> str:
    """Angle of attack, inflow and force on a blade over the disk, a row per element and azimuth.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    omega, speed, beta : float
        Operating point [rad/s], [m/s], [rad].
    """
    field = rotor.inflow(omega, speed, beta)
    radius, psi = np.meshgrid(field.radius, np.degrees(field.azimuth), indexing="ij")
    columns = (
        radius,
        psi,
        np.degrees(field.alpha),
        field.local_inflow,
        field.normal_force,
        np.degrees(field.past_stall),
        field.reverse.astype(int),
    )
    flat = [values.ravel().tolist() for values in columns]
    return csv_text(
        COLUMNS, [dict(zip(COLUMNS, row, strict=True)) for row in zip(*flat, strict=True)]
    )
