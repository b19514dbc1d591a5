"""Shapes of the inflow around the disk: printed values, and limits."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import propmap as pm
from propmap.arrays.namespace import by_numpy
from propmap.physics.inflow_harmonics import (
    LEAST_MASS_FLOW,
    Coleman,
    DiskFlow,
    Drees,
    HarmonicResponse,
    InflowShape,
    PittPeters,
    PittPetersGradient,
    WhiteBlake,
)

TIP = 0.1
SHAPES = (PittPeters(), PittPetersGradient(), Coleman(), WhiteBlake(), Drees())


def disk(v_axial: float, v_inplane: float, inflow: float, omega: float = 600.0) -> DiskFlow:
    return DiskFlow(*(np.array([value]) for value in (omega, v_axial, v_inplane, inflow)))


def response(shape: InflowShape, flow: DiskFlow) -> SimpleNamespace:
    with by_numpy():
        found: HarmonicResponse = shape.response(flow, np.float64(TIP))
    return SimpleNamespace(**{k: float(v[0]) for k, v in found._asdict().items()})


def test_hover_has_the_gains_of_pitt_and_peters() -> None:
    """Their matrix L at chi = 0: 1/2, -2 and -2, over the mass-flow parameter 2 v_i."""
    area, mass_flow = np.pi * TIP**2, 2.0 * 5.0
    found = response(PittPeters(), disk(0.0, 0.0, 5.0))
    assert found.mean_by_thrust == pytest.approx(0.5 / (area * mass_flow))
    assert found.by_roll == pytest.approx(2.0 / (area * TIP * mass_flow))
    assert found.by_pitch == pytest.approx(found.by_roll)
    assert found.by_thrust == 0.0


def test_edgewise_flight_has_the_gains_of_pitt_and_peters() -> None:
    """At chi = 90 deg: 15 pi/64 from thrust, 4 from roll, none from pitch."""
    area, speed = np.pi * TIP**2, 12.0
    found = response(PittPeters(), disk(0.0, speed, 1e-9))
    assert found.by_thrust == pytest.approx(15.0 * np.pi / 64.0 / (area * speed))
    assert found.by_roll == pytest.approx(4.0 / (area * TIP * speed))
    assert found.by_pitch == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("shape", "factor"),
    [
        (PittPetersGradient(), 15.0 * np.pi / 32.0 * np.tan(np.radians(30.0))),
        (Coleman(), np.tan(np.radians(30.0))),
        (WhiteBlake(), np.sqrt(2.0) * np.sin(np.radians(60.0))),
    ],
)
def test_gradients_at_a_skew_of_sixty_degrees(shape: InflowShape, factor: float) -> None:
    through, inflow = 4.0, 3.0
    flow = disk(through - inflow, through * np.tan(np.radians(60.0)), inflow)
    found = response(shape, flow)
    assert found.longitudinal == pytest.approx(factor * inflow)
    assert found.lateral == 0.0


def test_drees_at_an_advance_ratio() -> None:
    """4/3 (1 - cos chi - 1.8 mu^2) / sin chi and -2 mu."""
    omega, inflow, through, across = 600.0, 3.0, 4.0, 9.0
    mu, chi = across / (omega * TIP), np.arctan2(across, through)
    found = response(Drees(), disk(through - inflow, across, inflow, omega))
    factor = 4.0 / 3.0 * (1.0 - np.cos(chi) - 1.8 * mu**2) / np.sin(chi)
    assert found.longitudinal == pytest.approx(factor * inflow)
    assert found.lateral == pytest.approx(-2.0 * mu * inflow)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("v_axial", [-8.0, 0.0, 8.0])
def test_axial_flow_has_no_harmonics_of_its_own(shape: InflowShape, v_axial: float) -> None:
    found = response(shape, disk(v_axial, 0.0, 5.0))
    assert (found.lateral, found.longitudinal, found.by_thrust) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_rotor_at_rest_has_finite_gains(shape: InflowShape) -> None:
    found = response(shape, disk(0.0, 0.0, 0.0, omega=0.0))
    assert np.isfinite(list(vars(found).values())).all()


def test_the_mass_flow_is_the_slope_of_the_momentum_thrust() -> None:
    inflow, step = 3.0, 1e-6
    with by_numpy():
        flows = [disk(2.0, 7.0, inflow + by) for by in (step, -step)]
        above, below = (float((flow.inflow * flow.speed)[0]) for flow in flows)
        slope = (above - below) / (2.0 * step)
        assert float(disk(2.0, 7.0, inflow).mass_flow[0]) == pytest.approx(slope, rel=1e-8)


def test_the_mass_flow_has_lower_limits() -> None:
    braking, ring = disk(6.0, 0.5, -5.0), disk(-5.0, 0.5, 5.0)
    with by_numpy():
        assert braking.mass_flow == LEAST_MASS_FLOW * braking.speed
        assert ring.mass_flow == ring.recirculation == 5.0
        # The wake is not taken to leave along the disk.
        assert ring.skew_cosine > 0.99


def test_two_shapes_are_refused() -> None:
    two = (pm.correction("pitt-peters"), pm.correction("coleman"))
    with pytest.raises(pm.InputError, match="pitt-peters and coleman both set"):
        pm.Model(pm.propeller("apc-8x6e"), pm.airfoil("paper-apc"), corrections=two)
