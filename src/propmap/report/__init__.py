"""Pictures and comparisons of loads; every function takes package objects."""
