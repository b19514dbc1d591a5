"""Tables of many columns in narrow windows: whole cells, and a word on what was left out."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from propmap.cli.output import WideGrid

HEADS = "<name|P shaft [W]|P electric [W]|throttle [%]|<status"
ROWS = [("uiuc-apcsf-11x4.7", "201.9", "263.2", "32.5", "ok"), ("b", "1", "2", "3", "rpm_limit")]
GRID = WideGrid(HEADS, ROWS, "", "caption", ("throttle [%]", "P shaft [W]"))


def shown(width: int) -> str:
    text = io.StringIO()
    Console(file=text, width=width, highlight=False, markup=False).print(GRID)
    return text.getvalue()


@pytest.mark.parametrize("width", [120, 68, 60, 50])
def test_no_cell_is_cut(width: int) -> None:
    text = shown(width)
    assert max(map(len, text.splitlines())) <= width
    assert "…" not in text and "uiuc-apcsf-11x4.7" in text and "rpm_limit" in text
    assert ("32.5" in text) != ("throttle [%]" in text.partition("hidden")[2])


def test_columns_go_in_their_order() -> None:
    assert "hidden" not in shown(120)
    assert "throttle" in shown(62).partition("hidden")[2]
    assert "P shaft" not in shown(62).partition("hidden")[2]
    narrow = shown(48)
    assert "201.9" not in narrow and "263.2" in narrow
