"""Pages on the propellers with bundled constants: one card each, a list, and the population.

The pictures are inline SVG from a small writer in this package: 140 cards take seconds, are small
and follow the colors of the theme.
"""
