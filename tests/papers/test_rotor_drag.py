"""What is in the rotor drag of 2019: a known factor and a known plate are found again."""

from __future__ import annotations

import numpy as np
import pytest

import propmap
from papers.gill_dandrea_2017.rotor_drag import (
    fits,
    momentum_inflow,
    sources,
)
from papers.gill_dandrea_2017.tunnel import (
    OBLIQUE,
    OBLIQUE_LABEL,
    OTHER_FORM,
    OTHER_LABEL,
    RECOMMENDED_LABEL,
    Compared,
)
from propmap.catalogue.lookup import measurement
from propmap.typing import Floats

DATA = measurement(OBLIQUE)
LAW = propmap.airfoil("apc-8x6e-2019")
RADIUS = propmap.propeller("apc-8x6e").radius


def _compared(theory: Floats) -> Compared:
    """The oblique set with an invented theory, of the measured thrust and this drag [N]."""
    loads = {"thrust": DATA.loads["thrust"], "drag": theory}
    predicted = {OBLIQUE_LABEL: loads, RECOMMENDED_LABEL: loads}
    predicted[OTHER_LABEL] = dict(measurement(OTHER_FORM).loads)
    return Compared(DATA, {OBLIQUE_LABEL: LAW}, predicted)


def test_momentum_inflow_is_glauert_s() -> None:
    product = np.array([9.0, 9.0, 9.0, -2.0])
    inplane, axial = np.array([0.0, 40.0, 3.0, 5.0]), np.array([0.0, 0.0, 4.0, 10.0])
    found = momentum_inflow(product, inplane, axial)
    np.testing.assert_allclose(found * np.hypot(inplane, axial + found), product, rtol=1e-9)
    # At rest v_h, in fast edgewise flight T/(2 rho A V), against a braking rotor negative.
    assert found[0] == pytest.approx(3.0)
    assert found[1] == pytest.approx(9.0 / 40.0, rel=1e-3)
    assert found[3] < 0.0


def test_a_factor_and_a_plate_are_told_apart() -> None:
    generator = np.random.default_rng(26)
    theory, pressure = generator.random((2, 50)) * np.array([[0.4], [90.0]])
    factor, plate, both = fits(theory, pressure, 1.3 * theory + 14e-4 * pressure)
    assert (both.factor, both.area) == (pytest.approx(1.3), pytest.approx(14e-4))
    assert both.error < 1e-9 < min(factor.error, plate.error)
    assert (factor.area, plate.factor) == (0.0, 1.0)
    _, plate, _ = fits(theory, pressure, theory + 20e-4 * pressure)
    assert plate.area == pytest.approx(20e-4) and plate.error < 1e-9
    # Drag below the theory's leaves nothing for a plate.
    factor, plate, both = fits(theory, pressure, 0.5 * theory)
    assert plate.area == both.area == 0.0
    assert [factor.factor, both.factor] == pytest.approx([0.5, 0.5])


def test_sources_by_shares_that_propellers_have_in_common() -> None:
    tip_speed = DATA.omega * RADIUS
    advance = DATA.speed * np.sin(DATA.beta) / tip_speed
    size = 0.5 * DATA.air_density * np.pi * RADIUS**2 * tip_speed**2
    theory, recommended, chord_line, zero_lift, polynomials, model = sources(
        _compared(0.02 * size * advance)
    )
    assert [theory.incidence, theory.edgewise] == pytest.approx([0.02, 0.02])
    assert recommended.edgewise == theory.edgewise
    edgewise = (DATA.beta > 1.5) & (DATA.speed > 0.0)
    share = (0.02 * size * advance)[edgewise].sum()
    share /= (DATA.loads["thrust"] * advance)[edgewise].sum()
    assert theory.edgewise_by_thrust == pytest.approx(share)
    # The campaign's own figure for this propeller, 0.043, at every angle.
    assert polynomials.incidence == pytest.approx(0.043, rel=0.01)
    assert polynomials.edgewise == pytest.approx(0.043, rel=0.01)
    assert model.edgewise == pytest.approx(0.043, rel=0.05)
    # A fin of more side area has more side force; it says nothing of edgewise flow.
    assert 0.0 < chord_line.incidence < zero_lift.incidence
    assert np.isnan(chord_line.edgewise) and np.isnan(chord_line.edgewise_by_thrust)
