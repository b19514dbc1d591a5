"""What a certificate counts, on a model whose errors are known."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from propmap.table import LoadTable
from propmap.table.interpolation import TableContent, locate
from propmap.table.verification import CachedModel, certify

from .conftest import OffRotor, random_points

SMOOTH, JUMP = 0.002, 0.04
ROWS, COLUMNS = slice(6, 10), slice(24, 28)


def _off(content: TableContent, _: object, advance: Any, beta: Any) -> dict[str, Any]:
    """Thrust jumps in some cells."""
    i, j = locate(content.advance, advance)[0], locate(content.beta, beta)[0]
    jumps = (i >= ROWS.start) & (i < ROWS.stop) & (j >= COLUMNS.start) & (j < COLUMNS.stop)
    return {"thrust": np.where(jumps, JUMP, SMOOTH)}


def test_unresolved_cells_have_their_own_bound(invented: LoadTable) -> None:
    """How many, how much of the envelope, and how large the error is there."""
    content = invented.content
    cells = content.cells.copy()
    cells[ROWS, COLUMNS] = 2
    table = LoadTable(replace(content, cells=cells))
    rotor: Any = OffRotor(invented, _off)
    model = CachedModel(rotor, content.omega)
    told, _ = certify(table, model, 0.005, points=2048, seed=5)
    assert told.holds
    # The static loads between the ends of omega are linear in its root; so are the table's.
    assert told.max_error["thrust"] == pytest.approx(SMOOTH, rel=1e-6)
    assert told.rms_error["thrust"] == pytest.approx(SMOOTH, rel=1e-6)
    assert told.unresolved_max_error["thrust"] == pytest.approx(JUMP, rel=1e-6)
    assert told.unresolved_cells == 16
    status = table.loads(*random_points(table, 200_000, seed=14)).status
    share = np.mean(status == "unresolved")
    assert share > 0.002
    assert told.unresolved_volume == pytest.approx(share, rel=0.1)
    assert told.unresolved_points > 5 * told.unresolved > 0
    unmarked, _ = certify(invented, model, 0.005, points=2048, seed=5)
    assert not unmarked.holds
    assert unmarked.max_error["thrust"] == pytest.approx(JUMP, rel=1e-6)
    assert (unmarked.unresolved_cells, unmarked.unresolved_volume) == (0, 0.0)
