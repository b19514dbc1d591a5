"""Print a Markdown table of the effect of corrections on the rotor drag of the APC 8x6E.

Usage: python -m tools.drag_effects
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

import propmap
from propmap.rotor import Rotor
from propmap.typing import Floats

ADDED = ("pitt-peters", "blade-to-hub", "radial-friction")
"""Corrections in the order of their addition to the paper's model."""

ROTATION = 6000.0 * np.pi / 30.0  # Omega [rad/s]
ANGLES = np.radians([45.0, 60.0, 75.0, 90.0])  # beta [rad]
SPEEDS = np.array([5.0, 10.0, 15.0])  # V [m/s]


class DragEffect(NamedTuple):
    """Rotor drag with a set of corrections; arrays have the shape (angles, speeds)."""

    corrections: tuple[str, ...]  # names for ``propmap.correction``; empty for the paper's model
    drag: Floats  # D [N]
    change: Floats  # D over the drag of the paper's model, minus 1 [-]


def drag_effects(added: tuple[str, ...] = ADDED) -> list[DragEffect]:
    """Compute the drag of the paper's model, then add the corrections ``added`` one by one."""
    paper = propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))
    found: list[DragEffect] = []
    for count in range(len(added) + 1):
        texts = added[:count]
        model = replace(paper, corrections=tuple(propmap.correction(text) for text in texts))
        drag = Rotor(model).loads(ROTATION, SPEEDS[None, :], ANGLES[:, None]).drag
        first = found[0].drag if found else drag
        found.append(DragEffect(texts, drag, drag / first - 1.0))
    return found


def table(effects: list[DragEffect]) -> str:
    """Return a table with a row per angle and speed: the paper's drag [mN], and its changes.

    Each change [%] includes one more correction than the column before it.
    """
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
