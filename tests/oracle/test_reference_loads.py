"""The package against the literal SciPy reference, which shares no code with the theory."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import propmap as pm
from propmap.results import Loads
from propmap.rotor import Rotor
from tests.oracle.frozen import ReferenceLoads, frozen_loads
from tests.oracle.make_reference import reference_row, solver
from tests.oracle.points import reference_points

SETS = ("soft", "stiff", "apc")


def _columns(name: str) -> dict[str, NDArray[np.float64]]:
    rows: list[ReferenceLoads] = [row for row in frozen_loads() if row.set == name]
    fields = [f for f in ReferenceLoads._fields if f != "set"]
    return {f: np.array([getattr(row, f) for row in rows]) for f in fields}


def _loads(rotor: Rotor, want: dict[str, NDArray[np.float64]]) -> Loads:
    across, along = want["v_inplane"], want["v_axial"]
    velocity = np.stack([across, np.zeros_like(across), along], axis=-1)
    return rotor.loads_at_velocity(want["rpm"] * np.pi / 30.0, velocity)


@pytest.mark.parametrize(
    ("accuracy", "limit"),
    [("standard", 1e-3), pytest.param("fine", 1e-4, marks=pytest.mark.slow)],
)
@pytest.mark.parametrize("name", SETS)
def test_loads_agree_with_the_reference(name: str, accuracy: str, limit: float) -> None:
    """0.1 % of static thrust and torque by default, 0.01 % with accuracy="fine"."""
    rotor = pm.Rotor(
        pm.Model(pm.propeller("apc-8x6e"), pm.airfoil(f"paper-{name}")), accuracy=accuracy
    )
    want = _columns(name)
    assert want["rpm"].size >= 200
    got = _loads(rotor, want)
    thrust, torque = want["static_thrust"], want["static_torque"]
    assert np.max(np.abs(got.thrust - want["thrust"]) / thrust) < limit
    assert np.max(np.abs(got.drag - want["drag"]) / thrust) < limit
    assert np.max(np.abs(got.torque - want["torque"]) / torque) < limit
    radius = rotor.model.propeller.radius
    assert np.max(np.abs(got.roll_moment - want["roll_moment"]) / (thrust * radius)) < limit


@pytest.mark.slow
@pytest.mark.parametrize("name", SETS)
def test_the_frozen_reference_is_what_the_literal_code_gives(name: str) -> None:
    blade = pm.propeller("apc-8x6e")
    solve = solver(blade.station, blade.chord, blade.twist, blade.blades)
    frozen = [row for row in frozen_loads() if row.set == name]
    points = reference_points(len(frozen))
    for k in range(0, len(frozen), 83):
        assert reference_row(solve, name, points[k])[1:] == pytest.approx(frozen[k][1:], rel=1e-9)
