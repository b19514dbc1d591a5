"""Tools for flight logs before a fit: plausibility checks, steady segments, simulated flights."""
