"""A table of a rotor on a mount holds the drag of both."""

from __future__ import annotations

import numpy as np
import pytest

import propmap
from propmap.table import build_table


@pytest.mark.slow
def test_the_drag_of_the_mount_is_in_the_table() -> None:
    bare = propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))
    model = bare.with_mount(propmap.correction("installed:factor=1,area_m2=0.0014"))
    table = build_table(
        propmap.Rotor(model),
        omega=(420.0, 460.0),
        speed=(13.0, 16.0),
        beta=(1.3, 0.5 * np.pi),
        tolerance=0.02,
        certificate_points=512,
    )
    point = (440.0, np.array([13.7, 15.2]), np.array([1.5, 1.4]))
    found = table.loads(*point)
    wanted, without = (propmap.Rotor(m).loads(*point) for m in (model, bare))
    static = propmap.Rotor(bare).loads(440.0, 0.0, 0.0).thrust
    np.testing.assert_allclose(found.drag, wanted.drag, atol=0.02 * static)
    assert (wanted.drag - without.drag > 0.04 * static).all()
    assert table.info["corrections"] == ["installed:factor=1,area_m2=0.0014,wake=1.0"]
    assert table.info["model_sha256"] == model.fingerprint()
