"""The constants that come with propmap."""

from __future__ import annotations

import numpy as np

import propmap as pm
from propmap import catalogue
from propmap.catalogue.identified import LIFT_LAW, all_identified, identified
from propmap.catalogue.lookup import measurement


def test_every_entry_has_a_blade_and_a_covariance_that_is_one() -> None:
    entries = all_identified()
    assert len({(one.propeller, one.blades) for one in entries}) == len(entries) > 130
    for one in entries:
        assert one.propeller in catalogue.names()
        assert np.linalg.eigvalsh(one.covariance).min() > 0.0, one.propeller
        assert 0.0 < one.thrust_rms < 0.02 and 0.0 < one.power_rms < 0.02
        assert one.rpm_low <= one.rpm_high and one.rows >= one.static_rows
        assert one.airfoil.lift_law == LIFT_LAW and one.verdict


def test_they_are_found_by_blade_and_number_of_blades() -> None:
    two, three = (identified("UIUC-DA4022-5x3.75", blades) for blades in (2, 3))
    assert two is not None and three is not None
    assert (two.blades, three.blades) == (2, 3) and two.constants[0] != three.constants[0]
    assert identified("uiuc-da4022-5x3.75", 7) is None and identified("none", 2) is None


def test_nine_propellers_in_ten_are_fitted_well() -> None:
    """What the section law with its two further terms is worth, over all propellers."""
    thrust, power = (
        np.array([getattr(one, name) for one in all_identified()])
        for name in ("thrust_rms", "power_rms")
    )
    assert np.median(thrust) <= 0.0026 and np.quantile(thrust, 0.9) <= 0.0048
    assert np.median(power) <= 0.0018 and np.quantile(power, 0.9) <= 0.0036


def test_the_8x6e_has_the_measured_loads() -> None:
    """With the paper's constants, thrust in axial flow is 40 % low."""
    measured = measurement("uiuc-8x6e")
    one = identified("apc-8x6e", 2)
    assert one is not None
    rotor = pm.Rotor(pm.Model(pm.propeller("apc-8x6e"), one.airfoil))
    found = rotor.loads(measured.omega, measured.speed, measured.beta)
    for name, most in (("thrust", 0.06), ("torque", 0.05)):
        told = measured.loads[name]
        error = np.sqrt(np.mean((getattr(found, name) - told) ** 2) / np.mean(told**2))
        assert error < most, name
