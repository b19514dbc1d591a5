"""A propeller in the browser: a local web application on the models, fits and tables."""

from propmap.errors import require

require("explore")
