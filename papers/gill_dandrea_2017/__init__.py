"""The paper's results from its own ingredients and public data: numbers, figures, one page.

The numbers are computed by the modules here, and drawn and told in ``pages``.
"""

from propmap.report.html import file_names

FIGURES = (
    "figure-6-level-circles",
    "figure-6-hover-failure",
    "figure-7-axial",
    "figure-7-oblique",
    "figure-7-8x4.5mr",
    "camber",
    "rotor-drag",
)
TABLES = (
    "table-1-sets",
    "table-1-blades",
    "table-1-identified",
    "figure-6-identification",
    "figure-6-failure-speeds",
    "figure-7-errors",
    "rotor-drag-by-angle",
    "rotor-drag-sources",
    "rotor-drag-plate",
    "rotor-drag-in-flight",
    "times",
)
FILES = file_names(FIGURES, TABLES)
"""What ``propmap reproduce`` writes."""
