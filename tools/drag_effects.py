"""Print what corrections change in the rotor drag of the APC 8x6E, as a table in Markdown.

Usage: python -m tools.drag_effects
"""

from __future__ import annotations

import numpy as np

from propmap.papers.gill_dandrea_2017.drag_effects import (
    ANGLES,
    SPEEDS,
    DragEffect,
    drag_effects,
)


def table(effects: list[DragEffect]) -> str:
    """A row per angle and speed: the paper's drag [mN], and the change in per cent [%] with each
    correction and all before it."""
    paper, *others = effects
    heads = ["β [deg]", "V [m/s]", "paper [mN]", *(f"+ `{one.corrections[-1]}`" for one in others)]
    rows = [heads, ["---:"] * len(heads)]
    for i, beta in enumerate(np.degrees(ANGLES)):
        for k, speed in enumerate(SPEEDS):
            cells = [f"{beta:.0f}", f"{speed:g}", f"{1e3 * paper.drag[i, k]:.0f}"]
            rows.append(cells + [_percent(one.change[i, k]) for one in others])
    return "\n".join(f"| {' | '.join(cells)} |" for cells in rows)


def _percent(share: float) -> str:
    return f"{100.0 * share:+.0f} %".replace("-", "\N{MINUS SIGN}")


if __name__ == "__main__":
    print(table(drag_effects()))
