"""A local web application that explores models, fits, tables and vehicles in the browser."""

from propmap.errors import require

require("explore")
