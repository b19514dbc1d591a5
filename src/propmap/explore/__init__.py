"""A propeller in the browser: a local web application on the models, fits and tables."""

from __future__ import annotations

from propmap.errors import require

require("explore")
