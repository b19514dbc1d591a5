"""A blade that flattens as it turns, against a blade measured flat; and its derivatives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.model.corrections import BladeUntwist

BLADE = propmap.propeller("apc-8x6e")
LAW = propmap.airfoil("paper-apc")
AT_100 = 100.0 / BLADE.radius
"""Rotational speed at which the tip moves at 100 m/s [rad/s]."""


def rotor(angle: float | None, blade: propmap.Propeller = BLADE) -> propmap.Rotor:
    corrections = () if angle is None else (BladeUntwist(angle),)
    model = propmap.Model(blade, LAW, corrections=corrections)
    return propmap.Rotor(model, accuracy="fine")


@pytest.mark.parametrize("share", [0.5, 1.0, 1.5])
def test_loads_are_those_of_a_blade_with_that_twist(share: float) -> None:
    s = BLADE.station / BLADE.radius
    lost = 0.03 * share**2 * s * (2.0 - s)
    flat = rotor(None, replace(BLADE, twist=BLADE.twist - lost))
    flow = (share * AT_100, [0.0, 6.0, 12.0], [0.0, 0.7, 1.5])
    bent, rigid = rotor(0.03).loads(*flow), rotor(None).loads(*flow)
    for name in LOADS:
        wanted = getattr(flat.loads(*flow), name)
        np.testing.assert_allclose(getattr(bent, name), wanted, rtol=2e-4, atol=1e-6)
    assert (bent.thrust < rigid.thrust).all()


def test_slow_blades_and_none_are_rigid() -> None:
    flow = (0.02 * AT_100, 0.1, 1.0)
    assert rotor(0.05).loads(*flow).thrust == pytest.approx(rotor(None).loads(*flow).thrust, 1e-3)
    assert rotor(0.0).loads(AT_100, 5.0, 1.0) == rotor(None).loads(AT_100, 5.0, 1.0)


def test_derivatives_by_it_and_by_rotational_speed() -> None:
    flow = (np.array([AT_100]), np.array([4.0]), np.array([7.0]))
    found = rotor(0.02).gradients(("untwist", "omega"), *flow).slopes
    speed, beta = np.hypot(4.0, 7.0), np.arctan2(7.0, 4.0)

    def at(angle: float, omega: float) -> list[float]:
        loads = rotor(angle).loads(omega, speed, beta)
        return [float(getattr(loads, name)) for name in LOADS]

    steps = ((1e-4, 0.0), (0.0, 1.0))
    for k, (angle, omega) in enumerate(steps):
        up, down = at(0.02 + angle, AT_100 + omega), at(0.02 - angle, AT_100 - omega)
        wanted = (np.array(up) - np.array(down)) / (2.0 * (angle + omega))
        np.testing.assert_allclose(found[:, k, 0], wanted, rtol=2e-3, atol=1e-7)


@pytest.mark.parametrize("angle", [0.3, -0.3, np.nan, np.inf])
def test_angles_that_no_blade_survives_are_refused(angle: float) -> None:
    with pytest.raises(InputError, match="100 m/s"):
        BladeUntwist(angle)
