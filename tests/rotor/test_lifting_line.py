"""Inflow that varies around the disk, against an unsteady lifting line."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.lifting_line import checks
from benchmarks.lifting_line.compare import (
    CONSTANTS,
    Point,
    by_rigid_wake,
    by_theory,
)
from benchmarks.lifting_line.wake import Resolution


def test_an_elliptic_wing_has_prandtls_lift() -> None:
    found, known = checks.elliptic_wing()
    assert found == pytest.approx(known, rel=2e-3)


@pytest.mark.parametrize("k", [0.05, 0.3])
def test_a_heaving_section_has_theodorsens_lift(k: float) -> None:
    """Within what a vortex at a quarter of the chord loses against thin-airfoil theory."""
    for found, known in checks.heaving_section(k, phases=48):
        assert found == pytest.approx(known, abs=0.02)


def test_a_wake_of_constant_circulation_is_colemans_cylinder() -> None:
    skew = float(np.radians(40.0))
    mean, slope = checks.skewed_cylinder(skew, Resolution(stations=2, phases=24, turns=20))
    assert mean.found == pytest.approx(mean.known, rel=3e-3)
    assert slope.found == pytest.approx(slope.known, rel=0.02, abs=1e-9)


@pytest.mark.slow
def test_roll_in_oblique_flow_is_that_of_a_lifting_line() -> None:
    """Within 20 % on a coarse lattice with the same constants, where the annulus is 20 % above."""
    point = Point(10.0, 75.0)
    found = by_rigid_wake(CONSTANTS, point, Resolution(stations=10, phases=24, turns=4))
    line = found.loads
    assert found.left < 1e-5
    theories = by_theory([point])
    (harmonic,), (annulus,) = theories["pitt_peters"], theories["annulus"]
    assert harmonic.roll_moment == pytest.approx(line.roll_moment, rel=0.2)
    miss = abs(harmonic.roll_moment - line.roll_moment)
    assert miss < 0.5 * abs(annulus.roll_moment - line.roll_moment)
    assert line.pitch_moment * harmonic.pitch_moment > 0.0
    assert harmonic.drag == pytest.approx(line.drag, rel=0.25)
