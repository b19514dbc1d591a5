"""The files that ``propmap report`` writes; a folder that holds others is not replaced."""

from __future__ import annotations

PAGE = "index.html"

FIGURES = (
    "fit-coverage",
    "fit-errors",
    "fit-loads",
    "fit-parameters",
    "fit-check",
    "fit-measured",
    "table-cells",
    "table-loads",
    "table-maps",
    "table-hover",
)
"""As SVG, most of them with their numbers as CSV."""

TABLES = ("fit-correlations", "table-certificate")

FILES = frozenset(
    [PAGE, *(f"{name}{end}" for name in FIGURES for end in (".svg", ".csv"))]
    + [f"{name}.csv" for name in TABLES]
)
