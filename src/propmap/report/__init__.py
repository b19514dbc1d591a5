"""Figures, and web pages about fits and tables, from objects of the package."""

from propmap.errors import require

require("figures")
