"""Ribner's fin analogy: its limits, and the theory where both must agree."""

from __future__ import annotations

import numpy as np
import pytest

import propmap
from papers.gill_dandrea_2017.fin_analogy import (
    dynamic_pressure_factor,
    inflow_factor,
    side_area,
    side_force,
)
from propmap.errors import InputError

RHO, RADIUS, ROOT = 1.225, 0.1, 0.02


def _blade(twist: np.ndarray, station: np.ndarray, blades: int = 2) -> propmap.Propeller:
    return propmap.Propeller("made", blades, station, np.full_like(station, 0.015), twist)


def test_inflow_carries_the_thrust() -> None:
    thrust, speed = np.array([0.0, 0.5, 4.0]), np.array([12.0, 8.0, 2.0])
    a = inflow_factor(thrust, speed, RADIUS, RHO)
    assert a[0] == 0.0
    # Mass flow through the disk times the change of velocity far behind it.
    flow = RHO * np.pi * RADIUS**2 * speed * (1.0 + a)
    assert flow * 2.0 * a * speed == pytest.approx(thrust, rel=1e-12)
    assert np.isnan(inflow_factor(-10.0, 3.0, RADIUS, RHO))
    with pytest.raises(InputError, match="airspeed"):
        inflow_factor(1.0, 0.0, RADIUS, RHO)


def test_dynamic_pressure_factor_between_its_limits() -> None:
    assert dynamic_pressure_factor(0.0) == 1.0
    a = np.linspace(0.0, 5.0, 200)
    factor = dynamic_pressure_factor(a)
    assert (np.diff(factor) > 0.0).all()
    # Strip theory with an undisturbed sidewash has 1 + a; the correction is at most a fifth.
    assert (factor >= 1.0 + a).all() and (factor <= 1.25 * (1.0 + a)).all()
    assert dynamic_pressure_factor(1e4) == pytest.approx(1.0 + 1e4, rel=1e-3)


def test_side_area_by_hand() -> None:
    station = np.linspace(ROOT, RADIUS, 9)
    flat = _blade(np.full(9, np.radians(30.0)), station, blades=3)
    assert side_area(flat) == pytest.approx(1.5 * 0.015 * (RADIUS - ROOT) * 0.5, rel=1e-9)
    raised = side_area(flat, np.radians(-15.0))
    assert raised == pytest.approx(side_area(flat) * np.sqrt(2.0), rel=1e-9)


def test_force_grows_as_a_fins() -> None:
    blade = _blade(np.full(9, 0.4), np.linspace(ROOT, RADIUS, 9))
    force = side_force(blade, 0.0, 9.0, 0.1, RHO)
    slope = 2.0 * np.pi * 8.0 / 10.0
    assert force == pytest.approx(0.5 * RHO * 81.0 * slope * side_area(blade) * np.sin(0.1))
    assert side_force(blade, 1.0, 9.0, 0.1, RHO) > force


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
