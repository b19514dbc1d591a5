"""Fields over the disk add up to the loads, whether the inflow varies around the disk or not.

The recommended model has friction along the blade; the paper's has its root cut out here.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap as pm
from propmap.model.corrections import Installed

FLOWS = {
    "oblique": (628.0, 12.0, 1.2),
    "edgewise": (628.0, 6.0, 0.5 * np.pi),
    "descent": (500.0, 8.0, 2.6),
    "climb": (628.0, 5.0, 0.0),
}


@pytest.mark.parametrize("flow", FLOWS.values(), ids=FLOWS)
@pytest.mark.parametrize("corrections", [None, ()], ids=["recommended", "paper"])
def test_fields_add_up_to_the_loads(
    corrections: tuple[()] | None, flow: tuple[float, float, float]
) -> None:
    model = pm.catalogue_model("apc-8x6e", corrections=corrections)
    if corrections is None:
        model = model.with_mount(Installed(1.0, 0.0))
    else:
        model = replace(model, propeller=model.propeller.with_root_cutout(0.04))
    rotor, blade = pm.Rotor(model), model.propeller
    radius = np.linspace(blade.root, blade.radius, 400)
    field, loads = rotor.inflow(*flow, radius=radius), rotor.loads(*flow)

    def along(values: np.ndarray) -> float:
        return float(np.trapezoid(values, radius))

    def around(values: np.ndarray) -> np.ndarray:
        return np.trapezoid(values, field.azimuth, axis=1) / (2.0 * np.pi)

    force, psi = blade.blades * field.normal_force, field.azimuth
    # The trapezoid rule and the radial nodes of the loads differ by less than 1e-4.
    assert along(field.thrust_per_radius) == pytest.approx(loads.thrust, rel=2e-4)
    assert along(field.torque_per_radius) == pytest.approx(loads.torque, rel=2e-4)
    assert along(field.drag_per_radius) == pytest.approx(loads.drag, rel=2e-3, abs=1e-9)
    assert along(around(force)) == pytest.approx(loads.thrust, rel=2e-4)
    size = 2e-4 * float(loads.thrust) * blade.radius
    assert along(radius * around(force * np.sin(psi))) == pytest.approx(loads.roll_moment, abs=size)
    assert -along(radius * around(force * np.cos(psi))) == pytest.approx(
        loads.pitch_moment, abs=size
    )
    np.testing.assert_allclose(around(field.local_inflow), field.inflow, rtol=1e-9)
