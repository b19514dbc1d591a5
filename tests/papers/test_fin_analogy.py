"""Ribner's fin analogy: its limits, and the theory where both must agree."""

from __future__ import annotations

import numpy as np
import pytest

import propmap
from papers.gill_dandrea_2017.fin_analogy import (
    dynamic_pressure_factor,
    side_force,
)

RHO, RADIUS, ROOT = 1.225, 0.1, 0.02


def _blade(twist: np.ndarray, station: np.ndarray, blades: int = 2) -> propmap.Propeller:
    return propmap.Propeller("made", blades, station, np.full_like(station, 0.015), twist)


def test_dynamic_pressure_factor_between_its_limits() -> None:
    assert dynamic_pressure_factor(0.0) == 1.0
    a = np.linspace(0.0, 5.0, 200)
    factor = dynamic_pressure_factor(a)
    assert (np.diff(factor) > 0.0).all()
    # Strip theory with an undisturbed sidewash has 1 + a; the correction is at most a fifth.
    assert (factor >= 1.0 + a).all() and (factor <= 1.25 * (1.0 + a)).all()
    assert dynamic_pressure_factor(1e4) == pytest.approx(1.0 + 1e4, rel=1e-3)


def test_a_windmilling_screw_without_friction_is_a_fin() -> None:
    """A blade twisted along its own helix carries nothing; tilted, it is the fin of its side area.

    The theory knows no sidewash, so its section's lift slope is that of the whole fin.
    """
    omega, speed, incidence = 600.0, 10.0, 0.01
    station = np.linspace(ROOT, RADIUS, 60)
    blade = _blade(np.arctan(speed / (omega * station)), station)
    law = propmap.Airfoil(c_l1=2.0 * np.pi * 0.8, c_l2=2.0, c_d=0.0, alpha_0=0.5, c_d0=0.0, c_p=0.0)
    rotor = propmap.Rotor(propmap.Model(blade, law, propmap.Air(density=RHO)))
    loads = rotor.loads(omega, speed, incidence)
    assert abs(float(loads.thrust)) < 1e-3
    fin = side_force(blade, 0.0, speed, incidence, RHO)
    assert float(loads.drag) == pytest.approx(float(fin), rel=0.01)
