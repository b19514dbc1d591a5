"""Simpler models of a propeller, to compare with."""
