"""Random section laws on ten blades, beyond the three sets of the paper."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

import propmap as pm
from propmap.loads import error_scales

Numbers = NDArray[np.float64]
Flow = tuple[Numbers, Numbers, Numbers]
"""omega [rad/s], V cos(beta) and V sin(beta) [m/s], (N,)."""

BLADES = (
    "apc-8x6e",
    "apc-8x4.5mr",
    "apc-11x7e",
    "apc-9x6e",
    "apc-8x6sf",
    "uiuc-apcsf-10x4.7",
    "uiuc-da4002-9x6.75",
    "uiuc-gwsdd-5x4.3",
    "uiuc-magf-10x6",
    "uiuc-apce-19x12",
)

STATIONS = 24
"""Stations of ``resampled`` blades."""


class OtherRotor(NamedTuple):
    """A catalogue's blade, how many of them, and a random law."""

    blade: str
    blades: int
    airfoil: pm.Airfoil

    def propeller(self) -> pm.Propeller:
        """The blade as the catalogue has it."""
        return replace(pm.propeller(self.blade), blades=self.blades)

    def resampled(self) -> pm.Propeller:
        """The blade at ``STATIONS`` radii."""
        return replace(_resampled(self.blade), blades=self.blades)


@cache
def _resampled(name: str) -> pm.Propeller:
    blade = pm.propeller(name)
    y = np.linspace(blade.station[0], blade.station[-1], STATIONS)
    chord, twist = (PchipInterpolator(blade.station, v)(y) for v in (blade.chord, blade.twist))
    return replace(blade, station=y, chord=np.maximum(chord, 0.0), twist=twist)


def other_rotors(count: int, seed: int) -> list[OtherRotor]:
    """Rotors with 2 to 6 blades, blades by turns; a quarter of the laws without lift past stall."""
    rng = np.random.default_rng(seed)
    found = []
    for k in range(count):
        most = rng.choice([0.0, 3.0, 10.0], p=[0.25, 0.375, 0.375])
        airfoil = pm.Airfoil(
            c_l1=round(rng.uniform(3.0, 8.0), 3),
            c_l2=round(rng.uniform(0.0, most), 3),
            c_d=round(rng.uniform(0.5, 4.0), 3),
            alpha_0=round(rng.uniform(0.1, 0.9), 4),
            zero_lift_angle=round(rng.uniform(-0.15, 0.05), 4),
            c_d0=round(rng.uniform(0.0, 0.1), 4),
            sharpness=round(rng.uniform(50.0, 150.0), 1),
        )
        found.append(OtherRotor(BLADES[k % len(BLADES)], int(rng.integers(2, 7)), airfoil))
    return found


def other_flow(count: int, seed: int) -> Flow:
    """2000-10000 rpm, 0-20 m/s, 0-90 deg."""
    rng = np.random.default_rng(seed)
    omega = rng.uniform(2000.0, 10000.0, count) * np.pi / 30.0
    speed, beta = rng.uniform(0.0, 20.0, count), rng.uniform(0.0, 0.5 * np.pi, count)
    return omega, speed * np.cos(beta), speed * np.sin(beta)


def error_scales_of(model: pm.Model, omega: Numbers) -> dict[str, Numbers]:
    """Static loads by name of load [N] and [N m], (N,); of a blade stalled at rest, instead of
    thrust, rho A (Omega R)^2 / 2 times the solidity."""
    rotor = pm.Rotor(model)
    rest = rotor.loads(omega[0], 0.0, 0.0)
    blade, rates = model.propeller, (omega / omega[0]) ** 2
    thrust, torque = abs(float(rest.thrust)) * rates, abs(float(rest.torque)) * rates
    if rotor.inflow(float(omega[0]), 0.0, 0.0).stalled[:, 0].mean() > 0.5:
        area = blade.blades * np.trapezoid(blade.chord, blade.station)
        thrust = 0.5 * model.air.density * area * (omega * blade.radius) ** 2
        torque = thrust * blade.radius
    return error_scales({"thrust": thrust, "torque": torque}, blade.radius)
