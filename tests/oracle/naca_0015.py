"""The NACA 0015 of the shared data as the literal reference reads it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.oracle.literal_section import LiteralTable

FILE = Path(__file__).parents[3] / "shared" / "data" / "airfoil" / "NACA_0015.dat"


def naca_0015() -> LiteralTable:
    """All its Reynolds numbers; angles in rad."""
    blocks: list[list[list[float]]] = []
    reynolds = []
    for line in FILE.read_text().splitlines():
        if line.startswith("Reynolds Number:"):
            reynolds.append(float(line.split(":")[1]))
            blocks.append([])
        elif blocks and line[:1] in "-0123456789" and line.strip():
            blocks[-1].append([float(word) for word in line.split()])
    table = np.array(blocks)  # (Re, angle, column)
    angle = np.radians(table[0, :, 0])
    angle[[0, -1]] = -np.pi, np.pi
    return LiteralTable(angle, np.array(reynolds), table[..., 1], table[..., 2])
