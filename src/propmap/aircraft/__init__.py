"""Steady states of aircraft: trim, power, top speed, missions, and the ranking of propellers."""
