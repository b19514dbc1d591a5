"""The package against the literal SciPy reference, which shares no code with the theory.

Tables, losses, and inflow that varies around the disk extend it; these cover descent.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import propmap as pm
from propmap.loads import LOADS, error_scales
from propmap.units import RPM
from tests.oracle.make_reference import BLADE, EXTENDED, SECTION_OF, frozen_rows, solved
from tests.oracle.naca_0015 import FILE, naca_0015
from tests.oracle.points import SECTIONS

CORRECTIONS = {
    "tip-loss": ("tip-loss",),
    "hub-loss": ("hub-loss",),
    "both-losses": ("tip-loss", "hub-loss"),
}
CASES = [
    *(("reference_loads", name) for name in SECTIONS),
    *(("reference_loads_extended", name) for name in EXTENDED),
    *(("reference_loads_harmonic", name) for name in SECTIONS),
]
"""Tables, and sets of their rows."""


def rows_of(table: str, name: str) -> list[Any]:
    return [row for row in frozen_rows(table) if row.set == name]


def model_of(table: str, name: str) -> pm.Model:
    """The model that the rows of a set were computed for."""
    texts = CORRECTIONS.get(name, ("pitt-peters",) if table.endswith("harmonic") else ())
    corrections = tuple(pm.correction(text) for text in texts)
    if name != "naca-0015":
        law = pm.airfoil(f"paper-{SECTION_OF.get(name, name)}")
        return pm.Model(BLADE, law, corrections=corrections)
    if not FILE.exists():
        pytest.skip(f"{FILE.name} is not beside this checkout")
    section = naca_0015()
    law = pm.SectionTable(section.angle, section.reynolds, section.lift, section.drag)
    return pm.Model(BLADE, law)


@pytest.mark.parametrize(
    ("table", "name", "accuracy", "limit"),
    [
        *((*case, "standard", 1e-3) for case in CASES),
        *(pytest.param(*case, "fine", 1e-4, marks=pytest.mark.slow) for case in CASES[:3]),
    ],
)
def test_loads_agree_with_the_reference(table: str, name: str, accuracy: str, limit: float) -> None:
    """0.1 % of static thrust and torque by default, 0.01 % with accuracy="fine"."""
    rotor, rows = pm.Rotor(model_of(table, name), accuracy=accuracy), rows_of(table, name)
    assert len(rows) >= {"reference_loads": 200, "reference_loads_extended": 20}.get(table, 60)
    assert table == "reference_loads" or sum(row.v_axial < 0.0 for row in rows) >= 5
    want = {
        field: np.array([getattr(row, field) for row in rows]) for field in list(vars(rows[0]))[1:]
    }
    omega = want["rpm"] * RPM if "rpm" in want else want["omega"]
    velocity = np.stack([want["v_inplane"], 0.0 * omega, want["v_axial"]], axis=-1)
    got = rotor.loads_at_velocity(omega, velocity)
    static = {"thrust": want["static_thrust"], "torque": want["static_torque"]}
    scales = error_scales(static, BLADE.radius)
    for load in want.keys() & LOADS.keys():
        error = np.abs(getattr(got, load) - want[load]) / scales[load]
        worst = rows[int(error.argmax())]
        assert error.max() < limit, f"{load}: {error.max():.2e} at {worst}"


@pytest.mark.slow
@pytest.mark.parametrize(
    "table", sorted({table for table, _ in CASES} | {"reference_loads_other_laws"})
)
def test_the_frozen_loads_are_what_the_literal_code_gives(table: str) -> None:
    rows = [
        row for row in frozen_rows(table) if getattr(row, "set", "") != "naca-0015" or FILE.exists()
    ]
    # The table of harmonics has nine digits.
    exact = 1e-6 if table.endswith("harmonic") else 1e-9
    for row in rows[:: len(rows) // 3]:
        want, got = (list(vars(one).values())[1:] for one in (row, solved(row)))
        assert got == pytest.approx(want, rel=exact, abs=exact)
