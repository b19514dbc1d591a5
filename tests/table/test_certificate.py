"""What a certificate counts, on a model whose errors are known."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from propmap.loads import LOADS
from propmap.table import LoadTable
from propmap.table.interpolation import TableContent, locate
from propmap.table.verification import CachedModel, certify

from .conftest import random_points

SMOOTH, JUMP = 0.002, 0.04
ROWS, COLUMNS = slice(6, 10), slice(24, 28)


class _Off:
    """A rotor whose thrust is off the table's by shares of static thrust: a jump in some cells."""

    def __init__(self, content: TableContent) -> None:
        self.table = LoadTable(content)
        self.model = SimpleNamespace(propeller=SimpleNamespace(radius=content.radius))

    def loads(self, omega: np.ndarray, speed: np.ndarray, beta: np.ndarray) -> Any:
        content = self.table.content
        i = locate(content.advance, speed / (omega * content.radius))[0]
        j = locate(content.beta, beta)[0]
        jumps = (i >= ROWS.start) & (i < ROWS.stop) & (j >= COLUMNS.start) & (j < COLUMNS.stop)
        found, still = self.table.loads(omega, speed, beta), self.table.loads(omega, 0.0, 0.0)
        values = {name: getattr(found, name) for name in LOADS}
        off = np.where(jumps, JUMP, SMOOTH) * (speed > 0.0) * still.thrust
        values["thrust"] = values["thrust"] + off
        return SimpleNamespace(**values, status=np.full(omega.shape, "ok"))


def test_unresolved_cells_have_their_own_bound(invented: LoadTable) -> None:
    """How many, how much of the envelope, and how large the error is there."""
    content = invented.content
    cells = content.cells.copy()
    cells[ROWS, COLUMNS] = 2
    table = LoadTable(replace(content, cells=cells))
    rotor: Any = _Off(content)
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
