"""Pictures and comparisons of loads; every function takes package objects."""

from propmap.errors import require

require("figures")
