"""Tables and losses against the literal reference extended by them, descent included."""

from __future__ import annotations

import numpy as np
import pytest

import propmap as pm
from tests.oracle.frozen import EXTENDED_TABLE, frozen_loads
from tests.oracle.make_reference import EXTENDED, SECTION_OF, reference_row, solver
from tests.oracle.naca_0015 import FILE, naca_0015
from tests.oracle.points import extended_points

LOSSES = {
    "naca-0015": (),
    "tip-loss": ("tip-loss",),
    "hub-loss": ("hub-loss",),
    "both-losses": ("tip-loss", "hub-loss"),
}
BLADE = pm.propeller("apc-8x6e")


def extended_model(name: str) -> pm.Model:
    """The model that an extension's rows were computed for."""
    corrections = tuple(pm.correction(text) for text in LOSSES[name])
    if name in SECTION_OF:
        return pm.Model(BLADE, pm.airfoil(f"paper-{SECTION_OF[name]}"), corrections=corrections)
    if not FILE.exists():
        pytest.skip(f"{FILE.name} is not beside this checkout")
    table = naca_0015()
    section = pm.SectionTable(table.angle, table.reynolds, table.lift, table.drag)
    return pm.Model(BLADE, section, corrections=corrections)


@pytest.mark.parametrize("name", EXTENDED)
def test_loads_agree_with_the_extended_reference(name: str) -> None:
    """0.1 % of static thrust and torque, as of the paper's own rotor."""
    rotor = pm.Rotor(extended_model(name))
    rows = [row for row in frozen_loads(EXTENDED_TABLE) if row.set == name]
    assert sum(row.v_axial < 0.0 for row in rows) >= 10
    assert len(rows) >= 20
    want = {f: np.array([getattr(row, f) for row in rows]) for f in rows[0]._fields[1:]}
    velocity = np.stack([want["v_inplane"], 0.0 * want["rpm"], want["v_axial"]], axis=-1)
    got = rotor.loads_at_velocity(want["rpm"] * np.pi / 30.0, velocity)
    thrust, torque = want["static_thrust"], want["static_torque"]
    for field, scale in (
        ("thrust", thrust),
        ("drag", thrust),
        ("torque", torque),
        ("roll_moment", thrust * BLADE.radius),
    ):
        error = np.abs(getattr(got, field) - want[field]) / scale
        worst = rows[int(error.argmax())]
        assert error.max() < 1e-3, f"{field}: {error.max():.2e} at {worst}"


@pytest.mark.slow
@pytest.mark.parametrize("name", EXTENDED)
def test_the_frozen_extension_is_what_the_literal_code_gives(name: str) -> None:
    extended_model(name)  # skips where there is no table
    solve = solver(BLADE.station, BLADE.chord, BLADE.twist, BLADE.blades)
    frozen = [row for row in frozen_loads(EXTENDED_TABLE) if row.set == name]
    points = extended_points(len(frozen))
    for k in range(0, len(frozen), 13):
        assert reference_row(solve, name, points[k])[1:] == pytest.approx(frozen[k][1:], rel=1e-9)
