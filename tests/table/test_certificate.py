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

from .conftest import invented_content, random_points

SMOOTH, JUMP = 0.002, 0.04
ROWS, COLUMNS = slice(6, 10), slice(24, 28)


def _content() -> TableContent:
    cells = np.zeros_like(invented_content().cells)
    cells[ROWS, COLUMNS] = 2
    return replace(invented_content(), cells=cells)


class _Off:
    """A rotor whose thrust is off the table's by shares of static thrust: a jump in some cells."""

    def __init__(self, content: TableContent) -> None:
        self.table = LoadTable(replace(content, cells=np.zeros_like(content.cells)))
        self.cells = content.cells > 0
        self.model = SimpleNamespace(propeller=SimpleNamespace(radius=content.radius))

    def loads(self, omega: np.ndarray, speed: np.ndarray, beta: np.ndarray) -> Any:
        found = self.table.loads(omega, speed, beta)
        content = self.table.content
        advance = speed / (omega * content.radius)
        inside = self.cells[locate(content.advance, advance)[0], locate(content.beta, beta)[0]]
        still = self.table.loads(omega, 0.0, 0.0).thrust
        moves = speed > 0.0
        thrust = found.thrust + np.where(inside, JUMP, SMOOTH) * moves * still
        values = {name: getattr(found, name) for name in LOADS}
        status = np.full(omega.shape, "ok")
        return SimpleNamespace(**{**values, "thrust": thrust}, status=status)


def test_unresolved_cells_have_their_own_bound() -> None:
    """How many, how much of the envelope, and how large the error is there."""
    content = _content()
    table = LoadTable(content)
    rotor: Any = _Off(content)
    told, _ = certify(table, CachedModel(rotor, content.omega), 0.005, points=2048, seed=5)
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


def test_what_is_off_elsewhere_breaks_it() -> None:
    content = _content()
    rotor: Any = _Off(content)
    model = CachedModel(rotor, content.omega)
    unmarked = LoadTable(replace(content, cells=np.zeros_like(content.cells)))
    told, _ = certify(unmarked, model, 0.005, points=2048, seed=5)
    assert not told.holds
    assert told.max_error["thrust"] == pytest.approx(JUMP, rel=1e-6)
    assert (told.unresolved_cells, told.unresolved_volume, told.unresolved_points) == (0, 0.0, 0)
