"""Measurements of speed and of numerical accuracy, run by hand: `make bench`, `make convergence`.

Times and error figures belong here, never in a test.
"""
