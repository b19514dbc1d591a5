"""Figures, and web pages about fits and tables, from objects of the package."""

import logging

from propmap.errors import require

require("figures")
# Matplotlib warns if it cannot write its cache, for example to a read-only home folder.
logging.getLogger("matplotlib").setLevel(logging.ERROR)
