"""Pages on the propellers whose constants come with propmap: a card each, a list, the population.

Pictures are SVG inside the pages, drawn by a hundred lines of their own: a hundred and forty cards
take seconds, weigh little and follow the theme's colours.
"""
