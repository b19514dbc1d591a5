"""Pictures and comparisons of loads; every function takes package objects."""

from __future__ import annotations

from propmap.errors import require

require("figures")
