"""Print what corrections change in the rotor drag of the APC 8x6E, as a table in Markdown.

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
"""Corrections in the order in which they are added to the paper's physics."""

ROTATION = 6000.0 * np.pi / 30.0  # Omega [rad/s]
ANGLES = np.radians([45.0, 60.0, 75.0, 90.0])  # beta [rad]
SPEEDS = np.array([5.0, 10.0, 15.0])  # V [m/s]


class DragEffect(NamedTuple):
    """Rotor drag with some corrections; arrays are (angles, speeds)."""

    corrections: tuple[str, ...]  # as ``propmap.correction`` reads them; none for the paper's
    drag: Floats  # D [N]
    change: Floats  # D over that of the paper's physics, less 1 [-]


def drag_effects(added: tuple[str, ...] = ADDED) -> list[DragEffect]:
    """Compute the paper's drag, then that with one more of the corrections ``added`` each."""
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
    """Make a row per angle and speed: the paper's drag [mN], and its change with each correction.

    Changes are those by a correction and all before it, in per cent.
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
