"""Measurements of speed and of numerical accuracy, run by hand by `make bench`.

Times and error figures belong here, never in a test.
"""
