"""Flights that were not flown: twins for tests, and what a planned flight would tell."""
