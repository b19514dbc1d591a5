"""Loads with corrections of the blade and of its sections."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import propmap as pm
from propmap.loads import LOADS
from tests.oracle.literal_rotor import literal_loads
from tests.oracle.points import MU, RHO, SECTIONS

BLADE, LAW = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")
BOTH = ("blade-to-hub", "radial-friction")


def rotor(*texts: str, accuracy: str = "standard") -> pm.Rotor:
    corrections = tuple(pm.correction(text) for text in texts)
    model = pm.Model(BLADE, LAW, corrections=corrections)
    return pm.Rotor(model, accuracy=accuracy)


def literal(omega: float, along: float, across: float, hub: float) -> dict[str, float]:
    """The literal rotor on a blade that was continued beforehand, by hand."""
    first = float(BLADE.station[0])
    chord_at = PchipInterpolator(BLADE.station, BLADE.chord)
    taper = (float(chord_at(first + 0.01016)) - BLADE.chord[0]) / 0.01016
    inside = np.linspace(hub, first, 40)[:-1]
    pitch = 2.0 * np.pi * first * np.tan(BLADE.twist[0])
    chord = np.clip(BLADE.chord[0] - taper * (first - inside), 0.5 * BLADE.chord[0], BLADE.chord[0])
    return literal_loads(
        np.concatenate([inside, BLADE.station]),
        np.concatenate([chord, BLADE.chord]),
        np.concatenate([np.arctan(pitch / (2.0 * np.pi * inside)), BLADE.twist]),
        BLADE.blades,
        SECTIONS["apc"],
        *(RHO, MU, omega, along, across),
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("omega", "along", "across"),
    [
        (600.0, 0.0, 0.0),
        (600.0, 6.0, 8.0),
        (500.0, 0.0, 15.0),
        (700.0, 3.0, 1.0),
        (600.0, 12.0, 0.0),
    ],
)
def test_a_longer_blade_has_the_loads_of_the_literal_rotor(
    omega: float, along: float, across: float
) -> None:
    """To 0.1 % of static loads, like every load."""
    one = rotor("blade-to-hub:radius_m=0.008")
    got, still = one.loads_at_velocity(omega, [across, 0.0, along]), one.loads(omega, 0.0, 0.0)
    want = literal(omega, along, across, 0.008)
    for name in ("thrust", "drag", "torque", "roll_moment"):
        load = LOADS[name]
        scale = float(getattr(still, load.scale))
        scale *= 1.0 if load.unit == LOADS[load.scale].unit else BLADE.radius
        assert float(getattr(got, name)) == pytest.approx(want[name], abs=1e-3 * scale), name


def test_a_blade_that_is_hardly_longer_has_hardly_other_loads() -> None:
    points = (600.0, np.array([0.0, 3.0, 10.0, 9.0]), np.array([0.0, 0.3, 1.4, 1.7]))
    plain = rotor(accuracy="fine").loads(*points)
    hub = float(BLADE.station[0]) - 1e-6
    longer = rotor(f"blade-to-hub:radius_m={hub!r}", accuracy="fine").loads(*points)
    for name in LOADS:
        off = np.abs(getattr(longer, name) - getattr(plain, name))
        assert off.max() < 2e-4 * float(plain.thrust.max()), name


def test_what_is_inside_is_dragged_along_and_lifts_little() -> None:
    points = (600.0, np.array([5.0, 10.0, 15.0]), np.pi / 2)
    plain, longer = rotor().loads(*points), rotor("blade-to-hub").loads(*points)
    assert (longer.drag > 1.05 * plain.drag).all()
    assert (longer.drag < 1.25 * plain.drag).all()
    np.testing.assert_allclose(longer.thrust, plain.thrust, rtol=0.02)
    smaller = rotor("blade-to-hub:radius_m=0.005").loads(*points)
    assert (smaller.drag > longer.drag).all()


def test_reverse_flow_and_inflow_reach_to_the_hub() -> None:
    one, plain = rotor("blade-to-hub"), rotor()
    assert one.inflow(600.0, 10.0, 1.5).radius[0] == pytest.approx(0.08 * BLADE.radius)
    longer, shorter = (float(r.loads(600.0, 20.0, 1.5).reverse_flow) for r in (one, plain))
    assert longer > shorter
    assert one.model.reynolds(600.0, 10.0, 1.5)[0] < plain.model.reynolds(600.0, 10.0, 1.5)[0]


def test_a_mirrored_rotor_has_a_mirrored_wrench() -> None:
    """About the plane of symmetry y = 0: force (x, -y, z), moment (-x, y, -z)."""
    one = rotor("pitt-peters", *BOTH)
    ccw = one.wrench(600.0, [7.0, 3.0, 2.0], "ccw")
    cw = one.wrench(600.0, [7.0, -3.0, 2.0], "cw")
    np.testing.assert_allclose(cw.force, ccw.force * [1.0, -1.0, 1.0], rtol=1e-12)
    np.testing.assert_allclose(cw.moment, ccw.moment * [-1.0, 1.0, -1.0], rtol=1e-12)


def test_points_of_the_whole_envelope_have_loads_or_a_status() -> None:
    random = np.random.default_rng(5)
    points = (
        random.uniform(200.0, 900.0, 60),
        random.uniform(0.0, 20.0, 60),
        random.uniform(0.0, np.pi, 60),
    )
    got = rotor("pitt-peters", *BOTH).loads(*points)
    lost = got.status == "not_converged"
    for name in LOADS:
        assert (np.isfinite(getattr(got, name)) == ~lost).all()
    assert lost.sum() == 0
