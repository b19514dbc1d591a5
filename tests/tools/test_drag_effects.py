"""The table of what corrections change in rotor drag."""

from __future__ import annotations

import numpy as np
import pytest

import propmap as pm
from tools.drag_effects import ADDED, ANGLES, SPEEDS, drag_effects, table


def test_each_is_added_to_those_before() -> None:
    found = drag_effects(ADDED[1:])
    assert [one.corrections for one in found] == [(), ADDED[1:2], ADDED[1:]]
    paper, longer, both = found
    assert (paper.change == 0.0).all()
    assert ((longer.change > 0.08) & (longer.change < 0.22)).all()
    more = both.drag / longer.drag - 1.0
    assert ((more > 0.02) & (more < 0.05)).all()
    model = pm.Model(pm.propeller("apc-8x6e"), pm.airfoil("paper-apc"))
    edgewise = pm.Rotor(model).loads(200.0 * np.pi, 10.0, np.pi / 2)
    # A batch has other nodes than a single point, within the accuracy promised.
    assert paper.drag[3, 1] == pytest.approx(float(edgewise.drag), rel=1e-3)


def test_the_table_says_the_change_in_per_cent() -> None:
    paper, longer = drag_effects(ADDED[1:2])
    lines = table([paper, longer]).splitlines()
    assert lines[0] == "| β [deg] | V [m/s] | paper [mN] | + `blade-to-hub` |"
    assert len(lines) == 2 + ANGLES.size * SPEEDS.size
    first = [cell.strip() for cell in lines[2].split("|")[1:-1]]
    assert first[:2] == ["45", "5"]
    assert float(first[2]) == round(1e3 * float(paper.drag[0, 0]))
    assert first[3] == f"+{round(100.0 * float(longer.change[0, 0]))} %"
