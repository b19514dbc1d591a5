"""The files that the command writes; a folder that holds others is not replaced."""

from __future__ import annotations

PAGE = "index.html"

FIGURES = (
    "figure-6-level-circles",
    "figure-6-hover-failure",
    "figure-7-axial",
    "figure-7-oblique",
    "figure-7-8x4.5mr",
    "camber",
    "rotor-drag",
)
"""Each as SVG, with its numbers as CSV."""

TABLES = (
    "table-1-sets",
    "table-1-blades",
    "table-1-identified",
    "figure-6-identification",
    "figure-6-failure-speeds",
    "figure-7-errors",
    "rotor-drag-by-angle",
    "rotor-drag-in-flight",
    "times",
)

FILES = frozenset(
    [PAGE, *(f"{name}{end}" for name in FIGURES for end in (".svg", ".csv"))]
    + [f"{name}.csv" for name in TABLES]
)
